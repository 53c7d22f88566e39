"""Timing block of the verdict: what the pacer measured, in the words of ``verdict.json``."""

from typing import Any

import numpy as np
from numpy.typing import NDArray

from bench.loop.pacing import PERIOD_NS, TickTimes

LATE_NS = PERIOD_NS


def percentiles_us(values_ns: NDArray[np.int64]) -> dict[str, float]:
    """p50, p99, p99.9 and the largest of times given in ns, in µs."""
    if values_ns.size == 0:
        return {"p50": 0.0, "p99": 0.0, "p999": 0.0, "max": 0.0}
    p50, p99, p999 = np.percentile(values_ns, [50, 99, 99.9]) / 1e3
    return {"p50": float(p50), "p99": float(p99), "p999": float(p999), "max": float(values_ns.max() / 1e3)}


def late_ticks(times: TickTimes) -> tuple[NDArray[np.bool_], NDArray[np.bool_]]:
    """Ticks (n,) that were late, and those of them that were late by the bench's own processor time.

    A tick is late if it began more than one period after its deadline. It is late by our doing if the processor time of
    the tick before it was longer than the period, or if it carried such a tick's delay over.
    """
    n = times.count
    late = times.lateness_ns[:n] > LATE_NS
    ours = np.zeros(n, np.bool_)
    for tick in np.flatnonzero(late[1:]) + 1:
        ours[tick] = ours[tick - 1] or times.cpu_ns[tick - 1] > PERIOD_NS
    return late, ours


def summarise(times: TickTimes) -> dict[str, Any]:
    """Lateness, processor time, late ticks split into ours and the machine's, skipped ticks."""
    n = times.count
    lateness, cpu = times.lateness_ns[:n], times.cpu_ns[:n]
    late, ours = late_ticks(times)
    return {
        "lateness_us": percentiles_us(lateness),
        "tick_cpu_us": percentiles_us(cpu),
        "tick_duration_us": percentiles_us(times.duration_ns[:n]),
        "late_ticks": int(late.sum()),
        "late_ticks_ours": int(ours.sum()),
        "late_ticks_machine": int(late.sum() - ours.sum()),
        "overruns": times.overruns,
        "skipped_ticks": times.skipped,
    }
