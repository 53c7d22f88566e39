"""Speed of the car from wheels that may all slip: nothing here knows an ideal speed.

The reference runs on with the car's acceleration (accelerometer with a learned correction, or a deceleration learned
from recovered wheels), rises with any faster wheel, and is re-anchored at a wheel that rolls: one whose brake is nearly
released and whose speed has settled. If none has rolled for a while, a rear wheel is released for that purpose.
"""

from typing import Any

from numba import njit

from bench.ecu.records import TASK_S, bus_position
from bench.ecu.slip_control import SLICK_ROAD_PA

_ACCELERATION = bus_position("longitudinal_acceleration")
FREE_PRESSURE_PA = 2e5
LEAST_CREDIBLE = 0.85
FREE_TASKS = 30
START_TASKS = 20
"""Tasks after power-on in which the reference is simply taken from the wheels."""
SETTLED_LOW, SETTLED_HIGH = -16.0, 4.0
"""Acceleration of a rolling wheel where the car's own is not known well, m/s^2."""
GAIN_TIME_S = 0.08
"""Time over which a wheel's speed is compared with the reference: short enough for a release, long for its noise."""
SLICK_FREE_PA, SLICK_GAIN, SLICK_TASKS = 1e5, 2.0, 20.0
"""A wheel rolls on a slick road: pressure, gain on the car in m/s^2 (room for a faulty accelerometer or a steep road),
and the tasks for which it must hold. A slipping wheel that turns round gains nothing either, but not as long.
"""
SLICK_PATIENCE = 5.0
"""A released rear wheel needs this many times the usual time there until it rolls."""
LEARN_AGE_S, SLICK_LEARN_AGE_S = 0.1, 0.5
"""Shortest time between rolling wheels that says something about the accelerometer."""


@njit(cache=True)
def _fastest(state: Any) -> float:
    speed = 0.0
    for wheel in range(4):
        if state.wheel_valid[wheel]:
            speed = max(speed, state.path_speed[wheel])
    return speed


@njit(cache=True)
def _second_slowest(state: Any) -> float:
    """Speed that neither one spinning axle nor one dragging wheel falsifies."""
    slowest, second = 1e9, 1e9
    for wheel in range(4):
        if state.wheel_valid[wheel]:
            speed = state.path_speed[wheel]
            if speed < slowest:
                slowest, second = speed, slowest
            elif speed < second:
                second = speed
    return second if second < 1e8 else max(state.reference, 0.0)


@njit(cache=True)
def _helped(calibration: Any, state: Any) -> bool:
    """May the accelerometer help?"""
    return bool(calibration.reference_use_accelerometer > 0.5 and state.inertial_ok)


@njit(cache=True)
def _predict_acceleration(calibration: Any, state: Any, values: Any) -> float:
    if _helped(calibration, state):
        return float(values[_ACCELERATION] + state.bias)
    return float(state.learned_acceleration)


@njit(cache=True)
def _learn_correction(calibration: Any, state: Any, correction: float) -> None:
    limit = calibration.reference_bias_limit
    state.bias = min(max(state.bias + correction, -limit), limit)


@njit(cache=True)
def _follow_wheels(calibration: Any, state: Any, target: float, slowest_fall: float) -> None:
    """No wheel is unstable: stay with the wheels, within what a car can do."""
    before = state.reference
    change = 0.4 * (target - before) if abs(target - before) > 1e-6 else 0.0
    rise = calibration.reference_largest_acceleration * TASK_S
    state.reference = max(before + min(max(change, slowest_fall * TASK_S), rise), 0.0)
    measured = (state.reference - before) / TASK_S
    if state.reference > 2.0:
        if state.inertial_ok and not state.braking:
            _learn_correction(calibration, state, 0.0025 * (measured - state.predicted_acceleration))
        state.learned_acceleration += 0.05 * (measured - state.learned_acceleration)
    state.anchor_speed, state.anchor_age = state.reference, 0.0


@njit(cache=True)
def _is_slick(calibration: Any, state: Any, wheel: int) -> bool:
    """Bears the road so little that a wheel turns up as slowly as a rolling one seems to?"""
    return bool(_helped(calibration, state) and state.road_pressure[wheel] < SLICK_ROAD_PA)


@njit(cache=True)
def _tasks_until_credible(calibration: Any, state: Any, wheel: int) -> float:
    """Tasks of steady rolling before a wheel's speed counts."""
    return SLICK_TASKS if _is_slick(calibration, state, wheel) else float(calibration.reference_anchor_tasks)


@njit(cache=True)
def _watch_gain(state: Any) -> None:
    """Let the late deficits follow: what a wheel lacks to the reference, and lacked a moment ago."""
    for wheel in range(4):
        deficit = state.reference - state.path_speed[wheel]
        state.late_deficit[wheel] += TASK_S / (GAIN_TIME_S + TASK_S) * (deficit - state.late_deficit[wheel])


