"""What the sensors' noise does to the observer replay."""

from dataclasses import replace

import numpy as np
import pytest
from library_stop import SPEEDS, driven, planned_inputs

from model_diagnosis.manoeuvre import Manoeuvre
from model_diagnosis.replay import Replay
from vehicle_model import load_vehicle
from vehicle_model.vehicle_file import VehicleFile

SETTLED = 200
"""Samples after which the yaw rate that a start takes from noisy wheels is forgotten."""


@pytest.fixture(scope="module")
def car() -> VehicleFile:
    return load_vehicle("ekf_car")


@pytest.fixture(scope="module")
def quiet(car: VehicleFile) -> Manoeuvre:
    return driven(car, *planned_inputs())


def _predicted(car: VehicleFile, drive: Manoeuvre, noise_stds: float) -> np.ndarray:
    """Predicted wheel speeds (n, 4) with so much noise of their sensors on the measured ones."""
    random, noisy = np.random.default_rng(5), dict(drive.channels)
    for name in SPEEDS:
        std = Replay(car, []).sensor_std(name)
        noisy[name] = noisy[name] + noise_stds * std * np.clip(random.standard_normal(drive.samples), -1.9, 1.9)
    replay = Replay(car, [replace(drive, channels=noisy)])
    places = [replay.signals(0).index(name) for name in SPEEDS]
    return replay.predict(np.zeros(len(replay.columns)), 0)[SETTLED:, places]


def test_ordinary_noise_of_a_wheel_speed_moves_no_predicted_wheel(car: VehicleFile, quiet: Manoeuvre) -> None:
    """Else the wheel that forgets the noise soonest would be predicted best: a wrong inertia, differential or lag."""
    np.testing.assert_allclose(_predicted(car, quiet, 1.0), _predicted(car, quiet, 0.0), atol=1e-3)
