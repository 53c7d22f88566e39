"""One tick of the attitude filters, compiled (attitude document 3.6)."""

import math
from typing import Any

from numba import njit

from estimators.attitude_car import friction_share
from estimators.attitude_filter import correct_filter, predict_filter
from estimators.attitude_forms import (
    ENTRIES,
    LATERAL_SPEED,
    PHI,
    ROW_SPEED,
    SPEED,
    THETA,
)
from estimators.attitude_memory import (
    ABS,
    ACCUMULATED,
    ACTIVE,
    BEST,
    CAR,
    CENTRE,
    DELAY,
    ELEVATION_POLE,
    EXTERNAL,
    FILTERING,
    FRICTION_SHARE,
    HELD,
    INNOVATION,
    LARGEST_CENTRE,
    LOG_VOLUME,
    LOOP,
    MINIMUM_SPEED,
    PERIOD,
    PERIOD_TICKS,
    RECENTRING,
    RECENTRING_START,
    REPORTED,
    RESETS,
    SAMPLE_TIME,
    SAMPLES,
    SETTLING_TICKS,
    SMOOTHING,
    STALE_AGE,
    STEPS,
    STUDENT,
    SUSPECT,
    SUSPICIOUS_STEPS,
    SUSPICIOUS_WEIGHT,
    TICKS,
    VERDICT,
    VIRTUAL,
    Memory,
)
from estimators.attitude_sensing import ABS_AGE, ABS_SOURCE, SPEED_CHANNEL, measured_speed, sense, take_inputs
from estimators.attitude_settings import ATTITUDE_OUTPUTS
from estimators.attitude_two_wheeler import (
    L_ELEVATION,
    L_FRONT,
    L_REAR,
    L_SLOPE,
    M_FX,
    follow_springs,
    mechanics,
    road_slope,
    wheel_loads,
)
from estimators.attitude_weights import (
    GRID,
    LOG,
    OFFSET,
    SMOOTH,
    WEIGHT,
    log_likelihood,
    most_likely,
    nearest_to_zero,
    separation,
    smooth,
    weigh,
)
from estimators.inputs import DATA_AGE, INPUTS_LOST, accept_inputs
from estimators.kalman.covariance import FloatArray, IntArray, all_finite

_POSITION = {output.name: position for position, output in enumerate(ATTITUDE_OUTPUTS)}
_OUT_STATE = _POSITION["pitch_angle"]
_OUT_SLIP, _OUT_AGE = _POSITION["side_slip_angle"], _POSITION["roll_angle_age"]
_OUT_VIRTUAL, _OUT_ZERO, _OUT_LARGEST = (
    _POSITION[name] for name in ("virtual_offset", "zero_weight", "largest_weight")
)
_OUT_SEPARATION, _OUT_HELD = _POSITION["separation"], _POSITION["weights_held"]
_OUT_SUSPICIOUS, _OUT_FRONT, _OUT_REAR = (
    _POSITION[name] for name in ("sensor_suspicious", "vertical_load_front", "vertical_load_rear")
)
_OUT_ELEVATION, _OUT_SLOPE = _POSITION["elevation_angle"], _POSITION["road_slope"]
_OUT_INNOVATION = _POSITION["innovation"]
_MOST_REPORTED = 1e12
"""Bound of what is reported of a filter that is about to break down."""


@njit(cache=True)
def _moves(entry: int) -> bool:
    return entry in (THETA, PHI, SPEED, LATERAL_SPEED)


@njit(cache=True)
def _begin(a: Memory, keeps: bool) -> None:
    """Start every filter upright at the measured speed; ``keeps`` what they know of the offsets and their weights."""
    for i in range(a.state.shape[0]):
        x, covariance = a.state[i], a.covariance[i]
        for entry in range(ENTRIES):
            if _moves(entry) or not keeps:
                x[entry] = 0.0
        x[SPEED] = a.filtered[SPEED_CHANNEL, 2]
        for row in range(a.entries.shape[0]):
            for column in range(a.entries.shape[0]):
                if not keeps or _moves(a.entries[row]) or _moves(a.entries[column]):
                    covariance[row, column] = a.initial[row] ** 2 if row == column else 0.0
        if not keeps:
            a.bank[SMOOTH, i] = 0.0
            a.bank[WEIGHT, i] = 1.0 / a.state.shape[0]
            a.bank[OFFSET, i] = a.bank[GRID, i]
    if not keeps:
        a.status[CENTRE] = a.status[SUSPECT] = a.status[STEPS] = 0.0
    a.loads[:] = 0.0
    a.status[TICKS] = 0.0


