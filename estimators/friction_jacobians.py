"""Prediction and measurement of the friction EKF with their Jacobians, in closed form.

Friction document, sections 3.6.3 to 3.6.6 (Enisz 2015, eqs 90-105, appendices 2-9). The four cases of the document
differ only in the slip branch of each axle, so two variants of one axle's rows stand for all of them.
"""

import numpy as np
from numba import njit

from estimators.friction_model import (
    ACCELERATION,
    AXLES,
    BY_LIMIT_F,
    BY_LIMIT_R,
    BY_SLIP_F,
    BY_SLIP_R,
    BY_SPEED,
    FORCE_F,
    FORCE_R,
    INERTIA_F,
    INERTIA_R,
    LIMIT_F,
    LIMIT_R,
    RADIUS_F,
    RADIUS_R,
    RATE_F,
    RATE_R,
    SLIP_F,
    SLIP_R,
    SLIP_RATE_SIGN,
    SPEED,
    SPEED_FLOOR,
    STATES,
    STOPPED_F,
    STOPPED_R,
    VALUE,
    WHEEL_F,
    WHEEL_R,
    axle_forces,
    slip_rate,
    slip_ratio,
    wheel_acceleration,
)
from estimators.kalman.covariance import FloatArray
from estimators.longitudinal_inputs import BRAKE_F, BRAKE_R, DRIVE_F, DRIVE_R

MEASUREMENTS = 8
ROW_ACCELERATION, ROW_WHEEL_F, ROW_WHEEL_R, ROW_SLIP_F, ROW_SLIP_R, ROW_LIMIT_F, ROW_LIMIT_R, ROW_SPEED = range(8)

# columns that may be non-zero, 3.6.5 and 3.6.6; -1 ends a shorter row
TRANSITION_COLUMNS = np.array(
    [
        [SPEED, SLIP_F, SLIP_R, LIMIT_F, LIMIT_R, -1],
        [SPEED, WHEEL_F, SLIP_F, SLIP_R, LIMIT_F, LIMIT_R],
        [SPEED, WHEEL_R, SLIP_F, SLIP_R, LIMIT_F, LIMIT_R],
        [SPEED, WHEEL_F, SLIP_F, SLIP_R, LIMIT_F, LIMIT_R],
        [SPEED, WHEEL_R, SLIP_F, SLIP_R, LIMIT_F, LIMIT_R],
        [LIMIT_F, RATE_F, -1, -1, -1, -1],
        [RATE_F, -1, -1, -1, -1, -1],
        [LIMIT_R, RATE_R, -1, -1, -1, -1],
        [RATE_R, -1, -1, -1, -1, -1],
    ]
)
DESIGN_COLUMNS = np.array(
    [
        [SPEED, SLIP_F, SLIP_R, LIMIT_F, LIMIT_R],
        [WHEEL_F, -1, -1, -1, -1],
        [WHEEL_R, -1, -1, -1, -1],
        [SPEED, WHEEL_F, SLIP_F, -1, -1],
        [SPEED, WHEEL_R, SLIP_R, -1, -1],
        [LIMIT_F, -1, -1, -1, -1],
        [LIMIT_R, -1, -1, -1, -1],
        [SPEED, -1, -1, -1, -1],
    ]
)


