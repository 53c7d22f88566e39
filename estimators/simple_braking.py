"""Simple evaluation of a braking for the comparison of asphalts (Enisz 2015, eqs 120-127; friction document 3.7)."""

import math
from collections.abc import Mapping
from functools import partial

import numpy as np
from numba import njit

from estimators.baseline_settings import SimpleBrakingSettings, simple_braking_inputs
from estimators.inputs import INPUTS_LOST, VALUE, accept_inputs, forget_inputs, input_guard
from estimators.interface import Estimator
from estimators.kalman.covariance import FloatArray, IntArray
from estimators.longitudinal_inputs import IN_ACCELERATION, axle_speeds
from estimators.speed_tracker import track_speed
from estimators.vehicle_numbers import GRAVITY_M_S2, longitudinal_car

(
    SAMPLE_TIME,
    MASS,
    WHEELBASE,
    FRONT_LENGTH,
    HEIGHT,
    DRAG_HEIGHT,
    DRAG_FACTOR,
    ROLLING,
    RADIUS_F,
    RADIUS_R,
    HEAD_WIND,
    GRADE,
    BRAKING_START,
    MINIMUM_SPEED,
) = range(14)

_SPEED, _BRAKING, _COUNT, _SUM, _SQUARES = range(5)
_STATE_SIZE = 5
_LEAST_SAMPLES_S = 0.1


@njit(cache=True)
def drag_force(speed: float, values: FloatArray) -> float:
    """Air resistance with head wind [N] (eq. 121)."""
    relative = speed + values[HEAD_WIND]
    return values[DRAG_FACTOR] * relative * abs(relative)


@njit(cache=True)
def axle_loads(acceleration: float, speed: float, values: FloatArray) -> tuple[float, float]:
    """Vertical loads of front and rear axle [N] (eqs 124 and 125)."""
    weight = values[MASS] * GRAVITY_M_S2
    moment = (
        drag_force(speed, values) * values[DRAG_HEIGHT]
        + values[MASS] * acceleration * values[HEIGHT]
        + weight * values[HEIGHT] * math.sin(values[GRADE])
    )
    normal = weight * math.cos(values[GRADE])
    rear_length = values[WHEELBASE] - values[FRONT_LENGTH]
    front = (normal * rear_length - moment) / values[WHEELBASE]
    rear = (normal * values[FRONT_LENGTH] + moment) / values[WHEELBASE]
    return front, rear


@njit(cache=True)
def friction_in_use(acceleration: float, speed: float, values: FloatArray) -> float:
    """Longitudinal force over vertical load of the car (eqs 120, 126, 127); negative in braking."""
    front, rear = axle_loads(acceleration, speed, values)
    load = front + rear
    force = (
        values[MASS] * acceleration
        + drag_force(speed, values)
        + load * values[ROLLING]
        + values[MASS] * GRAVITY_M_S2 * math.sin(values[GRADE])
    )
    return force / load


@njit(cache=True)
def _tick(
    state: FloatArray,
    values: FloatArray,
    guard: FloatArray,
    positions: IntArray,
    inputs: FloatArray,
    ages: FloatArray,
    out: FloatArray,
) -> None:
    verdict = accept_inputs(guard, positions, inputs, ages, values[SAMPLE_TIME])
    wheel_f, wheel_r = axle_speeds(guard)
    # an accelerometer on a slope also feels gravity's part along the road; the equations want the change of speed
    acceleration = guard[IN_ACCELERATION, VALUE] - GRAVITY_M_S2 * math.sin(values[GRADE])
    rim_f, rim_r = values[RADIUS_F] * wheel_f, values[RADIUS_R] * wheel_r
    state[_SPEED] = track_speed(state[_SPEED], acceleration, rim_f, rim_r, values[BRAKING_START], values[SAMPLE_TIME])
    active = verdict != INPUTS_LOST and state[_SPEED] >= values[MINIMUM_SPEED]
    braking = active and acceleration < -values[BRAKING_START]
    friction = friction_in_use(acceleration, state[_SPEED], values) if active else 0.0
    if braking and state[_BRAKING] == 0.0:
        state[_COUNT], state[_SUM], state[_SQUARES] = 0.0, 0.0, 0.0
    state[_BRAKING] = 1.0 if braking else 0.0
    if braking:
        state[_COUNT] += 1.0
        state[_SUM] += abs(friction)
        state[_SQUARES] += friction * friction
    count = max(state[_COUNT], 1.0)
    mean = state[_SUM] / count
    out[0] = 1.0 if active else 0.0
    out[1] = verdict
    out[2] = state[_SPEED]
    out[3], out[4] = axle_loads(acceleration if active else 0.0, state[_SPEED], values)
    out[5], out[6] = friction, state[_BRAKING]
    out[7] = mean
    out[8] = math.sqrt(max(0.0, state[_SQUARES] / count - mean * mean))
    out[9] = 1.0 if state[_COUNT] * values[SAMPLE_TIME] >= _LEAST_SAMPLES_S else 0.0


class SimpleBraking(Estimator):
    """Simple braking evaluation; build it with :func:`estimators.create`."""

    def __init__(
        self, vehicle: Mapping[str, float], settings: SimpleBrakingSettings, sample_time_s: float = 0.001
    ) -> None:
        car = longitudinal_car(vehicle, with_brakes=False)
        values = np.zeros(14)
        values[SAMPLE_TIME], values[MASS], values[WHEELBASE] = sample_time_s, car.mass, car.wheelbase
        values[FRONT_LENGTH], values[HEIGHT], values[DRAG_HEIGHT] = car.front_length, car.height, car.drag_height
        values[DRAG_FACTOR], values[ROLLING] = car.drag_factor, car.rolling_coefficient
        values[RADIUS_F], values[RADIUS_R] = car.radius
        values[HEAD_WIND], values[GRADE] = settings.head_wind, settings.grade
        values[BRAKING_START], values[MINIMUM_SPEED] = settings.braking_start, settings.minimum_speed
        self.settings = settings
        self._state = np.zeros(_STATE_SIZE)
        inputs = simple_braking_inputs(settings)
        self._guard, positions = input_guard(inputs, settings.input_timeout)
        super().__init__("simple_braking", inputs, sample_time_s)
        self.tick = partial(_tick, self._state, values, self._guard, positions)

    def reset(self) -> None:
        """Return to the state of a new estimator."""
        self._state[:] = 0.0
        forget_inputs(self._guard)