@njit(cache=True)
def _weigh(a: Memory, car: Any) -> None:
    """Low-pass 58 and weights, unless ABS control or the friction holds them; the plausibility of the zero offset."""
    t = a.tuning
    a.status[HELD] = a.status[ABS]
    if t[CAR] > 0.0 and friction_share(a.combined, a.inputs[0], car[0]) > t[FRICTION_SHARE]:
        a.status[HELD] = 1.0
    if a.status[HELD] > 0.0:
        return
    smooth(a.bank, t[SMOOTHING], t[ACCUMULATED] > 0.0)
    weigh(a.bank, t[SAMPLES] if t[ACCUMULATED] > 0.0 else 0.0)
    unlikely = a.bank[WEIGHT, nearest_to_zero(a.bank)] < t[SUSPICIOUS_WEIGHT]
    a.status[SUSPECT] = a.status[SUSPECT] + 1.0 if unlikely else 0.0


@njit(cache=True)
def _combine(a: Memory) -> None:
    """(28), (29): all entries with the same weights, the virtual offset among them; variances of the mixture."""
    best = most_likely(a.bank)
    n = a.state.shape[0]
    for entry in range(ENTRIES):
        total = 0.0
        for i in range(n):
            total += a.bank[WEIGHT, i] * a.state[i, entry]
        a.combined[entry] = a.state[best, entry] if a.tuning[BEST] > 0.0 else total
        spread = 0.0
        for i in range(n):
            spread += a.bank[WEIGHT, i] * (a.state[i, entry] - a.combined[entry]) ** 2
        a.variance[entry] = spread
    for row in range(a.entries.shape[0]):
        for i in range(n):
            a.variance[a.entries[row]] += a.bank[WEIGHT, i] * a.covariance[i, row, row]


@njit(cache=True)
def _recentre(a: Memory) -> None:
    """Offset correction loop (3.7): virtual offsets follow the estimate within the range of the sensor."""
    t = a.tuning
    if t[RECENTRING] > 0.0 and t[VIRTUAL] >= 0.0 and a.status[STEPS] * t[PERIOD] >= t[RECENTRING_START]:
        if a.status[HELD] == 0.0:
            centre = a.status[CENTRE] + t[RECENTRING] * (a.combined[int(t[VIRTUAL])] - a.status[CENTRE])
            a.status[CENTRE] = min(max(centre, -t[LARGEST_CENTRE]), t[LARGEST_CENTRE])
        for i in range(a.bank.shape[1]):
            a.bank[OFFSET, i] = a.status[CENTRE] + a.bank[GRID, i]


@njit(cache=True)
def _close_loop(a: Memory, bike: Any) -> None:
    """Blocks 60 to 90 from the combined state; zeta reaches the filters in the next step."""
    mechanics(a.combined, a.inputs[0], bike[0], a.mechanics)
    wheel_loads(a.combined, a.mechanics, bike[0], a.loads)
    follow_springs(a.mechanics[M_FX], bike[0], a.tuning[PERIOD], a.tuning[ELEVATION_POLE], a.loads)
    a.loads[L_SLOPE] = road_slope(a.combined[THETA], a.combined[PHI], a.loads[L_ELEVATION])


@njit(cache=True)
def _step(a: Memory, bike: Any, car: Any, guard: FloatArray, first: bool) -> bool:
    """One cycle of 3.6; False where a filter broke down."""
    take_inputs(a, guard, not first)
    virtual = int(a.tuning[VIRTUAL])
    squares = 0.0
    for i in range(a.state.shape[0]):
        x, covariance = a.state[i], a.covariance[i]
        if virtual >= 0:
            x[virtual] = a.bank[OFFSET, i]
        if a.tuning[EXTERNAL] > 0.0:
            x[SPEED] = a.measured[ROW_SPEED]
        if not first:
            predict_filter(x, covariance, a, bike[0], car[0])
        squared = correct_filter(x, covariance, a, bike[0], car[0])
        if not (math.isfinite(squared) and all_finite(x)):
            return False
        a.bank[LOG, i] = log_likelihood(squared, a.status[LOG_VOLUME], a.rows.shape[0], a.tuning[STUDENT])
        squares += a.bank[WEIGHT, i] * squared
    a.status[INNOVATION] = min(squares, _MOST_REPORTED)
    a.status[STEPS] += 1.0
    _weigh(a, car)
    _combine(a)
    _recentre(a)
    if a.tuning[LOOP] > 0.0:
        _close_loop(a, bike)
    elif a.tuning[CAR] == 0.0:
        a.loads[L_SLOPE] = road_slope(a.combined[THETA], a.combined[PHI], 0.0)
    return True


