"""Wheel speeds of a tone ring, timed between teeth: below one tooth per sample the value stands still by itself."""

import numpy as np
import pytest

from model_diagnosis.data.sample_values import check_random_hold
from model_diagnosis.data.samples import Samples

TEETH, PERIOD_S, RESOLUTION_RAD_S = 48, 0.005, 0.005
FIRST_RAD_S, LAST_RAD_S, DURATION_S = 90.0, 5.0, 10.0
HELD = 0.2


def _stop(held: float) -> Samples:
    """A wheel that slows down evenly, as its ring's edges tell it; a share of the samples repeats the one before."""
    random = np.random.default_rng(11)
    rate = (LAST_RAD_S - FIRST_RAD_S) / DURATION_S
    pitch = 2.0 * np.pi / TEETH
    turned = FIRST_RAD_S * DURATION_S + 0.5 * rate * DURATION_S**2
    angles = pitch * np.arange(1, int(turned / pitch))
    edges = (np.sqrt(FIRST_RAD_S**2 + 2.0 * rate * angles) - FIRST_RAD_S) / rate
    speeds = np.concatenate(([FIRST_RAD_S], pitch / np.diff(edges))) + random.normal(0.0, 0.1, len(edges))
    time = PERIOD_S * np.arange(10, int(DURATION_S / PERIOD_S))
    values = RESOLUTION_RAD_S * np.round(speeds[np.searchsorted(edges, time, side="right") - 1] / RESOLUTION_RAD_S)
    for row in np.flatnonzero(random.random(len(values)) < held):
        values[row] = values[row - 1]
    return Samples("wheel_speed_fl", "rad/s", time, values, np.ones(len(values), dtype=np.bool_), "speed", "log.csv")


def test_a_wheel_slower_than_its_teeth_has_lost_no_frame() -> None:
    """Below 26 rad/s (48 teeth, 5 ms) samples repeat: a twentieth of this stop and more."""
    stop = _stop(0.0)
    assert np.mean(np.diff(stop.values) == 0.0) > 0.05
    checked, faults = check_random_hold(stop)
    assert not faults
    assert checked.valid.all()


def test_frames_that_are_held_above_are_still_named() -> None:
    _, (fault,) = check_random_hold(_stop(HELD))
    # 1400 of the 2000 samples are above 31 rad/s: three standard deviations of a share of a fifth
    assert fault.value == pytest.approx(HELD, abs=3.0 * np.sqrt(HELD * (1.0 - HELD) / 1400))
