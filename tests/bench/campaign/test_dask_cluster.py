"""A campaign on a real dask.distributed scheduler with two worker processes, one of which is killed on the way."""

import json
import os
import signal
import subprocess
import sys
import threading
import time
from collections.abc import Iterator
from pathlib import Path

import psutil
import pytest

from bench.campaign.engine import CampaignRun, Progress, read_campaign
from bench.campaign.store import read_rows
from bench.execution.executors import DaskCluster
from signals.errors import RunError

distributed = pytest.importorskip("distributed", reason="dask.distributed is not installed (pip install distributed)")

SMALL = Path(__file__).parent / "small.yaml"
START_S = 120.0


@pytest.fixture
def cluster(tmp_path: Path) -> Iterator[tuple[str, list["subprocess.Popen[bytes]"]]]:
    """Address of a scheduler, and its two workers."""
    file = tmp_path / "scheduler.json"
    quiet = {"stdout": subprocess.DEVNULL, "stderr": subprocess.DEVNULL}
    module = [sys.executable, "-m", "distributed.cli.dask_scheduler", "--port", "0", "--no-dashboard"]
    workers: list[subprocess.Popen[bytes]] = []
    scheduler = subprocess.Popen([*module, "--host", "127.0.0.1", "--scheduler-file", str(file)], **quiet)
    try:
        deadline = time.monotonic() + START_S
        while not file.exists() or not file.read_text():
            assert time.monotonic() < deadline, "the scheduler does not start"
            time.sleep(0.05)
        options = ["--scheduler-file", str(file), "--nthreads", "1", "--no-dashboard"]
        worker = [sys.executable, "-m", "distributed.cli.dask_worker", *options, "--local-directory", str(tmp_path)]
        workers = [subprocess.Popen(worker, **quiet) for _ in range(2)]
        address = json.loads(file.read_text())["address"]
        with distributed.Client(address, set_as_default=False) as client:
            client.wait_for_workers(2, timeout=START_S)
        yield address, workers
    finally:
        for process in (scheduler, *workers):
            for child in psutil.Process(process.pid).children(recursive=True) if process.poll() is None else []:
                child.kill()
            process.kill()
            process.wait()


def results(folder: Path) -> dict[str, tuple[str, str]]:
    return {row["key"]: (row["motion"], row["outcome"]) for row in read_rows(folder)}


def test_a_cluster_makes_the_same_runs_even_if_a_worker_is_killed(
    cluster: tuple[str, list["subprocess.Popen[bytes]"]], tmp_path: Path
) -> None:
    address, workers = cluster
    killed = threading.Event()

    def kill_one(progress: Progress) -> None:
        if progress.made == 3 and not killed.is_set():
            killed.set()
            nannies = psutil.Process(workers[0].pid).children(recursive=True)
            os.kill((nannies or [psutil.Process(workers[0].pid)])[-1].pid, signal.SIGKILL)

    campaign = read_campaign(SMALL)
    progress = CampaignRun(campaign, SMALL, tmp_path / "dask", kill_one).run(scheduler=address)
    assert killed.is_set()
    assert (progress.made, progress.lost) == (10, 0)
    CampaignRun(campaign, SMALL, tmp_path / "local").run(workers=1)
    assert results(tmp_path / "dask") == results(tmp_path / "local")


def test_no_scheduler_is_one_clear_message() -> None:
    with pytest.raises(RunError, match=r"no scheduler at tcp://127\.0\.0\.1:9"):
        DaskCluster("tcp://127.0.0.1:9", timeout_s=1.0)
