"""What every friction filter does before its filter step: inputs, torques, measurements, start and reset.

Friction document, sections 3.6.2 and 3.6.7.
"""

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
    LIMIT_F,
    LIMIT_R,
    MODEL_PARAMETERS,
    RADIUS_F,
    RADIUS_R,
    RATE_F,
    RATE_R,
    SLIP_F,
    SLIP_R,
    SPEED,
    STATES,
    WHEEL_F,
    WHEEL_R,
    slip_ratio,
)
from estimators.inputs import FRESH, INPUTS_LOST, VALUE, accept_inputs, forget_inputs
from estimators.kalman.correction import ROW_MISSING, ROW_STALE, ROW_USED
from estimators.kalman.covariance import FloatArray, IntArray
from estimators.longitudinal_inputs import IN_ACCELERATION, axle_speeds, axle_torques, fresh_axles, slower_wheels
from estimators.longitudinal_start import IDLE, START, STOP, decide, start_speed
from estimators.wheel_speed_sensor import bring_forward, forget_changes, is_lingering

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
    LARGEST_LIMIT,
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
) = range(MODEL_PARAMETERS, MODEL_PARAMETERS + 24)
PROCESS_VARIANCE = SUBSTEPS + 1
MEASUREMENT_VARIANCE = PROCESS_VARIANCE + STATES
INITIAL_VARIANCE = MEASUREMENT_VARIANCE + MEASUREMENTS
TUNING_SIZE = INITIAL_VARIANCE + STATES

# status: one float64 array, then the memories of three post-filters
ACTIVE, RESETS, CONFIDENT_F, CONFIDENT_R, CONFIDENT_M, INPUT_STATE, INNOVATION, SPEED_ROW_WAIT = range(8)
WAS_LOST, RIM_MEAN, ROLLING_TIME = range(8, 11)
STATUS_SIZE = 11

_RIM_WINDOW_S = 0.02
_ROLLING_MARGIN_M_S2 = 8.0
_ROLLING_TIME_S = 0.03


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
    slower_f, slower_r = slower_wheels(guard)
    action = decide(
        status[ACTIVE] > 0.0,
        verdict == INPUTS_LOST,
        rim_f,
        rim_r,
        min(tuning[RADIUS_F] * slower_f, tuning[RADIUS_R] * slower_r),
        state[SPEED],
        tuning[MINIMUM_SPEED],
        tuning[HYSTERESIS],
    )
    if status[WAS_LOST] > 0.0 and verdict != INPUTS_LOST:
        rolls = _rolls(status, tuning, max(rim_f, rim_r), guard[IN_ACCELERATION, VALUE])
        if action == START and not rolls:
            action = IDLE
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
        if verdict == INPUTS_LOST:
            status[WAS_LOST], status[RIM_MEAN], status[ROLLING_TIME] = 1.0, 0.0, 0.0
    return action


@njit(cache=True)
def _rolls(status: FloatArray, tuning: FloatArray, rim: float, acceleration: float) -> bool:
    """Whether the wheels tell the car's speed after a loss of inputs.

    In a braked car they do not while they are on the way into slip or locked: a filter that started from them would be
    wrong and sure of it. They are believed once their speed has changed like the car's for some time.
    """
    if acceleration >= -tuning[BRAKING_START]:
        return True
    before = status[RIM_MEAN]
    status[RIM_MEAN] = rim if before == 0.0 else before + (rim - before) * tuning[SAMPLE_TIME] / _RIM_WINDOW_S
    # a first-order lag follows a ramp by its slope times the time constant
    like_the_car = before > 0.0 and abs((rim - before) / _RIM_WINDOW_S - acceleration) < _ROLLING_MARGIN_M_S2
    status[ROLLING_TIME] = status[ROLLING_TIME] + tuning[SAMPLE_TIME] if like_the_car else 0.0
    return bool(status[ROLLING_TIME] >= _ROLLING_TIME_S)


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
    return is_lingering(wheel_speed, tuning[TEETH], tuning[WINDOW], tuning[radius] * wheel_speed, speed)


@njit(cache=True)
def compensate_sensors(
    history: FloatArray,
    tuning: FloatArray,
    change_f: float,
    change_r: float,
    measured: FloatArray,
    variances: FloatArray,
) -> None:
    """Noise variances of the rows; wheel speeds brought forward to this tick where they come from tone rings.

    Parameters
    ----------
    history : array, shape (2, 66)
        Of :mod:`estimators.wheel_speed_sensor`, changed.
    change_f, change_r : float
        Change of the wheel speeds in this tick's prediction [rad/s].
    measured : array, shape (8,)
        Its rows of the wheel speeds are changed.
    variances : array, shape (8,)
        Filled.
    """
    for r in range(MEASUREMENTS):
        variances[r] = tuning[MEASUREMENT_VARIANCE + r]
    if tuning[TEETH] > 0.0:
        wheels = slice(ROW_WHEEL_F, ROW_WHEEL_R + 1)
        bring_forward(
            history, tuning[TEETH], tuning[WINDOW], tuning[SAMPLE_TIME], change_f, change_r, measured[wheels],
            variances[wheels],
        )  # fmt: skip


@njit(cache=True)
def guard_limits(state: FloatArray, tuning: FloatArray) -> None:
    """Keep the friction limits between their guards.

    Below zero the tyre curve would be turned over. At a slip near zero, such as that of a wrong speed, no limit makes
    the force that the accelerometer tells, and the filter would raise it without end.
    """
    for limit in (LIMIT_F, LIMIT_R):
        if state[limit] < tuning[SMALLEST_LIMIT]:
            state[limit] = tuning[SMALLEST_LIMIT]
            state[limit + 1] = max(state[limit + 1], 0.0)
        elif state[limit] > tuning[LARGEST_LIMIT]:
            state[limit] = tuning[LARGEST_LIMIT]
            state[limit + 1] = min(state[limit + 1], 0.0)