@njit(cache=True)
def predict(
    state: FloatArray,
    torques: FloatArray,
    time_step: float,
    parameters: FloatArray,
    kinematic_wheels: bool,
    forces: FloatArray,
    predicted: FloatArray,
    transition: FloatArray,
) -> None:
    """Explicit Euler step f and its Jacobian F.

    Parameters
    ----------
    state : array, shape (9,)
    torques : array, shape (4,)
        Drive front, rear, and torque that the brake can transmit front, rear, axle totals [N m], brakes positive.
    time_step : float
        Step [s].
    parameters : array, shape (19,)
        Of :mod:`estimators.friction_model`.
    kinematic_wheels : bool
        Mode Z2 (3.6.9): wheel speeds and slips are random walks, no torque is used.
    forces : array, shape (4, 6)
        Receives the table of :func:`estimators.friction_model.axle_forces` at ``state``; the last two columns of its
        last row tell which axle its brake stops.
    predicted : array, shape (9,)
        Receives f(x).
    transition : array, shape (9, 9)
        Receives F; entries outside ``TRANSITION_COLUMNS`` are not touched and must be zero.
    """
    axle_forces(state, parameters, forces)
    acceleration = forces[ACCELERATION]
    predicted[SPEED] = state[SPEED] + time_step * acceleration[VALUE]
    _fill_row(transition[SPEED], acceleration, time_step)
    transition[SPEED, SPEED] += 1.0
    for limit in (LIMIT_F, LIMIT_R):
        predicted[limit] = state[limit] + time_step * state[limit + 1]
        predicted[limit + 1] = state[limit + 1]
        transition[limit, limit] = 1.0
        transition[limit, limit + 1] = time_step
        transition[limit + 1, limit + 1] = 1.0
    forces[AXLES, STOPPED_F], forces[AXLES, STOPPED_R] = 0.0, 0.0
    if kinematic_wheels:
        for i in range(WHEEL_F, SLIP_R + 1):
            predicted[i] = state[i]
            for j in range(STATES):
                transition[i, j] = 0.0
            transition[i, i] = 1.0
        return
    forces[AXLES, STOPPED_F] = _predict_axle(
        state, torques[DRIVE_F], torques[BRAKE_F], time_step, acceleration, forces[FORCE_F], WHEEL_F, SLIP_F,
        parameters[RADIUS_F], parameters[INERTIA_F], parameters, predicted, transition,
    )  # fmt: skip
    forces[AXLES, STOPPED_R] = _predict_axle(
        state, torques[DRIVE_R], torques[BRAKE_R], time_step, acceleration, forces[FORCE_R], WHEEL_R, SLIP_R,
        parameters[RADIUS_R], parameters[INERTIA_R], parameters, predicted, transition,
    )  # fmt: skip


@njit(cache=True)
def _fill_row(row: FloatArray, gradient: FloatArray, factor: float) -> None:
    row[SPEED] = factor * gradient[BY_SPEED]
    row[SLIP_F] = factor * gradient[BY_SLIP_F]
    row[SLIP_R] = factor * gradient[BY_SLIP_R]
    row[LIMIT_F] = factor * gradient[BY_LIMIT_F]
    row[LIMIT_R] = factor * gradient[BY_LIMIT_R]


@njit(cache=True)
def _add_row(row: FloatArray, gradient: FloatArray, factor: float) -> None:
    row[SPEED] += factor * gradient[BY_SPEED]
    row[SLIP_F] += factor * gradient[BY_SLIP_F]
    row[SLIP_R] += factor * gradient[BY_SLIP_R]
    row[LIMIT_F] += factor * gradient[BY_LIMIT_F]
    row[LIMIT_R] += factor * gradient[BY_LIMIT_R]


@njit(cache=True)
def _predict_axle(
    state: FloatArray,
    drive: float,
    brake: float,
    time_step: float,
    acceleration: FloatArray,
    force: FloatArray,
    wheel: int,
    slip: int,
    radius: float,
    inertia: float,
    parameters: FloatArray,
    predicted: FloatArray,
    transition: FloatArray,
) -> float:
    speed = max(state[SPEED], parameters[SPEED_FLOOR])
    floored = state[SPEED] <= parameters[SPEED_FLOOR]
    sign = parameters[SLIP_RATE_SIGN]
    eta, stopped = wheel_acceleration(
        drive - brake, brake > 0.0, force[VALUE], radius, inertia, state[wheel], time_step
    )
    rate = slip_rate(speed, state[wheel], state[slip], acceleration[VALUE], eta, radius, sign)
    predicted[wheel] = state[wheel] + time_step * eta
    predicted[slip] = state[slip] + time_step * rate

    wheel_row, slip_row = transition[wheel], transition[slip]
    if speed >= radius * state[wheel]:
        by_eta = sign * radius / speed
        _fill_row(slip_row, acceleration, -time_step * (1.0 + state[slip]) / speed)
        slip_row[wheel] = 0.0
        slip_row[slip] -= time_step * acceleration[VALUE] / speed
        if not floored:
            slip_row[SPEED] -= time_step * rate / speed
    else:
        by_eta = (1.0 - state[slip]) / state[wheel]
        _fill_row(slip_row, acceleration, -time_step / (radius * state[wheel]))
        slip_row[wheel] = -time_step * rate / state[wheel]
        slip_row[slip] -= time_step * eta / state[wheel]
    slip_row[slip] += 1.0
    if stopped:
        _fill_row(wheel_row, force, 0.0)
        wheel_row[wheel] = 0.0
        slip_row[wheel] -= by_eta
        return 1.0
    _fill_row(wheel_row, force, -time_step * radius / inertia)
    wheel_row[wheel] = 1.0
    _add_row(slip_row, force, -time_step * by_eta * radius / inertia)
    return 0.0


