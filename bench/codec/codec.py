"""Values ↔ frames: the codec of one CAN database, compiled, with end-to-end protection and its checks."""

from collections.abc import Iterable, Sequence
from functools import cache
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from bench.codec.kernels import AGES, CHANNEL, GROUPS, MESSAGES, NEVER_TICKS, PLACES, SENDER, SIGNALS, VALUES, unpack
from bench.codec.kernels import receive as _receive
from bench.codec.kernels import transmit as _transmit
from bench.codec.layout import AGE_GROUPS, Carrier, Layout
from bench.codec.mapping_file import BUS_NAMES, Protection
from bench.codec.resolve import load_layout
from bench.codec.tables import (
    ACCEPTED,
    BY_CRC,
    BY_CRC_AND_COUNTER,
    COUNTER,
    CRC_ERRORS,
    EXPECTED,
    LAST_COUNTER,
    LAST_TICK,
    NEXT_DUE,
    OFFSET,
    PERIOD,
    PROTECTED,
    REPEATED,
    STATISTICS,
    UNPROTECTED,
    WRONG_LENGTH,
    WRONG_SEQUENCE,
    Tables,
    build_tables,
    by_identifier,
)
from bench.links.frame import ROLES, frames_address, new_frames
from signals.catalogue import catalogue
from signals.errors import InputError
from signals.record_memory import addresses_of

CHECKS: dict[Protection, int] = {"none": UNPROTECTED, "crc": BY_CRC, "full": BY_CRC_AND_COUNTER}
AGE_NAMES: tuple[str, ...] = tuple(signal.name for signal in catalogue() if signal.block == "bus_age")


@cache
def _shipped_layout() -> Layout:
    """Layout of the shipped database, read once: a process that makes thousands of runs asks for it in each."""
    return load_layout()


class Codec:
    """Messages of a CAN database bound to the signals of block "bus".

    Parameters
    ----------
    layout : Layout
        From :func:`bench.codec.resolve.load_layout`; :meth:`load` does both.
    """

    def __init__(self, layout: Layout) -> None:
        self.layout = layout

    @classmethod
    def load(cls, dbc: str | Path | None = None, mapping: str | Path | None = None) -> "Codec":
        """Read a database (default: the shipped one) and a mapping file.

        Raises
        ------
        InputError
            If a file is bad or a needed message or signal is absent.
        """
        return cls(_shipped_layout() if dbc is None and mapping is None else load_layout(dbc, mapping))

    @property
    def bit_rate(self) -> int:
        """Bit rate of the bus that the database describes, bit/s."""
        return self.layout.bit_rate

    def transmitter(
        self, role: str, values: NDArray[np.float64], names: Sequence[str] = BUS_NAMES, *, channel: int = 0
    ) -> "Transmitter":
        """Sender of all messages of "bench" or "ecu" that packs from ``values`` (in the order of ``names``)."""
        return Transmitter(self.layout.sent_by(role), role, values, names, channel)

    def receiver(
        self,
        role: str,
        values: NDArray[np.float64],
        ages: NDArray[np.float64],
        *,
        channel: int | None = None,
        protection: Protection = "full",
        notes_lateness: bool = False,
    ) -> "Receiver":
        """Receiver of the other side's messages, or with role "all" of every message.

        Parameters
        ----------
        role : {"bench", "ecu", "all"}
            Who listens: the bench hears the ECU's messages, the ECU the bench's.
        values, ages : float64 arrays
            Blocks "bus" and "bus_age"; only entries whose messages this receiver hears are written.
        channel : int, optional
            Listen to one channel of the link only.
        protection : {"full", "crc", "none"}
            What is checked of protected frames: CRC and alive counter, the CRC alone, or nothing.
        notes_lateness : bool
            Ages count what a frame comes late by its counter. Only for senders that miss no cycle: one that pauses and
            goes on counting where it was looks like frames that were held up.
        """
        sender = {"bench": "ecu", "ecu": "bench", "all": "all"}[role]
        return Receiver(self.layout.sent_by(sender), values, ages, channel, protection, notes_lateness)

    def require(self, role: str, names: Iterable[str], purpose: str) -> None:
        """Raise InputError, listing them, if the messages that ``role`` sends lack one of the signals."""
        self.layout.require(role, names, purpose)

    def identifiers(self, role: str) -> frozenset[tuple[int, bool]]:
        """(identifier, extended) of the messages that "bench", "ecu" or "all" sends."""
        return frozenset((c.message.identifier, c.message.extended) for c in self.layout.sent_by(role))

    def modulus(self, name: str) -> float:
        """Value at which a wrapping signal starts again at zero; infinity for all others.

        Raises
        ------
        KeyError
            If no message carries the signal.
        """
        for carrier in self.layout.carriers:
            for carried in carrier.carried:
                if carried.name == name:
                    signal = carried.signal
                    return 2.0**signal.length * signal.scale * carried.scale if signal.wraps else np.inf
        raise KeyError(name)


