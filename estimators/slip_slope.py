"""Slip-slope method with recursive least squares (Enisz 2015, eqs 24-34; friction document 3.2).

Force is regressed on slip while slip is small; a table of known roads turns the slope into a forecast of the friction
limit before it is reached. At large slip the friction in use is regressed on the load alone.
"""

import math
from collections.abc import Mapping
from functools import partial

import numpy as np
from numba import njit

from estimators.baseline_settings import SlipSlopeSettings, slip_slope_inputs
from estimators.friction_model import slip_ratio
from estimators.inputs import INPUTS_LOST, VALUE, accept_inputs, forget_inputs, input_guard
from estimators.interface import Estimator
from estimators.kalman.covariance import FloatArray, IntArray
from estimators.longitudinal_inputs import IN_ACCELERATION, axle_speeds
from estimators.speed_tracker import track_speed
from estimators.vehicle_numbers import longitudinal_car

(
    SAMPLE_TIME,
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
    BRAKING_START,
    MINIMUM_SPEED,
    FORGETTING,
    STIFFNESS_RATIO,
    LINEAR_SLIP,
    TABLE_SLIP,
    SMALLEST_FORCE,
    PEAK_DECAY,
    USE_REFERENCE_SPEED,
) = range(20)
_VALUES = 20

IN_REFERENCE_SPEED = 5
# estimate, P, noise variance of the two regressions, then speed, forecast, peak, whether the peak was reached
_SLOPE, _USED = 0, 3
_SPEED, _FORECAST, _PEAK, _REACHED = 6, 7, 8, 9
_STATE_SIZE = 10
# slips are of the order of 0.01: a slope is free to move while P is above their inverse square
_FIRST_P = 1e4
_LARGEST_P = 1e6


@njit(cache=True)
def least_squares_step(regression: FloatArray, regressor: float, measured: float, forgetting: float) -> None:
    """One step of recursive least squares with a scalar parameter (eqs 32-34 with the update that the print lacks).

    Parameters
    ----------
    regression : array, shape (3,)
        Parameter, its P and the variance of the error, changed.
    regressor, measured : float
        xi and y.
    forgetting : float
        lambda.
    """
    error = measured - regressor * regression[0]
    weighted = regression[1] * regressor
    divisor = forgetting + regressor * weighted
    regression[0] += weighted / divisor * error
    # without excitation P would grow for ever
    regression[1] = min((regression[1] - weighted * weighted / divisor) / forgetting, _LARGEST_P)
    regression[2] += (1.0 - forgetting) * (error * error - regression[2])


@njit(cache=True)
def force_and_loads(acceleration: float, speed: float, values: FloatArray) -> tuple[float, float, float]:
    """Longitudinal tyre force and the axle loads front and rear [N] (eqs 25 and 26, signed)."""
    drag = values[DRAG_FACTOR] * speed * speed
    force = values[MASS] * acceleration + values[ROLLING_FORCE] + drag
    moment = values[MASS] * acceleration * values[HEIGHT] + drag * values[DRAG_HEIGHT]
    weight, length = values[WEIGHT], values[WHEELBASE]
    front = (weight * (length - values[FRONT_LENGTH]) - moment) / length
    return force, front, weight - front


@njit(cache=True)
def limit_of_slope(slope: float, slopes: FloatArray, limits: FloatArray) -> float:
    """Friction limit of a slip slope by linear interpolation in the table, constant beyond its ends."""
    if slope <= slopes[0]:
        return limits[0]
    for k in range(1, slopes.shape[0]):
        if slope <= slopes[k]:
            part = (slope - slopes[k - 1]) / (slopes[k] - slopes[k - 1])
            return limits[k - 1] + part * (limits[k] - limits[k - 1])
    return limits[-1]


@njit(cache=True)
def _evaluate(
    state: FloatArray, values: FloatArray, slopes: FloatArray, limits: FloatArray, acceleration: float,
    slip_f: float, slip_r: float,
) -> None:  # fmt: skip
    force, load_f, load_r = force_and_loads(acceleration, state[_SPEED], values)
    load = load_f + load_r
    slip = max(abs(slip_f), abs(slip_r))
    least_squares_step(state[_USED : _USED + 3], 1.0, force / load, values[FORGETTING])
    used = abs(state[_USED])
    # in units of the load, so that P does not depend on the car
    regressor = (values[STIFFNESS_RATIO] * slip_f * load_f + slip_r * load_r) / load
    if slip < values[LINEAR_SLIP] and used > values[SMALLEST_FORCE]:
        least_squares_step(state[_SLOPE : _SLOPE + 3], regressor, force / load, values[FORGETTING])
        if slip < values[TABLE_SLIP]:
            state[_FORECAST] = limit_of_slope(state[_SLOPE], slopes, limits)
    if slip >= values[LINEAR_SLIP]:
        state[_REACHED] = 1.0
    state[_PEAK] = max(used, state[_PEAK] * values[PEAK_DECAY])


