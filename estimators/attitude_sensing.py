"""Sensing of the attitude filters, compiled: low-passes 31 to 36, axes, differentiators 41 to 43, measured speed."""

from numba import njit

from estimators.attitude_forms import ROW_ROLL, ROW_SPEED, ROW_Y, ROW_Z
from estimators.attitude_memory import (
    CAR,
    CHANNELS,
    DOCUMENT_CYCLE,
    EXTERNAL,
    FILTERING,
    GRAVITY,
    PERIOD,
    SAMPLE_TIME,
    TARGET,
    Memory,
)
from estimators.attitude_two_wheeler import (
    INPUTS,
    L_ELEVATION,
    L_ELEVATION_RATE,
    U_ELEVATION,
    U_ELEVATION_RATE,
    U_ROLL,
    U_ROLL_RISE,
    U_STEER,
    U_X,
    U_Y,
)
from estimators.inputs import VALUE
from estimators.kalman.covariance import FloatArray

SPEED_CHANNEL = 6
STEER_SOURCE, ABS_SOURCE, ABS_AGE = 6, CHANNELS, CHANNELS + 1
"""Places in ``Memory.sources``: first wheel in the guard, after the road-wheel angle; report of the ABS, its age."""


@njit(cache=True)
def measured_speed(a: Memory, guard: FloatArray) -> float:
    """Mean rim speed of the chosen wheels, or the speed from outside [m/s]."""
    first = a.sources[STEER_SOURCE]
    if a.tuning[EXTERNAL] > 0.0:
        return guard[first, VALUE]
    total, n = 0.0, a.radii.shape[0]
    for i in range(n):
        total += a.radii[i] * guard[first + i, VALUE] / n
    return total


@njit(cache=True)
def _pass(memory: FloatArray, coefficients: FloatArray, value: float) -> None:
    """Second-order low-pass of a channel, transposed direct form."""
    out = coefficients[0] * value + memory[0]
    memory[3] = memory[2]
    memory[0] = coefficients[1] * value - coefficients[3] * out + memory[1]
    memory[1] = coefficients[2] * value - coefficients[4] * out
    memory[2] = out


@njit(cache=True)
def _settle(memory: FloatArray, coefficients: FloatArray, value: float) -> None:
    """State of a low-pass that has seen a constant for ever."""
    memory[2] = memory[3] = value
    memory[1] = (coefficients[2] - coefficients[4]) * value
    memory[0] = (coefficients[1] - coefficients[3]) * value + memory[1]


@njit(cache=True)
def sense(a: Memory, guard: FloatArray) -> None:
    """Low-passes 31 to 36, and that of the speed if there is one."""
    fresh = a.status[FILTERING] == 0.0
    for channel in range(CHANNELS):
        if channel == SPEED_CHANNEL:
            value = measured_speed(a, guard)
        else:
            source = a.sources[channel]
            value = guard[source, VALUE] if source >= 0 else 0.0
        row = 1 if channel == SPEED_CHANNEL else 0
        if fresh:
            _settle(a.filtered[channel], a.coefficients[row], value)
        else:
            _pass(a.filtered[channel], a.coefficients[row], value)
    a.status[FILTERING] += 1.0


@njit(cache=True)
def _along_axes(a: Memory, group: int, axis: int) -> float:
    """Rate (group 0) or specific force (group 1) about or along an axis of the vehicle."""
    total = 0.0
    for i in range(3):
        value = a.filtered[3 * group + i, 2]
        if group == 1 and i == 2:
            value += a.tuning[GRAVITY]
        total += a.matrices[group, axis, i] * value
    return total


@njit(cache=True)
def _rise_of_a_sample(a: Memory, axis: int) -> float:
    """Derivative of a low-passed rate [rad/s^2] over the last sample."""
    total = 0.0
    for i in range(3):
        total += a.matrices[0, axis, i] * (a.filtered[i, 2] - a.filtered[i, 3])
    return total / a.tuning[SAMPLE_TIME]


@njit(cache=True)
def _inputs_of_the_prediction(a: Memory) -> None:
    """Those of the last step in the document's cycle, else those of the middle of the step.

    There a difference of the rates over the step belongs, which is half a step old at its end.
    """
    now, before = a.inputs[0], a.inputs[1]
    for place in range(INPUTS):
        if a.tuning[DOCUMENT_CYCLE] > 0.0:
            a.inputs[2, place] = before[place]
        elif U_ROLL_RISE <= place < U_ROLL_RISE + 3:
            a.inputs[2, place] = now[place]
        else:
            a.inputs[2, place] = 0.5 * (now[place] + before[place])


@njit(cache=True)
def take_inputs(a: Memory, guard: FloatArray, differentiate: bool) -> None:
    """Inputs and measurement of a step; differentiators 41 to 43."""
    now, before = a.inputs[0], a.inputs[1]
    before[:] = now
    for axis in range(3):
        now[U_ROLL + axis] = _along_axes(a, 0, axis)
        rise = (now[U_ROLL + axis] - before[U_ROLL + axis]) / a.tuning[PERIOD]
        if a.tuning[DOCUMENT_CYCLE] > 0.0:
            rise = _rise_of_a_sample(a, axis)
        now[U_ROLL_RISE + axis] = rise if differentiate else 0.0
    now[U_X], now[U_Y] = _along_axes(a, 1, 0), _along_axes(a, 1, 1)
    now[U_ELEVATION], now[U_ELEVATION_RATE] = a.loads[L_ELEVATION], a.loads[L_ELEVATION_RATE]
    if a.tuning[CAR] > 0.0:
        now[U_STEER] = guard[a.sources[STEER_SOURCE] - 1, VALUE]
    _inputs_of_the_prediction(a)
    a.measured[ROW_Y], a.measured[ROW_Z] = now[U_Y], _along_axes(a, 1, 2)
    a.measured[ROW_SPEED], a.measured[ROW_ROLL] = a.filtered[SPEED_CHANNEL, 2], a.tuning[TARGET]
