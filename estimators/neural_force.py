"""Cascade of two observers with radial-basis-function networks for longitudinal tyre forces (force document, 3).

Observer 1 learns the front force from the yaw rate and gives the lateral speed; observer 2 learns the rear force from
the longitudinal speed. An error of the front force passes into the rear one with the opposite sign: their sum alone is
observable without steering.
"""

import math
from collections.abc import Mapping
from functools import partial
from typing import Any

import numpy as np
from numba import njit

from estimators.inputs import INPUTS_LOST, VALUE, accept_inputs, forget_inputs, input_guard
from estimators.interface import Estimator
from estimators.kalman.covariance import FloatArray, IntArray, all_finite
from estimators.neural_force_model import force_car, mean_rim_speed, network_centres, observer_gains, rolls
from estimators.neural_force_settings import NEURAL_FORCE_OUTPUTS, NeuralForceSettings, neural_force_inputs

IN_YAW_RATE, IN_ANGLE, IN_COMMAND, IN_WHEELS = range(4)
YAW_RATE, LATERAL_SPEED, SPEED, ANGLE = range(4)

_ACTIVE, _RESETS, _VERDICT, _CONFIDENCE, _SETTLED = range(5)
_STEP, _GAIN_YAW, _GAIN_LATERAL, _GAIN_SPEED, _GAIN_ANGLE = range(5)
_LEARN_FRONT, _LEARN_REAR, _FORGET_FRONT, _FORGET_REAR, _WIDTH = range(5, 10)
_NORMALISED, _INTEGRAL, _NO_SQUARE, _DOUBLE_COUNT, _WANDERING, _SLOWEST_POLE, _STATE_ERROR = range(10, 17)
_TUNING_SIZE = 17

# scales of the networks' inputs (3.4)
_YAW_SCALE, _LATERAL_SCALE, _SPEED_SCALE, _ANGLE_SCALE = 0.5, 1.0, 25.0, 1.0
_SMALL = 1e-9
_POSITION = {output.name: position for position, output in enumerate(NEURAL_FORCE_OUTPUTS)}
_OUT_LATERAL, _OUT_FRONT, _OUT_REAR = (_POSITION[name] for name in ("lateral_speed", "force_front", "force_rear"))
_OUT_TOTAL, _OUT_SPEED = _POSITION["force_total"], _POSITION["speed"]
_OUT_YAW, _OUT_ANGLE = _POSITION["yaw_rate"], _POSITION["road_wheel_angle"]


@njit(cache=True)
def regressors(first: float, second: float, grid: FloatArray, tuning: FloatArray, out: FloatArray) -> None:
    """Activations of a network at its two inputs, of length 1 if normalised.

    Parameters
    ----------
    grid : array, shape (n, 2)
        Centres.
    out : array, shape (n,)
    """
    n = grid.shape[0]
    if tuning[_INTEGRAL] > 0.0:
        for i in range(n):
            out[i] = 1.0 / math.sqrt(n)
        return
    width = tuning[_WIDTH]
    total = 0.0
    for i in range(n):
        squared = (first - grid[i, 0]) ** 2 + (second - grid[i, 1]) ** 2
        distance = math.sqrt(squared) if tuning[_NO_SQUARE] > 0.0 else squared
        out[i] = math.exp(-distance / (2.0 * width * width))
        total += out[i] * out[i]
    if tuning[_NORMALISED] > 0.0:
        scale = 1.0 / math.sqrt(total + _SMALL)
        for i in range(n):
            out[i] *= scale


@njit(cache=True)
def _dot(left: FloatArray, right: FloatArray) -> float:
    total = 0.0
    for i in range(left.shape[0]):
        total += left[i] * right[i]
    return total


@njit(cache=True)
def _learn(weights: FloatArray, activations: FloatArray, push: float, forgetting: float, step: float) -> None:
    """W <- W + h (g sigma phi e - kappa W), from the output error alone (3c)."""
    for i in range(weights.shape[0]):
        weights[i] += step * (push * activations[i] - forgetting * weights[i])


