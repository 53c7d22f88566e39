"""What every friction filter does around its filter step: inputs, torques, start and reset, confidence, outputs.

Friction document, sections 3.6.2 and 3.6.7.
"""

import math

from numba import njit

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
)
from estimators.friction_model import (
    AXLES,
    LIMIT_F,
    LIMIT_R,
    LOAD_F,
    LOAD_R,
    MODEL_PARAMETERS,
    RADIUS_F,
    RADIUS_R,
    RATE_F,
    RATE_R,
    SHAPE_F,
    SHAPE_R,
    SLIP_F,
    SLIP_R,
    SPEED,
    STATES,
    STIFFNESS_F,
    STIFFNESS_R,
    USED_F,
    USED_R,
    WHEEL_F,
    WHEEL_R,
    axle_forces,
    slip_ratio,
)
from estimators.friction_outputs import FRICTION_OUTPUTS, POSITION
from estimators.inputs import FRESH, INPUTS_LOST, VALUE, accept_inputs, forget_inputs
from estimators.kalman.correction import ROW_MISSING, ROW_STALE, ROW_USED
from estimators.kalman.covariance import FloatArray, IntArray
from estimators.longitudinal_inputs import IN_ACCELERATION, axle_speeds, axle_torques, fresh_axles
from estimators.longitudinal_start import START, STOP, decide, start_speed
from estimators.post_filter import forget, post_filter
from estimators.wheel_speed_sensor import (
    change_since,
    forget_changes,
    remember_change,
    sample_delay,
    time_between_edges,
)

# tuning: one float64 array, the parameters of the model first
(
    SAMPLE_TIME,
    TORQUE_KNOWN,
    KINEMATIC_WHEELS,
    BRAKE_IS_CAPACITY,
    HOLD_INPUTS,
    BRAKE_GAIN_F,
    BRAKE_GAIN_R,
    MINIMUM_SPEED,
    HYSTERESIS,
    SMALLEST_LIMIT,
    SPEED_ROW_DELAY,
    BRAKING_START,
    PRIOR_LIMIT,
    GATE,
    CONFIDENCE_RATIO,
    CONFIDENCE_TIME,
    POST_FILTER,
    POST_FILTER_WEIGHT,
    LOCKED_RATE_DECAY,
    PITCH_FACTOR,
    TEETH,
    WINDOW,
    SUBSTEPS,
) = range(MODEL_PARAMETERS, MODEL_PARAMETERS + 23)
PROCESS_VARIANCE = SUBSTEPS + 1
MEASUREMENT_VARIANCE = PROCESS_VARIANCE + STATES
INITIAL_VARIANCE = MEASUREMENT_VARIANCE + MEASUREMENTS
TUNING_SIZE = INITIAL_VARIANCE + STATES
DEEP_SLIP = 0.5
"""Wheel speed over that of the car below which a wheel is on its way to locking."""

# status: one float64 array, then the memories of three post-filters
ACTIVE, RESETS, CONFIDENT_F, CONFIDENT_R, CONFIDENT_M, INPUT_STATE, INNOVATION, SPEED_ROW_WAIT = range(8)
STATUS_SIZE = 8

OUT_ACTIVE = POSITION["active"]
OUT_RESETS = POSITION["resets"]
OUT_INPUT_STATE = POSITION["input_state"]
OUT_SPEED = POSITION["speed"]
OUT_LIMIT_F = POSITION["friction_limit_front"]
OUT_LIMIT_R = POSITION["friction_limit_rear"]
OUT_RATE_F = POSITION["friction_limit_rate_front"]
OUT_RATE_R = POSITION["friction_limit_rate_rear"]
OUT_LIMIT_M = POSITION["friction_limit_mean"]
OUT_USED_F = POSITION["friction_used_front"]
OUT_USED_R = POSITION["friction_used_rear"]
OUT_USED_M = POSITION["friction_used_mean"]
OUT_FILTERED = POSITION["friction_limit_front_filtered"]
OUT_INNOVATION = POSITION["innovation"]
OUTPUTS = len(FRICTION_OUTPUTS)


