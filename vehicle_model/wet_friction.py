"""Friction that falls with speed and water film: Table 1 of the friction document (Enisz 2015, l. 278-288).

The table's values are ratios here: water divides by the dry value of the same speed and tread, speed on a dry road by
the dry value at 50 km/h. Between its speeds, depths and treads the table is linear; beyond them it holds.
"""

import numpy as np
from numba import njit

from vehicle_model.plant_record import Record

SPEEDS_M_S = np.array([50.0, 90.0, 130.0]) / 3.6
DEPTHS_M = np.array([0.0, 0.2e-3, 1e-3, 2e-3])
# tread (new, used with at least 1.6 mm), speed, depth
FRICTION = np.array(
    [
        [[0.85, 0.65, 0.55, 0.5], [0.8, 0.6, 0.3, 0.05], [0.75, 0.55, 0.2, 0.0]],
        [[1.0, 0.5, 0.4, 0.25], [0.95, 0.2, 0.1, 0.05], [0.9, 0.2, 0.1, 0.0]],
    ]
)


@njit(cache=True)
def _table(speed: float, depth: float, wear: float) -> float:
    row = 0 if speed < SPEEDS_M_S[1] else 1
    along = min(max((speed - SPEEDS_M_S[row]) / (SPEEDS_M_S[row + 1] - SPEEDS_M_S[row]), 0.0), 1.0)
    column = 0
    while column < 2 and depth >= DEPTHS_M[column + 1]:
        column += 1
    down = min(max((depth - DEPTHS_M[column]) / (DEPTHS_M[column + 1] - DEPTHS_M[column]), 0.0), 1.0)
    value = 0.0
    for tread in range(2):
        corner = FRICTION[tread]
        slow = corner[row, column] + down * (corner[row, column + 1] - corner[row, column])
        fast = corner[row + 1, column] + down * (corner[row + 1, column + 1] - corner[row + 1, column])
        value += (wear if tread else 1.0 - wear) * (slow + along * (fast - slow))
    return value


@njit(cache=True)
def wet_factor(road: Record, depth: float, speed: float) -> float:
    """Factor on friction.

    Parameters
    ----------
    road
        Its ``tread_wear`` (0 new, 1 used) and ``speed_share`` (0 no fall with speed on a dry road, 1 the table's).
    depth : m
        Water film at the wheel.
    speed : m/s
        Of the wheel's centre, not negative.
    """
    factor = 1.0
    if depth > 0.0:
        factor = _table(speed, depth, road.tread_wear) / _table(speed, 0.0, road.tread_wear)
    if road.speed_share != 0.0:
        dry = _table(speed, 0.0, road.tread_wear) / _table(SPEEDS_M_S[0], 0.0, road.tread_wear)
        factor *= 1.0 + road.speed_share * (dry - 1.0)
    return factor
