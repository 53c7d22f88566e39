"""A CAN bus in time: nodes with bit timing in quanta, oscillators and delays, which (re)synchronise on edges."""

import math
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from can_fault_injector import bus_kernel as kernel
from can_fault_injector import node_state as ns
from can_fault_injector import timed_kernel as timed
from can_fault_injector.bus import Bus
from can_fault_injector.bus_records import Node
from can_fault_injector.disturbance import Disturbance

_FS_PER_S = 10**15
_FS_PER_NS = 10**6
_SAMPLES_PER_RUN = 65_536


@dataclass(frozen=True)
class BitTiming:
    """Segments of a bit in time quanta; the synchronisation segment before them is one quantum.

    Parameters
    ----------
    propagation, phase_1, phase_2 : int
        Propagation segment and the phase segments before and after the sample point.
    jump_width : int
        Quanta by which a resynchronisation may move a node (SJW), at most ``phase_2``.
    """

    propagation: int = 7
    phase_1: int = 7
    phase_2: int = 5
    jump_width: int = 4

    def __post_init__(self) -> None:
        if min(self.phase_1, self.phase_2) < 1 or self.propagation < 0:
            raise ValueError("bit timing: phase segments are at least 1 quantum, the propagation segment at least 0")
        if not 1 <= self.jump_width <= min(self.phase_1, self.phase_2):
            raise ValueError(
                f"jump_width: found {self.jump_width}, allowed: 1 to the shorter phase segment, "
                f"{min(self.phase_1, self.phase_2)} quanta"
            )

    @property
    def quanta(self) -> int:
        """Quanta of a bit."""
        return 1 + self.propagation + self.phase_1 + self.phase_2

    @property
    def sample_point(self) -> float:
        """Instant of the sample in the bit, 0 to 1."""
        return (self.quanta - self.phase_2) / self.quanta


@dataclass(frozen=True)
class TimedNode:
    """A protocol node and its timing.

    Parameters
    ----------
    node : Node
        Its protocol settings; the sample point is that of ``timing``.
    timing, data_timing : BitTiming
        Of the arbitration and of the data phase (by default the same).
    delay_ns : float
        Between controller and bus, each way: transceiver, line, in-line device.
    clock_ppm : float
        Deviation of the oscillator; positive is slow (long bits).
    phase : float
        Share of its bit that has passed for the node at the beginning, 0 to 1.
    """

    node: Node
    timing: BitTiming = BitTiming()
    data_timing: BitTiming | None = None
    delay_ns: float = 0.0
    clock_ppm: float = 0.0
    phase: float = 0.0


class Sample(NamedTuple):
    """A node's sample: instant in ns, level, counters after it."""

    time_ns: float
    node: str
    level: int
    transmit_errors: int
    receive_errors: int