@njit(cache=True)
def begin_tick(
    state: FloatArray,
    covariance: FloatArray,
    status: FloatArray,
    tuning: FloatArray,
    guard: FloatArray,
    positions: IntArray,
    inputs: FloatArray,
    ages: FloatArray,
) -> int:
    """Take over the inputs, start or reset the filter.

    Returns
    -------
    int
        ``RUN`` where a filter step is to be made, else another action of :func:`estimators.longitudinal_start.decide`.
    """
    verdict = accept_inputs(guard, positions, inputs, ages, tuning[SAMPLE_TIME])
    status[INPUT_STATE] = verdict
    wheel_f, wheel_r = axle_speeds(guard)
    rim_f, rim_r = tuning[RADIUS_F] * wheel_f, tuning[RADIUS_R] * wheel_r
    action = decide(
        status[ACTIVE] > 0.0,
        verdict == INPUTS_LOST,
        rim_f,
        rim_r,
        state[SPEED],
        tuning[MINIMUM_SPEED],
        tuning[HYSTERESIS],
    )
    if action == START:
        acceleration = guard[IN_ACCELERATION, VALUE]
        initialise(state, covariance, tuning, start_speed(acceleration, rim_f, rim_r), wheel_f, wheel_r)
        for k in range(status.shape[0]):
            if k not in (RESETS, INPUT_STATE):
                status[k] = 0.0
        status[ACTIVE] = 1.0
        # the wheels of a braked car give a wrong speed, and row 8 repeats it with growing certainty
        if acceleration < -tuning[BRAKING_START]:
            status[SPEED_ROW_WAIT] = tuning[SPEED_ROW_DELAY]
    elif action == STOP:
        stop(state, covariance, status, tuning)
    return action


@njit(cache=True)
def initialise(
    state: FloatArray, covariance: FloatArray, tuning: FloatArray, speed: float, wheel_f: float, wheel_r: float
) -> None:
    """Initial state and covariance at a speed and measured wheel speeds."""
    state[SPEED] = speed
    state[WHEEL_F], state[WHEEL_R] = wheel_f, wheel_r
    state[SLIP_F] = slip_ratio(speed, tuning[RADIUS_F] * wheel_f)
    state[SLIP_R] = slip_ratio(speed, tuning[RADIUS_R] * wheel_r)
    state[LIMIT_F], state[LIMIT_R] = tuning[PRIOR_LIMIT], tuning[PRIOR_LIMIT]
    state[RATE_F], state[RATE_R] = 0.0, 0.0
    for i in range(STATES):
        for j in range(STATES):
            covariance[i, j] = 0.0
        covariance[i, i] = tuning[INITIAL_VARIANCE + i]


@njit(cache=True)
def stop(state: FloatArray, covariance: FloatArray, status: FloatArray, tuning: FloatArray) -> None:
    """Return to the initial state; counted."""
    initialise(state, covariance, tuning, 0.0, 0.0, 0.0)
    status[ACTIVE] = 0.0
    status[RESETS] += 1.0


@njit(cache=True)
def forget_everything(
    state: FloatArray,
    covariance: FloatArray,
    status: FloatArray,
    history: FloatArray,
    tuning: FloatArray,
    guard: FloatArray,
) -> None:
    """State of a new filter that has seen nothing."""
    initialise(state, covariance, tuning, 0.0, 0.0, 0.0)
    status[:] = 0.0
    forget_changes(history)
    forget_inputs(guard)


@njit(cache=True)
def read_torques(guard: FloatArray, tuning: FloatArray, torques: FloatArray) -> None:
    """Axle torques of this tick, zero in the modes without torques."""
    if tuning[TORQUE_KNOWN] > 0.0:
        capacity = tuning[BRAKE_IS_CAPACITY] > 0.0
        axle_torques(guard, tuning[BRAKE_GAIN_F], tuning[BRAKE_GAIN_R], capacity, torques)
        return
    for k in range(4):
        torques[k] = 0.0


@njit(cache=True)
def build_measurement(
    guard: FloatArray,
    tuning: FloatArray,
    status: FloatArray,
    speed_before: float,
    measured: FloatArray,
    rows: IntArray,
) -> None:
    """The eight measurements and which of them are there in this tick (3.6.2).

    Parameters
    ----------
    speed_before : float
        Estimated speed of the last tick [m/s], for row 8.
    measured : array, shape (8,)
        Filled.
    rows : array of int, shape (8,)
        Filled with ``ROW_USED``, ``ROW_MISSING`` or ``ROW_STALE``.
    """
    front, rear = axle_speeds(guard)
    # a nose that dips by c a under the deceleration a makes the accelerometer read a + g sin(c a)
    acceleration = guard[IN_ACCELERATION, VALUE] * tuning[PITCH_FACTOR]
    measured[ROW_ACCELERATION] = acceleration
    measured[ROW_WHEEL_F], measured[ROW_WHEEL_R] = front, rear
    measured[ROW_SLIP_F], measured[ROW_SLIP_R] = 0.0, 0.0
    measured[ROW_LIMIT_F], measured[ROW_LIMIT_R] = tuning[PRIOR_LIMIT], tuning[PRIOR_LIMIT]
    measured[ROW_SPEED] = speed_before + acceleration * tuning[SAMPLE_TIME]
    for r in range(MEASUREMENTS):
        rows[r] = ROW_USED
    if status[SPEED_ROW_WAIT] > 0.0:
        status[SPEED_ROW_WAIT] -= tuning[SAMPLE_TIME]
        rows[ROW_SPEED] = ROW_MISSING
    if tuning[HOLD_INPUTS] > 0.0:
        return
    if guard[IN_ACCELERATION, FRESH] == 0.0:
        rows[ROW_ACCELERATION] = ROW_MISSING
    fresh_f, fresh_r = fresh_axles(guard)
    if not fresh_f:
        rows[ROW_WHEEL_F] = ROW_MISSING
    if not fresh_r:
        rows[ROW_WHEEL_R] = ROW_MISSING
    if _is_stale(front, RADIUS_F, speed_before, tuning):
        rows[ROW_WHEEL_F] = ROW_STALE
    if _is_stale(rear, RADIUS_R, speed_before, tuning):
        rows[ROW_WHEEL_R] = ROW_STALE


