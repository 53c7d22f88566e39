"""What every bit of a frame on the wire is: its field, stuff bits, CRC, and the signals that the data carry."""

from dataclasses import dataclass
from typing import Any

from can_fault_injector import fields as f
from can_fault_injector.frame import Frame, ProtocolError
from can_fault_injector.notation import frame_text
from can_fault_injector.places import SignalBits, position_in

INTERMISSION_BITS = 3
_MEANINGS = {
    "sof": "start of frame",
    "rtr": "remote transmission request",
    "srr": "substitute remote request",
    "ide": "identifier extension",
    "r0": "reserved",
    "r1": "reserved",
    "rrs": "remote request substitution",
    "fdf": "CAN FD format",
    "res": "reserved",
    "brs": "bit rate switch",
    "esi": "error state indicator",
    "crc_del": "CRC delimiter",
    "ack_slot": "a receiver makes it 0",
    "ack_del": "acknowledge delimiter",
    "eof": "end of frame",
}
_NUMBERS = ("id", "id_ext", "dlc", "stuff_count", "crc")


@dataclass(frozen=True)
class Bit:
    """One bit: position from SOF, level (1 is recessive), name, whether it is a stuff bit, and the signal's bit."""

    position: int
    level: int
    name: str
    stuff: bool
    signal: str


@dataclass(frozen=True)
class Row:
    """Consecutive bits of one field (of the data: of one byte) and what they say."""

    field: str
    bits: tuple[Bit, ...]
    meaning: str


@dataclass(frozen=True)
class Explanation:
    """A frame bit by bit.

    Attributes
    ----------
    frame : Frame
    rows : tuple of Row
        In the order of transmission.
    crc : int
        Of ``crc_width`` bits.
    marked : tuple of int
        Positions of the bits that were asked for.
    """

    frame: Frame
    rows: tuple[Row, ...]
    crc: int
    crc_width: int
    marked: tuple[int, ...]

    @property
    def bits(self) -> tuple[Bit, ...]:
        """All bits in order."""
        return tuple(bit for row in self.rows for bit in row.bits)

    def summary(self) -> str:
        """One line: kind of frame and its length."""
        frame = self.frame
        kind = f"CAN FD {'ISO' if frame.iso else 'non-ISO'}" if frame.fd else "classic CAN"
        role = "remote" if frame.remote else "data"
        stuffed, fixed = self._stuff_bits()
        fixed_text = f", {fixed} fixed stuff bits" if frame.fd else ""
        return (
            f"{kind}, {'extended' if frame.extended else 'standard'} {role} frame, {len(frame.data)} data bytes: "
            f"{len(self.bits)} bits ({stuffed} stuff bits{fixed_text}), {len(self.bits) + INTERMISSION_BITS} with "
            f"intermission, CRC-{self.crc_width} {_hexadecimal(self.crc, self.crc_width)}"
        )

    def _stuff_bits(self) -> tuple[int, int]:
        stuffed = sum(bit.name.startswith("stuff.") for bit in self.bits)
        return stuffed, sum(bit.name.startswith("fixed_stuff.") for bit in self.bits)

    def as_data(self) -> dict[str, Any]:
        """Everything as plain data."""
        frame = self.frame
        stuffed, fixed = self._stuff_bits()
        return {
            "frame": frame_text(frame),
            "identifier": frame.identifier,
            "extended": frame.extended,
            "remote": frame.remote,
            "fd": frame.fd,
            "iso": frame.iso,
            "bit_rate_switch": frame.bit_rate_switch,
            "error_state_indicator": frame.error_state_indicator,
            "dlc": frame.length_code,
            "data": frame.data.hex(),
            "crc": self.crc,
            "crc_width": self.crc_width,
            "length": len(self.bits),
            "stuff_bits": stuffed,
            "fixed_stuff_bits": fixed,
            "marked": list(self.marked),
            "bits": [
                {"position": bit.position, "level": bit.level, "name": bit.name, "stuff": bit.stuff}
                | ({"signal": bit.signal} if bit.signal else {})
                for bit in self.bits
            ],
        }


