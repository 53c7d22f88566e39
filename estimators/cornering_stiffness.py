"""Cornering-stiffness method (Enisz 2015, eqs 35-40; friction document 3.3).

The slope of side friction over slip angle, regressed over the shortest window that spans enough slip angle; where it
vanishes, the axle is at its limit.
"""

import math
from collections.abc import Mapping
from functools import partial

import numpy as np
from numba import njit

from estimators.baseline_settings import CorneringStiffnessSettings, cornering_stiffness_inputs
from estimators.inputs import INPUTS_LOST, VALUE, accept_inputs, forget_inputs, input_guard
from estimators.interface import Estimator
from estimators.kalman.covariance import FloatArray, IntArray
from estimators.longitudinal_inputs import axle_speeds
from estimators.vehicle_numbers import GRAVITY_M_S2, longitudinal_car, required

(
    SAMPLE_TIME,
    MASS,
    WEIGHT,
    WHEELBASE,
    FRONT_LENGTH,
    HEIGHT,
    YAW_INERTIA,
    STEERING_RATIO,
    RADIUS_F,
    RADIUS_R,
    MINIMUM_SPEED,
    SPAN,
    FLAT_SLOPE,
    YAW_WEIGHT,
    SIDE_SLIP_DECAY,
    SIGNAL_WEIGHT,
    ROLL_FACTOR,
) = range(17)
_VALUES = 17

IN_LONGITUDINAL, IN_LATERAL, IN_YAW_RATE, IN_STEERING = 0, 5, 6, 7

_YAW_RATE_BEFORE, _YAW_ACCELERATION, _SIDE_SLIP, _NEXT, _FILLED = range(5)
_FILTERED = 5  # slip angle and friction of the front, then of the rear axle
_STATE_SIZE = 9
_CONFIDENCES = 17
"""Outputs from here on are the confidences of angles and friction in use."""


@njit(cache=True)
def axle_side_forces(lateral_acceleration: float, yaw_acceleration: float, values: FloatArray) -> tuple[float, float]:
    """Side forces of the front and the rear axle [N] (eq. 38)."""
    inertia = values[YAW_INERTIA] * yaw_acceleration
    rear_length = values[WHEELBASE] - values[FRONT_LENGTH]
    front = (values[MASS] * lateral_acceleration * rear_length + inertia) / values[WHEELBASE]
    rear = (values[MASS] * lateral_acceleration * values[FRONT_LENGTH] - inertia) / values[WHEELBASE]
    return front, rear


@njit(cache=True)
def axle_slip_angles(
    steer: float, side_slip: float, yaw_rate: float, speed: float, values: FloatArray
) -> tuple[float, float]:
    """Slip angles of the front and the rear axle [rad], positive with positive side force (eq. 37)."""
    rear_length = values[WHEELBASE] - values[FRONT_LENGTH]
    front = steer - side_slip - yaw_rate * values[FRONT_LENGTH] / speed
    rear = -side_slip + yaw_rate * rear_length / speed
    return front, rear


@njit(cache=True)
def window_slope(
    angles: FloatArray, frictions: FloatArray, newest: int, filled: int, span: float, result: FloatArray
) -> None:
    """Slope of friction over slip angle in the shortest window that spans ``span`` (eqs 39 and 40).

    Parameters
    ----------
    angles, frictions : array, shape (n,)
        Rings of samples.
    newest, filled : int
        Position of the newest sample, number of samples in the ring.
    result : array, shape (3,)
        Filled with slope [1/rad], its standard deviation [1/rad] and length of the window in samples, 0 if no window
        spans it; the slope then stays as it is.
    """
    size = angles.shape[0]
    low, high = angles[newest], angles[newest]
    # sums about the newest sample keep small differences exact
    angle_0, friction_0 = angles[newest], frictions[newest]
    sum_a, sum_f, sum_aa, sum_af, sum_ff = 0.0, 0.0, 0.0, 0.0, 0.0
    for k in range(filled):
        position = newest - k if newest >= k else newest - k + size
        angle, friction = angles[position] - angle_0, frictions[position] - friction_0
        sum_a += angle
        sum_f += friction
        sum_aa += angle * angle
        sum_af += angle * friction
        sum_ff += friction * friction
        low, high = min(low, angles[position]), max(high, angles[position])
        if high - low >= span and k >= 2:
            count = k + 1.0
            spread = sum_aa - sum_a * sum_a / count
            common = sum_af - sum_a * sum_f / count
            slope = common / spread
            rest = max(0.0, sum_ff - sum_f * sum_f / count - slope * common)
            result[0], result[1], result[2] = slope, math.sqrt(rest / (count - 2.0) / spread), count
            return
    result[2] = 0.0


@njit(cache=True)
def _follow(state: FloatArray, values: FloatArray, speed: float, lateral: float, yaw_rate: float) -> None:
    """Yaw acceleration and side-slip angle of this tick."""
    step = values[SAMPLE_TIME]
    derivative = (yaw_rate - state[_YAW_RATE_BEFORE]) / step
    state[_YAW_RATE_BEFORE] = yaw_rate
    state[_YAW_ACCELERATION] += values[YAW_WEIGHT] * (derivative - state[_YAW_ACCELERATION])
    # integrated from a_y / v - yaw rate, returning slowly to the value of slow rolling, L_r yaw rate / v
    rolling = (values[WHEELBASE] - values[FRONT_LENGTH]) * yaw_rate / speed
    state[_SIDE_SLIP] += step * (lateral / speed - yaw_rate)
    state[_SIDE_SLIP] = rolling + values[SIDE_SLIP_DECAY] * (state[_SIDE_SLIP] - rolling)


