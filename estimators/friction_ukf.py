"""Unscented (or cubature) Kalman filter for the friction between tyre and road.

The document's own next step (3.8, l. 1826): states, model, measurements, noise, start and outputs are those of the
friction EKF; sigma points take the place of the Jacobians.
"""

from collections.abc import Mapping
from functools import partial

import numpy as np
from numba import njit

from estimators.friction_filter import FrictionFilter, finish_tick, prepare_step
from estimators.friction_jacobians import (
    MEASUREMENTS,
    ROW_ACCELERATION,
    ROW_LIMIT_F,
    ROW_LIMIT_R,
    ROW_SLIP_F,
    ROW_SLIP_R,
    ROW_SPEED,
    ROW_WHEEL_F,
    ROW_WHEEL_R,
    share_limit_noise,
)
from estimators.friction_model import (
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
    WHEEL_F,
    WHEEL_R,
    axle_motion,
    slip_rate,
    slip_ratio,
    wheel_acceleration,
)
from estimators.friction_settings import FrictionUkfSettings
from estimators.friction_step import (
    INNOVATION,
    KINEMATIC_WHEELS,
    LOCKED_RATE_DECAY,
    PROCESS_VARIANCE,
    SAMPLE_TIME,
    compensate_sensors,
)
from estimators.kalman.correction import ROW_STALE
from estimators.kalman.covariance import FloatArray, IntArray
from estimators.kalman.sigma_points import (
    correct_points,
    cubature_weights,
    draw_points,
    predict_points,
    unscented_weights,
)
from estimators.longitudinal_inputs import BRAKE_F, BRAKE_R, DRIVE_F, DRIVE_R

POINTS = 2 * STATES + 1

# rows of the memory, nine columns each
_STATE, _TORQUES = 0, 1
_COVARIANCE = 2
_FACTOR = _COVARIANCE + STATES
_NOISE = _FACTOR + STATES
_POINTS = _NOISE + STATES
_FORCES = _POINTS + POINTS
_MEMORY_ROWS = _FORCES + 3

# rows of the second memory, eight columns each
_MEASURED, _VARIANCES = 0, 1
_EXPECTED = 2
_OUTPUTS = 4
_INNOVATION = _OUTPUTS + POINTS
_ROW_NOISE = _INNOVATION + 2 * MEASUREMENTS
_CROSS = _ROW_NOISE + MEASUREMENTS
_GAIN = _CROSS + STATES
_MEASUREMENT_ROWS = _GAIN + STATES


@njit(cache=True)
def step_point(point: FloatArray, torques: FloatArray, time_step: float, tuning: FloatArray) -> tuple[bool, bool]:
    """Explicit Euler step of a state in place; whether the brakes stop the front and the rear axle."""
    acceleration, force_f, force_r = axle_motion(point, tuning)
    speed = max(point[SPEED], tuning[SPEED_FLOOR])
    point[SPEED] += time_step * acceleration
    point[LIMIT_F] += time_step * point[RATE_F]
    point[LIMIT_R] += time_step * point[RATE_R]
    if tuning[KINEMATIC_WHEELS] > 0.0:
        return False, False
    sign = tuning[SLIP_RATE_SIGN]
    eta_f, stopped_f = wheel_acceleration(
        torques[DRIVE_F] - torques[BRAKE_F], torques[BRAKE_F] > 0.0, force_f, tuning[RADIUS_F], tuning[INERTIA_F],
        point[WHEEL_F], time_step,
    )  # fmt: skip
    eta_r, stopped_r = wheel_acceleration(
        torques[DRIVE_R] - torques[BRAKE_R], torques[BRAKE_R] > 0.0, force_r, tuning[RADIUS_R], tuning[INERTIA_R],
        point[WHEEL_R], time_step,
    )  # fmt: skip
    rate_f = slip_rate(speed, point[WHEEL_F], point[SLIP_F], acceleration, eta_f, tuning[RADIUS_F], sign)
    rate_r = slip_rate(speed, point[WHEEL_R], point[SLIP_R], acceleration, eta_r, tuning[RADIUS_R], sign)
    point[WHEEL_F] += time_step * eta_f
    point[WHEEL_R] += time_step * eta_r
    point[SLIP_F] += time_step * rate_f
    point[SLIP_R] += time_step * rate_r
    return stopped_f, stopped_r


@njit(cache=True)
def measure_point(point: FloatArray, tuning: FloatArray, output: FloatArray) -> None:
    """The eight expected measurements of a state."""
    speed = max(point[SPEED], tuning[SPEED_FLOOR])
    output[ROW_ACCELERATION] = axle_motion(point, tuning)[0]
    output[ROW_WHEEL_F], output[ROW_WHEEL_R] = point[WHEEL_F], point[WHEEL_R]
    output[ROW_SLIP_F] = slip_ratio(speed, tuning[RADIUS_F] * point[WHEEL_F]) - point[SLIP_F]
    output[ROW_SLIP_R] = slip_ratio(speed, tuning[RADIUS_R] * point[WHEEL_R]) - point[SLIP_R]
    output[ROW_LIMIT_F], output[ROW_LIMIT_R] = point[LIMIT_F], point[LIMIT_R]
    output[ROW_SPEED] = point[SPEED]


