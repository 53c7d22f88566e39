"""CAN sockets, interfaces and tools, multicast, serial ports."""

import errno
import os
import shutil
import socket
import struct
from collections.abc import Iterator
from pathlib import Path

from bench.doctor.finding import Finding
from bench.doctor.machine import read

_ARPHRD_CAN = "280"
_QUEUE = 1000
_GROUP = "239.74.163.2"
_MAKE_VCAN = "sudo modprobe vcan && sudo ip link add vcan0 type vcan && sudo ip link set vcan0 up"


def findings() -> Iterator[Finding]:
    """Everything that links need."""
    kernel = kernel_can()
    yield kernel
    if kernel.state == "ok":
        yield virtual_can()
        yield from queues()
    yield tools()
    yield multicast()
    yield serial_ports()


def kernel_can() -> Finding:
    """CAN sockets of the kernel."""
    try:
        socket.socket(socket.AF_CAN, socket.SOCK_RAW, socket.CAN_RAW).close()
    except OSError as error:
        if error.errno == errno.EPERM:
            return Finding("af_can", "warn", "CAN sockets are not permitted", "run outside the sandbox, or --link udp")
        mend = "ci/can_kernel bench run …  (behaviour only), or --link udp"
        return Finding("af_can", "warn", "AF_CAN missing: this kernel has no CAN sockets", mend)
    return Finding("af_can", "ok", "AF_CAN")


def _interfaces() -> list[Path]:
    folder = Path("/sys/class/net")
    return [path for path in sorted(folder.glob("*")) if read(path / "type") == _ARPHRD_CAN]


def virtual_can() -> Finding:
    """vcan0, the default link."""
    path = Path("/sys/class/net/vcan0")
    if not path.exists():
        return Finding("vcan", "warn", "no vcan0", _MAKE_VCAN)
    flags = read(path / "flags") or "0x0"
    if not int(flags, 16) & 1:
        return Finding("vcan", "warn", "vcan0 is down", "sudo ip link set vcan0 up")
    return Finding("vcan", "ok", "vcan0 is up")


def queues() -> Iterator[Finding]:
    """Transmit queues of real CAN interfaces."""
    for path in _interfaces():
        length = read(path / "tx_queue_len")
        if not length.isdigit() or "virtual" in str(path.resolve()):
            continue
        name, text = f"txqueuelen_{path.name}", f"{path.name}: transmit queue of {length} frames"
        if int(length) < _QUEUE:
            yield Finding(name, "warn", text, f"sudo ip link set {path.name} txqueuelen {_QUEUE}")
        else:
            yield Finding(name, "ok", text)


def tools() -> Finding:
    """candump and cangen."""
    missing = [name for name in ("candump", "cangen", "slcand") if shutil.which(name) is None]
    if missing:
        text = f"can-utils: no {', '.join(missing)}"
        return Finding("can_utils", "info", text, "sudo apt-get install can-utils")
    return Finding("can_utils", "ok", "can-utils")


def multicast() -> Finding:
    """Whether a multicast datagram comes back, as the link udp needs it."""
    try:
        _send_to_myself()
    except OSError as error:
        reason = (error.strerror or "no answer").lower()
        mend = "sudo ip route add 239.0.0.0/8 dev lo  (without it udp falls back to loopback datagrams)"
        return Finding("multicast", "warn", f"multicast on this machine: {reason}", mend)
    return Finding("multicast", "ok", "multicast route")


def _send_to_myself() -> None:
    with (
        socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as receiver,
        socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as sender,
    ):
        receiver.bind((_GROUP, 0))
        request = struct.pack("4sl", socket.inet_aton(_GROUP), socket.INADDR_ANY)
        receiver.setsockopt(socket.IPPROTO_IP, socket.IP_ADD_MEMBERSHIP, request)
        receiver.settimeout(0.2)
        # a hop limit of 0 keeps the datagram on this machine
        sender.setsockopt(socket.IPPROTO_IP, socket.IP_MULTICAST_TTL, 0)
        sender.setsockopt(socket.IPPROTO_IP, socket.IP_MULTICAST_LOOP, 1)
        sender.sendto(b"bench", (_GROUP, receiver.getsockname()[1]))
        receiver.recv(16)


def serial_ports() -> Finding:
    """Serial devices and whether they may be opened."""
    ports = [path for pattern in ("ttyUSB*", "ttyACM*") for path in sorted(Path("/dev").glob(pattern))]
    if not ports:
        return Finding("serial", "info", "no serial port (only for slcan adapters, relay card, power supply)")
    closed = [path.name for path in ports if not os.access(path, os.R_OK | os.W_OK)]
    text = f"serial: {', '.join(_named(path) for path in ports)}"
    if closed:
        mend = "sudo usermod -aG dialout $USER; then log in again"
        return Finding("serial", "warn", f"{text}; not permitted: {', '.join(closed)}", mend)
    return Finding("serial", "ok", text)


def _named(port: Path) -> str:
    """Port with the name that its device gives itself."""
    for link in Path("/dev/serial/by-id").glob("*"):
        if link.resolve() == port:
            return f"{port} ({link.name})"
    return str(port)
