"""Extended Kalman filter with axle forces as random walks: what the neural observer is compared with (B2).

Source: force document, section 4 (baselines); model (15c) with constant forces.
"""

import math
from collections.abc import Mapping
from functools import partial
from typing import Any

import numpy as np
from numba import njit

from estimators.inputs import INPUTS_LOST, VALUE, accept_inputs, forget_inputs, input_guard
from estimators.interface import Estimator
from estimators.kalman.correction import ROW_USED, correct_rows
from estimators.kalman.covariance import FloatArray, IntArray, all_finite, propagate
from estimators.neural_force_model import force_car, mean_rim_speed, rolls
from estimators.neural_force_settings import RandomWalkForceSettings, random_walk_inputs

STATES = 5
SPEED, LATERAL_SPEED, YAW_RATE, FORCE_F, FORCE_R = range(STATES)
_IN_YAW_RATE, _IN_ANGLE, _IN_WHEELS = range(3)
_ACTIVE, _RESETS, _VERDICT, _INNOVATION = range(4)
_INITIAL_VARIANCE = np.array([1.0, 0.1, 0.1, 300.0**2, 3000.0**2])
"""P_0 of the document."""

_COLUMNS = np.tile(np.arange(STATES), (2, 1))


@njit(cache=True)
def predict(car: Any, x: FloatArray, angle: float, step: float, next_x: FloatArray, jacobian: FloatArray) -> None:
    """Euler step of (15c) with constant forces, and its Jacobian by the state."""
    divisor = max(x[SPEED], car.slowest)
    moving = 1.0 if x[SPEED] > car.slowest else 0.0
    drift_f, drift_r = x[LATERAL_SPEED] + car.to_front * x[YAW_RATE], x[LATERAL_SPEED] - car.to_rear * x[YAW_RATE]
    side_f, side_r = car.front * (angle - drift_f / divisor), -car.rear * drift_r / divisor
    # side forces by speed, lateral speed, yaw rate
    f_speed, r_speed = moving * car.front * drift_f / divisor**2, moving * car.rear * drift_r / divisor**2
    f_drift, r_drift = -car.front / divisor, -car.rear / divisor
    m, i_z, a, b = car.mass, car.yaw_inertia, car.to_front, car.to_rear
    rates = jacobian
    rates[:] = 0.0
    rates[SPEED, SPEED] = -angle * f_speed / m
    rates[SPEED, LATERAL_SPEED] = x[YAW_RATE] - angle * f_drift / m
    rates[SPEED, YAW_RATE] = x[LATERAL_SPEED] - angle * a * f_drift / m
    rates[SPEED, FORCE_F] = rates[SPEED, FORCE_R] = 1.0 / m
    rates[LATERAL_SPEED, SPEED] = -x[YAW_RATE] + (f_speed + r_speed) / m
    rates[LATERAL_SPEED, LATERAL_SPEED] = (f_drift + r_drift) / m
    rates[LATERAL_SPEED, YAW_RATE] = -x[SPEED] + (a * f_drift - b * r_drift) / m
    rates[LATERAL_SPEED, FORCE_F] = angle / m
    rates[YAW_RATE, SPEED] = (a * f_speed - b * r_speed) / i_z
    rates[YAW_RATE, LATERAL_SPEED] = (a * f_drift - b * r_drift) / i_z
    rates[YAW_RATE, YAW_RATE] = (a * a * f_drift + b * b * r_drift) / i_z
    rates[YAW_RATE, FORCE_F] = a * angle / i_z
    for i in range(STATES):
        for j in range(STATES):
            jacobian[i, j] = step * rates[i, j] + (1.0 if i == j else 0.0)
        next_x[i] = x[i]
    next_x[SPEED] += step * (x[LATERAL_SPEED] * x[YAW_RATE] + (x[FORCE_F] + x[FORCE_R] - side_f * angle) / m)
    next_x[LATERAL_SPEED] += step * (-x[SPEED] * x[YAW_RATE] + (x[FORCE_F] * angle + side_f + side_r) / m)
    next_x[YAW_RATE] += step * (a * (x[FORCE_F] * angle + side_f) - b * side_r) / i_z


@njit(cache=True)
def _begin(memory: FloatArray, speed: float, yaw_rate: float, initial: FloatArray) -> None:
    memory[: STATES + 1] = 0.0
    memory[0, SPEED], memory[0, YAW_RATE] = speed, yaw_rate
    for i in range(STATES):
        memory[1 + i, i] = initial[i]


