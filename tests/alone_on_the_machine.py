"""Tests against the clock run while no other worker of the same run has a test in progress.

A test marked ``real_time`` starts a loop of 1 kHz in several processes and expects their answers within a second or so.
With a compilation or another bench beside it on the same two cores that fails for want of processor time. Every worker
holds a shared lock during each of its tests; such a test holds it alone.
"""

import fcntl
import os
import tempfile
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

import pytest

MARK = "real_time"


class AloneOnTheMachine:
    """Plugin of one worker of pytest-xdist; ``run_id`` is common to the workers of one run."""

    def __init__(self, run_id: str) -> None:
        self._folder = Path(tempfile.gettempdir())
        self._run_id = run_id

    @pytest.hookimpl(wrapper=True, tryfirst=True)
    def pytest_runtest_protocol(self, item: pytest.Item) -> Iterator[None]:
        exclusive = item.get_closest_marker(MARK) is not None
        # who waits for the lock alone keeps the gate closed, else shared holders could pass it on for ever
        with self._locked("gate", exclusive=True) as gate, self._locked("tests", exclusive=exclusive):
            fcntl.flock(gate, fcntl.LOCK_UN)
            return (yield)

    @contextmanager
    def _locked(self, name: str, *, exclusive: bool) -> Iterator[int]:
        descriptor = os.open(self._folder / f"bench_tests_{self._run_id}_{name}.lock", os.O_CREAT | os.O_RDWR, 0o600)
        try:
            fcntl.flock(descriptor, fcntl.LOCK_EX if exclusive else fcntl.LOCK_SH)
            yield descriptor
        finally:
            os.close(descriptor)

    def pytest_sessionfinish(self) -> None:
        for name in ("gate", "tests"):
            (self._folder / f"bench_tests_{self._run_id}_{name}.lock").unlink(missing_ok=True)
