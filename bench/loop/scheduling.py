"""Rights and settings of the process that owns the tick: scheduling class, cores, memory, garbage collector.

Each step is tried and its outcome reported; none is needed for a run to be right, only for it to be on time.
"""

import ctypes
import gc
import os
import resource
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass, field

FIFO_PRIORITY = 60
PR_SET_TIMERSLACK = 29
PR_SET_PDEATHSIG = 1
MCL_CURRENT, MCL_FUTURE = 1, 2

_libc = ctypes.CDLL(None, use_errno=True)


@dataclass(frozen=True)
class CorePlan:
    """Cores of the loop and of every other process of a run.

    With one allowed core both sets are that core, and the verdict carries a remark.
    """

    loop: frozenset[int]
    helpers: frozenset[int]

    @property
    def shared(self) -> bool:
        """True if loop and helpers have to share a core."""
        return bool(self.loop & self.helpers)


def plan_cores(allowed: set[int] | None = None) -> CorePlan:
    """Loop alone on the last allowed core, everything else on the others."""
    cores = sorted(os.sched_getaffinity(0) if allowed is None else allowed)
    if len(cores) == 1:
        return CorePlan(frozenset(cores), frozenset(cores))
    return CorePlan(frozenset(cores[-1:]), frozenset(cores[:-1]))


@dataclass
class SchedulingReport:
    """What the process got, for the verdict's timing block."""

    scheduler: str = "other"
    memory_locked: bool = False
    timer_slack_ns: int | None = None
    cores: list[int] = field(default_factory=list)
    remarks: list[str] = field(default_factory=list)


def _try_fifo(report: SchedulingReport, wanted: bool) -> None:
    try:
        if not wanted:
            raise PermissionError
        os.sched_setscheduler(0, os.SCHED_FIFO | os.SCHED_RESET_ON_FORK, os.sched_param(FIFO_PRIORITY))
        report.scheduler = f"fifo {FIFO_PRIORITY}"
    except PermissionError:
        if _libc.prctl(PR_SET_TIMERSLACK, 1, 0, 0, 0) == 0:
            report.timer_slack_ns = 1
        if wanted:
            report.remarks.append(
                "SCHED_FIFO not allowed, timer slack 1 ns instead: bench doctor names the missing right"
            )


def _try_lock_memory(report: SchedulingReport) -> None:
    limit, _ = resource.getrlimit(resource.RLIMIT_MEMLOCK)
    if limit != resource.RLIM_INFINITY and os.geteuid() != 0:
        # with a small limit MCL_FUTURE makes later allocations fail, which is worse than a page fault
        report.remarks.append("memory not locked: the memlock limit is finite")
        return
    report.memory_locked = _libc.mlockall(MCL_CURRENT | MCL_FUTURE) == 0
    if not report.memory_locked:
        report.remarks.append("memory not locked: mlockall was refused")


@contextmanager
def real_time_process(plan: CorePlan, *, fifo: bool = True) -> Iterator[SchedulingReport]:
    """Give the calling process what a 1 kHz loop wants and take it back at the end.

    Parameters
    ----------
    fifo : bool
        False does without SCHED_FIFO, as a user without the right has to.
    """
    report = SchedulingReport()
    affinity_before = os.sched_getaffinity(0)
    os.sched_setaffinity(0, plan.loop)
    report.cores = sorted(plan.loop)
    if plan.shared:
        report.remarks.append("one core only: loop and helper processes share it")
    _try_fifo(report, fifo)
    _try_lock_memory(report)
    gc.collect()
    gc.freeze()
    gc.disable()
    try:
        yield report
    finally:
        gc.enable()
        gc.unfreeze()
        if report.memory_locked:
            _libc.munlockall()
        if report.scheduler.startswith("fifo"):
            os.sched_setscheduler(0, os.SCHED_OTHER, os.sched_param(0))
        os.sched_setaffinity(0, affinity_before)


def die_with_parent(signal_number: int) -> None:
    """Ask the kernel to signal this process when its parent ends, so that no helper outlives a run."""
    _libc.prctl(PR_SET_PDEATHSIG, signal_number, 0, 0, 0)
