"""Addresses of bits: by field and number, ``crc.14``, or by a decoded signal, ``data.signal(wheel_speed_fl).bit 5``."""

import re
from collections.abc import Mapping, Sequence

from can_fault_injector.frame import Frame
from can_fault_injector.node_state import PLACES
from signals.errors import InputError, unknown_name

SignalBits = Mapping[str, Sequence[int]]
"""Of each signal of a message the numbers of its bits in the data field, least significant first.

Bit n of the data field is the n-th that is sent: 0 is the most significant bit of byte 0. Who knows the message passes
this in; see `from_database_position`.
"""

_SIGNAL = re.compile(r"data\.signal\((?P<name>[^()]+)\)\.bit[ .](?P<bit>\d+)")
_NUMBERED = re.compile(r"(?P<field>[a-z_0-9]+?)(?:\.(?P<number>\d+))?")
_POSITION = "bit"


def from_database_position(position: int) -> int:
    """Number in the data field of a bit at byte × 8 + bit, bit 0 the least significant, as CAN databases count."""
    return 8 * (position >> 3) + 7 - (position & 7)


def resolve(place: str, signals: SignalBits | None = None) -> str:
    """Place by field and number; that of a signal's bit through the layout of its message.

    Raises
    ------
    InputError
        If the text is no place, or names a signal or bit that the message does not have.
    """
    text = place.strip()
    match = _SIGNAL.fullmatch(text)
    if match is None:
        numbered = _NUMBERED.fullmatch(text)
        if numbered is None or numbered["field"] not in PLACES:
            raise InputError(
                "place of a bit",
                found=repr(place),
                allowed=f"FIELD.NUMBER or data.signal(NAME).bit NUMBER; FIELD is one of {', '.join(PLACES)}",
                mend="for example crc.14, ack_slot, stuff.2, data.signal(wheel_speed_fl).bit 5",
            )
        return f"{numbered['field']}.{int(numbered['number'] or 0)}"
    if signals is None:
        raise InputError(f"place {place}: no layout of the message", mend="name a CAN database that has it")
    name, bit = match["name"].strip(), int(match["bit"])
    if name not in signals:
        raise unknown_name("signal", name, list(signals))
    if bit >= len(signals[name]):
        raise InputError(f"place {place}", found=f"bit {bit}", allowed=f"0 to {len(signals[name]) - 1}")
    return f"data.{signals[name][bit]}"


def position_in(frame: Frame, place: str, signals: SignalBits | None = None) -> int:
    """Position of an addressed bit in ``frame.bits()``, SOF is 0.

    Raises
    ------
    InputError
        If this frame has no such bit.
    """
    name = resolve(place, signals)
    names = list(frame.bit_names())
    field, _, number = name.partition(".")
    if field == _POSITION and int(number) < len(names):
        return int(number)
    if name not in names:
        field_bits = [other for other in names if other.partition(".")[0] == field]
        fields = ", ".join(dict.fromkeys(other.partition(".")[0] for other in names))
        allowed = f"{field_bits[0]} to {field_bits[-1]}" if field_bits else f"bits of {fields}"
        raise InputError("place of a bit in this frame", found=place, allowed=allowed)
    return names.index(name)