@njit(cache=True)
def _forget_road(state: FloatArray) -> None:
    state[:] = 0.0
    state[_SLOPE + 1], state[_USED + 1] = _FIRST_P, _FIRST_P
    state[_FORECAST] = 1.0


@njit(cache=True)
def _tick(
    state: FloatArray,
    values: FloatArray,
    slopes: FloatArray,
    limits: FloatArray,
    guard: FloatArray,
    positions: IntArray,
    inputs: FloatArray,
    ages: FloatArray,
    out: FloatArray,
) -> None:
    verdict = accept_inputs(guard, positions, inputs, ages, values[SAMPLE_TIME])
    acceleration = guard[IN_ACCELERATION, VALUE]
    wheel_f, wheel_r = axle_speeds(guard)
    rim_f, rim_r = values[RADIUS_F] * wheel_f, values[RADIUS_R] * wheel_r
    if values[USE_REFERENCE_SPEED] > 0.0:
        speed = max(0.0, guard[IN_REFERENCE_SPEED, VALUE])
    else:
        speed = track_speed(state[_SPEED], acceleration, rim_f, rim_r, values[BRAKING_START], values[SAMPLE_TIME])
    active = verdict != INPUTS_LOST and speed >= values[MINIMUM_SPEED]
    if not active:
        _forget_road(state)
    state[_SPEED] = speed
    slip_f, slip_r = slip_ratio(speed, rim_f), slip_ratio(speed, rim_r)
    if active:
        _evaluate(state, values, slopes, limits, acceleration, slip_f, slip_r)
    reached = state[_REACHED] > 0.0
    out[0], out[1] = 1.0 if active else 0.0, verdict
    out[2], out[3], out[4] = speed, slip_f if active else 0.0, slip_r if active else 0.0
    out[5], out[6] = state[_SLOPE], math.sqrt(max(0.0, state[_SLOPE + 1] * state[_SLOPE + 2]))
    out[7], out[8] = state[_USED], math.sqrt(max(0.0, state[_USED + 1] * state[_USED + 2]))
    out[9] = state[_PEAK] if reached else max(state[_FORECAST], state[_PEAK])
    asked = abs(state[_USED]) > values[SMALLEST_FORCE] and max(abs(slip_f), abs(slip_r)) < values[TABLE_SLIP]
    out[10] = 1.0 if active and (reached or asked) else 0.0


class SlipSlopeRls(Estimator):
    """Slip-slope method; build it with :func:`estimators.create`."""

    def __init__(self, vehicle: Mapping[str, float], settings: SlipSlopeSettings, sample_time_s: float = 0.001) -> None:
        car = longitudinal_car(vehicle, with_brakes=False)
        values = np.zeros(_VALUES)
        values[SAMPLE_TIME], values[MASS], values[WEIGHT] = sample_time_s, car.mass, car.weight
        values[WHEELBASE], values[FRONT_LENGTH] = car.wheelbase, car.front_length
        values[HEIGHT], values[DRAG_HEIGHT] = car.height, car.drag_height
        values[DRAG_FACTOR], values[ROLLING_FORCE] = car.drag_factor, car.rolling_force
        values[RADIUS_F], values[RADIUS_R] = car.radius
        values[BRAKING_START], values[MINIMUM_SPEED] = settings.braking_start, settings.minimum_speed
        values[FORGETTING], values[STIFFNESS_RATIO] = settings.forgetting, settings.stiffness_ratio
        values[LINEAR_SLIP], values[TABLE_SLIP] = settings.linear_slip, settings.table_slip
        values[SMALLEST_FORCE] = settings.smallest_force
        values[PEAK_DECAY] = math.exp(-sample_time_s / settings.peak_time_constant)
        values[USE_REFERENCE_SPEED] = settings.speed_source == "ecu_reference_speed"
        self.settings = settings
        self._state = np.zeros(_STATE_SIZE)
        inputs = slip_slope_inputs(settings)
        self._guard, positions = input_guard(inputs, settings.input_timeout)
        super().__init__("slip_slope_rls", inputs, sample_time_s)
        slopes, limits = np.array(settings.slopes), np.array(settings.limits)
        self.tick = partial(_tick, self._state, values, slopes, limits, self._guard, positions)
        self.reset()

    def reset(self) -> None:
        """Return to the state of a new estimator."""
        _forget_road(self._state)
        forget_inputs(self._guard)
