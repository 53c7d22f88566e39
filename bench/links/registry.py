"""A link by its text.

``virtual[:NAME]`` · ``udp[:GROUP:PORT]`` · ``udp_loopback[:PORT:PORT]`` · ``socketcan:vcan0[,vcan1]`` ·
``slcan:/dev/ttyUSB0[@500000[,115200]]`` · ``IFACE:CHANNEL[@500000]`` for any other interface of python-can.
"""

from bench.links.available import (
    draw_group_and_port,
    draw_two_ports,
    interface_is_up,
    kernel_has_can,
    multicast_works,
)
from bench.links.interface import Link
from signals.errors import InputError, nearest_name

DEFAULT_BIT_RATE = 500_000
DEFAULT_BAUD_RATE = 115_200

OWN_KINDS = ("virtual", "udp", "udp_loopback", "socketcan", "slcan")
_FORMS = "virtual, udp, udp:GROUP:PORT, udp_loopback, socketcan:vcan0, slcan:/dev/ttyUSB0@500000, IFACE:CHANNEL"


def open_link(text: str, *, role: str) -> Link:
    """Open a link.

    Parameters
    ----------
    text : str
        As in the module's first lines; where group or ports are left out they are drawn, and ``link.text`` is what the
        peer has to open.
    role : {"bench", "ecu", "injector"}
        Who we are on it.

    Raises
    ------
    InputError
        If the text is no link.
    LinkError
        If it does not exist here or is not permitted.
    """
    kind, _, rest = text.partition(":")
    if kind == "virtual":
        from bench.links.virtual import VirtualLink

        return VirtualLink(rest or "default", role)
    if kind == "udp":
        return _open_udp(text, rest, role)
    if kind == "udp_loopback":
        return _open_udp_loopback(text, rest, role)
    if kind == "socketcan":
        return _open_socketcan(text, rest, role)
    if kind == "slcan":
        return _open_slcan(text, rest, role)
    return _open_python_can(text, kind, rest, role)


def default_link_text() -> str:
    """The best link that this machine has: vcan0, else UDP multicast, else UDP on two ports of loopback."""
    if interface_is_up("vcan0") and kernel_has_can():
        return "socketcan:vcan0"
    if multicast_works():
        group, port = draw_group_and_port()
        return f"udp:{group}:{port}"
    one, two = draw_two_ports()
    return f"udp_loopback:{one}:{two}"


def _bad(text: str, problem: str) -> InputError:
    return InputError(f"link {text!r}: {problem}", allowed=_FORMS)


def _number(text: str, part: str) -> int:
    if not part.isdecimal():
        raise _bad(text, f"{part!r} is no number")
    return int(part)


def _open_udp(text: str, rest: str, role: str) -> Link:
    from bench.links.udp import open_multicast

    if not rest:
        return open_multicast(*draw_group_and_port(), role)
    group, _, port = rest.partition(":")
    return open_multicast(group, _number(text, port), role)


def _open_udp_loopback(text: str, rest: str, role: str) -> Link:
    from bench.links.udp import open_loopback

    if not rest:
        return open_loopback(*draw_two_ports(), role)
    one, _, two = rest.partition(":")
    return open_loopback(_number(text, one), _number(text, two), role)


def _open_socketcan(text: str, rest: str, role: str) -> Link:
    from bench.links.socketcan import SocketCanLink

    interfaces = tuple(rest.split(","))
    if not all(interfaces) or len(interfaces) > 2 or len(set(interfaces)) < len(interfaces):
        raise _bad(text, "one or two interfaces")
    return SocketCanLink(interfaces, role)


def _open_slcan(text: str, rest: str, role: str) -> Link:
    from bench.links.slcan import SlcanLink

    port, _, speeds = rest.partition("@")
    bit_rate, _, baud_rate = speeds.partition(",")
    if not port:
        raise _bad(text, "no serial device")
    return SlcanLink(
        port,
        _number(text, bit_rate) if bit_rate else DEFAULT_BIT_RATE,
        _number(text, baud_rate) if baud_rate else DEFAULT_BAUD_RATE,
        role,
    )


def _open_python_can(text: str, kind: str, rest: str, role: str) -> Link:
    from bench.links.python_can import PythonCanLink
    from bench.links.python_can_library import can

    if kind not in can.VALID_INTERFACES:
        nearest = nearest_name(kind, [*OWN_KINDS, *can.VALID_INTERFACES])
        raise InputError(f"link {text!r}: no kind of link is called {kind!r}", allowed=_FORMS, nearest=nearest)
    channel, _, bit_rate = rest.partition("@")
    if not channel:
        raise _bad(text, "no channel")
    return PythonCanLink(kind, channel, _number(text, bit_rate) if bit_rate else None, role)