class _Memory:
    """What the compiled codec works on: a list of addresses and numbers, and the arrays that it names.

    Attributes
    ----------
    address : int
        Of the list.
    """

    def __init__(
        self,
        tables: Tables,
        values: NDArray[np.float64],
        channel: int,
        groups: NDArray[np.int64],
        ages: NDArray[np.float64],
    ) -> None:
        self._arrays = (tables.messages, tables.signals, tables.payloads, values, groups, ages)
        if not all(array.flags.c_contiguous for array in self._arrays):
            raise ValueError("found an array with gaps, allowed: consecutive numbers, as numpy.zeros gives")
        self.list = np.zeros(PLACES, np.int64)
        self.list[: len(self._arrays)] = addresses_of(*self._arrays)
        self.list[[MESSAGES, SIGNALS, VALUES]] = len(tables.messages), len(tables.signals), len(values)
        self.list[[GROUPS, AGES, CHANNEL]] = len(groups), len(ages), channel
        self.address = int(self.list.ctypes.data)
        self._frames = new_frames(0)
        self._frames_at = 0

    def frames_at(self, frames: NDArray[np.void]) -> int:
        """Address of frame records: the same come tick by tick, so it is kept."""
        if frames is not self._frames:
            self._frames_at = frames_address(frames)
            self._frames = frames
        return self._frames_at


class Transmitter:
    """Sends each message of one side in its cycle; made by :meth:`Codec.transmitter`.

    Attributes
    ----------
    address : int
        Of the memory that ``kernels.transmit`` works on, for compiled callers.
    """

    def __init__(
        self,
        carriers: Sequence[Carrier],
        role: str,
        values: NDArray[np.float64],
        names: Sequence[str],
        channel: int,
    ) -> None:
        without_cycle = [carrier.message.name for carrier in carriers if carrier.cycle_ms < 1]
        if without_cycle:
            raise InputError(
                f"the database gives no cycle time for {', '.join(without_cycle)}, which the {role} has to send",
                mend=f"add to the mapping file:  messages: {{{without_cycle[0]}: {{cycle: 10 ms}}}}",
            )
        tables = build_tables(carriers, names)
        self._carriers = by_identifier(carriers)
        self._messages = tables.messages
        self._memory = _Memory(tables, values, channel, np.zeros((0, 0), np.int64), np.zeros(0))
        self._memory.list[SENDER] = ROLES[role]
        self.address = self._memory.address
        self.reset()

    def reset(self) -> None:
        """Start again: counters at zero, each message due at its offset."""
        self._messages[:, COUNTER] = 0
        self._messages[:, NEXT_DUE] = self._messages[:, OFFSET]

    def rows_of(self, names: Iterable[str]) -> NDArray[np.int64]:
        """Rows of the messages that carry one of the signals, for :meth:`postpone`."""
        wanted = set(names)
        carrying = (any(carried.name in wanted for carried in carrier.carried) for carrier in self._carriers)
        return np.array([row for row, carries in enumerate(carrying) if carries], np.int64)

    def rows_of_all_but(self, rows: NDArray[np.int64]) -> NDArray[np.int64]:
        """Rows of all other messages."""
        return np.setdiff1d(np.arange(len(self._carriers)), rows)

    def postpone(self, rows: NDArray[np.int64], tick: int) -> None:
        """Leave messages out in a tick; they are sent again at their next regular tick. The alive counter goes on."""
        messages = self._messages
        for row in rows:
            period, offset = messages[row, PERIOD], messages[row, OFFSET]
            if tick >= messages[row, NEXT_DUE]:
                messages[row, COUNTER] = (messages[row, COUNTER] + 1) & 15
            messages[row, NEXT_DUE] = tick + 1 + (offset - tick - 1) % period

    def due(self, tick: int, frames: NDArray[np.void], start: int = 0) -> int:
        """Pack the frames that are due in a tick into ``frames[start:]``; returns their number.

        A message whose tick was skipped is sent at the next call, then again at its regular ticks.
        """
        count: int = _transmit(self.address, self._memory.frames_at(frames), start, tick)
        return count


