"""Observers of vertical loads and axle forces on their documents' cars and the MuJoCo car, from decoded CAN frames."""

from collections.abc import Callable

import numpy as np
import pytest
from conftest import Judge

from bench.estimation.made_runs import make_run
from bench.estimation.offline import Request, run_offline
from vehicle_model.vehicle_file import load_vehicle

NAMES = (
    "vertical_load_lane_change",
    "vertical_load_rough_road",
    "vertical_load_gyro_offset",
    "neural_force_slalom",
    "neural_force_straight",
)


@pytest.mark.parametrize("name", NAMES)
def test_scenario(name: str, judged: Judge) -> None:
    """Every criterion with limits has to pass."""
    for criterion in judged(f"state/{name}").criteria.values():
        limited = any(limit is not None for limit in criterion.limits)
        assert criterion.verdict == "pass" or not limited, f"{criterion.id} = {criterion.value}, {criterion.limits}"


@pytest.mark.acceptance("L-18")
def test_price_of_the_roll_gyroscope_on_an_uneven_road(judged: Judge, record: Callable[..., None]) -> None:
    run = judged("state/vertical_load_gyro_offset")
    for criterion, label, printed in (
        ("set_b", "Q_B", "265 N"),
        ("set_a", "Q_A", "41 N"),
        ("two_sensors", "KF-2", "0"),
    ):
        record(
            f"MuJoCo, uneven: front load moved by 0.005 rad/s, {label}", run.value(criterion), f"{printed} on its car"
        )
    assert run.value("set_a") < 0.3 * run.value("set_b")


@pytest.mark.acceptance("N-15")
def test_front_force_is_flagged_live(judged: Judge, record: Callable[..., None]) -> None:
    run = judged("state/neural_force_straight")
    record("live: confidence in the front force while steering", run.value("confidence_steered"), "at least 0.5")
    record("live: largest confidence from 8 s straight on", run.value("confidence_straight"), "below 0.5")
    record("live: range of the held front force", run.value("held"), "at most 10 N")
    assert run.value("confidence_straight") < 0.5 < run.value("confidence_steered")
    assert run.value("held") < 10.0


def test_on_the_mujoco_car_the_network_learns_the_pull_of_the_cornering_force() -> None:
    """docs/models/neural_force.md: F_yf sin(delta) of tyres that carry is what its model, C_f = 1000 N/rad, lacks."""
    source = make_run("state/neural_force_slalom", {}, plant="mujoco")
    request = Request("observer", "neural_force_observer", {})
    (estimate,) = run_offline(source, load_vehicle(source.vehicle).numbers(), [request])
    names = [signal.name.partition(".")[2] for signal in estimate.outputs]
    found = {name: estimate.values[:, names.index(name)] for name in ("force_total", "lateral_speed")}
    array = source.data.array
    wheels = ("fl", "fr", "rl", "rr")
    error = found["force_total"] - sum(array(f"longitudinal_force_{wheel}") for wheel in wheels)
    angles = {wheel: array(f"true_road_wheel_angle_{wheel}") for wheel in ("fl", "fr")}
    pull = -sum(array(f"lateral_force_{wheel}") * np.sin(angle) for wheel, angle in angles.items())
    angle = 0.5 * sum(angles.values())
    slip = angle - (found["lateral_speed"] + 1.25 * array("true_yaw_rate")) / np.maximum(array("speed"), 1.0)
    known = -1000.0 * slip * angle
    late = source.data.time > 5.0
    assert np.sqrt(np.mean(np.square(pull[late]))) > 10.0 * np.sqrt(np.mean(np.square(known[late])))
    assert np.mean(error[late]) == pytest.approx(np.mean((pull - known)[late]), rel=0.1)
