"""One tick of the observers of the vertical loads, compiled (vertical-load document, section 3)."""

import math
from typing import Any

import numpy as np
from numba import njit

from estimators.inputs import DATA_AGE, INPUTS_LOST, VALUE, accept_inputs
from estimators.kalman.covariance import FloatArray, IntArray, all_finite
from estimators.kalman.sigma_points import correct_points, draw_points, predict_points, weighted_covariance
from estimators.vertical_load_model import (
    LATERAL_SPEED,
    MEASURED,
    ROLL,
    ROLL_RATE,
    STATES,
    YAW_RATE,
    continuous,
    discretise,
    lateral_transfer_row,
    wheel_loads,
)
from estimators.vertical_load_settings import VERTICAL_LOAD_OUTPUTS

_IN_ACCELERATION_Y, _IN_YAW_RATE, _IN_STEER, _IN_ACCELERATION_X, _IN_ROLL_RATE = range(5)
_POSITION = {output.name: position for position, output in enumerate(VERTICAL_LOAD_OUTPUTS)}
_OUT_STATE = _POSITION["lateral_speed"]
OUT_LOAD = _POSITION["vertical_load_fl"]
_OUT_ACCELERATION, _OUT_INNOVATION = _POSITION["lateral_acceleration"], _POSITION["innovation"]

SAMPLE_TIME, PERIOD_TICKS, STALE_AGE, MINIMUM_SPEED, PERIOD, DAMPED = range(6)
SENSORS, REDRAW, DIAGONAL, SPREAD, ENLARGED = range(6, 11)
TUNING_SIZE = 11
_ACTIVE, _RESETS, _TICKS, _STEER, _VERDICT, _INNOVATION, _ACCELERATION_X = range(7)
_STATUS_SIZE = 7

STEP_RECORD = np.dtype(
    [
        ("status", "f8", (_STATUS_SIZE,)),
        ("state", "f8", (STATES,)),
        ("covariance", "f8", (STATES, STATES)),
        ("a", "f8", (STATES, STATES)),
        ("b", "f8", (STATES,)),
        ("c", "f8", (MEASURED, STATES)),
        ("d", "f8", (MEASURED,)),
        ("phi", "f8", (STATES, STATES)),
        ("gamma", "f8", (STATES,)),
        ("work", "f8", (4, STATES + 1, STATES + 1)),
        ("row", "f8", (STATES,)),
        ("measured", "f8", (MEASURED,)),
        ("used", "i8", (MEASURED,)),
        ("loads", "f8", (4,)),
        # of the unscented filter
        ("initial", "f8", (STATES,)),
        ("points", "f8", (2 * STATES + 1, STATES)),
        ("outputs", "f8", (2 * STATES + 1, MEASURED)),
        ("weights", "f8", (2 * STATES + 1,)),
        ("process", "f8", (STATES, STATES)),
        ("noise", "f8", (MEASURED, MEASURED)),
        ("factor", "f8", (STATES, STATES)),
        ("drawn", "f8", (STATES, STATES)),
        ("expected", "f8", (2, MEASURED)),
        ("innovation", "f8", (2, MEASURED, MEASURED)),
        ("cross", "f8", (STATES, MEASURED)),
        ("gain", "f8", (STATES, MEASURED)),
    ]
)


@njit(cache=True)
def _sense(m: Any, car: Any, guard: FloatArray, tuning: FloatArray) -> tuple[float, float]:
    """Fill the measurement; returns speed [m/s], never below the smallest one, and road-wheel angle [rad]."""
    sensors = int(tuning[SENSORS])
    m.measured[0], m.measured[1] = guard[_IN_ACCELERATION_Y, VALUE], guard[_IN_YAW_RATE, VALUE]
    m.used[0] = 1 if guard[_IN_ACCELERATION_Y, DATA_AGE] <= tuning[STALE_AGE] else 0
    m.used[1] = 1 if guard[_IN_YAW_RATE, DATA_AGE] <= tuning[STALE_AGE] else 0
    m.used[2] = 0
    if sensors == MEASURED:
        m.measured[2] = guard[_IN_ROLL_RATE, VALUE]
        m.used[2] = 1 if guard[_IN_ROLL_RATE, DATA_AGE] <= tuning[STALE_AGE] else 0
    m.status[_ACCELERATION_X] = guard[_IN_ACCELERATION_X, VALUE]
    first_wheel = 2 + sensors
    speed = 0.0
    for i in range(4):
        speed += 0.25 * car.radius[i] * guard[first_wheel + i, VALUE]
    return max(speed, tuning[MINIMUM_SPEED]), guard[_IN_STEER, VALUE] / car.steering_ratio