@njit(cache=True)
def _is_rolling(calibration: Any, state: Any, wheel: int) -> bool:
    """Has this wheel a nearly released brake and a settled speed?"""
    slick = _is_slick(calibration, state, wheel)
    free = SLICK_FREE_PA if slick else FREE_PRESSURE_PA
    rest = max(calibration.reference_anchor_pressure_ratio * state.road_pressure[wheel], free)
    acceleration = state.acceleration[wheel]
    tolerance = calibration.reference_anchor_tolerance
    if slick:
        # turning up from deep slip takes half a second there, at no more than the noise of the acceleration
        gain = (state.late_deficit[wheel] - (state.reference - state.path_speed[wheel])) / GAIN_TIME_S
        settled = abs(gain) < SLICK_GAIN
    elif _helped(calibration, state):
        settled = abs(acceleration - state.predicted_acceleration) < tolerance
    else:
        settled = SETTLED_LOW < acceleration < SETTLED_HIGH
    # a locked wheel is settled too: a wheel far below the reference only counts with its brake fully released
    credible = state.path_speed[wheel] > LEAST_CREDIBLE * state.reference or state.free_tasks[wheel] > FREE_TASKS
    return bool(state.wheel_valid[wheel] and state.pressure[wheel] <= rest and settled and credible)


@njit(cache=True)
def _shift(state: Any, change: float) -> None:
    """Correct the reference; what wheels gain on the car does not change by that."""
    state.reference += change
    for wheel in range(4):
        state.late_deficit[wheel] += change


@njit(cache=True)
def _anchor(calibration: Any, state: Any, speed: float, least_age: float) -> None:
    """Take the speed of a rolling wheel for the car's and learn from the difference."""
    error = speed - state.reference
    _shift(state, calibration.reference_anchor_gain * error)
    age = state.anchor_age
    if age > least_age:
        _learn_correction(calibration, state, min(max(0.3 * error / age, -0.4), 0.4))
        measured = (speed - state.anchor_speed) / age
        if age < 2.0 and -calibration.reference_largest_deceleration < measured < 1.0:
            state.learned_acceleration += 0.7 * (measured - state.learned_acceleration)
        state.anchor_speed, state.anchor_age = speed, 0.0


@njit(cache=True)
def _run_on(calibration: Any, state: Any) -> None:
    """Some wheels are unstable: run on with the car's acceleration, corrected by faster and by rolling wheels."""
    state.reference = max(state.reference + state.predicted_acceleration * TASK_S, 0.0)
    state.anchor_age += TASK_S
    fastest = _fastest(state)
    if fastest > state.reference:
        _shift(state, calibration.reference_recovery_gain * (fastest - state.reference))
    _watch_gain(state)
    for wheel in range(4):
        state.free_tasks[wheel] = state.free_tasks[wheel] + 1 if state.pressure[wheel] < FREE_PRESSURE_PA else 0
        if not _is_rolling(calibration, state, wheel):
            state.rolling_tasks[wheel] = 0
            continue
        state.rolling_tasks[wheel] += 1
        if state.rolling_tasks[wheel] >= _tasks_until_credible(calibration, state, wheel):
            least_age = SLICK_LEARN_AGE_S if _is_slick(calibration, state, wheel) else LEARN_AGE_S
            share = min(state.pressure[wheel] / max(state.road_pressure[wheel], FREE_PRESSURE_PA), 1.0)
            speed = state.path_speed[wheel] / (1.0 - calibration.reference_residual_slip * share)
            _anchor(calibration, state, speed, least_age)


@njit(cache=True)
def update_reference(calibration: Any, state: Any, values: Any) -> None:
    """Reference speed of this task."""
    state.predicted_acceleration = _predict_acceleration(calibration, state, values)
    if state.started < START_TASKS:
        state.reference = _second_slowest(state)
        state.started += state.ignition
    elif state.abs_active:
        _run_on(calibration, state)
    elif state.braking:
        fall = -calibration.reference_largest_deceleration
        if _helped(calibration, state):
            fall = max(fall, state.predicted_acceleration - calibration.reference_deceleration_margin)
        _follow_wheels(calibration, state, _fastest(state), min(fall, 0.0))
    else:
        _follow_wheels(calibration, state, _second_slowest(state), -2.0 * calibration.reference_largest_deceleration)


@njit(cache=True)
def choose_underbraked_wheel(calibration: Any, state: Any) -> None:
    """Decide whether a rear wheel is released to find the car's speed; -1 is none."""
    if not state.abs_active or state.reference < 2.0 * calibration.limits_cut_in_speed:
        state.underbraked_wheel = -1
        return
    wheel = state.underbraked_wheel
    if wheel >= 0:
        state.underbraking_tasks += 1
        found = state.rolling_tasks[wheel] > _tasks_until_credible(calibration, state, wheel)
        timeout = calibration.reference_underbraking_timeout
        if _is_slick(calibration, state, wheel):
            timeout *= SLICK_PATIENCE
        if found or state.underbraking_tasks * TASK_S > timeout:
            state.underbraked_wheel = -1
            state.anchor_age = min(state.anchor_age, 0.0 if found else 0.5 * state.anchor_age)
        return
    patience = calibration.reference_underbraking_interval
    if not _helped(calibration, state):
        patience *= 0.5
    if state.anchor_age > patience:
        state.next_underbraked = 5 - state.next_underbraked
        state.underbraked_wheel = state.next_underbraked
        state.underbraking_tasks = 0
