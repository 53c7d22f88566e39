"""Longitudinal car of the friction filters: single track, quasi-static load transfer, reduced tyre curve.

Friction document, sections 3.6.3 and 3.6.5 (Enisz 2015, eqs 88-99). Written once for the extended and the unscented
filter. State order: speed, wheel speed front, wheel speed rear, slip front, slip rear, friction limit front, its rate,
friction limit rear, its rate. Forces, loads, inertias and torques are those of whole axles (2.4.3 of the document).
"""

import math

from numba import njit

from estimators.kalman.covariance import FloatArray

SPEED, WHEEL_F, WHEEL_R, SLIP_F, SLIP_R, LIMIT_F, RATE_F, LIMIT_R, RATE_R = range(9)
STATES = 9

(
    MASS,
    WEIGHT,
    WHEELBASE,
    FRONT_LENGTH,
    HEIGHT,
    DRAG_HEIGHT,
    DRAG_FACTOR,
    ROLLING_FORCE,
    RADIUS_F,
    RADIUS_R,
    INERTIA_F,
    INERTIA_R,
    SHAPE_F,
    STIFFNESS_F,
    SHAPE_R,
    STIFFNESS_R,
    SLIP_RATE_SIGN,
    EXACT_LOADS,
    SPEED_FLOOR,
) = range(19)
MODEL_PARAMETERS = 19

# rows of the table that axle_forces fills
ACCELERATION, FORCE_F, FORCE_R, AXLES = range(4)
# its columns: value, then the derivatives by the five states that forces depend on
VALUE, BY_SPEED, BY_SLIP_F, BY_SLIP_R, BY_LIMIT_F, BY_LIMIT_R = range(6)
# columns of row AXLES; the last two are written by the prediction
USED_F, USED_R, LOAD_F, LOAD_R, STOPPED_F, STOPPED_R = range(6)


@njit(cache=True)
def axle_forces(state: FloatArray, parameters: FloatArray, forces: FloatArray) -> None:
    """Acceleration and axle forces with their gradients (eqs 90-96).

    Parameters
    ----------
    state : array, shape (9,)
    parameters : array, shape (19,)
    forces : array, shape (4, 6)
        Filled: rows acceleration [m/s^2], front and rear force [N] with value and gradient; last row friction used
        front, rear [1], load front, rear [N].
    """
    speed = max(state[SPEED], parameters[SPEED_FLOOR])
    angle_f = parameters[SHAPE_F] * math.atan(parameters[STIFFNESS_F] * state[SLIP_F])
    angle_r = parameters[SHAPE_R] * math.atan(parameters[STIFFNESS_R] * state[SLIP_R])
    curve_f = math.sin(angle_f)
    curve_r = math.sin(angle_r)
    used_f = state[LIMIT_F] * curve_f
    used_r = state[LIMIT_R] * curve_r
    slope_f = _slope(state[LIMIT_F], angle_f, parameters[SHAPE_F], parameters[STIFFNESS_F], state[SLIP_F])
    slope_r = _slope(state[LIMIT_R], angle_r, parameters[SHAPE_R], parameters[STIFFNESS_R], state[SLIP_R])

    mass, height, wheelbase = parameters[MASS], parameters[HEIGHT], parameters[WHEELBASE]
    drag_height = parameters[DRAG_HEIGHT]
    drag = parameters[DRAG_FACTOR] * speed * speed
    drag_by_speed = 2.0 * parameters[DRAG_FACTOR] * speed if state[SPEED] > parameters[SPEED_FLOOR] else 0.0
    base_f, base_r, load_f, load_r = axle_loads(used_f, used_r, drag, parameters)
    lever = wheelbase + height * (used_f - used_r)
    if parameters[EXACT_LOADS] > 0.0:
        load_f_by_speed = drag_by_speed * (height - drag_height) / lever
    else:
        load_f_by_speed = -drag_by_speed * drag_height / wheelbase

    transfer_f = height * base_f / lever
    transfer_r = height * base_r / lever
    front_by_front = load_f - used_f * transfer_f
    front_by_rear = -used_f * transfer_r
    rear_by_front = used_r * transfer_f
    rear_by_rear = load_r + used_r * transfer_r

    front, rear, acceleration = forces[FORCE_F], forces[FORCE_R], forces[ACCELERATION]
    front[VALUE] = used_f * load_f
    front[BY_SPEED] = used_f * load_f_by_speed
    front[BY_SLIP_F] = front_by_front * slope_f
    front[BY_SLIP_R] = front_by_rear * slope_r
    front[BY_LIMIT_F] = front_by_front * curve_f
    front[BY_LIMIT_R] = front_by_rear * curve_r
    rear[VALUE] = used_r * load_r
    rear[BY_SPEED] = -used_r * load_f_by_speed
    rear[BY_SLIP_F] = rear_by_front * slope_f
    rear[BY_SLIP_R] = rear_by_rear * slope_r
    rear[BY_LIMIT_F] = rear_by_front * curve_f
    rear[BY_LIMIT_R] = rear_by_rear * curve_r
    for c in range(6):
        acceleration[c] = (front[c] + rear[c]) / mass
    acceleration[VALUE] -= (parameters[ROLLING_FORCE] + drag) / mass
    acceleration[BY_SPEED] -= drag_by_speed / mass
    axles = forces[AXLES]
    axles[USED_F], axles[USED_R], axles[LOAD_F], axles[LOAD_R] = used_f, used_r, load_f, load_r