@njit(cache=True)
def _predicted(m: Any, x: FloatArray, steer: float, into: FloatArray) -> None:
    """Phi x + Gamma u."""
    for i in range(STATES):
        total = m.gamma[i] * steer
        for j in range(STATES):
            total += m.phi[i, j] * x[j]
        m.row[i] = total
    for i in range(STATES):
        into[i] = m.row[i]


@njit(cache=True)
def _expected(m: Any, x: FloatArray, steer: float, into: FloatArray) -> None:
    """C x + D u."""
    for r in range(MEASURED):
        total = m.d[r] * steer
        for j in range(STATES):
            total += m.c[r, j] * x[j]
        into[r] = total


@njit(cache=True)
def _draw(m: Any, tuning: FloatArray) -> bool:
    """Sigma points of the present estimate; False where its covariance is not positive definite."""
    for i in range(STATES):
        for j in range(STATES):
            m.drawn[i, j] = m.covariance[i, j] if i == j or tuning[DIAGONAL] == 0.0 else 0.0
    return draw_points(m.state, m.drawn, tuning[SPREAD], m.points, m.factor)


@njit(cache=True)
def _ukf_step(m: Any, car: Any, guard: FloatArray, tuning: FloatArray) -> bool:
    """Predict with the last road-wheel angle and correct with the present one; False where the filter broke down."""
    speed, steer = _sense(m, car, guard, tuning)
    continuous(car, speed, m.a, m.b, m.c, m.d)
    discretise(m.a, m.b, tuning[PERIOD], m.phi, m.gamma, m.work)
    if not _draw(m, tuning):
        return False
    for k in range(m.points.shape[0]):
        _predicted(m, m.points[k], m.status[_STEER], m.points[k])
    predict_points(m.points, m.weights, m.weights, m.process, m.state, m.covariance)
    if tuning[REDRAW] > 0.0:
        if not _draw(m, tuning):
            return False
        if tuning[ENLARGED] > 0.0:
            # the points now stand for a wider spread than the covariance that they came from
            weighted_covariance(m.points, m.state, m.points, m.state, m.weights, m.covariance)
    for k in range(m.points.shape[0]):
        _expected(m, m.points[k], steer, m.outputs[k])
    m.status[_STEER] = steer
    m.status[_INNOVATION] = correct_points(
        m.state,
        m.covariance,
        m.points,
        m.outputs,
        m.weights,
        m.weights,
        m.noise,
        m.measured,
        m.used,
        m.expected,
        m.innovation,
        m.cross,
        m.gain,
    )
    return math.isfinite(m.status[_INNOVATION])


@njit(cache=True)
def _kalman_step(m: Any, car: Any, guard: FloatArray, tuning: FloatArray) -> bool:
    """Predictor form (20) with the feed-through in the innovation; the gain stays as designed."""
    speed, steer = _sense(m, car, guard, tuning)
    continuous(car, speed, m.a, m.b, m.c, m.d)
    discretise(m.a, m.b, tuning[PERIOD], m.phi, m.gamma, m.work)
    _predicted(m, m.state, m.status[_STEER], m.state)
    _expected(m, m.state, steer, m.expected[0])
    m.status[_STEER] = steer
    squared = 0.0
    for r in range(MEASURED):
        m.expected[1, r] = m.measured[r] - m.expected[0, r] if m.used[r] > 0 else 0.0
    for r in range(MEASURED):
        for q in range(MEASURED):
            squared += m.expected[1, r] * m.innovation[0, r, q] * m.expected[1, q]
    for i in range(STATES):
        for r in range(MEASURED):
            m.state[i] += m.gain[i, r] * m.expected[1, r]
    m.status[_INNOVATION] = squared
    return all_finite(m.state)


