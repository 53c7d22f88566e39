"""Pool of warm worker processes."""

from collections.abc import Iterable, Iterator
from concurrent.futures import FIRST_COMPLETED, Future, wait
from types import TracebackType

from bench.execution.executors import Executors, LocalProcesses
from bench.execution.job import ERROR, LOST, Job, RunRow, hash_of
from bench.execution.worker import Observe, process_id, run_text
from signals.errors import RunError

_WAITING_PER_WORKER = 2


class WorkerPool:
    """Processes that stay alive and warm from job to job.

    Parameters
    ----------
    workers : int, optional
        By default one per core that this process may use.
    example : Job, optional
        A few ticks of it are run in every worker at its start, so that no job pays for imports and compiling.
    executors : Executors, optional
        Where the jobs run; by default spawned processes of this machine.
    observe : callable, optional
        Makes further plain data of a finished run, for its row; a function of a module.

    Notes
    -----
    Workers are spawned, not forked: a script that makes a pool needs ``if __name__ == "__main__":`` around it.
    """

    def __init__(
        self,
        workers: int | None = None,
        example: Job | None = None,
        *,
        executors: Executors | None = None,
        observe: Observe | None = None,
    ) -> None:
        self._executors = executors or LocalProcesses(workers, "" if example is None else example.scenario)
        self.workers = self._executors.workers
        self._observe = observe
        self._executor = self._executors.new()

    def __enter__(self) -> "WorkerPool":
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        self.close()

    def close(self) -> None:
        """End the workers; jobs that have not begun are dropped."""
        self._executors.end(self._executor)
        self._executors.close()

    def start(self) -> None:
        """Start every worker of this machine now and return when all are warm, so that a clock may be started."""
        seen: set[int] = set()
        while len(seen) < self.workers:
            asked = [self._executor.submit(process_id) for _ in range(self.workers)]
            seen.update(future.result() for future in asked)

    def run(self, jobs: Iterable[Job]) -> Iterator[RunRow]:
        """Rows of all jobs, in the order in which they are done.

        Jobs are taken from ``jobs`` as workers need them, so that an endless source is no problem. If a worker dies,
        the jobs that were on the way are run again one by one; one in which a worker dies again is "lost".
        """
        source = iter(jobs)
        on_the_way: dict[Future[RunRow], Job] = {}
        try:
            while True:
                again = self._fill(on_the_way, source)
                if not on_the_way and not again:
                    return
                done = wait(on_the_way, return_when=FIRST_COMPLETED).done if on_the_way else set()
                for future in done:
                    job = on_the_way.pop(future)
                    row = self._row(future)
                    if row is None:
                        again.append(job)
                    else:
                        yield row
                if again:
                    again += on_the_way.values()
                    on_the_way.clear()
                    yield from self._one_by_one(again)
        finally:
            for future in on_the_way:
                future.cancel()

    def _fill(self, on_the_way: dict[Future[RunRow], Job], source: Iterator[Job]) -> list[Job]:
        """Give the workers jobs up to their limit; returns the job that met a broken pool, if any."""
        while len(on_the_way) < _WAITING_PER_WORKER * self.workers:
            job = next(source, None)
            if job is None:
                return []
            try:
                on_the_way[self._submit(job)] = job
            except self._executors.worker_died:
                return [job]
        return []

    def _one_by_one(self, jobs: list[Job]) -> Iterator[RunRow]:
        self._renew()
        for job in jobs:
            row = self._attempt(job)
            if row is None:
                self._renew()
                row = _lost(job)
            yield row

    def _attempt(self, job: Job) -> RunRow | None:
        try:
            return self._row(self._submit(job))
        except self._executors.worker_died:  # it died before it got the job
            return None

    def _renew(self) -> None:
        self._executors.abandon(self._executor)
        self._executor = self._executors.new()

    def _submit(self, job: Job) -> Future[RunRow]:
        return self._executor.submit(run_text, job.key, job.scenario, job.seed, self._observe)

    def _row(self, future: Future[RunRow]) -> RunRow | None:
        """Row of a finished job, or None if its worker died."""
        try:
            return future.result()
        except self._executors.worker_died:
            return None
        except self._executors.gone as error:
            raise RunError(f"the workers are gone: {type(error).__name__}", mend="run the same command again") from None


def _lost(job: Job) -> RunRow:
    scenario = job.scenario_file()
    return RunRow(
        key=job.key,
        scenario=scenario.id,
        seed=scenario.seed,
        scenario_hash=hash_of(scenario),
        outcome=LOST,
        verdict=ERROR,
        reason="the worker died in this run, twice",
    )
