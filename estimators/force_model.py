"""Model of the force EKF: axle forces as states, no tyre curve (Enisz 2015, eqs 81-87; friction document 3.5).

State order: speed, wheel speed front, wheel speed rear, force front, its rate, force rear, its rate, unmodelled force,
its rate. Forces, inertias and torques of whole axles.
"""

import math

import numpy as np
from numba import njit

from estimators.friction_model import wheel_acceleration
from estimators.kalman.covariance import FloatArray
from estimators.longitudinal_inputs import BRAKE_F, BRAKE_R, DRIVE_F, DRIVE_R

SPEED, WHEEL_F, WHEEL_R, FORCE_F, FORCE_RATE_F, FORCE_R, FORCE_RATE_R, EXTRA, EXTRA_RATE = range(9)
STATES = 9
ROW_ACCELERATION, ROW_WHEEL_F, ROW_WHEEL_R = range(3)
MEASUREMENTS = 3

MASS, ROLLING_FORCE, DRAG_FACTOR, COSINE_SPEED, RADIUS_F, RADIUS_R, INERTIA_F, INERTIA_R = range(8)
MODEL_PARAMETERS = 8

# columns that may be non-zero; -1 ends a shorter row
TRANSITION_COLUMNS = np.array(
    [
        [SPEED, FORCE_F, FORCE_R, EXTRA],
        [WHEEL_F, FORCE_F, -1, -1],
        [WHEEL_R, FORCE_R, -1, -1],
        [FORCE_F, FORCE_RATE_F, -1, -1],
        [FORCE_RATE_F, -1, -1, -1],
        [FORCE_R, FORCE_RATE_R, -1, -1],
        [FORCE_RATE_R, -1, -1, -1],
        [EXTRA, EXTRA_RATE, -1, -1],
        [EXTRA_RATE, -1, -1, -1],
    ]
)
DESIGN_COLUMNS = np.array(
    [
        [SPEED, FORCE_F, FORCE_R, EXTRA],
        [WHEEL_F, FORCE_F, FORCE_RATE_F, -1],
        [WHEEL_R, FORCE_R, FORCE_RATE_R, -1],
    ]
)


@njit(cache=True)
def resistance(speed: float, parameters: FloatArray) -> tuple[float, float]:
    """Drag and rolling resistance F_xra [N], not positive, and its derivative by the speed [N s/m].

    With a ``COSINE_SPEED`` v0 above zero the cosine substitute of eq. 83 takes the place of v^2; over [0, v0] both have
    the same integral.
    """
    rolling, drag = parameters[ROLLING_FORCE], parameters[DRAG_FACTOR]
    v0 = parameters[COSINE_SPEED]
    if v0 <= 0.0:
        return -rolling - drag * speed * speed, -2.0 * drag * speed
    scale = math.pi * v0 * v0 / (3.0 * math.pi - 6.0)
    angle = math.pi * speed / (2.0 * v0)
    return (
        -rolling - drag * scale * (1.0 - math.cos(angle)),
        -drag * math.pi * math.pi * v0 / (2.0 * (3.0 * math.pi - 6.0)) * math.sin(angle),
    )


@njit(cache=True)
def acceleration_row(state: FloatArray, parameters: FloatArray, row: FloatArray) -> float:
    """Acceleration [m/s^2] of a state; its derivatives go to ``row``, shape (9,)."""
    mass = parameters[MASS]
    force, by_speed = resistance(state[SPEED], parameters)
    row[SPEED] = by_speed / mass
    row[FORCE_F], row[FORCE_R], row[EXTRA] = 1.0 / mass, 1.0 / mass, 1.0 / mass
    return (force + state[FORCE_F] + state[FORCE_R] + state[EXTRA]) / mass


