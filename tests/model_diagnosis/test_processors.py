"""How many threads a diagnosis uses."""

import os

import pytest

from model_diagnosis.processors import threads_here


@pytest.mark.parametrize(
    ("told", "expected"), [("1", 1), ("3", 3), (" 2", None), ("0", None), ("many", None), ("", None)]
)
def test_threads_are_as_many_as_told_or_as_processors(
    monkeypatch: pytest.MonkeyPatch, told: str, expected: int | None
) -> None:
    """What is no number of threads is passed over, as OpenMP passes it over."""
    monkeypatch.setenv("OMP_NUM_THREADS", told)
    assert threads_here() == (expected or len(os.sched_getaffinity(0)))


def test_a_process_that_may_use_one_processor_has_one_thread(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.delenv("OMP_NUM_THREADS", raising=False)
    monkeypatch.setattr(os, "sched_getaffinity", lambda _pid: {0})
    assert threads_here() == 1