@njit(cache=True)
def _report(a: Memory) -> None:
    """Outputs of a step, which the ticks up to the next one repeat."""
    out = a.report
    out[:] = 0.0
    for entry in range(ENTRIES):
        moves = a.status[ACTIVE] > 0.0 or not _moves(entry)
        out[_OUT_STATE + 2 * entry] = a.combined[entry] if moves else 0.0
        out[_OUT_STATE + 2 * entry + 1] = math.sqrt(min(max(a.variance[entry], 0.0), _MOST_REPORTED))
    if a.status[ACTIVE] == 0.0:
        return
    speed = max(abs(a.combined[SPEED]), a.tuning[MINIMUM_SPEED])
    out[_OUT_SLIP] = math.atan2(a.combined[LATERAL_SPEED], speed)
    out[_OUT_SLIP + 1] = out[_OUT_STATE + 2 * LATERAL_SPEED + 1] / speed
    out[_OUT_VIRTUAL] = a.combined[int(a.tuning[REPORTED])] if a.tuning[REPORTED] >= 0.0 else 0.0
    out[_OUT_ZERO] = a.bank[WEIGHT, nearest_to_zero(a.bank)]
    out[_OUT_LARGEST] = a.bank[WEIGHT, most_likely(a.bank)]
    out[_OUT_SEPARATION] = separation(a.bank)
    out[_OUT_HELD] = a.status[HELD]
    out[_OUT_SUSPICIOUS] = 1.0 if a.status[SUSPECT] > a.tuning[SUSPICIOUS_STEPS] else 0.0
    out[_OUT_FRONT], out[_OUT_REAR] = a.loads[L_FRONT], a.loads[L_REAR]
    out[_OUT_ELEVATION], out[_OUT_SLOPE] = a.loads[L_ELEVATION], a.loads[L_SLOPE]
    out[_OUT_INNOVATION] = a.status[INNOVATION]


@njit(cache=True)
def _write(a: Memory, guard: FloatArray, out: FloatArray) -> None:
    for place in range(out.shape[0]):
        out[place] = a.report[place]
    out[0], out[1], out[2] = a.status[ACTIVE], a.status[RESETS], a.status[VERDICT]
    if a.status[ACTIVE] > 0.0:
        out[_OUT_AGE] = a.tuning[DELAY] + guard[0, DATA_AGE] + a.status[TICKS] * a.tuning[SAMPLE_TIME]


@njit(cache=True)
def forget(a: Memory) -> None:
    """Everything that the filters know."""
    _begin(a, False)
    a.state[:] = 0.0
    a.combined[:] = 0.0
    a.variance[:] = 0.0
    a.filtered[:] = 0.0
    a.inputs[:] = 0.0
    a.report[:] = 0.0
    a.status[ACTIVE] = a.status[FILTERING] = a.status[HELD] = a.status[INNOVATION] = 0.0


@njit(cache=True)
def attitude_tick(
    a: Memory,
    bike: Any,
    car: Any,
    guard: FloatArray,
    positions: IntArray,
    inputs: FloatArray,
    ages: FloatArray,
    out: FloatArray,
) -> None:
    """Take the inputs in; every period one cycle of all filters; write the outputs."""
    status, t = a.status, a.tuning
    status[VERDICT] = accept_inputs(guard, positions, inputs, ages, t[SAMPLE_TIME])
    if status[VERDICT] == INPUTS_LOST:
        if status[ACTIVE] > 0.0:
            status[RESETS] += 1.0
        forget(a)
        _report(a)
        _write(a, guard, out)
        return
    sense(a, guard)
    status[ABS] = 0.0
    if a.sources[ABS_SOURCE] >= 0:
        age, reported = ages[a.sources[ABS_AGE]], inputs[a.sources[ABS_SOURCE]]
        status[ABS] = 1.0 if 0.0 <= age <= t[STALE_AGE] and 0.5 < reported <= 1.0 else 0.0
    # the first sample, on which the low-passes start, is as noisy as any
    if status[FILTERING] < t[SETTLING_TICKS] or measured_speed(a, guard) < t[MINIMUM_SPEED]:
        if status[ACTIVE] > 0.0:
            status[ACTIVE] = 0.0
            _report(a)
        _write(a, guard, out)
        return
    status[TICKS] += 1.0
    first = status[ACTIVE] == 0.0
    if first:
        _begin(a, status[STEPS] > 0.0)
        status[ACTIVE] = 1.0
    if first or status[TICKS] >= t[PERIOD_TICKS]:
        status[TICKS] = 0.0
        if not _step(a, bike, car, guard, first):
            status[RESETS] += 1.0
            forget(a)
        _report(a)
    _write(a, guard, out)


@njit(cache=True)
def replay_rows(
    a: Memory,
    bike: Any,
    car: Any,
    guard: FloatArray,
    positions: IntArray,
    inputs: FloatArray,
    ages: FloatArray,
    out: FloatArray,
) -> None:
    """A tick for every row of recorded blocks; arrays of shape (n, width)."""
    for k in range(inputs.shape[0]):
        attitude_tick(a, bike, car, guard, positions, inputs[k], ages[k], out[k])
