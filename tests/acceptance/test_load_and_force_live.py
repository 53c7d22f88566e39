"""Observers of vertical loads and axle forces on their documents' cars and the MuJoCo car, from decoded CAN frames."""

from collections.abc import Callable

import pytest
from conftest import Judge

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
