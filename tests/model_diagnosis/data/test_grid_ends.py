"""The end of a drive on the common time base."""

import numpy as np
import pytest

from model_diagnosis.data.grid import on_grid
from model_diagnosis.data.samples import Samples
from signals.errors import InputError


def channel(name: str, period_s: float, values: np.ndarray) -> Samples:
    time = period_s * np.arange(len(values))
    return Samples(name, "1", time, values, np.isfinite(values), name, "log.mf4")


def test_a_fast_channel_is_averaged_over_the_last_step_too() -> None:
    """2 ms samples of a ramp that go on after the other channel ended: the last step is a mean like every other."""
    fast = channel("longitudinal_acceleration", 0.002, 0.002 * np.arange(1000))
    slow = channel("speed", 0.01, np.linspace(20.0, 19.0, 101))
    time, values, _ = on_grid({"longitudinal_acceleration": fast, "speed": slow})
    assert values["longitudinal_acceleration"] == pytest.approx(time, abs=0.0021)


def test_a_torque_that_stays_at_zero_does_not_end_the_drive() -> None:
    """The engine's torque does not change any more while the car brakes: the stop is still part of the drive."""
    torque = channel("drive_torque_r", 0.01, np.concatenate((np.sin(np.arange(150.0)), np.zeros(50))))
    speed = channel("speed", 0.01, np.linspace(30.0, 10.0, 200))
    time, _, _ = on_grid({"drive_torque_r": torque, "speed": speed})
    assert time[-1] == pytest.approx(1.99, abs=1e-9)


def test_a_log_of_two_samples_is_told_as_short() -> None:
    with pytest.raises(InputError, match=r"cover 0\.010 s only") as told:
        on_grid({"speed": channel("speed", 0.01, np.array([20.0, 19.0]))})
    assert "allowed: 0.02 s at least" in str(told.value)
