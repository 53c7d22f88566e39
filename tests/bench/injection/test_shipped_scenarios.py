"""The shipped scenarios with faults on the bus meet their criteria in lock-step."""

from pathlib import Path

import pytest

from bench.loop.runs import run_in_memory
from bench.scenario.resolution import resolve
from can_fault_injector.faults.levels import E2E_CLASSES

SCENARIOS = sorted((Path(__file__).resolve().parents[3] / "scenarios/faults").glob("can_*.yaml"))


def test_there_are_enough_of_them_and_they_differ() -> None:
    """At least eight, of different disturbances, standing for at least five classes of the E2E list."""
    models = [fault.disturbance for path in SCENARIOS for fault in resolve(path).faults]
    assert len({model.kind for model in models}) >= 8
    assert len({model.model.e2e for model in models} & set(E2E_CLASSES)) >= 5


@pytest.mark.acceptance("F-37")
@pytest.mark.parametrize("path", SCENARIOS, ids=lambda path: path.stem)
def test_it_passes(path: Path, record) -> None:
    run = run_in_memory(resolve(path), keep_frames=False)
    failed = {c.id: c.value for c in run.verdict.criteria if str(c.verdict) != "pass"}
    assert failed == {}
    speed = next(c.value for c in run.verdict.criteria if c.id == "filter_speed")
    record("speed error of the friction filter while it is sure m/s", speed, "3")