class Receiver:
    """Takes in frames, checks them and decodes the good ones; made by :meth:`Codec.receiver`.

    Attributes
    ----------
    address : int
        Of the memory that ``kernels.receive`` works on, for compiled callers.
    """

    def __init__(
        self,
        carriers: Sequence[Carrier],
        values: NDArray[np.float64],
        ages: NDArray[np.float64],
        channel: int | None,
        protection: Protection,
        notes_lateness: bool,
    ) -> None:
        self._notes_lateness = notes_lateness
        self._carriers = by_identifier(carriers)
        self._tables = tables = build_tables(carriers)
        tables.messages[:, PROTECTED] = np.minimum(tables.messages[:, PROTECTED], CHECKS[protection])
        self._values = values
        self._groups = groups = self._age_groups()
        self._memory = _Memory(tables, values, -1 if channel is None else channel, groups, ages)
        self.address = self._memory.address
        self.reset()

    def _age_groups(self) -> NDArray[np.int64]:
        rows = [[0] * (len(self._carriers) + 1)]
        for group, signals in AGE_GROUPS.items():
            members = [int(any(carried.name in signals for carried in c.carried)) for c in self._carriers]
            if any(members):
                rows.append([AGE_NAMES.index(group), *members])
        return np.array(rows, np.int64)

    def reset(self) -> None:
        """Forget everything received: start values, no counter expected, statistics at zero."""
        tables = self._tables
        tables.messages[:, LAST_COUNTER:] = 0
        tables.messages[:, LAST_COUNTER] = -1
        tables.messages[:, LAST_TICK] = -NEVER_TICKS
        tables.messages[:, EXPECTED] = 0 if self._notes_lateness else -1
        self._groups[0, 0] = 0
        for carrier, row in zip(self._carriers, tables.messages, strict=True):
            data = np.zeros(64, np.uint8)
            data[: carrier.message.length] = np.frombuffer(carrier.message.start_payload, np.uint8)
            unpack(data, row, tables.signals, self._values)
        self.accept(new_frames(1), 0, 0)

    def accept(self, frames: NDArray[np.void], count: int, tick: int) -> int:
        """Decode the first ``count`` frames, update the ages; returns the number of frames accepted.

        Call it in every tick, also with no frames, so that the ages grow. A frame with a wrong length, CRC or counter
        changes nothing but the statistics: neither the values, nor the ages, nor the counter that is expected next.
        """
        accepted: int = _receive(self.address, self._memory.frames_at(frames), count, tick)
        return accepted

    def statistics(self) -> dict[str, dict[str, int]]:
        """Counts of each message by name: accepted, crc_errors, repeated, lost, wrong_sequence, wrong_length."""
        return {
            carrier.message.name: dict(zip(STATISTICS, (int(value) for value in row[ACCEPTED:EXPECTED]), strict=True))
            for carrier, row in zip(self._carriers, self._tables.messages, strict=True)
        }

    @property
    def unknown_frames(self) -> int:
        """Data frames whose identifier is none of the messages listened to."""
        return int(self._groups[0, 0])

    @property
    def rejected_frames(self) -> int:
        """Frames of a known identifier that were refused, for whatever reason."""
        return int(self._tables.messages[:, (CRC_ERRORS, REPEATED, WRONG_SEQUENCE, WRONG_LENGTH)].sum())

    @property
    def messages(self) -> NDArray[np.int64]:
        """Live table of the messages listened to, columns of ``bench.codec.tables``; not to be written."""
        return self._tables.messages

    def row_of(self, signal: str) -> int:
        """Row in ``messages`` of the message that carries a signal, −1 if none does."""
        rows = (n for n, c in enumerate(self._carriers) if any(carried.name == signal for carried in c.carried))
        return next(rows, -1)
