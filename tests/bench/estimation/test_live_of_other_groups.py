"""Observers of loads, axle forces and attitude, and all estimators at once: offline they give what they gave live."""

from pathlib import Path
from typing import Any

import numpy as np
import pytest

import bench
from bench.estimation.groups import GROUPS
from bench.estimation.offline import requests_of, run_offline
from bench.estimation.source import open_source
from estimators import names
from vehicle_model.vehicle_file import load_vehicle


@pytest.mark.parametrize(
    ("group", "scenario", "sets"),
    [
        ("load", "state/vertical_load_lane_change", {"manoeuvre.steps.straight.until": {"time": 0.2}}),
        ("force", "state/neural_force_slalom", {}),
        ("attitude", "state/attitude_slalom", {"manoeuvre.steps.straight.until": {"time": 0.2}}),
    ],
)
def test_an_offline_estimate_of_a_recording_is_the_live_one(
    group: str, scenario: str, sets: dict[str, Any], tmp_path: Path
) -> None:
    """All settings that the comparison of the group knows, on the first second of a steered car."""
    estimators = {name: dict(keys) for name, keys in GROUPS[group].variants.items()}
    sets = {**sets, "estimators": estimators, "criteria": [], "time_limit": 1.2}
    run = bench.run(scenario, sets=sets, pacing="lockstep", out=tmp_path / "run")
    assert run.folder is not None
    source = open_source(run.folder)
    requests = requests_of([], {}, source)
    assert {request.name for request in requests} >= set(GROUPS[group].variants)
    for estimate in run_offline(source, load_vehicle(source.vehicle).numbers(), requests):
        assert len(estimate.time) == len(source.data)
        moves = np.ptp(estimate.values[len(estimate.values) // 2 :], axis=0)
        still = estimate.name == "vertical_load_static"
        assert still or np.count_nonzero(moves) >= 3, f"{estimate.name} does not move"
        for k, signal in enumerate(estimate.outputs):
            live = source.data.array(signal.name)
            assert np.array_equal(estimate.values[:, k], live, equal_nan=True), signal.name


def test_all_estimators_run_at_once_in_one_stop(tmp_path: Path) -> None:
    """Every estimator of the registry live on one car, under ABS: finite, running, and offline the same bit for bit."""
    sets = {
        "vehicle": "lada_vesta_assumed_steering",
        "ecu.kind": "inprocess",
        "estimators": {name: {} for name in names()},
        "criteria": [],
        "time_limit": 3.0,
    }
    run = bench.run("stops/dry", sets=sets, pacing="lockstep", out=tmp_path / "run")
    assert run.folder is not None
    source = open_source(run.folder)
    estimates = run_offline(source, load_vehicle(source.vehicle).numbers(), requests_of([], {}, source))
    assert {estimate.name for estimate in estimates} == set(names())
    for estimate in estimates:
        live = np.stack([source.data.array(signal.name) for signal in estimate.outputs], axis=1)
        assert np.array_equal(estimate.values, live), estimate.name
        assert np.isfinite(live).all(), estimate.name
        outputs = [signal.name.partition(".")[2] for signal in estimate.outputs]
        if "active" in outputs:
            assert live[-1, outputs.index("active")] == 1.0, estimate.name
