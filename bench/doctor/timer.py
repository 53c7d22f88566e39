"""How late this machine wakes a process that sleeps to a deadline."""

import ctypes
import time
from collections.abc import Iterator

from bench.doctor.finding import Finding

PERIOD_NS = 1_000_000
TICKS = 1000
_PR_SET_TIMERSLACK = 29
_GOOD_P99_US = 200.0


def findings() -> Iterator[Finding]:
    """Timer quality."""
    yield timer()


def lateness_us(ticks: int = TICKS) -> list[float]:
    """Lateness of each of ``ticks`` wake-ups at 1 kHz, sorted."""
    # without any right a process may ask for exact timers; the kernel's default is 50 us of slack
    ctypes.CDLL(None).prctl(_PR_SET_TIMERSLACK, 1, 0, 0, 0)
    start = time.perf_counter_ns() + PERIOD_NS
    late = []
    for tick in range(ticks):
        deadline = start + tick * PERIOD_NS
        ahead = deadline - time.perf_counter_ns()
        if ahead > 0:
            time.sleep(ahead * 1e-9)
        late.append((time.perf_counter_ns() - deadline) * 1e-3)
    return sorted(late)


def timer() -> Finding:
    """One second of wake-ups."""
    late = lateness_us()
    p99, p999 = late[int(0.99 * len(late))], late[int(0.999 * len(late))]
    text = f"timer: p99 {p99:.0f} us, p99.9 {p999:.0f} us (1 s, sleep only)"
    if p99 > _GOOD_P99_US:
        return Finding("timer", "warn", text, "end other programs; allow SCHED_FIFO; see the lines above")
    return Finding("timer", "ok", text)