@njit(cache=True)
def _tick(
    state: FloatArray,
    rings: FloatArray,
    slopes: FloatArray,
    values: FloatArray,
    guard: FloatArray,
    positions: IntArray,
    inputs: FloatArray,
    ages: FloatArray,
    out: FloatArray,
) -> None:
    verdict = accept_inputs(guard, positions, inputs, ages, values[SAMPLE_TIME])
    wheel_f, wheel_r = axle_speeds(guard)
    speed = 0.5 * (values[RADIUS_F] * wheel_f + values[RADIUS_R] * wheel_r)
    active = verdict != INPUTS_LOST and speed >= values[MINIMUM_SPEED]
    out[:] = 0.0
    out[0], out[1] = 1.0 if active else 0.0, verdict
    if not active:
        state[:] = 0.0
        state[_YAW_RATE_BEFORE] = guard[IN_YAW_RATE, VALUE]
        slopes[:] = 0.0
        return
    # a body that leans out by c a under the lateral acceleration a makes the accelerometer read a + g sin(c a)
    lateral, yaw_rate = guard[IN_LATERAL, VALUE] * values[ROLL_FACTOR], guard[IN_YAW_RATE, VALUE]
    _follow(state, values, speed, lateral, yaw_rate)
    steer = guard[IN_STEERING, VALUE] / values[STEERING_RATIO]
    angle_f, angle_r = axle_slip_angles(steer, state[_SIDE_SLIP], yaw_rate, speed, values)
    force_f, force_r = axle_side_forces(lateral, state[_YAW_ACCELERATION], values)
    transfer = values[MASS] * guard[IN_LONGITUDINAL, VALUE] * values[HEIGHT] / values[WHEELBASE]
    load_f = values[WEIGHT] * (values[WHEELBASE] - values[FRONT_LENGTH]) / values[WHEELBASE] - transfer
    load_r = values[WEIGHT] - load_f
    newest, size = int(state[_NEXT]), rings.shape[1]
    state[_FILLED] = min(state[_FILLED] + 1.0, float(size))
    state[_NEXT] = (newest + 1) % size
    sample = (angle_f, force_f / load_f, angle_r, force_r / load_r)
    for k in range(4):
        if state[_FILLED] == 1.0:
            state[_FILTERED + k] = sample[k]
        state[_FILTERED + k] += values[SIGNAL_WEIGHT] * (sample[k] - state[_FILTERED + k])
        rings[k, newest] = state[_FILTERED + k]
    out[2], out[3], out[4] = state[_SIDE_SLIP], angle_f, angle_r
    out[5], out[6] = sample[1], sample[3]
    out[_CONFIDENCES:] = 1.0
    for axle in range(2):
        result = slopes[axle]
        window_slope(rings[2 * axle], rings[2 * axle + 1], newest, int(state[_FILLED]), values[SPAN], result)
        spans = result[2] > 0.0
        out[7 + 3 * axle], out[8 + 3 * axle] = result[0], result[1]
        out[9 + 3 * axle] = 1.0 if spans else 0.0
        out[13 + axle] = result[2] * values[SAMPLE_TIME]
        out[15 + axle] = 1.0 if spans and result[0] <= values[FLAT_SLOPE] else 0.0


class CorneringStiffnessRls(Estimator):
    """Cornering-stiffness method; build it with :func:`estimators.create`."""

    def __init__(
        self, vehicle: Mapping[str, float], settings: CorneringStiffnessSettings, sample_time_s: float = 0.001
    ) -> None:
        car = longitudinal_car(vehicle, with_brakes=False)
        values = np.zeros(_VALUES)
        values[SAMPLE_TIME], values[MASS], values[WEIGHT] = sample_time_s, car.mass, car.weight
        values[WHEELBASE], values[FRONT_LENGTH], values[HEIGHT] = car.wheelbase, car.front_length, car.height
        values[YAW_INERTIA] = required(vehicle, "body.yaw_inertia")
        values[STEERING_RATIO] = required(vehicle, "steering.ratio")
        values[RADIUS_F], values[RADIUS_R] = car.radius
        values[MINIMUM_SPEED] = settings.minimum_speed
        values[SPAN], values[FLAT_SLOPE] = settings.slip_angle_span, settings.flat_slope
        values[YAW_WEIGHT] = min(1.0, sample_time_s / settings.yaw_acceleration_time_constant)
        values[SIDE_SLIP_DECAY] = math.exp(-sample_time_s / settings.side_slip_time_constant)
        values[ROLL_FACTOR] = 1.0 / (1.0 + GRAVITY_M_S2 * settings.roll_gradient)
        values[SIGNAL_WEIGHT] = min(1.0, sample_time_s / settings.signal_time_constant)
        self.settings = settings
        self._state, self._slopes = np.zeros(_STATE_SIZE), np.zeros((2, 3))
        inputs = cornering_stiffness_inputs(settings)
        self._guard, positions = input_guard(inputs, settings.input_timeout)
        super().__init__("cornering_stiffness_rls", inputs, sample_time_s)
        rings = np.zeros((4, settings.longest_window))
        self.tick = partial(_tick, self._state, rings, self._slopes, values, self._guard, positions)

    def reset(self) -> None:
        """Return to the state of a new estimator."""
        self._state[:] = 0.0
        self._slopes[:] = 0.0
        forget_inputs(self._guard)
