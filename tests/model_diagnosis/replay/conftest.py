"""Logs of the MuJoCo car for the tests of the replay."""

import sys
from pathlib import Path

import pytest

sys.path.insert(0, str(Path(__file__).parent))

from plant_log import brake_in_turn, coast_and_drive, drive, gentle_stop, ideal_sensors, pulsed_stop, sine_steer

from model_diagnosis.replay import Replay
from vehicle_model.vehicle_file import VehicleFile, load_vehicle


@pytest.fixture(scope="session")
def car() -> VehicleFile:
    return ideal_sensors(load_vehicle("asphalt_car"))


@pytest.fixture(scope="session")
def replay(car: VehicleFile) -> Replay:
    """Five drives of the MuJoCo car and their replay by the same vehicle file."""
    return Replay(
        car,
        [
            drive(car, gentle_stop, 4.0, 30.0, name="gentle"),
            drive(car, pulsed_stop, 3.0, 30.0, name="pulsed"),
            drive(car, sine_steer, 5.0, 25.0, name="sine"),
            drive(car, brake_in_turn, 4.5, 20.0, name="turn"),
            drive(car, coast_and_drive, 8.0, 25.0, name="coast"),
        ],
    )
