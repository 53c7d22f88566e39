"""Wheel speeds from tone rings: their delay is compensated, the lingering speed of a locking wheel is left out."""

import math

import friction_twin as twin
import numpy as np
import pytest
from friction_figures import Estimate, stop

from estimators.wheel_speed_sensor import HISTORY, HISTORY_SIZE, change_since, remember_change, sample_delay

WITH_RINGS = twin.TABLE_8 | {"sensors.wheel_speed.teeth": 48.0, "sensors.wheel_speed.window": 0.005}


def test_delay_of_a_sample():
    """Half of the window, or of the time between edges where that is longer, and half of that time."""
    fast, slow = 2 * math.pi / (48 * 0.001), 2 * math.pi / (48 * 0.010)
    assert sample_delay(fast, 48.0, 0.005) == pytest.approx(0.0030)
    assert sample_delay(slow, 48.0, 0.005) == pytest.approx(0.010)
    assert sample_delay(0.0, 48.0, 0.005) == 0.0
    assert sample_delay(50.0, 0.0, 0.005) == 0.0


def test_changes_are_remembered_between_ticks_and_around_the_ring():
    random = np.random.default_rng(1)
    history = np.zeros((2, HISTORY_SIZE))
    changes = random.standard_normal((200, 2))
    for front, rear in changes:
        remember_change(history, front, rear)
    for axle in range(2):
        assert change_since(history, axle, 0.0) == 0.0
        assert change_since(history, axle, 7.0) == pytest.approx(changes[-7:, axle].sum())
        expected = changes[-3:, axle].sum() + 0.25 * changes[-4, axle]
        assert change_since(history, axle, 3.25) == pytest.approx(expected)
        assert change_since(history, axle, 1e9) == pytest.approx(changes[-(HISTORY - 2) :, axle].sum())


@pytest.mark.acceptance("F-A6")
@pytest.mark.parametrize("estimator", ["friction_ekf", "friction_ukf"])
@pytest.mark.parametrize("name", ["E8", "E9"])
def test_compensation_improves_the_slip(name, estimator, record):
    truth = stop(name)
    plain = Estimate(truth, path="tone_ring", estimator=estimator)
    compensated = Estimate(truth, path="tone_ring", estimator=estimator, vehicle=WITH_RINGS)
    for axle in ("front", "rear"):
        slip = getattr(truth, f"slip_{axle}")
        error = compensated.rmse(f"slip_{axle}", slip)
        record(f"slip RMSE {axle}, wheel speeds from tone rings, {estimator}", error, "0.02")
        assert error <= 0.015
        assert error < 0.9 * plain.rmse(f"slip_{axle}", slip)


@pytest.mark.acceptance("F-A7", "F-A8")
@pytest.mark.parametrize("sign", [1, -1])
@pytest.mark.parametrize("name", ["E6", "E7"])
def test_friction_limits_when_wheels_lock(name, sign, record):
    """A locked wheel's speed lingers on the bus for up to 0.3 s; believed, it would be friction that is not there."""
    truth = stop(name)
    estimate = Estimate(truth, path="tone_ring", vehicle=WITH_RINGS, slip_rate_sign=sign)
    identifier = "F-A7" if name == "E6" else "F-A8"
    for axle in ("front", "rear"):
        ratio = estimate.mean(f"friction_limit_{axle}") / getattr(truth, f"limit_{axle}")[0]
        record(
            f"k0 {axle} / truth, wheel speeds from tone rings",
            ratio,
            "0.95 ... 1.05",
            id=identifier,
        )
        assert ratio == pytest.approx(1.0, abs=0.05)
    believed = Estimate(truth, path="tone_ring", slip_rate_sign=sign)
    worst = max(
        abs(believed.mean(f"friction_limit_{axle}") / getattr(truth, f"limit_{axle}")[0] - 1)
        for axle in ("front", "rear")
    )
    assert worst > 0.05