class TimedBus(Bus):
    """Protocol nodes that each have their own time.

    Parameters
    ----------
    nodes : sequence of TimedNode
    bit_rate, data_bit_rate : float [bit/s]

    Attributes
    ----------
    samples : list of Sample
        Every sample of every node so far, in order.

    Notes
    -----
    The number of a bit, of events and of disturbances that begin at one, is the time over the nominal bit time. A
    disturbance at a place begins with that bit of the node that sends the frame (or of its ``reference``), ``begin``
    and ``width`` are shares of that node's bit. Senders have no second sample point in the data phase: their delay both
    ways has to be shorter than their sample point there.
    """

    def __init__(self, nodes: Sequence[TimedNode], bit_rate: float = 500e3, *, data_bit_rate: float | None = None):
        super().__init__([item.node for item in nodes], bit_rate, data_bit_rate=data_bit_rate, trace=False)
        self._bit_time = round(_FS_PER_S / bit_rate)
        self._timing = np.zeros((len(nodes), timed.TIMING_COLUMNS), np.int64)
        for row, item in zip(self._timing, nodes, strict=True):
            self._set_timing(row, item, bit_rate, data_bit_rate or bit_rate)
        self._times = np.zeros((len(nodes), timed.HISTORY), np.int64)
        self._levels_driven = np.ones((len(nodes), timed.HISTORY), np.uint8)
        self._changes = np.zeros(len(nodes), np.int64)
        self._windows = np.zeros((0, timed.WINDOWS), np.int64)
        self._driven_unit = self._bit_time
        self._now = 0
        self.samples: list[Sample] = []

    @staticmethod
    def _set_timing(row: NDArray[np.int64], item: TimedNode, bit_rate: float, data_bit_rate: float) -> None:
        slow = 1.0 + item.clock_ppm * 1e-6
        nominal, fast = item.timing, item.data_timing or item.timing
        row[timed.T_QUANTUM] = round(_FS_PER_S / bit_rate / nominal.quanta * slow)
        row[timed.T_SEGMENT_1] = nominal.propagation + nominal.phase_1
        row[timed.T_SEGMENT_2], row[timed.T_JUMP] = nominal.phase_2, nominal.jump_width
        row[timed.T_DATA_QUANTUM] = round(_FS_PER_S / data_bit_rate / fast.quanta * slow)
        row[timed.T_DATA_SEGMENT_1] = fast.propagation + fast.phase_1
        row[timed.T_DATA_SEGMENT_2], row[timed.T_DATA_JUMP] = fast.phase_2, fast.jump_width
        row[timed.T_DELAY] = round(item.delay_ns * _FS_PER_NS)
        row[timed.T_LENGTH_1], row[timed.T_LENGTH_2] = row[timed.T_SEGMENT_1], row[timed.T_SEGMENT_2]
        row[timed.T_SAMPLED] = row[timed.T_SEEN] = row[timed.T_LEVEL] = 1
        passed = item.phase * nominal.quanta
        row[timed.T_AT] = math.ceil(passed)
        row[timed.T_NEXT] = round((math.ceil(passed) - passed) * row[timed.T_QUANTUM])

    @property
    def time_s(self) -> float:
        """Time run so far."""
        return self._now / _FS_PER_S

    @property
    def bit(self) -> int:
        """Nominal bit times run so far."""
        return self._now // self._bit_time

    def disturb(self, disturbance: Disturbance) -> int:
        """Arm a disturbance; returns its number for `hits`."""
        number = super().disturb(disturbance)
        self._windows = np.vstack([self._windows, np.zeros((1, timed.WINDOWS), np.int64)])
        row = self._disturbances[number]
        if row[kernel.D_TRIGGER] == kernel.AT_BIT:
            start = int(row[kernel.D_START]) * self._bit_time
            end = row[kernel.D_END] or kernel.WHOLE_BIT
            self._windows[number, 0] = start + self._bit_time * row[kernel.D_BEGIN] // kernel.WHOLE_BIT
            length = (row[kernel.D_LENGTH] - 1) * kernel.WHOLE_BIT + end
            self._windows[number, 1] = start + self._bit_time * length // kernel.WHOLE_BIT
        return number

    def withdraw(self, number: int) -> None:
        """End a disturbance, now and for good."""
        super().withdraw(number)
        self._windows[number] = 0

    def forget(self) -> None:
        """Drop what has piled up, the samples too; see `Bus.forget`."""
        super().forget()
        self._windows = self._windows[:0]
        self.samples.clear()

    def drive(self, levels: Iterable[int], start: int | None = None, unit: float = 1.0) -> None:
        """Put levels on the bus from a bit on (default: now), each for ``unit`` nominal bit times."""
        super().drive(levels, start)
        self._driven_unit = round(unit * self._bit_time)

    def _idle(self) -> bool:
        waiting = self._states[:, ns.QUEUE_TAIL] != self._states[:, ns.QUEUE_HEAD]
        driving = self._now < self._driven_start * self._bit_time + self._driven.size * self._driven_unit
        return not (driving or waiting.any() or (self._states[:, ns.PHASE] != ns.IDLE).any())

    def _run(self, bits: int, until_idle: bool) -> int:
        """Run whole nominal bits; with ``until_idle`` a frame's length at a time."""
        begin = self.bit
        step = min(bits, 16 if until_idle else bits)
        until = self._now + step * self._bit_time
        while self._now < until:
            samples = np.zeros((_SAMPLES_PER_RUN, timed.SAMPLE_COLUMNS), np.int64)
            count = timed.run_quanta(
                until,
                self._bit_time,
                self._states,
                self._timing,
                self._times,
                self._levels_driven,
                self._changes,
                self._data,
                self._queues,
                self._table.passive_rows,
                self._table.bits,
                self._table.codes,
                self._table.numbers,
                self._table.extended,
                self._table.identifiers,
                self._disturbances,
                self._windows,
                self._wiring,
                self._driven,
                self._driven_start * self._bit_time,
                self._driven_unit,
                self._events,
                self._received,
                self._payloads,
                self._counters,
                samples,
            )
            self.samples += [Sample(t / _FS_PER_NS, self.names[j], *rest) for t, j, *rest in samples[:count].tolist()]
            self._drain()
            self._now = min(until, int(self._timing[:, timed.T_NEXT].min()))
        return self.bit - begin