@njit(cache=True)
def hold_limit_rates(predicted: FloatArray, transition: FloatArray, decay: float) -> None:
    """Let the rates of the friction limits die out while the brakes hold both axles still.

    The torque of a locked wheel is the road's, not the brake's, so only the sum of both axle forces is observed, by the
    accelerometer. Nothing would correct the difference of the rates, and the split between the axles would drift.

    Parameters
    ----------
    predicted, transition : arrays, shape (9,) and (9, 9)
        f(x) and F, changed.
    decay : float
        Factor on the rates in this step.
    """
    for rate in (RATE_F, RATE_R):
        predicted[rate] *= decay
        transition[rate, rate] = decay


@njit(cache=True)
def share_limit_noise(covariance: FloatArray, variances: FloatArray) -> None:
    """Process noise of the friction limits common to both axles: an unobserved split keeps its certainty.

    Parameters
    ----------
    covariance : array, shape (9, 9)
        Predicted P, its diagonal noise already added; changed.
    variances : array, shape (9,)
        Diagonal of Q of this step.
    """
    common = np.sqrt(variances[LIMIT_F] * variances[LIMIT_R])
    covariance[LIMIT_F, LIMIT_R] += common
    covariance[LIMIT_R, LIMIT_F] += common


@njit(cache=True)
def measure(
    state: FloatArray, parameters: FloatArray, forces: FloatArray, expected: FloatArray, design: FloatArray
) -> None:
    """Expected measurements h and their Jacobian H (3.6.2, 3.6.6).

    Parameters
    ----------
    state : array, shape (9,)
        Predicted state.
    forces : array, shape (4, 6)
        Receives the table of :func:`estimators.friction_model.axle_forces` at ``state``.
    expected : array, shape (8,)
        Receives h(x).
    design : array, shape (8, 9)
        Receives H; entries outside ``DESIGN_COLUMNS`` are not touched and must be zero.
    """
    axle_forces(state, parameters, forces)
    expected[ROW_ACCELERATION] = forces[ACCELERATION, VALUE]
    _fill_row(design[ROW_ACCELERATION], forces[ACCELERATION], 1.0)
    for row, index in (
        (ROW_WHEEL_F, WHEEL_F),
        (ROW_WHEEL_R, WHEEL_R),
        (ROW_LIMIT_F, LIMIT_F),
        (ROW_LIMIT_R, LIMIT_R),
        (ROW_SPEED, SPEED),
    ):
        expected[row] = state[index]
        design[row, index] = 1.0
    _measure_slip(state, WHEEL_F, SLIP_F, parameters[RADIUS_F], parameters, ROW_SLIP_F, expected, design)
    _measure_slip(state, WHEEL_R, SLIP_R, parameters[RADIUS_R], parameters, ROW_SLIP_R, expected, design)


@njit(cache=True)
def _measure_slip(
    state: FloatArray,
    wheel: int,
    slip: int,
    radius: float,
    parameters: FloatArray,
    row: int,
    expected: FloatArray,
    design: FloatArray,
) -> None:
    speed = max(state[SPEED], parameters[SPEED_FLOOR])
    rim_speed = radius * state[wheel]
    expected[row] = slip_ratio(speed, rim_speed) - state[slip]
    design[row, slip] = -1.0
    if speed >= rim_speed:
        design[row, SPEED] = -rim_speed / (speed * speed) if state[SPEED] > parameters[SPEED_FLOOR] else 0.0
        design[row, wheel] = radius / speed
    else:
        design[row, SPEED] = -1.0 / rim_speed if state[SPEED] > parameters[SPEED_FLOOR] else 0.0
        design[row, wheel] = speed / (rim_speed * state[wheel])
