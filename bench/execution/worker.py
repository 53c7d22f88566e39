"""Inside a worker process: start, then one run after the other."""

import fcntl
import os
import signal
import sys
import threading
import time
from collections.abc import Callable
from multiprocessing import parent_process
from typing import TYPE_CHECKING, Any

from bench.execution.job import DONE, ERROR, Job, RunRow, hash_of, job_of
from signals.compile_cache import compile_folder

if TYPE_CHECKING:
    from bench.api import Run

Observe = Callable[["Run"], dict[str, Any]]

WARM_UP_S = 0.06
_ONE_THREAD = ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS")


def initialise(example: str) -> None:
    """Make a fresh process ready: no interrupts, ends with its parent, code compiled and loaded.

    Parameters
    ----------
    example : str
        Resolved scenario as JSON; a few ticks of it are run so that the first job finds everything loaded. Empty for
        none.
    """
    for name in _ONE_THREAD:  # the pool uses the cores; libraries that start threads of their own only disturb
        os.environ.setdefault(name, "1")
    signal.signal(signal.SIGINT, signal.SIG_IGN)  # Ctrl-C is the business of the process that owns the pool
    threading.Thread(target=_end_with_parent, daemon=True).start()
    if example:
        _warm_up(example)


def _end_with_parent() -> None:
    """A parent that is killed leaves no workers behind; the thread sleeps until then."""
    parent = parent_process()
    if parent is not None:
        parent.join()
        os._exit(1)


def _warm_up(example: str) -> None:
    from bench.loop.warm_up import COMPILING, MARK

    folder = compile_folder()
    folder.mkdir(parents=True, exist_ok=True)
    mark = folder / "workers_compiled.txt"
    with (folder / "workers_compiling.lock").open("w") as lock:
        if not mark.exists():  # one worker compiles, the others wait and load what it compiled
            fcntl.flock(lock, fcntl.LOCK_EX)
            if not (mark.exists() or (folder / MARK).exists()):
                print(f"          {COMPILING}", file=sys.stderr, flush=True)
        scenario = Job("", example).scenario_file()
        # what fails here fails again in the first job, whose row says it
        run_job(job_of(scenario.model_copy(update={"time_limit": WARM_UP_S})))
        mark.touch()


def process_id() -> int:
    """Number of this process, after a moment in which the other workers can take a job of theirs."""
    time.sleep(0.02)
    return os.getpid()


def run_text(key: str, scenario: str, seed: int | None, observe: Observe | None = None) -> RunRow:
    """Run a job that comes as plain texts and numbers, which is all that passes between the processes."""
    return run_job(Job(key, scenario, seed), observe)


def run_job(job: Job, observe: Observe | None = None) -> RunRow:
    """Run a job to its row; an error becomes a row too.

    Parameters
    ----------
    observe : callable, optional
        Makes the row's ``observations`` of the run.
    """
    from bench.loop.runs import run_in_memory
    from bench.verdict.result import plain
    from signals.errors import BenchError

    began = time.perf_counter()
    scenario = job.scenario_file()
    known: dict[str, Any] = {
        "key": job.key,
        "scenario": scenario.id,
        "seed": scenario.seed,
        "scenario_hash": hash_of(scenario),
    }
    try:
        run = run_in_memory(scenario, keep_frames=False)
        observations = plain(observe(run)) if observe is not None else {}
    except BenchError as error:
        return RunRow(**known, outcome=ERROR, verdict=ERROR, reason=str(error), wall_s=time.perf_counter() - began)
    except Exception as error:  # a defect shows in its row instead of ending thousands of other runs
        reason = f"{type(error).__name__}: {error}"
        return RunRow(**known, outcome=ERROR, verdict=ERROR, reason=reason, wall_s=time.perf_counter() - began)
    verdict = run.verdict
    told = ("value", "unit", "limits", "margin", "verdict")
    criteria = {entry.id: {name: entry.as_json()[name] for name in told} for entry in verdict.criteria}
    return RunRow(
        **known,
        outcome=DONE,
        verdict=verdict.verdict,
        criteria=criteria,
        metrics=plain(verdict.metrics),
        observations=observations,
        wall_s=time.perf_counter() - began,
    )
