"""Initial slope of a tyre's side force, for the reference plants whose tyres are given by it."""

import numpy as np

from vehicle_model.tyres.coefficients import SURFACE_FACTOR, SURFACE_SIZE, TYRE_SIZE, write_tyre
from vehicle_model.tyres.kernel import PREPARED_SIZE, STIFFNESS_Y, prepare
from vehicle_model.vehicle_file import VehicleFile

_SPEED_M_S = 20.0


def side_force_slope(vehicle: VehicleFile, axle: int) -> float:
    """Side force per slip angle of one tyre of an axle (0 front, 1 rear) at its static load [N/rad]."""
    tyre, surface, prepared = np.zeros(TYRE_SIZE), np.zeros(SURFACE_SIZE), np.zeros(PREPARED_SIZE)
    pair = vehicle.tyre_pair
    write_tyre(pair.front if axle == 0 else pair.rear, tyre, right=False)
    surface[SURFACE_FACTOR] = 1.0
    prepare(tyre, surface, 1.0, vehicle.static_loads()[2 * axle], _SPEED_M_S, 0.0, prepared)
    return float(prepared[STIFFNESS_Y])