@njit(cache=True)
def filter_step(
    memory: FloatArray,
    second: FloatArray,
    history: FloatArray,
    tuning: FloatArray,
    weights: FloatArray,
    rows: IntArray,
) -> float:
    """One step of the filter; the normalised innovation squared, NaN where a covariance is not positive definite."""
    state, torques = memory[_STATE], memory[_TORQUES]
    covariance, factor = memory[_COVARIANCE:_FACTOR], memory[_FACTOR:_NOISE]
    noise, points = memory[_NOISE:_POINTS], memory[_POINTS:_FORCES]
    mean_weights, covariance_weights, spread = weights[0], weights[1], weights[2, 0]
    if not draw_points(state, covariance, spread, points, factor):
        return np.nan
    stopped_f, stopped_r = step_point(points[0], torques, tuning[SAMPLE_TIME], tuning)
    for k in range(1, POINTS):
        step_point(points[k], torques, tuning[SAMPLE_TIME], tuning)
    blind_f = stopped_f or rows[ROW_WHEEL_F] == ROW_STALE
    blind_r = stopped_r or rows[ROW_WHEEL_R] == ROW_STALE
    locked = blind_f and blind_r
    if locked:
        for k in range(POINTS):
            points[k, RATE_F] *= tuning[LOCKED_RATE_DECAY]
            points[k, RATE_R] *= tuning[LOCKED_RATE_DECAY]
    before_f, before_r = state[WHEEL_F], state[WHEEL_R]
    predict_points(points, mean_weights, covariance_weights, noise, state, covariance)
    compensate_sensors(
        history, tuning, state[WHEEL_F] - before_f, state[WHEEL_R] - before_r, second[_MEASURED], second[_VARIANCES]
    )
    for r in range(MEASUREMENTS):
        second[_ROW_NOISE + r, r] = second[_VARIANCES, r]
    if locked:
        share_limit_noise(covariance, tuning[PROCESS_VARIANCE : PROCESS_VARIANCE + STATES])
    if not draw_points(state, covariance, spread, points, factor):
        return np.nan
    outputs = second[_OUTPUTS:_INNOVATION]
    for k in range(POINTS):
        measure_point(points[k], tuning, outputs[k])
    return correct_points(
        state,
        covariance,
        points,
        outputs,
        mean_weights,
        covariance_weights,
        second[_ROW_NOISE:_CROSS],
        second[_MEASURED],
        rows,
        second[_EXPECTED:_OUTPUTS],
        second[_INNOVATION:_ROW_NOISE].reshape(2, MEASUREMENTS, MEASUREMENTS),
        second[_CROSS:_GAIN],
        second[_GAIN:_MEASUREMENT_ROWS],
    )


@njit(cache=True)
def _tick(
    memory: FloatArray,
    second: FloatArray,
    history: FloatArray,
    weights: FloatArray,
    status: FloatArray,
    filters: FloatArray,
    rows: IntArray,
    tuning: FloatArray,
    guard: FloatArray,
    positions: IntArray,
    inputs: FloatArray,
    ages: FloatArray,
    out: FloatArray,
) -> None:
    state, covariance = memory[_STATE], memory[_COVARIANCE:_FACTOR]
    torques, measured = memory[_TORQUES], second[_MEASURED]
    stepped = prepare_step(
        state, covariance, status, history, tuning, guard, positions, inputs, ages, torques, measured, rows
    )
    if stepped:
        status[INNOVATION] = filter_step(memory, second, history, tuning, weights, rows)
    forces = memory[_FORCES:_MEMORY_ROWS].ravel()[:24].reshape(4, 6)
    finish_tick(stepped, state, covariance, status, tuning, forces, filters, out)


class FrictionUkf(FrictionFilter):
    """Friction UKF; build it with :func:`estimators.create`."""

    settings: FrictionUkfSettings

    def __init__(
        self, vehicle: Mapping[str, float], settings: FrictionUkfSettings, sample_time_s: float = 0.001
    ) -> None:
        super().__init__("friction_ukf", vehicle, settings, sample_time_s, _MEMORY_ROWS, _COVARIANCE)
        self._second = np.zeros((_MEASUREMENT_ROWS, MEASUREMENTS))
        self._memory[_NOISE:_POINTS] = np.diag(self._tuning[PROCESS_VARIANCE : PROCESS_VARIANCE + STATES])
        self._weights = np.zeros((3, POINTS))
        mean, covariance, spread = (
            cubature_weights(STATES)
            if settings.points == "cubature"
            else unscented_weights(STATES, settings.alpha, settings.beta, settings.kappa)
        )
        self._weights[0], self._weights[1], self._weights[2, 0] = mean, covariance, spread
        self.tick = partial(
            _tick,
            self._memory,
            self._second,
            self._history,
            self._weights,
            self._status,
            self._filters,
            self._rows,
            self._tuning,
            self._guard,
            self._positions,
        )