def explain(frame: Frame, signals: SignalBits | None = None, places: tuple[str, ...] = ()) -> Explanation:
    """Explain a frame.

    Parameters
    ----------
    signals : optional
        Layout of the message's signals, see `places.SignalBits`.
    places
        Addresses of bits to mark.

    Raises
    ------
    InputError
        If the frame has no such bit.
    """
    signal_of = {number: f"{name}.{i}" for name, bits in (signals or {}).items() for i, number in enumerate(bits)}
    levels, codes, _ = frame.encoded()
    rows: list[list[Bit]] = []
    titles: list[str] = []
    for position, name in enumerate(frame.bit_names()):
        field, _, number = name.partition(".")
        stuff = codes[position] in (f.STUFF, f.FIXED_STUFF)
        signal = signal_of.get(int(number), "") if field == "data" else ""
        title = f"data[{int(number) // 8}]" if field == "data" else field
        # a stuff bit stands in the row of the bit before it
        if not stuff and (not titles or titles[-1] != title):
            titles.append(title)
            rows.append([])
        rows[-1].append(Bit(position, int(levels[position]), name, stuff, signal))
    crc_bits = [bit.level for row in rows for bit in row if bit.name.startswith("crc.")]
    return Explanation(
        frame,
        tuple(Row(title, tuple(row), _meaning(title, row)) for title, row in zip(titles, rows, strict=True)),
        _number(crc_bits),
        len(crc_bits),
        tuple(position_in(frame, place, signals) for place in places),
    )


@dataclass(frozen=True)
class Reading:
    """What a receiver makes of a frame with flipped bits.

    Attributes
    ----------
    flipped : tuple of int
        Positions of the flipped bits.
    accepted : Frame or None
        The frame that it accepts.
    error, position : str, int
        Kind of the error that it finds instead, and where; "" and -1 if it accepts.
    """

    flipped: tuple[int, ...]
    accepted: Frame | None
    error: str
    position: int

    def summary(self, sent: Frame) -> str:
        """One line."""
        if self.accepted is None:
            return f"a receiver rejects it: {self.error} error at bit {self.position}"
        content = "as it was sent" if self.accepted == sent else "WITH OTHER CONTENT"
        return f"a receiver accepts {frame_text(self.accepted)}, {content}"

    def as_data(self) -> dict[str, Any]:
        """Everything as plain data."""
        accepted = None if self.accepted is None else frame_text(self.accepted)
        return {"flipped": list(self.flipped), "accepted": accepted, "error": self.error, "position": self.position}


def reading(frame: Frame, flips: tuple[str, ...], signals: SignalBits | None = None) -> Reading:
    """What a receiver reads of an acknowledged frame of which some bits are flipped.

    Raises
    ------
    InputError
        If the frame has no such bit.
    """
    bits, codes, _ = frame.encoded()
    bits[codes == f.ACK_SLOT] = 0
    flipped = tuple(position_in(frame, place, signals) for place in flips)
    bits[list(flipped)] ^= 1
    try:
        return Reading(flipped, Frame.from_bits(bits, frame.iso), "", -1)
    except ProtocolError as error:
        return Reading(flipped, None, error.kind, error.position)


def _number(levels: list[int]) -> int:
    value = 0
    for level in levels:
        value = 2 * value + level
    return value


def _hexadecimal(value: int, width: int) -> str:
    return f"0x{value:0{-(-width // 4)}X}"


def _meaning(title: str, row: list[Bit]) -> str:
    levels = [bit.level for bit in row if not bit.stuff]
    value = _number(levels)
    if title.startswith("data["):
        names = dict.fromkeys(bit.signal.rpartition(".")[0] for bit in row if bit.signal)
        return " ".join([f"0x{value:02X}", *names])
    if title in _NUMBERS:
        return _hexadecimal(value, len(levels))
    return _MEANINGS[title]
