"""Cars for the tests of the plant."""

from collections.abc import Mapping

import numpy as np

from signals.wheels import WHEELS
from vehicle_model.plant import Plant
from vehicle_model.road_file import RoadFile
from vehicle_model.vehicle_file import VehicleFile, load_vehicle, set_parameter

GRAVITY = 9.81


def without_losses(changes: Mapping[str, float] | None = None) -> VehicleFile:
    """The car of Table 8 without drag and rolling resistance."""
    vehicle = load_vehicle("ekf_car")
    set_parameter(vehicle, "aerodynamics.drag_coefficient", 0.0)
    for wheel in WHEELS:
        set_parameter(vehicle, f"wheels.{wheel}.rolling_resistance", 0.0)
    for path, value in (changes or {}).items():
        set_parameter(vehicle, path, value)
    return vehicle


def stop(car: Plant, brake_torque: float | list[float], steer: float = 0.0, limit_ticks: int = 20000) -> int:
    """Brake until the car stands; returns the number of ticks."""
    for tick in range(limit_ticks):
        if car.outputs[0] <= 0.0:
            return tick
        car.step(1, brake_torque=brake_torque, steer=steer)
    raise AssertionError("the car does not stop")


def loads(car: Plant) -> np.ndarray:
    """Vertical loads of the four wheels."""
    state = car.state()
    return np.array([state[f"vertical_load_{wheel}"] for wheel in WHEELS])


def car_on(road: RoadFile | None = None, name: str = "ekf_car") -> Plant:
    """A shipped car on a road."""
    return Plant(load_vehicle(name), road)
