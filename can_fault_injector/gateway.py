"""The in-line device bit by bit: the state machine of the CAN error generator (friction document 5.2.3).

    INIT -> WAIT_IDLE -> WAIT_SOF -> SOF -> ID -> CONTROL (RTR, IDE, r) -> DLC -> DATA -> CRC -> CRC_DELIMITER -> ACK
    -> ACK_DELIMITER -> END (EOF and intermission) -> INIT

One routine reads, modifies, forwards and checks every bit; each state knows the field that it reads and what is to be
changed there. A state ends when all its bits have been read, stuff bits included. Classic CAN, as the source has it.

The identifier is not known before it has passed, so a change inside it goes by the part that was read up to there: a
frame that begins like the wanted one is changed up to the bit in which it differs.
"""

from collections import deque
from collections.abc import Mapping
from enum import Enum, auto
from typing import Literal

IDLE_BITS = 11
_STUFF_RUN = 5
_CRC_POLYNOMIAL, _CRC_BITS = 0x4599, 15
_EOF_AND_INTERMISSION = 10
RECESSIVE = 1


class State(Enum):
    """States of 5.2.3."""

    INIT = auto()
    WAIT_IDLE = auto()
    WAIT_SOF = auto()
    SOF = auto()
    ID = auto()
    CONTROL = auto()
    DLC = auto()
    DATA = auto()
    CRC = auto()
    CRC_DELIMITER = auto()
    ACK = auto()
    ACK_DELIMITER = auto()
    END = auto()


_STUFFED = (State.SOF, State.ID, State.CONTROL, State.DLC, State.DATA, State.CRC)
_NAMES = {State.ID: "id", State.CONTROL: "control", State.DLC: "dlc", State.DATA: "data", State.CRC: "crc"}
_STANDARD_CONTROL, _EXTENDED_CONTROL = 3, 23
"""Bits between the first 11 of the identifier and DLC: RTR, IDE, r0; or SRR, IDE, 18 bits, RTR, r1, r0."""