@njit(cache=True)
def _is_stale(wheel_speed: float, radius: int, speed: float, tuning: FloatArray) -> bool:
    """A locking wheel gives no more pulses: what is left of its measured speed is the age of the last one.

    The brake's known capacity then says when it stands; believed, the lingering speed would be taken for a road that
    carries the whole torque of the brake.
    """
    pulses = wheel_speed * tuning[TEETH] * tuning[WINDOW] / (2.0 * math.pi)
    return 0.0 < pulses < 1.0 and tuning[radius] * wheel_speed < DEEP_SLIP * speed


@njit(cache=True)
def bring_forward(
    history: FloatArray,
    tuning: FloatArray,
    change_f: float,
    change_r: float,
    measured: FloatArray,
    variances: FloatArray,
) -> None:
    """Add to the measured wheel speeds what the model says they changed by since they were true.

    When the last edge passed before the sample is not known, only that it was less than the time between two edges: as
    much as the speed changed in that time is uncertain.

    Parameters
    ----------
    history : array, shape (2, 66)
        Of :mod:`estimators.wheel_speed_sensor`, changed.
    change_f, change_r : float
        Change of the wheel speeds in this tick's prediction [rad/s].
    measured : array, shape (8,)
        Its rows of the wheel speeds are changed.
    variances : array, shape (8,)
        Filled with the noise variances of the rows.
    """
    for r in range(MEASUREMENTS):
        variances[r] = tuning[MEASUREMENT_VARIANCE + r]
    if tuning[TEETH] <= 0.0:
        return
    remember_change(history, change_f, change_r)
    for axle in range(2):
        row = ROW_WHEEL_F + axle
        delay = sample_delay(measured[row], tuning[TEETH], tuning[WINDOW])
        if delay > 0.0:
            moved = change_since(history, axle, delay / tuning[SAMPLE_TIME])
            uncertain = moved * time_between_edges(measured[row], tuning[TEETH]) / delay
            variances[row] += uncertain * uncertain / 12.0
            measured[row] = max(0.0, measured[row] + moved)


@njit(cache=True)
def guard_limits(state: FloatArray, tuning: FloatArray) -> None:
    """Keep the friction limits above their smallest value; below zero the tyre curve would be turned over."""
    for limit in (LIMIT_F, LIMIT_R):
        if state[limit] < tuning[SMALLEST_LIMIT]:
            state[limit] = tuning[SMALLEST_LIMIT]
            state[limit + 1] = max(state[limit + 1], 0.0)


