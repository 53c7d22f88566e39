"""Directions of the discs, turned on step by step, against the angle itself."""

import math

import numpy as np
import pytest

from model_diagnosis.replay.brake_step import turn_disc
from model_diagnosis.replay.state import STATE_RECORD


@pytest.mark.parametrize("spin_rad_s", [0.0, 30.0, 149.0, 151.0, 900.0])
def test_ten_seconds_of_turning_end_at_the_angle(spin_rad_s: float) -> None:
    """5000 steps of 2 ms: the error is the rounding of so many products."""
    state = np.zeros(1, STATE_RECORD)
    state[0]["disc_cosine"][:] = 1.0
    for _ in range(5000):
        turn_disc(state[0], 1, 0.002 * spin_rad_s)
    angle = math.fmod(5000 * 0.002 * spin_rad_s, 2.0 * math.pi)
    assert state[0]["disc_sine"][1] == pytest.approx(math.sin(angle), abs=1e-9)
    assert state[0]["disc_cosine"][1] == pytest.approx(math.cos(angle), abs=1e-9)
