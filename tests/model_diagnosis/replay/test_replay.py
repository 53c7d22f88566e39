"""The replay against the MuJoCo car with the same vehicle file, and the promises of its interface."""

import importlib.util
import sys
from pathlib import Path

import numpy as np
import pytest

from model_diagnosis.replay.replay import Replay
from vehicle_model.vehicle_file import load_vehicle

_SPEC = importlib.util.spec_from_file_location("plant_log", Path(__file__).with_name("plant_log.py"))
assert _SPEC is not None and _SPEC.loader is not None
plant_log = importlib.util.module_from_spec(_SPEC)
sys.modules["plant_log"] = plant_log
_SPEC.loader.exec_module(plant_log)


@pytest.fixture(scope="module")
def replay() -> Replay:
    vehicle = plant_log.ideal_sensors(load_vehicle("asphalt_car"))
    logs = [
        plant_log.drive(vehicle, plant_log.gentle_stop, 5.0, 30.0, name="gentle"),
        plant_log.drive(vehicle, plant_log.pulsed_stop, 3.5, 30.0, name="pulsed"),
        plant_log.drive(vehicle, plant_log.sine_steer, 8.0, 25.0, name="sine"),
        plant_log.drive(vehicle, plant_log.brake_in_turn, 5.0, 20.0, name="turn"),
    ]
    return Replay(vehicle, logs)


def _error(replay: Replay, m: int, signal: str, *, free: bool = False) -> float:
    """Root mean square error of a signal over the samples that count."""
    theta = np.zeros(len(replay.columns))
    predicted = replay.free_run(theta, m) if free else replay.predict(theta, m)
    k = replay.signals(m).index(signal)
    valid = replay.weights()[m][:, k] > 0.0
    difference = replay.measured(m)[valid, k] - predicted[valid, k]
    return float(np.sqrt(np.mean(difference**2)))


# The two models share tyre and brake and differ in the body: MuJoCo has unsprung masses that move on their own, finite
# angles and 0.2 ms for the spin, where the replay has tyres in series with the springs, small angles and 2 ms.
@pytest.mark.parametrize(
    ("manoeuvre", "signal", "most"),
    [
        (0, "wheel_speed_fl", 0.04),
        (0, "longitudinal_acceleration", 0.03),
        (0, "vertical_load_fl", 30.0),
        (2, "yaw_rate", 0.01),
        (2, "lateral_acceleration", 0.25),
        (3, "yaw_rate", 0.005),
        (3, "wheel_speed_rl", 0.05),
    ],
)
def test_observer_replay_follows_the_plant(replay: Replay, manoeuvre: int, signal: str, most: float) -> None:
    assert _error(replay, manoeuvre, signal) < most


def test_free_run_of_a_gentle_stop_keeps_to_the_plant(replay: Replay) -> None:
    assert _error(replay, 0, "speed", free=True) < 0.01


def test_deviations_of_zero_change_no_bit(replay: Replay) -> None:
    theta = np.zeros(len(replay.columns))
    first = [replay.predict(theta, m) for m in range(len(replay.manoeuvres))]
    second = [replay.predict(-theta, m) for m in range(len(replay.manoeuvres))]
    for one, other in zip(first, second, strict=True):
        assert np.array_equal(one, other)
