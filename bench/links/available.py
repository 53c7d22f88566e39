"""Which links this machine can offer; nothing here imports compiled code, so that ``bench doctor`` may ask too."""

import ipaddress
import random
import re
import socket
from pathlib import Path

MULTICAST_ROUTE = "sudo ip link set lo multicast on && sudo ip route add 239.0.0.0/8 dev lo"
"""Command that brings multicast to a machine that has only the loopback interface."""


def kernel_has_can() -> bool:
    """Whether this kernel knows AF_CAN and lets this process use it."""
    try:
        socket.socket(socket.AF_CAN, socket.SOCK_RAW, socket.CAN_RAW).close()
    except OSError:
        return False
    return True


def interface_is_up(interface: str) -> bool:
    """Whether a network interface exists and is up."""
    try:
        flags = int((Path("/sys/class/net") / interface / "flags").read_text(), 16)
    except (OSError, ValueError):
        return False
    return bool(flags & 1)


def is_virtual(interface: str) -> bool:
    """Whether an interface is a virtual CAN bus (vcan, vxcan), where frames take no time on a wire."""
    path = Path("/sys/class/net") / interface
    return re.match(r"vx?can", interface) is not None and "/virtual/" in str(path.resolve())


def draw_group_and_port() -> tuple[str, int]:
    """A multicast group of the organisation-local scope (RFC 2365) and a port for one run."""
    group = ipaddress.IPv4Address("239.192.0.0") + random.SystemRandom().randrange(1, 1 << 18)
    return str(group), random.SystemRandom().randrange(20_000, 32_000)


def draw_two_ports() -> tuple[int, int]:
    """Two free ports of 127.0.0.1."""
    with _datagram_socket() as one, _datagram_socket() as two:
        one.bind(("127.0.0.1", 0))
        two.bind(("127.0.0.1", 0))
        return one.getsockname()[1], two.getsockname()[1]


def multicast_works() -> bool:
    """Whether a datagram to a group comes back on this machine."""
    group, port = draw_group_and_port()
    with _datagram_socket() as sender, _datagram_socket() as receiver:
        try:
            aim_at_group(sender, group, port)
            join_group(receiver, group, port)
            receiver.settimeout(0.2)
            sender.send(b"?")
            return receiver.recv(16) == b"?"
        except OSError:
            return False


def aim_at_group(sender: socket.socket, group: str, port: int) -> None:
    """Connect a socket to a multicast group; its datagrams never leave this machine."""
    sender.setsockopt(socket.IPPROTO_IP, socket.IP_MULTICAST_TTL, 0)
    sender.connect((group, port))


def join_group(receiver: socket.socket, group: str, port: int) -> None:
    """Bind a socket to a multicast group, as many others may."""
    receiver.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEADDR, 1)
    receiver.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEPORT, 1)
    receiver.bind((group, port))
    membership = socket.inet_aton(group) + socket.inet_aton("0.0.0.0")
    receiver.setsockopt(socket.IPPROTO_IP, socket.IP_ADD_MEMBERSHIP, membership)


def _datagram_socket() -> socket.socket:
    return socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
