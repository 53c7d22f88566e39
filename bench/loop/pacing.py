"""Pacers: when the next tick may start.

Both pacers have the same two methods, so the loop is one piece of code in real time and in lock-step.
"""

import time
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

PERIOD_NS = 1_000_000
CATCH_UP_TICKS = 5
SPIN_FLOOR_NS = 60_000
SPIN_CEILING_NS = 400_000
SPIN_DECAY = 0.999
"""Share of the spin time kept per tick: a wake-up that came late is remembered for about a second."""


@dataclass
class TickTimes:
    """Three numbers per tick, in ns: how late it began, how long it took, its processor time; and what was missed.

    ``overruns`` counts the ticks that ended after the next deadline, ``skipped`` those that were left out. Lateness
    holds the machine's wake-up latency and what an earlier tick carried over; ``cpu_ns`` is the tick's own work, so a
    late end with little processor time is the machine's doing.
    """

    lateness_ns: NDArray[np.int64]
    duration_ns: NDArray[np.int64]
    cpu_ns: NDArray[np.int64]
    count: int = 0
    skipped: int = 0
    overruns: int = 0

    @classmethod
    def for_ticks(cls, ticks: int) -> "TickTimes":
        """Storage for a run of at most ``ticks`` ticks, touched so that no page fault comes later."""
        return cls(np.zeros(ticks, np.int64), np.zeros(ticks, np.int64), np.zeros(ticks, np.int64))


class LockstepPacer:
    """Virtual time: a tick starts as soon as the previous one has ended."""

    mode = "lockstep"

    def __init__(self, ticks: int) -> None:
        self.times = TickTimes.for_ticks(0)

    def prepare(self) -> None:
        """Nothing to measure: nothing ever sleeps."""

    def start(self) -> None:
        """Nothing to anchor: virtual time starts at the first tick."""

    def wait(self, tick: int) -> None:
        """Never waits."""

    def done(self, tick: int) -> None:
        """Nothing to measure: the time of a tick has no meaning in virtual time."""


class RealtimePacer:
    """Absolute deadlines start + n × 1 ms: sleep to shortly before, then spin.

    Late wake-ups come in bursts: after one the loop spins for longer, up to 0.4 ms of each period, and forgets slowly.
    After a stall at most five ticks run back to back; more are skipped: the time base moves, and the skipped ticks are
    counted. Simulated time then stands still for as long as the machine did.
    """

    mode = "realtime"

    def __init__(self, ticks: int) -> None:
        self.times = TickTimes.for_ticks(ticks)
        self._tail_ns = SPIN_CEILING_NS
        self._start_ns = 0
        self._wake_ns = 0
        self._cpu_ns = 0

    def prepare(self) -> None:
        """Measure how late this machine wakes up."""
        self._tail_ns = measure_wake_up_ns()

    def start(self) -> None:
        """Anchor the time base one period ahead."""
        self._start_ns = time.perf_counter_ns() + PERIOD_NS

    def wait(self, tick: int) -> None:
        """Return at the deadline of ``tick``."""
        clock = time.perf_counter_ns
        deadline = self._start_ns + tick * PERIOD_NS
        now = clock()
        behind = now - deadline
        if behind > CATCH_UP_TICKS * PERIOD_NS:
            skip = behind // PERIOD_NS
            self._start_ns += skip * PERIOD_NS
            deadline += skip * PERIOD_NS
            self.times.skipped += int(skip)
        ahead = deadline - now - self._tail_ns
        if ahead > 0:
            time.sleep(ahead * 1e-9)
            intended = now + ahead
            now = clock()
            self._tail_ns = spin_time_ns(self._tail_ns, now - intended)
        while now < deadline:
            now = clock()
        self._wake_ns = now
        self._cpu_ns = time.thread_time_ns()
        self.times.lateness_ns[tick] = now - deadline

    def done(self, tick: int) -> None:
        """Note how long the tick took."""
        times = self.times
        times.cpu_ns[tick] = time.thread_time_ns() - self._cpu_ns
        duration = time.perf_counter_ns() - self._wake_ns
        times.duration_ns[tick] = duration
        times.overruns += bool(times.lateness_ns[tick] + duration > PERIOD_NS)
        times.count = tick + 1


def spin_time_ns(spin_ns: int, wake_up_ns: int) -> int:
    """Spin time of the next tick after a wake-up that came ``wake_up_ns`` late."""
    return int(min(max(wake_up_ns * 5 // 4, spin_ns * SPIN_DECAY, SPIN_FLOOR_NS), SPIN_CEILING_NS))


def measure_wake_up_ns(trials: int = 100) -> int:
    """Spin time that covers the wake-up latency of this machine: its 99 % point, within fixed bounds."""
    late = np.empty(trials, np.int64)
    for i in range(trials):
        before = time.perf_counter_ns()
        time.sleep(300e-6)
        late[i] = time.perf_counter_ns() - before - 300_000
    return int(np.clip(np.percentile(late, 99), SPIN_FLOOR_NS, SPIN_CEILING_NS))