@njit(cache=True)
def write_outputs(
    state: FloatArray,
    covariance: FloatArray,
    status: FloatArray,
    tuning: FloatArray,
    forces: FloatArray,
    filters: FloatArray,
    out: FloatArray,
) -> None:
    """Fill the outputs from state and covariance; update confidence and post-filters."""
    running = status[ACTIVE] > 0.0
    out[OUT_ACTIVE] = status[ACTIVE]
    out[OUT_RESETS] = status[RESETS]
    out[OUT_INPUT_STATE] = status[INPUT_STATE]
    for i in range(SLIP_R + 1):
        out[OUT_SPEED + 2 * i] = state[i]
        out[OUT_SPEED + 2 * i + 1] = _root(covariance[i, i])
    out[OUT_LIMIT_F], out[OUT_LIMIT_F + 1] = state[LIMIT_F], _root(covariance[LIMIT_F, LIMIT_F])
    out[OUT_LIMIT_R], out[OUT_LIMIT_R + 1] = state[LIMIT_R], _root(covariance[LIMIT_R, LIMIT_R])
    out[OUT_RATE_F], out[OUT_RATE_F + 1] = state[RATE_F], _root(covariance[RATE_F, RATE_F])
    out[OUT_RATE_R], out[OUT_RATE_R + 1] = state[RATE_R], _root(covariance[RATE_R, RATE_R])

    axle_forces(state, tuning, forces)
    used_f, used_r = forces[AXLES, USED_F], forces[AXLES, USED_R]
    share = forces[AXLES, LOAD_F] / (forces[AXLES, LOAD_F] + forces[AXLES, LOAD_R])
    limit = share * state[LIMIT_F] + (1.0 - share) * state[LIMIT_R]
    used = share * used_f + (1.0 - share) * used_r
    out[OUT_LIMIT_M] = limit
    out[OUT_LIMIT_M + 1] = _root(
        share * share * covariance[LIMIT_F, LIMIT_F]
        + 2.0 * share * (1.0 - share) * covariance[LIMIT_F, LIMIT_R]
        + (1.0 - share) * (1.0 - share) * covariance[LIMIT_R, LIMIT_R]
    )
    curve_f, slope_f = _curve(state[LIMIT_F], state[SLIP_F], tuning[SHAPE_F], tuning[STIFFNESS_F])
    curve_r, slope_r = _curve(state[LIMIT_R], state[SLIP_R], tuning[SHAPE_R], tuning[STIFFNESS_R])
    out[OUT_USED_F], out[OUT_USED_R], out[OUT_USED_M] = used_f, used_r, used
    out[OUT_USED_F + 1] = _used_deviation(covariance, curve_f, slope_f, 0.0, 0.0)
    out[OUT_USED_R + 1] = _used_deviation(covariance, 0.0, 0.0, curve_r, slope_r)
    out[OUT_USED_M + 1] = _used_deviation(
        covariance, share * curve_f, share * slope_f, (1.0 - share) * curve_r, (1.0 - share) * slope_r
    )
    out[OUT_LIMIT_F + 2] = _confident(status, CONFIDENT_F, running, used_f, state[LIMIT_F], tuning)
    out[OUT_LIMIT_R + 2] = _confident(status, CONFIDENT_R, running, used_r, state[LIMIT_R], tuning)
    out[OUT_LIMIT_M + 2] = _confident(status, CONFIDENT_M, running, used, limit, tuning)

    kind, weight = int(tuning[POST_FILTER]), tuning[POST_FILTER_WEIGHT]
    if not running:
        for k in range(3):
            forget(filters[k])
    out[OUT_FILTERED] = post_filter(filters[0], kind, weight, state[LIMIT_F])
    out[OUT_FILTERED + 1] = post_filter(filters[1], kind, weight, state[LIMIT_R])
    out[OUT_FILTERED + 2] = post_filter(filters[2], kind, weight, limit)
    out[OUT_INNOVATION] = status[INNOVATION] if running else 0.0


@njit(cache=True)
def _confident(status: FloatArray, timer: int, running: bool, used: float, limit: float, tuning: FloatArray) -> float:
    if running and limit > 0.0 and abs(used) > tuning[CONFIDENCE_RATIO] * limit:
        status[timer] += tuning[SAMPLE_TIME]
    else:
        status[timer] = 0.0
    return 1.0 if status[timer] >= tuning[CONFIDENCE_TIME] - 1e-9 and status[timer] > 0.0 else 0.0


@njit(cache=True)
def _curve(limit: float, slip: float, shape: float, stiffness: float) -> tuple[float, float]:
    """Derivatives of the friction in use by the friction limit and by the slip."""
    scaled = stiffness * slip
    angle = shape * math.atan(scaled)
    return math.sin(angle), limit * shape * stiffness * math.cos(angle) / (1.0 + scaled * scaled)


@njit(cache=True)
def _used_deviation(
    covariance: FloatArray, by_limit_f: float, by_slip_f: float, by_limit_r: float, by_slip_r: float
) -> float:
    """Standard deviation of a function of limits and slips with these derivatives."""
    p = covariance
    front = by_limit_f * by_limit_f * p[LIMIT_F, LIMIT_F] + by_slip_f * by_slip_f * p[SLIP_F, SLIP_F]
    front += 2.0 * by_limit_f * by_slip_f * p[LIMIT_F, SLIP_F]
    rear = by_limit_r * by_limit_r * p[LIMIT_R, LIMIT_R] + by_slip_r * by_slip_r * p[SLIP_R, SLIP_R]
    rear += 2.0 * by_limit_r * by_slip_r * p[LIMIT_R, SLIP_R]
    both = by_limit_f * (by_limit_r * p[LIMIT_F, LIMIT_R] + by_slip_r * p[LIMIT_F, SLIP_R])
    both += by_slip_f * (by_limit_r * p[SLIP_F, LIMIT_R] + by_slip_r * p[SLIP_F, SLIP_R])
    return _root(front + rear + 2.0 * both)


@njit(cache=True)
def _root(variance: float) -> float:
    return math.sqrt(max(variance, 0.0))
