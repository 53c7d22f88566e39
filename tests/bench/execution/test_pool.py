"""Jobs through real worker processes: same numbers as in this process, errors as rows, dead workers survived."""

import os
import signal
import subprocess
import sys
import threading
from collections.abc import Callable, Iterator
from contextlib import suppress
from pathlib import Path

import psutil
import pytest

from bench.execution import worker
from bench.execution.job import DONE, ERROR, LOST, Job, RunRow, job_of
from bench.execution.pool import WorkerPool
from bench.execution.worker import run_job
from bench.scenario import resolve
from bench.scenario.schema import ScenarioFile

SHORT = Path(__file__).parents[1] / "whole_runs" / "short_stop.yaml"


@pytest.fixture(scope="module")
def short() -> ScenarioFile:
    return resolve(SHORT)


@pytest.fixture(scope="module")
def pool(short: ScenarioFile) -> Iterator[WorkerPool]:
    with WorkerPool(2, job_of(short)) as workers:
        yield workers


def result(row: RunRow) -> dict[str, object]:
    """The row without the time that it took."""
    return {name: value for name, value in row.as_json().items() if name != "wall_s"}


def test_rows_are_those_of_this_process_bit_for_bit(pool: WorkerPool, short: ScenarioFile) -> None:
    jobs = [job_of(short, key=str(seed), seed=seed) for seed in range(5)]
    rows = {row.key: row for row in pool.run(jobs)}
    assert set(rows) == {"0", "1", "2", "3", "4"}
    assert result(rows["3"]) == result(run_job(jobs[3]))
    assert rows["3"].outcome == DONE
    assert rows["3"].seed == 3
    assert len({row.scenario_hash for row in rows.values()}) == 5


def test_workers_that_have_to_compile_say_so_once(
    short: ScenarioFile, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setattr(worker, "compile_folder", lambda: tmp_path)
    monkeypatch.setattr(worker, "run_job", lambda job: None)
    for _ in range(2):
        worker._warm_up(job_of(short).scenario)
    printed = capsys.readouterr()
    assert printed.err.count("compiling the models") == 1
    assert printed.out == ""


def test_a_job_is_forced_into_virtual_time_with_the_controller_in_the_worker(short: ScenarioFile) -> None:
    emulated = short.model_copy(update={"ecu": short.ecu.model_copy(update={"kind": "emulated"}), "pacing": "realtime"})
    as_run = job_of(emulated).scenario_file()
    assert (as_run.ecu.kind, as_run.pacing) == ("inprocess", "lockstep")


def test_an_error_becomes_a_row_and_the_others_go_on(pool: WorkerPool, short: ScenarioFile) -> None:
    no_car = job_of(short.model_copy(update={"vehicle": "no_such_car"}), key="no car")
    rows = {row.key: row for row in pool.run([no_car, job_of(short, key="good")])}
    assert (rows["no car"].outcome, rows["no car"].verdict) == (ERROR, "error")
    assert "no_such_car" in rows["no car"].reason
    assert rows["good"].outcome == DONE


def test_jobs_are_taken_only_as_workers_need_them(pool: WorkerPool, short: ScenarioFile) -> None:
    taken = 0

    def endless() -> Iterator[Job]:
        nonlocal taken
        while True:
            taken += 1
            yield job_of(short, key=str(taken))

    rows = pool.run(endless())
    for _ in range(3):
        assert next(rows).outcome == DONE
    rows.close()  # type: ignore[attr-defined]
    assert taken <= 3 + 4 + 1  # two per worker are on the way


def is_worker(child: psutil.Process) -> bool:
    try:
        return "spawn_main" in " ".join(child.cmdline())
    except psutil.Error:  # it ended since it was listed
        return False


def workers_of_this_process() -> list[psutil.Process]:
    return [child for child in psutil.Process().children() if is_worker(child)]


def kill_workers(stop: Callable[[], bool]) -> None:
    while not stop():
        for child in workers_of_this_process():
            with suppress(psutil.NoSuchProcess):  # it ended since it was listed
                child.send_signal(signal.SIGKILL)
        threading.Event().wait(0.05)


def test_a_job_in_which_the_worker_dies_twice_is_lost_and_the_pool_goes_on(short: ScenarioFile) -> None:
    with WorkerPool(1) as pool:
        over = threading.Event()
        killer = threading.Thread(target=kill_workers, args=(over.is_set,))
        killer.start()
        rows = list(pool.run([job_of(short, key="killed")]))
        over.set()
        killer.join()
        assert [(row.key, row.outcome, row.verdict) for row in rows] == [("killed", LOST, "error")]
        assert [row.outcome for row in pool.run([job_of(short, key="next")])] == [DONE]


def test_a_worker_killed_once_costs_no_row(pool: WorkerPool, short: ScenarioFile) -> None:
    jobs = [job_of(short, key=str(seed), seed=seed) for seed in range(4)]
    rows = pool.run(jobs)
    found = [next(rows)]
    os.kill(workers_of_this_process()[0].pid, signal.SIGKILL)
    found += rows
    assert sorted(row.key for row in found) == ["0", "1", "2", "3"]
    assert all(row.outcome == DONE for row in found)


def test_a_worker_that_heeds_no_signal_does_not_hold_up_those_after_a_killed_one(short: ScenarioFile) -> None:
    """A stopped process leaves SIGTERM pending, as one that the broken pool never sent it to; the pool waits for it."""
    found: list[RunRow] = []
    with WorkerPool(2, job_of(short)) as pool:
        pool.start()
        stopped, killed = workers_of_this_process()[-2:]
        stopped.suspend()
        killed.kill()
        jobs = [job_of(short, key=str(seed), seed=seed) for seed in range(3)]
        running = threading.Thread(target=lambda: found.extend(pool.run(jobs)), daemon=True)
        running.start()
        running.join(120.0)
        is_held_up = running.is_alive()
        with suppress(psutil.NoSuchProcess):
            stopped.kill()  # so that the test ends and fails where it holds up the pool
        running.join()
        assert not is_held_up
    assert sorted((row.key, row.outcome) for row in found) == [("0", DONE), ("1", DONE), ("2", DONE)]


def test_workers_end_with_a_parent_that_is_killed(tmp_path: Path, short: ScenarioFile) -> None:
    script = tmp_path / "endless.py"
    script.write_text(
        "from itertools import count\n"
        "from bench.execution.job import Job\n"
        "from bench.execution.pool import WorkerPool\n"
        "if __name__ == '__main__':\n"
        f"    text = {job_of(short).scenario!r}\n"
        "    with WorkerPool(2) as pool:\n"
        "        for row in pool.run(Job(str(n), text, n) for n in count()):\n"
        "            print(row.key, flush=True)\n"
    )
    environment = {**os.environ, "PYTHONPATH": str(Path(__file__).parents[3])}
    owner = subprocess.Popen([sys.executable, str(script)], stdout=subprocess.PIPE, text=True, env=environment)
    assert owner.stdout is not None
    owner.stdout.readline()  # both are at work
    workers = psutil.Process(owner.pid).children(recursive=True)
    assert len(workers) >= 2
    owner.kill()
    owner.wait()
    gone, alive = psutil.wait_procs(workers, timeout=20.0)
    assert alive == []
    assert len(gone) == len(workers)