@njit(cache=True)
def _observe(
    x: FloatArray,
    status: FloatArray,
    networks: tuple[FloatArray, FloatArray],
    grids: tuple[FloatArray, FloatArray],
    active: tuple[FloatArray, FloatArray],
    car: Any,
    tuning: FloatArray,
    guard: FloatArray,
    told: FloatArray,
) -> None:
    """One explicit Euler step of both observers (3.6)."""
    h = tuning[_STEP]
    yaw, angle, command = guard[IN_YAW_RATE, VALUE], guard[IN_ANGLE, VALUE], guard[IN_COMMAND, VALUE]
    speed = mean_rim_speed(car, guard, IN_WHEELS)
    divisor = max(speed, car.slowest)
    rear = car.rear_sign * car.rear
    regressors(x[YAW_RATE] / _YAW_SCALE, x[LATERAL_SPEED] / _LATERAL_SCALE, grids[0], tuning, active[0])
    regressors(x[SPEED] / _SPEED_SCALE, x[ANGLE] / _ANGLE_SCALE, grids[1], tuning, active[1])
    force_f, force_r = _dot(networks[0], active[0]), _dot(networks[1], active[1])
    error_yaw, error_speed, error_angle = yaw - x[YAW_RATE], speed - x[SPEED], angle - x[ANGLE]
    # observer 1 (20c): the measured yaw rate inside the model
    front_drift = car.front * (x[LATERAL_SPEED] + car.to_front * yaw) / divisor
    rear_drift = rear * (x[LATERAL_SPEED] - car.to_rear * yaw) / divisor
    pull = angle * (force_f + car.front)
    yaw_rate = car.to_front * (pull - front_drift) + car.to_rear * rear_drift
    yaw_rate = yaw_rate / car.yaw_inertia + tuning[_GAIN_YAW] * error_yaw
    lateral = -speed * yaw + (pull - front_drift - rear_drift) / car.mass + tuning[_GAIN_LATERAL] * error_yaw
    # observer 2 (3.3): on what observer 1 has found
    cornering = car.front * (x[LATERAL_SPEED] + car.to_front * x[YAW_RATE]) * x[ANGLE] / divisor
    along = x[LATERAL_SPEED] * x[YAW_RATE] + tuning[_GAIN_SPEED] * error_speed
    along += (force_f + force_r - car.front * x[ANGLE] ** 2 + cornering) / car.mass
    steering = (command - x[ANGLE]) / car.time_constant + tuning[_GAIN_ANGLE] * error_angle
    if tuning[_DOUBLE_COUNT] > 0.0:
        steering -= angle / car.time_constant
    # F e of the printed update (3): the error of the lateral speed counts too
    wrong = error_yaw
    if tuning[_STATE_ERROR] > 0.0:
        wrong += tuning[_STATE_ERROR] * (told[0] - x[LATERAL_SPEED])
    _learn(networks[0], active[0], tuning[_LEARN_FRONT] * angle * wrong, tuning[_FORGET_FRONT], h)
    _learn(networks[1], active[1], tuning[_LEARN_REAR] * error_speed, tuning[_FORGET_REAR], h)
    x[YAW_RATE] += h * yaw_rate
    x[LATERAL_SPEED] += h * lateral
    x[SPEED] += h * along
    x[ANGLE] += h * steering
    _trust(status, car, tuning, angle, divisor)


@njit(cache=True)
def _trust(status: FloatArray, car: Any, tuning: FloatArray, angle: float, speed: float) -> None:
    """Confidence in the front force: its slowest pole of learning against the wandering of the force.

    The pole is that of the characteristic polynomial of 3.2 for small s, g (b_1 d + k b_2) / (L_11 d + k L_12 + g b_1).
    """
    b_1, b_2 = car.to_front / car.yaw_inertia, 1.0 / car.mass
    rear = car.rear_sign * car.rear
    k = (car.to_rear * rear - car.to_front * car.front) / (car.yaw_inertia * speed)
    d = (car.front + rear) / (car.mass * speed)
    g = tuning[_LEARN_FRONT] * angle * angle
    below = tuning[_GAIN_YAW] * d + k * tuning[_GAIN_LATERAL] + g * b_1
    rate = g * (b_1 * d + k * b_2) / below if below > 0.0 else 0.0
    trust = status[_CONFIDENCE]
    trust += tuning[_STEP] * (max(rate, 0.0) * (1.0 - trust) - trust / tuning[_WANDERING])
    status[_CONFIDENCE] = min(max(trust, 0.0), 1.0)
    status[_SETTLED] += tuning[_STEP] * tuning[_SLOWEST_POLE] * (1.0 - status[_SETTLED])


@njit(cache=True)
def _begin(x: FloatArray, networks: tuple[FloatArray, FloatArray], car: Any, guard: FloatArray) -> None:
    """Start at the measurement: a wrong start of the speed would peak in the rear force (finding F9)."""
    x[YAW_RATE], x[ANGLE] = guard[IN_YAW_RATE, VALUE], guard[IN_ANGLE, VALUE]
    x[SPEED], x[LATERAL_SPEED] = mean_rim_speed(car, guard, IN_WHEELS), 0.0
    networks[0][:] = 0.0
    networks[1][:] = 0.0