@njit(cache=True)
def predict(
    state: FloatArray,
    torques: FloatArray,
    time_step: float,
    parameters: FloatArray,
    predicted: FloatArray,
    transition: FloatArray,
) -> tuple[bool, bool]:
    """Explicit Euler step f and its Jacobian F (eqs 84 and 86 as corrected); whether the brakes hold front and rear.

    Parameters
    ----------
    torques : array, shape (4,)
        Drive front, rear, and torque that the brake can transmit front, rear, axle totals [N m].
    predicted, transition : arrays, shape (9,) and (9, 9)
        Filled; entries outside ``TRANSITION_COLUMNS`` are not touched and must be zero.
    """
    acceleration = acceleration_row(state, parameters, transition[SPEED])
    for column in (SPEED, FORCE_F, FORCE_R, EXTRA):
        transition[SPEED, column] *= time_step
    transition[SPEED, SPEED] += 1.0
    predicted[SPEED] = state[SPEED] + time_step * acceleration
    eta_f, stopped_f = wheel_acceleration(
        torques[DRIVE_F] - torques[BRAKE_F], torques[BRAKE_F] > 0.0, state[FORCE_F], parameters[RADIUS_F],
        parameters[INERTIA_F], state[WHEEL_F], time_step,
    )  # fmt: skip
    eta_r, stopped_r = wheel_acceleration(
        torques[DRIVE_R] - torques[BRAKE_R], torques[BRAKE_R] > 0.0, state[FORCE_R], parameters[RADIUS_R],
        parameters[INERTIA_R], state[WHEEL_R], time_step,
    )  # fmt: skip
    predicted[WHEEL_F] = state[WHEEL_F] + time_step * eta_f
    predicted[WHEEL_R] = state[WHEEL_R] + time_step * eta_r
    transition[WHEEL_F, WHEEL_F] = 0.0 if stopped_f else 1.0
    transition[WHEEL_R, WHEEL_R] = 0.0 if stopped_r else 1.0
    transition[WHEEL_F, FORCE_F] = 0.0 if stopped_f else -time_step * parameters[RADIUS_F] / parameters[INERTIA_F]
    transition[WHEEL_R, FORCE_R] = 0.0 if stopped_r else -time_step * parameters[RADIUS_R] / parameters[INERTIA_R]
    for force in (FORCE_F, FORCE_R, EXTRA):
        predicted[force] = state[force] + time_step * state[force + 1]
        predicted[force + 1] = state[force + 1]
        transition[force, force] = 1.0
        transition[force, force + 1] = time_step
        transition[force + 1, force + 1] = 1.0
    return stopped_f, stopped_r


@njit(cache=True)
def measure(state: FloatArray, parameters: FloatArray, expected: FloatArray, design: FloatArray) -> None:
    """Expected acceleration and wheel speeds and their Jacobian H (eq. 85); zeros outside ``DESIGN_COLUMNS``."""
    expected[ROW_ACCELERATION] = acceleration_row(state, parameters, design[ROW_ACCELERATION])
    expected[ROW_WHEEL_F], expected[ROW_WHEEL_R] = state[WHEEL_F], state[WHEEL_R]
    design[ROW_WHEEL_F, WHEEL_F] = 1.0
    design[ROW_WHEEL_R, WHEEL_R] = 1.0


@njit(cache=True)
def delay_wheel_row(design: FloatArray, row: int, delay: float, radius: float, inertia: float) -> None:
    """H of a wheel speed that is ``delay`` old [s] and was brought forward by the model's own force.

    The sample is w(t - d) = w - (M d - R (F d - F' d^2/2))/Theta: what it tells of the force is in these entries. Left
    out, the force is corrected as if the sample were of now, once more for every sample on the way, and swings up.
    """
    wheel = WHEEL_F if row == ROW_WHEEL_F else WHEEL_R
    force = FORCE_F if row == ROW_WHEEL_F else FORCE_R
    design[row, wheel] = 1.0
    design[row, force] = delay * radius / inertia
    design[row, force + 1] = -0.5 * delay * delay * radius / inertia


@njit(cache=True)
def hold_force_rates(predicted: FloatArray, transition: FloatArray, decay: float) -> None:
    """Let the rates of the axle forces die out while the brakes hold both axles: only the sum is observed then."""
    for rate in (FORCE_RATE_F, FORCE_RATE_R):
        predicted[rate] *= decay
        transition[rate, rate] = decay


@njit(cache=True)
def share_force_noise(state: FloatArray, covariance: FloatArray, variances: FloatArray) -> None:
    """Process noise of the axle forces in proportion to them, instead of independent: their split stays certain."""
    total = abs(state[FORCE_F]) + abs(state[FORCE_R])
    if total <= 0.0:
        return
    share_f, share_r = state[FORCE_F] / total, state[FORCE_R] / total
    whole = variances[FORCE_F] + variances[FORCE_R]
    covariance[FORCE_F, FORCE_F] += whole * share_f * share_f - variances[FORCE_F]
    covariance[FORCE_R, FORCE_R] += whole * share_r * share_r - variances[FORCE_R]
    covariance[FORCE_F, FORCE_R] += whole * share_f * share_r
    covariance[FORCE_R, FORCE_F] += whole * share_f * share_r
