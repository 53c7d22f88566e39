"""A short stop in memory and as a recording, for offline estimates."""

from pathlib import Path

import pytest

import bench
from bench.estimation.source import Source

STOP = "friction/e10_abs_grip_jump"
SETS = {
    "ecu.kind": "inprocess",
    "initial_speed": "40 km/h",
    "manoeuvre.steps.hold.hold_speed.speed": "40 km/h",
    "manoeuvre.steps.hold.until": {"distance": "4 m"},
    "road.jumps": [],
    "criteria": [],
    "valid_if": [],
}


@pytest.fixture(scope="session")
def stop() -> bench.Run:
    """A stop with the EKF of both signs running live."""
    return bench.run(STOP, sets=SETS, pacing="lockstep", record=False)


@pytest.fixture(scope="session")
def source(stop: bench.Run) -> Source:
    """The stop as what an offline estimate reads."""
    estimators = {name: dict(settings) for name, settings in stop.scenario.estimators.items()}
    return Source(Path("stop"), stop.data, None, "ekf_car", estimators)


@pytest.fixture(scope="session")
def recorded(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Folder of the same stop, recorded."""
    folder = tmp_path_factory.mktemp("runs") / "stop"
    run = bench.run(STOP, sets=SETS, pacing="lockstep", out=folder)
    assert run.folder is not None
    return run.folder
