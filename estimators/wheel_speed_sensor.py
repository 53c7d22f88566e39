"""Delay of wheel speeds that come from the teeth of a tone ring, and its compensation by the model.

A control unit divides the way between two edges by the time between them, over a window of some milliseconds. The
result belongs to the middle of that window, several milliseconds before the sample; while an ABS works, a wheel's speed
changes by more than 1 rad/s in that time. The filter's own model knows by how much: its predicted changes are
remembered, and those of the delay are added to the sample.
"""

import math

from numba import njit

from estimators.kalman.covariance import FloatArray

HISTORY = 64
_POSITION, _NOW = HISTORY, HISTORY + 1
HISTORY_SIZE = HISTORY + 2


@njit(cache=True)
def forget_changes(history: FloatArray) -> None:
    """Start a history, shape (2, 66), with wheels that have not changed their speed."""
    history[:] = 0.0


@njit(cache=True)
def remember_change(history: FloatArray, change_f: float, change_r: float) -> None:
    """Note by how much the model changed the front and the rear wheel speed in this tick [rad/s]."""
    for axle in range(2):
        position = (int(history[axle, _POSITION]) + 1) % HISTORY
        history[axle, _POSITION] = position
        history[axle, _NOW] += change_f if axle == 0 else change_r
        history[axle, position] = history[axle, _NOW]


@njit(cache=True)
def change_since(history: FloatArray, axle: int, ticks: float) -> float:
    """Predicted change of a wheel speed over the last ``ticks`` ticks [rad/s], at most those remembered."""
    ticks = min(max(ticks, 0.0), HISTORY - 2.0)
    whole = int(ticks)
    part = ticks - whole
    position = int(history[axle, _POSITION])
    newer = history[axle, (position - whole) % HISTORY]
    older = history[axle, (position - whole - 1) % HISTORY]
    return history[axle, _NOW] - (newer + part * (older - newer))


@njit(cache=True)
def time_between_edges(wheel_speed: float, teeth: float) -> float:
    """Time between two edges at a wheel speed above zero [s]."""
    return 2.0 * math.pi / (teeth * wheel_speed)


@njit(cache=True)
def sample_delay(wheel_speed: float, teeth: float, window: float) -> float:
    """Mean delay of a measured wheel speed [s].

    Half of the time over which edges are counted, which is the window or, if that is longer, the time between two
    edges; and half of the time between two edges, since the last one lies by so much before the sample.
    """
    if teeth <= 0.0 or wheel_speed <= 0.0:
        return 0.0
    between = time_between_edges(wheel_speed, teeth)
    return 0.5 * (max(window, between) + between)