@njit(cache=True)
def _tick(
    x: FloatArray,
    status: FloatArray,
    networks: tuple[FloatArray, FloatArray],
    grids: tuple[FloatArray, FloatArray],
    active: tuple[FloatArray, FloatArray],
    car_rows: Any,
    tuning: FloatArray,
    told: FloatArray,
    guard: FloatArray,
    positions: IntArray,
    inputs: FloatArray,
    ages: FloatArray,
    out: FloatArray,
) -> None:
    car = car_rows[0]
    status[_VERDICT] = accept_inputs(guard, positions, inputs, ages, tuning[_STEP])
    untold = tuning[_STATE_ERROR] > 0.0 and math.isnan(told[0])
    if status[_VERDICT] == INPUTS_LOST or untold or not rolls(car, guard, IN_WHEELS, status[_ACTIVE] > 0.0):
        if status[_ACTIVE] > 0.0:
            status[_RESETS] += 1.0
        x[:] = 0.0
        networks[0][:] = 0.0
        networks[1][:] = 0.0
        status[_ACTIVE] = status[_CONFIDENCE] = status[_SETTLED] = 0.0
        out[_OUT_LATERAL] = out[_OUT_SPEED] = out[_OUT_YAW] = out[_OUT_ANGLE] = 0.0
    else:
        if status[_ACTIVE] == 0.0:
            _begin(x, networks, car, guard)
            status[_ACTIVE] = 1.0
        # the step below ends at the next tick: these are the states at the time of this measurement
        out[_OUT_LATERAL], out[_OUT_SPEED] = x[LATERAL_SPEED], x[SPEED]
        out[_OUT_YAW], out[_OUT_ANGLE] = x[YAW_RATE], x[ANGLE]
        _observe(x, status, networks, grids, active, car, tuning, guard, told)
        if not (all_finite(x) and all_finite(networks[0]) and all_finite(networks[1])):
            status[_RESETS] += 1.0
            _begin(x, networks, car, guard)
            status[_CONFIDENCE] = status[_SETTLED] = 0.0
    out[0], out[1], out[2] = status[_ACTIVE], status[_RESETS], status[_VERDICT]
    out[_OUT_FRONT], out[_OUT_REAR] = _dot(networks[0], active[0]), _dot(networks[1], active[1])
    out[_OUT_TOTAL] = out[_OUT_FRONT] + out[_OUT_REAR]
    out[_OUT_FRONT + 1] = out[_OUT_REAR + 1] = status[_CONFIDENCE]
    for place in (_OUT_LATERAL, _OUT_TOTAL, _OUT_SPEED, _OUT_YAW, _OUT_ANGLE):
        out[place + 1] = status[_SETTLED]


class NeuralForceObserver(Estimator):
    """Neural force observer; build it with :func:`estimators.create`.

    Attributes
    ----------
    state : array, shape (4,)
        Yaw rate [rad/s], lateral speed [m/s], longitudinal speed [m/s], road-wheel angle [rad]; a view.
    weights : tuple of arrays
        Output weights of both networks [N]; views.
    told_lateral_speed : array, shape (1,)
        Where a demonstration of the printed update (``printed_update``) writes the true lateral speed [m/s]; nothing on
        the bus measures it, and until it is told that observer rests.
    """

    def __init__(
        self, vehicle: Mapping[str, float], settings: NeuralForceSettings, sample_time_s: float = 0.001
    ) -> None:
        self.settings = settings
        car = force_car(vehicle, settings)
        grids = network_centres(settings)
        self.state = np.zeros(4)
        self.weights = np.zeros(len(grids[0])), np.zeros(len(grids[1]))
        self.told_lateral_speed = np.full(1, np.nan)
        self._status = np.zeros(5)
        active = np.zeros(len(grids[0])), np.zeros(len(grids[1]))
        tuning = _tuning(settings, float(car[0]["time_constant"]), sample_time_s)
        names = neural_force_inputs(settings)
        self._guard, positions = input_guard(names, settings.input_timeout)
        super().__init__("neural_force_observer", names, sample_time_s)
        networks = self.state, self._status, self.weights, grids, active
        self.tick = partial(_tick, *networks, car, tuning, self.told_lateral_speed, self._guard, positions)

    def reset(self) -> None:
        """Return to the state of a new observer."""
        self.state[:] = 0.0
        self._status[:] = 0.0
        self.told_lateral_speed[:] = np.nan
        for weights in self.weights:
            weights[:] = 0.0
        forget_inputs(self._guard)


def _tuning(settings: NeuralForceSettings, time_constant: float, sample_time_s: float) -> FloatArray:
    values = np.zeros(_TUNING_SIZE)
    learns = settings.network != "none"
    values[_STEP] = sample_time_s
    values[_GAIN_YAW : _GAIN_ANGLE + 1] = observer_gains(settings, time_constant)
    values[_LEARN_FRONT], values[_LEARN_REAR] = learns * settings.learning_front, learns * settings.learning_rear
    values[_FORGET_FRONT], values[_FORGET_REAR] = settings.forgetting_front, settings.forgetting_rear
    values[_WIDTH], values[_NORMALISED] = settings.width, settings.normalised
    values[_INTEGRAL], values[_NO_SQUARE] = settings.network == "integral", settings.printed_exponent
    values[_DOUBLE_COUNT], values[_WANDERING] = settings.printed_double_count, settings.force_time_constant
    values[_STATE_ERROR] = settings.printed_update
    values[_SLOWEST_POLE] = min(-pole for pole in settings.poles_yaw)
    return values
