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
DEEP_SLIP = 0.5
"""Wheel speed over that of the car below which a wheel is on its way to locking."""


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


@njit(cache=True)
def is_lingering(wheel_speed: float, teeth: float, window: float, rim_speed: float, speed: float) -> bool:
    """A locking wheel gives no more pulses: what is left of its measured speed is the age of the last one.

    The brake's known capacity then says when it stands; believed, the lingering speed would be taken for a road that
    carries the whole torque of the brake.
    """
    pulses = wheel_speed * teeth * window / (2.0 * math.pi)
    return 0.0 < pulses < 1.0 and rim_speed < DEEP_SLIP * speed


@njit(cache=True)
def bring_forward(
    history: FloatArray,
    teeth: float,
    window: float,
    sample_time: float,
    change_f: float,
    change_r: float,
    measured: FloatArray,
    variances: FloatArray,
) -> None:
    """Add to the measured wheel speeds what the model says they changed by since they were true.

    When the last edge passed before the sample is not known, only that it was less than the time between two edges: as
    much as the speed changed in that time is uncertain.

    Parameters
    ----------
    history : array, shape (2, 66)
        Of :func:`remember_change`, changed.
    change_f, change_r : float
        Change of the wheel speeds in this tick's prediction [rad/s].
    measured, variances : arrays, shape (2,)
        Wheel speeds front and rear [rad/s] and their noise variances, changed.
    """
    remember_change(history, change_f, change_r)
    for axle in range(2):
        delay = sample_delay(measured[axle], teeth, window)
        if delay > 0.0:
            moved = change_since(history, axle, delay / sample_time)
            uncertain = moved * time_between_edges(measured[axle], teeth) / delay
            variances[axle] += uncertain * uncertain / 12.0
            measured[axle] = max(0.0, measured[axle] + moved)
