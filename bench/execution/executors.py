"""Where jobs run: processes of this machine, or a cluster of dask.distributed; both as ``concurrent.futures``."""

import os
from concurrent.futures import CancelledError, Executor, ProcessPoolExecutor
from concurrent.futures.process import BrokenProcessPool
from multiprocessing.context import SpawnContext, SpawnProcess
from typing import Any, Protocol

from bench.execution.worker import initialise
from signals.errors import InputError, RunError


class Executors(Protocol):
    """Makes executors, and knows how one tells that a worker died in a job.

    Attributes
    ----------
    workers : int
        Jobs that run at a time.
    worker_died : tuple of exception types
        What a job's future raises if its worker died.
    gone : tuple of exception types
        What it raises if nobody is left to run jobs.
    """

    workers: int
    worker_died: tuple[type[BaseException], ...]
    gone: tuple[type[BaseException], ...]

    def new(self) -> Executor:
        """A fresh executor; an earlier one may have lost its workers."""

    def end(self, executor: Executor) -> None:
        """End an executor; jobs that have not begun are dropped."""

    def abandon(self, executor: Executor) -> None:
        """End an executor in which a worker died; jobs on the way are dropped."""

    def close(self) -> None:
        """Free what outlives the executors."""


class _KnownProcesses(SpawnContext):
    """Spawns processes and keeps them in ``started``."""

    def __init__(self) -> None:
        super().__init__()
        self.started: list[SpawnProcess] = []

    def Process(self, *arguments: Any, **named: Any) -> SpawnProcess:  # type: ignore[override]
        process = SpawnProcess(*arguments, **named)
        self.started.append(process)
        return process


class LocalProcesses:
    """Spawned processes of this machine.

    Parameters
    ----------
    workers : int, optional
        By default one per core that this process may use.
    example : str
        Resolved scenario as JSON, a few ticks of which each worker runs at its start; empty for none.
    """

    worker_died: tuple[type[BaseException], ...] = (BrokenProcessPool,)
    gone: tuple[type[BaseException], ...] = ()

    def __init__(self, workers: int | None = None, example: str = "") -> None:
        self.workers = workers or len(os.sched_getaffinity(0))
        if self.workers < 1:
            raise ValueError(f"found {workers} workers, allowed: at least 1")
        self._example = example
        self._context = _KnownProcesses()

    def new(self) -> Executor:
        """A pool of processes that are made with the first job."""
        self._context = _KnownProcesses()
        return ProcessPoolExecutor(self.workers, self._context, initializer=initialise, initargs=(self._example,))

    def end(self, executor: Executor) -> None:
        """End the processes; jobs that have not begun are dropped."""
        executor.shutdown(wait=True, cancel_futures=True)

    def abandon(self, executor: Executor) -> None:
        """End the processes at once.

        A broken pool of the standard library waits for all of them, but terminates only those it knew when it broke:
        one that was spawned meanwhile may wait for ever on a lock that the dead one held.
        """
        for process in self._context.started:
            if process.pid is not None:
                process.kill()
        executor.shutdown(wait=True, cancel_futures=True)

    def close(self) -> None:
        """Nothing outlives the executors."""


class DaskCluster:
    """Workers of a running dask.distributed scheduler; they need the bench installed, in the same version.

    Parameters
    ----------
    address : str
        Of the scheduler, e.g. ``tcp://10.0.0.5:8786``.
    timeout_s : float
        For the scheduler to answer, and for its first worker.

    Raises
    ------
    InputError
        If dask.distributed is not installed.
    RunError
        If no scheduler answers there, or it has no worker.
    """

    def __init__(self, address: str, timeout_s: float = 30.0) -> None:
        try:
            from distributed import Client
            from distributed.client import FutureCancelledError
            from distributed.scheduler import KilledWorker
        except ImportError:
            raise InputError(
                "--scheduler needs dask.distributed", mend="pip install 'brake-control-bench[distributed]'"
            ) from None
        self.worker_died: tuple[type[BaseException], ...] = (KilledWorker,)
        self.gone: tuple[type[BaseException], ...] = (FutureCancelledError, CancelledError, OSError)
        try:
            self._client: Any = Client(address, timeout=timeout_s, set_as_default=False)
        except (OSError, ValueError) as error:
            raise RunError(
                f"no scheduler at {address}: {error}",
                mend="start one: dask scheduler; workers: dask worker ADDRESS",
            ) from None
        self.workers = self._count_workers(address, timeout_s)

    def _count_workers(self, address: str, timeout_s: float) -> int:
        try:
            self._client.wait_for_workers(1, timeout=timeout_s)
        except TimeoutError:
            self._client.close()
            raise RunError(
                f"the scheduler at {address} has no worker", mend=f"start some: dask worker {address}"
            ) from None
        threads: dict[str, int] = self._client.nthreads()
        return sum(threads.values())

    def new(self) -> Executor:
        """The cluster as an executor; the cluster itself repeats a job whose worker died."""
        executor: Executor = self._client.get_executor(pure=False)
        return executor

    def end(self, executor: Executor) -> None:
        """Drop the jobs; the cluster's workers live on."""
        executor.shutdown(wait=False)

    def abandon(self, executor: Executor) -> None:
        """As ``end``: the scheduler sees to workers that died."""
        self.end(executor)

    def close(self) -> None:
        """Leave the cluster; it goes on running."""
        self._client.close()