@njit(cache=True)
def _tick(
    memory: FloatArray,
    status: FloatArray,
    car_rows: Any,
    process: FloatArray,
    noise: FloatArray,
    initial: FloatArray,
    columns: IntArray,
    rows: IntArray,
    guard: FloatArray,
    positions: IntArray,
    step: float,
    inputs: FloatArray,
    ages: FloatArray,
    out: FloatArray,
) -> None:
    car = car_rows[0]
    x, covariance = memory[0], memory[1 : 1 + STATES]
    next_x, jacobian, work = memory[1 + STATES], memory[2 + STATES : 2 + 2 * STATES], memory[2 + 2 * STATES :]
    status[_VERDICT] = accept_inputs(guard, positions, inputs, ages, step)
    speed = mean_rim_speed(car, guard, _IN_WHEELS)
    yaw_rate = guard[_IN_YAW_RATE, VALUE]
    if status[_VERDICT] == INPUTS_LOST or not rolls(car, guard, _IN_WHEELS, status[_ACTIVE] > 0.0):
        status[_RESETS] += status[_ACTIVE]
        status[_ACTIVE] = status[_INNOVATION] = 0.0
        _begin(memory, 0.0, 0.0, initial)
    else:
        if status[_ACTIVE] == 0.0:
            _begin(memory, speed, yaw_rate, initial)
            status[_ACTIVE] = 1.0
        predict(car, x, guard[_IN_ANGLE, VALUE], step, next_x, jacobian)
        propagate(covariance, jacobian, process, work[:STATES])
        for i in range(STATES):
            x[i] = next_x[i]
        residual, design = work[STATES, :2], work[STATES + 1 : STATES + 3]
        design[:] = 0.0
        design[0, SPEED] = design[1, YAW_RATE] = 1.0
        residual[0], residual[1] = speed - x[SPEED], yaw_rate - x[YAW_RATE]
        rows[0] = rows[1] = ROW_USED
        status[_INNOVATION] = correct_rows(
            x, covariance, residual, design, noise, rows, 0.0, columns, work[STATES + 3 : STATES + 7]
        )
        if not all_finite(x):
            status[_RESETS] += 1.0
            _begin(memory, speed, yaw_rate, initial)
    out[0], out[1], out[2] = status[_ACTIVE], status[_RESETS], status[_VERDICT]
    for i in range(STATES):
        out[3 + 2 * i] = x[i]
        out[4 + 2 * i] = math.sqrt(max(covariance[i, i], 0.0))
    out[3 + 2 * STATES] = status[_INNOVATION]


class RandomWalkForce(Estimator):
    """Random-walk force filter; build it with :func:`estimators.create`.

    Attributes
    ----------
    state, covariance : arrays, shapes (5,) and (5, 5)
        Longitudinal, lateral speed [m/s], yaw rate [rad/s], front, rear force [N]; views.
    """

    def __init__(
        self, vehicle: Mapping[str, float], settings: RandomWalkForceSettings, sample_time_s: float = 0.001
    ) -> None:
        self.settings = settings
        self._memory = np.zeros((2 + 2 * STATES + STATES + 7, STATES))
        self.state, self.covariance = self._memory[0], self._memory[1 : 1 + STATES]
        self._status = np.zeros(4)
        deviations = (
            settings.process_speed,
            settings.process_speed,
            settings.process_yaw_rate,
            settings.process_force_front,
            settings.process_force_rear,
        )
        process = np.diag(np.square(deviations)) * sample_time_s
        noise = np.square([settings.measurement_speed, settings.measurement_yaw_rate])
        names = random_walk_inputs(settings)
        self._guard, positions = input_guard(names, settings.input_timeout)
        super().__init__("random_walk_force_ekf", names, sample_time_s)
        self.tick = partial(
            _tick,
            self._memory,
            self._status,
            force_car(vehicle, settings),
            process,
            noise,
            _INITIAL_VARIANCE,
            _COLUMNS,
            np.zeros(2, dtype=np.int64),
            self._guard,
            positions,
            sample_time_s,
        )
        self.reset()

    def reset(self) -> None:
        """Return to the state of a new filter."""
        self._status[:] = 0.0
        _begin(self._memory, 0.0, 0.0, _INITIAL_VARIANCE)
        forget_inputs(self._guard)
