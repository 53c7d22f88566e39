"""Real-time loop at 1 kHz with recording and dashboard open, two loops without a bench alternated with it.

python -m benchmarks.real_time_lateness [--seconds 60] [--slice 5] [--no-fifo]
Goals: p99 lateness at most 20 us with SCHED_FIFO and 200 us without rights; no tick late by the bench's own doing;
processor time of a tick p50 at most 150 us, p99 at most 350 us. What the empty loop suffers is the machine's. So is
what the constant loop suffers, whose every tick is the same arithmetic for as long as the bench's median tick: where a
hypervisor takes the core away within a tick, the kernel books that as the tick's own processor time, and the ticks
that this loop counts as "ours" say how many of the bench's are the machine's. A second witness: every slice is the same
stop with the same seed, so work that takes too long does so at the same tick of another slice too. Ticks that were late
by their own processor time in one slice only are not the bench's work. Beside them stands the time that the hypervisor
itself says it stole from the loop's core.
"""

import argparse
import os
import tempfile
import time
from pathlib import Path

import numpy as np
import psutil
from numba import njit

from bench.loop.pacing import RealtimePacer, TickTimes
from bench.loop.runs import run_recorded
from bench.loop.scheduling import plan_cores, real_time_process
from bench.loop.timing import late_ticks, summarise
from bench.scenario.resolution import resolve

SCENARIO = "stops/ice"
"""A stop that lasts longer than any slice."""


@njit(cache=True)
def arithmetic(rounds: int) -> float:
    """The same additions each time."""
    total = 0.0
    for n in range(rounds):
        total += 1.0 / (n + 1.0)
    return total


def rounds_per_us() -> float:
    """Speed of the arithmetic where nothing disturbs it: the best of many short trials."""
    arithmetic(1)
    best = np.inf
    for _ in range(200):
        begin = time.perf_counter_ns()
        arithmetic(100_000)
        best = min(best, time.perf_counter_ns() - begin)
    return 1e8 / best


def bare_loop(seconds: float, fifo: bool, rounds: int) -> TickTimes:
    """What the machine does to a loop whose ticks are all alike: so many rounds of arithmetic, or nothing."""
    ticks = round(seconds * 1000)
    pacer = RealtimePacer(ticks)
    with real_time_process(plan_cores(), fifo=fifo):
        pacer.start()
        for n in range(ticks):
            pacer.wait(n)
            if rounds:
                arithmetic(rounds)
            pacer.done(n)
    return pacer.times


def joined(parts: list[TickTimes]) -> TickTimes:
    """Times of several slices as one."""
    return TickTimes(
        np.concatenate([p.lateness_ns[: p.count] for p in parts]),
        np.concatenate([p.duration_ns[: p.count] for p in parts]),
        np.concatenate([p.cpu_ns[: p.count] for p in parts]),
        sum(p.count for p in parts),
        sum(p.skipped for p in parts),
        sum(p.overruns for p in parts),
    )


def repeated(parts: list[TickTimes]) -> list[int]:
    """Ticks that were late by the bench's own processor time in at least two slices of the same stop."""
    count = min(part.count for part in parts)
    slices = np.sum([late_ticks(part)[1][:count] for part in parts], axis=0)
    return [int(tick) for tick in np.flatnonzero(slices >= 2)]


def stolen_s() -> float:
    """Time that the hypervisor took from the loop's cores so far, as it reports it."""
    cores = psutil.cpu_times(percpu=True)
    return float(sum(getattr(cores[core], "steal", 0.0) for core in plan_cores().loop))


def show(name: str, times: TickTimes) -> None:
    """One line for people."""
    s = summarise(times)
    late, cpu = s["lateness_us"], s["tick_cpu_us"]
    print(
        f"{name:9s} {times.count} ticks  lateness us p50 {late['p50']:.1f}  p99 {late['p99']:.1f}  "
        f"p99.9 {late['p999']:.1f}  max {late['max']:.0f}  late {s['late_ticks']} (ours {s['late_ticks_ours']}, "
        f"machine {s['late_ticks_machine']})  skipped {s['skipped_ticks']}  "
        f"cpu us p50 {cpu['p50']:.0f}  p99 {cpu['p99']:.0f}"
    )


def alternate(folder: Path, slices: int, slice_s: float, *, fifo: bool, dashboard: bool) -> dict[str, list[TickTimes]]:
    """Slices of the bench, of the constant and of the empty loop in turn; the times of each slice."""
    bench_times: list[TickTimes] = []
    constant_times: list[TickTimes] = []
    empty_times: list[TickTimes] = []
    speed = rounds_per_us()
    scenario = resolve(SCENARIO, {"pacing": "realtime", "time_limit": slice_s})
    for n in range(slices):
        run = run_recorded(scenario, folder / f"slice{n}", dashboard=dashboard, fifo=fifo, times=bench_times)
        if run.verdict.errors:
            raise SystemExit(f"the run failed: {run.verdict.errors}")
        median_us = summarise(joined(bench_times))["tick_cpu_us"]["p50"]
        constant_times.append(bare_loop(slice_s, fifo, round(median_us * speed)))
        empty_times.append(bare_loop(slice_s, fifo, 0))
    return {"bench": bench_times, "constant": constant_times, "empty": empty_times}


def main() -> None:
    """Alternate slices of the three loops, then print their times."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--seconds", type=float, default=60.0)
    parser.add_argument("--slice", type=float, default=5.0)
    parser.add_argument("--no-fifo", action="store_true", help="measure as a user without rights")
    parser.add_argument("--no-dashboard", action="store_true")
    arguments = parser.parse_args()
    slices = max(1, round(arguments.seconds / arguments.slice))
    stolen_before = stolen_s()
    with tempfile.TemporaryDirectory() as folder:
        measured = alternate(
            Path(folder),
            slices,
            arguments.slice,
            fifo=not arguments.no_fifo,
            dashboard=not arguments.no_dashboard,
        )
    print(f"cores {sorted(os.sched_getaffinity(0))}, loop on {sorted(plan_cores().loop)}")
    for name, parts in measured.items():
        show(name, joined(parts))
    print(
        "ticks late by the bench's own processor time in more than one slice: "
        f"{repeated(measured['bench']) or 'none'}; stolen from the loop's core: {stolen_s() - stolen_before:.2f} s"
    )


if __name__ == "__main__":
    main()