@njit(cache=True)
def _write(m: Any, car: Any, tuning: FloatArray, out: FloatArray) -> None:
    """Outputs from state and covariance."""
    status, damped = m.status, tuning[DAMPED] > 0.0
    out[0], out[1], out[2] = status[_ACTIVE], status[_RESETS], status[_VERDICT]
    for i in range(STATES):
        out[_OUT_STATE + 2 * i] = m.state[i]
        out[_OUT_STATE + 2 * i + 1] = math.sqrt(max(m.covariance[i, i], 0.0))
    acceleration = m.d[0] * status[_STEER]
    acceleration += m.c[0, LATERAL_SPEED] * m.state[LATERAL_SPEED] + m.c[0, YAW_RATE] * m.state[YAW_RATE]
    wheel_loads(car, status[_ACCELERATION_X], acceleration, m.state[ROLL], m.state[ROLL_RATE], damped, m.loads)
    for axle in range(2):
        lateral_transfer_row(car, axle, m.c, damped, m.row)
        variance = 0.0
        for i in range(STATES):
            for j in range(STATES):
                variance += m.row[i] * m.covariance[i, j] * m.row[j]
        for side in range(2):
            place = OUT_LOAD + 4 * axle + 2 * side
            out[place], out[place + 1] = m.loads[2 * axle + side], math.sqrt(max(variance, 0.0))
    out[_OUT_ACCELERATION], out[_OUT_INNOVATION] = acceleration, status[_INNOVATION]


@njit(cache=True)
def forget_motion(m: Any, unscented: bool) -> None:
    """State of a car that drives straight on; the covariance of a fixed gain does not change."""
    m.state[:] = 0.0
    m.c[:] = 0.0
    m.d[:] = 0.0
    for place in (_ACTIVE, _TICKS, _STEER, _INNOVATION, _ACCELERATION_X):
        m.status[place] = 0.0
    if unscented:
        m.covariance[:] = 0.0
        for i in range(STATES):
            m.covariance[i, i] = m.initial[i]


@njit(cache=True)
def vertical_load_tick(
    m_rows: Any,
    car_rows: Any,
    tuning: FloatArray,
    guard: FloatArray,
    positions: IntArray,
    unscented: bool,
    inputs: FloatArray,
    ages: FloatArray,
    out: FloatArray,
) -> None:
    """Take over the inputs, step once a period, write the outputs.

    Parameters
    ----------
    m_rows, car_rows : shape (1,), dtypes ``STEP_RECORD`` and ``LOAD_CAR``
    tuning : shape (TUNING_SIZE,)
    guard, positions
        See :func:`estimators.inputs.input_guard`.
    unscented : bool
        The unscented filter, else the fixed gain.
    inputs, ages, out
        See :class:`estimators.interface.Estimator`.
    """
    m, car = m_rows[0], car_rows[0]
    status = m.status
    verdict = accept_inputs(guard, positions, inputs, ages, tuning[SAMPLE_TIME])
    status[_VERDICT] = verdict
    if verdict == INPUTS_LOST:
        if status[_ACTIVE] > 0.0:
            status[_RESETS] += 1.0
        forget_motion(m, unscented)
    elif status[_TICKS] > 0.0:
        status[_TICKS] -= 1.0
    else:
        if status[_ACTIVE] == 0.0:
            status[_STEER] = guard[_IN_STEER, VALUE] / car.steering_ratio
        whole = _ukf_step(m, car, guard, tuning) if unscented else _kalman_step(m, car, guard, tuning)
        if whole:
            status[_ACTIVE], status[_TICKS] = 1.0, tuning[PERIOD_TICKS] - 1.0
        else:
            status[_RESETS] += 1.0
            forget_motion(m, unscented)
    _write(m, car, tuning, out)
