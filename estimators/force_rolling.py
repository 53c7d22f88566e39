"""What an axle without torque tells the force EKF beside eqs 84-87: the car's speed and the accelerometer's offset.

In the document's equations drag alone ties the speed, so that 0.1 m/s^2 of offset pass for the drag of another speed.
"""

import numpy as np
from numba import njit

from estimators.force_model import SPEED
from estimators.kalman.correction import ROW_USED, correct_rows
from estimators.kalman.covariance import FloatArray, IntArray
from estimators.longitudinal_inputs import BRAKE_F, BRAKE_R, DRIVE_F, DRIVE_R

OFFSET, TRACKED = range(2)
"""Places of the tracker: offset [m/s^2]; rim speed as the accelerometer carries it on [m/s], 0 where nothing rolls."""

ROLLING_SHARE = 0.02
"""Torque of an axle over weight times radius below which it rolls: its slip is then some thousandths."""

_COLUMNS = np.array([[SPEED]])


@njit(cache=True)
def rolling_axles(torques: FloatArray, most: float) -> tuple[bool, bool]:
    """Which axle, front or rear, has neither drive nor brake torque above ``most`` [N m]: its rim speed is the car's.

    A negative ``most`` says that none is to count.
    """
    front = max(abs(torques[DRIVE_F]), torques[BRAKE_F])
    rear = max(abs(torques[DRIVE_R]), torques[BRAKE_R])
    return front <= most, rear <= most


@njit(cache=True)
def tie_speed(
    state: FloatArray,
    covariance: FloatArray,
    rim: float,
    variance: FloatArray,
    design: FloatArray,
    residual: FloatArray,
    row: IntArray,
    work: FloatArray,
) -> None:
    """Correct the speed by the rim speed of an axle that rolls.

    Parameters
    ----------
    rim : m/s
    variance, residual, row : arrays, shape (1,)
        Noise [m^2/s^2]; scratch.
    design, work : arrays, shape (1, 9) and (3, 9)
        Scratch; ``design`` has zeros beside the speed.
    """
    design[0, SPEED] = 1.0
    residual[0] = rim - state[SPEED]
    row[0] = ROW_USED
    correct_rows(state, covariance, residual, design, variance, row, 0.0, _COLUMNS, work)


@njit(cache=True)
def learn_offset(
    tracker: FloatArray, acceleration: float, rim: float, step: float, rate: float, largest: float
) -> None:
    """Follow by how much the accelerometer, integrated, runs away from an axle that rolls: its offset and the grade.

    A critically damped tracker of second order, beside the filter, whose forces would take a part of the offset.

    Parameters
    ----------
    tracker : array, shape (2,)
        ``OFFSET`` and ``TRACKED``.
    acceleration, rim : m/s^2, m/s
    step, rate, largest : s, 1/s, m/s^2
        Time step, inverse of the time constant, bound of the offset.
    """
    if tracker[TRACKED] <= 0.0:
        tracker[TRACKED] = rim
    tracker[TRACKED] += step * (acceleration - tracker[OFFSET])
    error = rim - tracker[TRACKED]
    tracker[TRACKED] += 2.0 * rate * step * error
    tracker[OFFSET] = min(max(tracker[OFFSET] - rate * rate * step * error, -largest), largest)
