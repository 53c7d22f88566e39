"""Worker processes of a challenge."""

import subprocess
from pathlib import Path

import pytest

from bench.challenge.answering import in_workers


def test_an_error_is_told_before_all_other_tasks_are_done(tmp_path: Path) -> None:
    """Tasks that a worker has begun or fetched end; the last of eight is none of them."""
    files = [tmp_path / str(number) for number in range(8)]
    tasks = [(["false"],), *((["sh", "-c", f"sleep 0.3; touch {file}"],) for file in files)]
    with pytest.raises(subprocess.CalledProcessError):
        list(in_workers(subprocess.check_call, tasks, 1))
    assert not files[-1].exists()