class InlineGateway:
    """One direction of the device: a level in, a level out, in every bit time.

    Parameters
    ----------
    changes : mapping
        New level of a bit by its place: ``id.0`` … ``id.10``, ``control.0`` … (RTR, IDE, r0 of a standard frame),
        ``dlc.0``, ``data.12``, ``crc.3``, counted without stuff bits in the order of transmission.
    identifier : int, optional
        Only frames with these first 11 bits of the identifier are changed.
    mode : str
        "raw": the changed bits replace the original ones, everything else stays as it is. "protocol_correct": the
        frame that leaves has stuff bits and a CRC of its own.
    lag_bits : int
        Bits by which protocol_correct forwards later, as a reserve for stuff bits that the new frame does not need.

    Raises
    ------
    ValueError
        If protocol_correct is to change DLC or CRC.
    """

    def __init__(
        self,
        changes: Mapping[str, int],
        *,
        identifier: int | None = None,
        mode: Literal["raw", "protocol_correct"] = "raw",
        lag_bits: int = 0,
    ) -> None:
        if mode == "protocol_correct" and any(place.startswith(("dlc", "crc")) for place in changes):
            raise ValueError("protocol_correct: found a change of DLC or CRC, allowed: id, control and data")
        self._changes = dict(changes)
        self._identifier = identifier
        self._correct = mode == "protocol_correct"
        self._lag = lag_bits
        self.frames = 0
        self.underruns = 0
        """Frames in which the next bit was needed before it had arrived: `lag_bits` was too small."""
        self._initialise()
        self.state = State.INIT

    @classmethod
    def rewriting(
        cls, identifier: int, to: int, mode: Literal["raw", "protocol_correct"], lag_bits: int = 0
    ) -> "InlineGateway":
        """The device that gives standard frames of one identifier another one (F4)."""
        changed = identifier ^ to
        changes = {f"id.{n}": to >> (10 - n) & 1 for n in range(11) if changed >> (10 - n) & 1}
        return cls(changes, identifier=identifier, mode=mode, lag_bits=lag_bits)

    def _initialise(self) -> None:
        """All variables of a frame as at its beginning."""
        self._index = self._run = self._last = 0
        self._extended = self._remote = False
        self._length = 0
        self._original_identifier = 0
        self._recessive = 0
        # what leaves: bits that wait, the run of equal ones, and the CRC over them
        self._out: deque[tuple[int, bool]] = deque()
        self._out_run, self._out_last = 0, RECESSIVE
        self._crc = 0
        self._sending = False
        self._held = self._lag

    def step(self, level: int) -> int:
        """Read the level of this bit time and give the one to forward (1 recessive)."""
        before = self.state
        self._take(level)
        if not self._correct:
            return self._forwarded
        if before in (State.INIT, State.WAIT_IDLE) and self.state is not State.SOF:
            return level
        return self._next_out()

    def _take(self, level: int) -> None:
        """The common routine: read, modify, check one bit."""
        self._forwarded = level
        if self.state is State.INIT:
            self._initialise()
            self.state = State.WAIT_IDLE
        if self.state is State.WAIT_IDLE:
            self._recessive = self._recessive + 1 if level else 0
            if self._recessive >= IDLE_BITS:
                self.state = State.WAIT_SOF
        elif self.state is State.WAIT_SOF:
            if level == 0:
                self._begin()
        elif self.state in _STUFFED:
            self._take_stuffed(level)
        else:
            self._take_fixed(level)

    def _begin(self) -> None:
        self._initialise()
        self.state, self._run, self._last = State.SOF, 1, 0
        self._emit(0)
        self._to(State.ID)

    def _to(self, state: State) -> None:
        self.state, self._index = state, 0

    def _take_stuffed(self, level: int) -> None:
        if self._run == _STUFF_RUN:
            if level == self._last:
                self._to(State.INIT)  # six equal bits: an error, the bus has to be idle before the next frame
            self._run, self._last = 1, level
            if self.state is State.CRC and self._index == _CRC_BITS:
                self._to(State.CRC_DELIMITER)
            return
        self._run = self._run + 1 if level == self._last else 1
        self._last = level
        name = f"{_NAMES[self.state]}.{self._index}"
        changed = self._changes.get(name, level) if self._meant(level) else level
        self._forwarded = changed
        if self.state is State.CRC:
            self._emit(self._crc >> (_CRC_BITS - 1 - self._index) & 1, counted=False)
        else:
            self._emit(changed)
        self._read_field(level)

    def _meant(self, level: int) -> bool:
        """Whether the identifier, as far as it is known with this bit, is the wanted one."""
        if self._identifier is None:
            return True
        known = self._original_identifier
        count = 11
        if self.state is State.ID:
            known, count = known << 1 | level, self._index + 1
        return known == self._identifier >> (11 - count)

    def _read_field(self, level: int) -> None:
        """What the bit means, and which state comes next."""
        self._index += 1
        if self.state is State.ID:
            self._original_identifier = self._original_identifier << 1 | level
            if self._index == 11:
                self._to(State.CONTROL)
        elif self.state is State.CONTROL:
            if self._index == 2:
                self._extended = bool(level)
            if self._index in (1, 21):
                self._remote = bool(level)
            if self._index == (_EXTENDED_CONTROL if self._extended else _STANDARD_CONTROL):
                self._to(State.DLC)
        elif self.state is State.DLC:
            self._length = self._length << 1 | level
            if self._index == 4:
                self._length = 0 if self._remote else 8 * min(self._length, 8)
                self._to(State.DATA if self._length else State.CRC)
        elif self.state is State.DATA:
            if self._index == self._length:
                self._to(State.CRC)
        elif self._index == _CRC_BITS and self._run < _STUFF_RUN:
            self._to(State.CRC_DELIMITER)

    def _take_fixed(self, level: int) -> None:
        self._emit(level, counted=False, stuffed=False)
        if self.state is State.CRC_DELIMITER:
            self._to(State.ACK)
        elif self.state is State.ACK:
            self._to(State.ACK_DELIMITER)
        elif self.state is State.ACK_DELIMITER:
            self._to(State.END)
        else:
            self._index += 1
            if self._index == _EOF_AND_INTERMISSION:
                self.frames += 1
                self._to(State.WAIT_SOF)
            elif level == 0:
                self._to(State.INIT)

    def _emit(self, level: int, *, counted: bool = True, stuffed: bool = True) -> None:
        """A bit of the frame that leaves."""
        if counted:
            top = self._crc >> (_CRC_BITS - 1) & 1
            self._crc = (self._crc << 1) & 0x7FFF ^ (_CRC_POLYNOMIAL if top ^ level else 0)
        self._out.append((level, stuffed))
        self._sending = True

    def _next_out(self) -> int:
        """The next level that leaves in protocol_correct: a stuff bit where one is due, else the oldest waiting bit."""
        if self._held and self._sending:
            self._held -= 1
            return RECESSIVE
        if self._out_run == _STUFF_RUN:  # after the last bit of the CRC too
            self._out_last, self._out_run = 1 - self._out_last, 1
            return self._out_last
        if not self._out:
            if self._sending and self.state in _STUFFED:
                self.underruns += 1
                self._to(State.INIT)
            return RECESSIVE
        level, stuffed = self._out.popleft()
        self._out_run = (self._out_run + 1 if level == self._out_last else 1) if stuffed else 0
        self._out_last = level
        return level
