"""Forces of the wind on the replay's body against the plant's: at their height, with the wind in drag and lift."""

import numpy as np
import pytest
from plant_log import drive

from model_diagnosis.replay import Replay
from vehicle_model.road_file import RoadFile
from vehicle_model.vehicle_file import VehicleFile

HEAD, SIDE = 14.0, 9.0
"""Wind from ahead and from the left [m/s]."""

Inputs = tuple[tuple[float, float, float, float], float, float]


def rolling(_time: float) -> Inputs:
    """Neither brakes nor drive nor steering."""
    return (0.0, 0.0, 0.0, 0.0), 0.0, 0.0


@pytest.mark.parametrize("raised", [0.0, 0.4], ids=["at the centre of gravity", "above it"])
def test_wind_leans_and_loads_the_car_as_in_the_plant(car: VehicleFile, raised: float) -> None:
    """What the wind adds to angles and loads, settled."""
    windy = car.model_copy(deep=True)
    windy.aerodynamics.lift_coefficient_front = 0.25
    windy.aerodynamics.side_force_coefficient = 2.0
    windy.aerodynamics.drag_height = windy.body.centre_of_gravity_height + raised
    wind = RoadFile(wind_speed_x=-HEAD, wind_speed_y=-SIDE)
    replay = Replay(windy, [drive(windy, rolling, 2.5, 35.0), drive(windy, rolling, 2.5, 35.0, wind)])
    theta = np.zeros(len(replay.columns))
    theta[replay.columns.index("head_wind.speed")] = HEAD
    theta[replay.columns.index("side_wind.speed")] = SIDE
    names = ("pitch_angle", "roll_angle", "vertical_load_fl", "vertical_load_rr")
    columns = [replay.signals(0).index(name) for name in names]
    late = slice(150, 250)
    measured = (replay.measured(1) - replay.measured(0))[late, columns].mean(axis=0)
    predicted = (replay.free_run(theta, 1) - replay.free_run(0.0 * theta, 0))[late, columns].mean(axis=0)
    assert np.all(np.abs(measured) > [2e-4, 2e-3, 50.0, 50.0])
    assert np.allclose(predicted, measured, rtol=0.08)