@njit(cache=True)
def axle_loads(used_f: float, used_r: float, drag: float, parameters: FloatArray) -> tuple[float, float, float, float]:
    """Axle loads without and with drag at its own height, front and rear [N] (eq. 95).

    ``EXACT_LOADS`` counts the inertia moment of the whole deceleration, drag and rolling resistance included; eq. 95
    leaves these two out of it.
    """
    weight, height, wheelbase = parameters[WEIGHT], parameters[HEIGHT], parameters[WHEELBASE]
    front_length, drag_height = parameters[FRONT_LENGTH], parameters[DRAG_HEIGHT]
    lever = wheelbase + height * (used_f - used_r)
    if parameters[EXACT_LOADS] > 0.0:
        moment = (parameters[ROLLING_FORCE] + drag) * height - drag * drag_height
        front = (weight * (wheelbase - front_length - height * used_r) + moment) / lever
        return front, weight - front, front, weight - front
    front = weight * (wheelbase - front_length - height * used_r) / lever
    rear = weight * (front_length + height * used_f) / lever
    shift = drag * drag_height / wheelbase
    return front, rear, front - shift, rear + shift


@njit(cache=True)
def axle_motion(state: FloatArray, parameters: FloatArray) -> tuple[float, float, float]:
    """Acceleration [m/s^2] and axle forces front and rear [N], without gradients (eqs 90-96)."""
    speed = max(state[SPEED], parameters[SPEED_FLOOR])
    used_f = state[LIMIT_F] * math.sin(parameters[SHAPE_F] * math.atan(parameters[STIFFNESS_F] * state[SLIP_F]))
    used_r = state[LIMIT_R] * math.sin(parameters[SHAPE_R] * math.atan(parameters[STIFFNESS_R] * state[SLIP_R]))
    drag = parameters[DRAG_FACTOR] * speed * speed
    _, _, load_f, load_r = axle_loads(used_f, used_r, drag, parameters)
    front, rear = used_f * load_f, used_r * load_r
    return (front + rear - parameters[ROLLING_FORCE] - drag) / parameters[MASS], front, rear


@njit(cache=True)
def _slope(limit: float, angle: float, shape: float, stiffness: float, slip: float) -> float:
    scaled = stiffness * slip
    return limit * shape * stiffness * math.cos(angle) / (1.0 + scaled * scaled)


@njit(cache=True)
def slip_ratio(speed: float, rim_speed: float) -> float:
    """Slip (R w - v) / max(R w, v) (eq. 97): -1 for a locked wheel, 0 where nothing moves."""
    fastest = max(speed, rim_speed)
    if fastest <= 0.0:
        return 0.0
    return (rim_speed - speed) / fastest


@njit(cache=True)
def wheel_acceleration(
    torque: float, braking: bool, force: float, radius: float, inertia: float, wheel_speed: float, time_step: float
) -> tuple[float, bool]:
    """Acceleration of an axle's wheels [rad/s^2] and whether the brake stops them within this step (eq. 91).

    A brake resists, it never turns a wheel backwards: where the torque that it could transmit is more than needed, the
    wheel stands still at the end of the step.
    """
    acceleration = (torque - radius * force) / inertia
    if braking and wheel_speed + time_step * acceleration < 0.0:
        return -wheel_speed / time_step, True
    return acceleration, False


@njit(cache=True)
def slip_rate(
    speed: float,
    wheel_speed: float,
    slip: float,
    acceleration: float,
    wheel_acceleration_: float,
    radius: float,
    sign: float,
) -> float:
    """Rate of change of the slip state (eq. 98).

    ``sign`` +1 is the derivative of eq. 97; -1 is the equation as printed, wrong in the branch v >= R w.
    """
    if speed >= radius * wheel_speed:
        return (-(1.0 + slip) * acceleration + sign * radius * wheel_acceleration_) / speed
    return (1.0 - slip) * wheel_acceleration_ / wheel_speed - acceleration / (radius * wheel_speed)
