"""Extended Kalman filter for the axle forces (Enisz 2015, stage 1; friction document, section 3.5)."""

import math
from collections.abc import Mapping
from functools import partial

import numpy as np
from numba import njit

from estimators.force_model import (
    COSINE_SPEED,
    DESIGN_COLUMNS,
    DRAG_FACTOR,
    FORCE_F,
    INERTIA_F,
    INERTIA_R,
    MASS,
    MEASUREMENTS,
    MODEL_PARAMETERS,
    RADIUS_F,
    RADIUS_R,
    ROLLING_FORCE,
    ROW_ACCELERATION,
    ROW_WHEEL_F,
    ROW_WHEEL_R,
    SPEED,
    STATES,
    TRANSITION_COLUMNS,
    WHEEL_F,
    WHEEL_R,
    delay_wheel_row,
    hold_force_rates,
    measure,
    predict,
    share_force_noise,
)
from estimators.force_rolling import OFFSET, ROLLING_SHARE, TRACKED, learn_offset, rolling_axles, tie_speed
from estimators.force_settings import FORCE_OUTPUTS, ForceEkfSettings, force_inputs
from estimators.inputs import FRESH, INPUTS_LOST, VALUE, accept_inputs, forget_inputs, input_guard
from estimators.interface import Estimator
from estimators.kalman.correction import ROW_MISSING, ROW_USED, correct_rows
from estimators.kalman.covariance import FloatArray, IntArray, all_finite, propagate_sparse
from estimators.longitudinal_inputs import (
    DRIVE_F,
    DRIVE_R,
    IN_ACCELERATION,
    axle_speeds,
    axle_torques,
    fresh_axles,
    slower_wheels,
)
from estimators.longitudinal_start import RUN, START, STOP, decide, start_speed
from estimators.vehicle_numbers import GRAVITY_M_S2, LongitudinalCar, longitudinal_car, tone_ring
from estimators.wheel_speed_sensor import HISTORY_SIZE, bring_forward, forget_changes, is_lingering, sample_delay

(
    SAMPLE_TIME,
    BRAKE_GAIN_F,
    BRAKE_GAIN_R,
    BRAKE_IS_CAPACITY,
    HOLD_INPUTS,
    MINIMUM_SPEED,
    HYSTERESIS,
    RATE_DECAY,
    TEETH,
    WINDOW,
    PITCH_FACTOR,
    BOUND_BY_WHEELS,
    CONTRADICTION_WEIGHT,
    CONTRADICTION_LIMIT,
    ROLLING_TORQUE,
    RESTARTS,
    ROLLING_VARIANCE,
    OFFSET_RATE,
    LARGEST_OFFSET,
) = range(MODEL_PARAMETERS, MODEL_PARAMETERS + 19)
PROCESS_VARIANCE = LARGEST_OFFSET + 1
MEASUREMENT_VARIANCE = PROCESS_VARIANCE + STATES
INITIAL_VARIANCE = MEASUREMENT_VARIANCE + MEASUREMENTS
TUNING_SIZE = INITIAL_VARIANCE + STATES

# rows of the memory, nine columns each
_STATE, _PREDICTED, _EXPECTED, _TORQUES, _STATUS, _NOISE = range(6)
_COVARIANCE = 6
_TRANSITION = _COVARIANCE + STATES
_DESIGN = _TRANSITION + STATES
_ROLLING = _DESIGN + MEASUREMENTS
_SCRATCH = _ROLLING + 1
_MEMORY_ROWS = _SCRATCH + STATES

_ACTIVE, _RESETS, _INPUT_STATE, _INNOVATION, _CONTRADICTION, _DISTRUSTED, _TRACKER = range(7)
_STATUS_KEPT = _TRACKER  # what a filter that starts again forgets ends here
_POSITION = {output.name: position for position, output in enumerate(FORCE_OUTPUTS)}
_OUT_SPEED, _OUT_FORCE_F, _OUT_INNOVATION = _POSITION["speed"], _POSITION["force_front"], _POSITION["innovation"]
_OUT_SPEED_CONFIDENCE = _POSITION["speed_confidence"]
_OUT_OFFSET = _POSITION["acceleration_offset"]


@njit(cache=True)
def _initialise(memory: FloatArray, tuning: FloatArray, speed: float, wheel_f: float, wheel_r: float) -> None:
    state, covariance = memory[_STATE], memory[_COVARIANCE:_TRANSITION]
    state[:] = 0.0
    state[SPEED], state[WHEEL_F], state[WHEEL_R] = speed, wheel_f, wheel_r
    covariance[:] = 0.0
    for i in range(STATES):
        covariance[i, i] = tuning[INITIAL_VARIANCE + i]


@njit(cache=True)
def _note_contradiction(
    status: FloatArray, covariance: FloatArray, design: FloatArray, residual: float, noise: float, weight: float
) -> None:
    """Follow the mean of the accelerometer's residual over its deviation: 0 where it and the wheels agree."""
    row = design[ROW_ACCELERATION]
    variance = noise
    for i in DESIGN_COLUMNS[ROW_ACCELERATION]:
        for j in DESIGN_COLUMNS[ROW_ACCELERATION]:
            variance += row[i] * covariance[i, j] * row[j]
    status[_CONTRADICTION] += weight * (residual / math.sqrt(variance) - status[_CONTRADICTION])


@njit(cache=True)
def _bound_speed(state: FloatArray, torques: FloatArray, rim_f: float, rim_r: float, by_wheels: bool) -> bool:
    """Hold the speed where the model is defined, and where asked above what rolls; True if it left the model's domain.

    Eq. 82 is the drag of a car that drives forward: below zero its square would push on. A wheel without drive torque
    turns no faster than the car goes.
    """
    if state[SPEED] < 0.0:
        state[SPEED] = 0.0
        return True
    if by_wheels and torques[DRIVE_F] <= 0.0:
        state[SPEED] = max(state[SPEED], rim_f)
    if by_wheels and torques[DRIVE_R] <= 0.0:
        state[SPEED] = max(state[SPEED], rim_r)
    return False


@njit(cache=True)
def _filter_step(
    memory: FloatArray, history: FloatArray, rows: IntArray, tuning: FloatArray, guard: FloatArray
) -> None:
    state, predicted, expected = memory[_STATE], memory[_PREDICTED], memory[_EXPECTED, :MEASUREMENTS]
    covariance, transition = memory[_COVARIANCE:_TRANSITION], memory[_TRANSITION:_DESIGN]
    design, scratch = memory[_DESIGN:_SCRATCH], memory[_SCRATCH:_MEMORY_ROWS]
    variances = tuning[PROCESS_VARIANCE : PROCESS_VARIANCE + STATES]
    torques, tracker = memory[_TORQUES], memory[_STATUS, _TRACKER : _TRACKER + 2]
    axle_torques(guard, tuning[BRAKE_GAIN_F], tuning[BRAKE_GAIN_R], tuning[BRAKE_IS_CAPACITY] > 0.0, torques)
    front, rear = axle_speeds(guard)
    teeth, window = tuning[TEETH], tuning[WINDOW]
    # a speed that is not to be trusted tells of no deep slip either: rolling wheels would be taken for locking ones
    speed = 0.0 if memory[_STATUS, _DISTRUSTED] > 0.0 else state[SPEED]
    stale_f = is_lingering(front, teeth, window, tuning[RADIUS_F] * front, speed)
    stale_r = is_lingering(rear, teeth, window, tuning[RADIUS_R] * rear, speed)
    stopped_f, stopped_r = predict(state, torques, tuning[SAMPLE_TIME], tuning, predicted, transition)
    # where neither wheel speed tells its axle's force, only the sum of both is observed
    locked = (stopped_f or stale_f) and (stopped_r or stale_r)
    if locked:
        hold_force_rates(predicted, transition, tuning[RATE_DECAY])
    propagate_sparse(covariance, transition, TRANSITION_COLUMNS, variances, scratch)
    change_f, change_r = predicted[WHEEL_F] - state[WHEEL_F], predicted[WHEEL_R] - state[WHEEL_R]
    state[:] = predicted
    if locked:
        share_force_noise(state, covariance, variances)
    measure(state, tuning, expected, design)
    noise, speeds = memory[_NOISE, :MEASUREMENTS], memory[_NOISE, MEASUREMENTS : MEASUREMENTS + 2]
    for r in range(MEASUREMENTS):
        noise[r] = tuning[MEASUREMENT_VARIANCE + r]
    speeds[0], speeds[1] = front, rear
    if teeth > 0.0:
        delay_f = 0.0 if stopped_f else sample_delay(front, teeth, window)
        delay_r = 0.0 if stopped_r else sample_delay(rear, teeth, window)
        delay_wheel_row(design, ROW_WHEEL_F, delay_f, tuning[RADIUS_F], tuning[INERTIA_F])
        delay_wheel_row(design, ROW_WHEEL_R, delay_r, tuning[RADIUS_R], tuning[INERTIA_R])
        bring_forward(history, teeth, window, tuning[SAMPLE_TIME], change_f, change_r, speeds, noise[ROW_WHEEL_F:])
    acceleration = guard[IN_ACCELERATION, VALUE] * tuning[PITCH_FACTOR]
    expected[ROW_ACCELERATION] = acceleration - tracker[OFFSET] - expected[ROW_ACCELERATION]
    expected[ROW_WHEEL_F] = speeds[0] - expected[ROW_WHEEL_F]
    expected[ROW_WHEEL_R] = speeds[1] - expected[ROW_WHEEL_R]
    hold = tuning[HOLD_INPUTS] > 0.0
    fresh_f, fresh_r = fresh_axles(guard)
    rows[ROW_ACCELERATION] = ROW_USED if hold or guard[IN_ACCELERATION, FRESH] > 0.0 else ROW_MISSING
    rows[ROW_WHEEL_F] = ROW_USED if (hold or fresh_f) and not stale_f else ROW_MISSING
    rows[ROW_WHEEL_R] = ROW_USED if (hold or fresh_r) and not stale_r else ROW_MISSING
    rim_f, rim_r = tuning[RADIUS_F] * speeds[0], tuning[RADIUS_R] * speeds[1]
    tied_f, tied_r = rolling_axles(torques, tuning[ROLLING_TORQUE] if tuning[ROLLING_VARIANCE] > 0.0 else -1.0)
    tied_f, tied_r = tied_f and not stale_f, tied_r and not stale_r
    if tied_f or tied_r:
        # a speed that the wheels tell needs no agreement with the accelerometer, whose offset they tell as well
        learn_offset(
            tracker, acceleration, rim_f if tied_f else rim_r, tuning[SAMPLE_TIME], tuning[OFFSET_RATE],
            tuning[LARGEST_OFFSET],
        )  # fmt: skip
        memory[_STATUS, _CONTRADICTION] = 0.0
    else:
        tracker[TRACKED] = 0.0
    if rows[ROW_ACCELERATION] == ROW_USED and not (tied_f or tied_r):
        _note_contradiction(
            memory[_STATUS], covariance, design, expected[ROW_ACCELERATION], noise[ROW_ACCELERATION],
            tuning[CONTRADICTION_WEIGHT],
        )  # fmt: skip
    memory[_STATUS, _INNOVATION] = correct_rows(
        state,
        covariance,
        expected,
        design,
        noise,
        rows[:MEASUREMENTS],
        0.0,
        DESIGN_COLUMNS,
        scratch[:4],
    )
    for tied, row, rim in ((tied_f, ROW_WHEEL_F, rim_f), (tied_r, ROW_WHEEL_R, rim_r)):
        if tied and rows[row] == ROW_USED:
            tie_speed(
                state, covariance, rim, tuning[ROLLING_VARIANCE : ROLLING_VARIANCE + 1], memory[_ROLLING:_SCRATCH],
                memory[_EXPECTED, MEASUREMENTS : MEASUREMENTS + 1], rows[MEASUREMENTS:], scratch[:4],
            )  # fmt: skip
    by_wheels = tuning[BOUND_BY_WHEELS] > 0.0
    outside = _bound_speed(state, torques, tuning[RADIUS_F] * front, tuning[RADIUS_R] * rear, by_wheels)
    # once it has given way to a contradiction nothing ties the speed again, also where drag then explains the rest
    if outside or abs(memory[_STATUS, _CONTRADICTION]) > tuning[CONTRADICTION_LIMIT]:
        memory[_STATUS, _DISTRUSTED] = 1.0


@njit(cache=True)
def _tick(
    memory: FloatArray,
    history: FloatArray,
    rows: IntArray,
    tuning: FloatArray,
    guard: FloatArray,
    positions: IntArray,
    inputs: FloatArray,
    ages: FloatArray,
    out: FloatArray,
) -> None:
    state, status, covariance = memory[_STATE], memory[_STATUS], memory[_COVARIANCE:_TRANSITION]
    verdict = accept_inputs(guard, positions, inputs, ages, tuning[SAMPLE_TIME])
    wheel_f, wheel_r = axle_speeds(guard)
    rim_f, rim_r = tuning[RADIUS_F] * wheel_f, tuning[RADIUS_R] * wheel_r
    slower_f, slower_r = slower_wheels(guard)
    action = decide(
        status[_ACTIVE] > 0.0,
        verdict == INPUTS_LOST,
        rim_f,
        rim_r,
        min(tuning[RADIUS_F] * slower_f, tuning[RADIUS_R] * slower_r),
        state[SPEED],
        tuning[MINIMUM_SPEED],
        tuning[HYSTERESIS],
    )
    if action == RUN:
        _filter_step(memory, history, rows, tuning, guard)
        if not all_finite(state):
            action = STOP
        elif status[_DISTRUSTED] > 0.0 and tuning[RESTARTS] > 0.0:
            rolls_f, rolls_r = rolling_axles(memory[_TORQUES], tuning[ROLLING_TORQUE])
            action = START if rolls_f or rolls_r else RUN
        if action == START:
            status[_RESETS] += 1.0
            forget_changes(history)
    else:
        forget_changes(history)
    if action == START:
        speed = start_speed(guard[IN_ACCELERATION, VALUE], rim_f, rim_r)
        _initialise(memory, tuning, speed, wheel_f, wheel_r)
        status[_ACTIVE], status[_INNOVATION:_STATUS_KEPT] = 1.0, 0.0
    elif action == STOP:
        _initialise(memory, tuning, 0.0, 0.0, 0.0)
        status[_ACTIVE], status[_INNOVATION:] = 0.0, 0.0
        status[_RESETS] += 1.0
    out[0], out[1], out[2] = status[_ACTIVE], status[_RESETS], verdict
    for i in range(WHEEL_R + 1):
        out[_OUT_SPEED + 2 * i] = state[i]
        out[_OUT_SPEED + 2 * i + 1] = math.sqrt(max(covariance[i, i], 0.0))
    for k in range(3):
        force = FORCE_F + 2 * k
        out[_OUT_FORCE_F + 2 * k] = state[force]
        out[_OUT_FORCE_F + 2 * k + 1] = math.sqrt(max(covariance[force, force], 0.0))
    out[_OUT_INNOVATION] = status[_INNOVATION]
    out[_OUT_OFFSET] = status[_TRACKER + OFFSET]
    out[_OUT_SPEED_CONFIDENCE] = 1.0 if status[_ACTIVE] > 0.0 and status[_DISTRUSTED] == 0.0 else 0.0


def model_parameters(car: LongitudinalCar, settings: ForceEkfSettings) -> FloatArray:
    """Parameters of :mod:`estimators.force_model`, shape (8,)."""
    values = np.zeros(MODEL_PARAMETERS)
    values[MASS], values[ROLLING_FORCE], values[DRAG_FACTOR] = car.mass, car.rolling_force, car.drag_factor
    values[COSINE_SPEED] = settings.cosine_speed if settings.drag == "cosine" else 0.0
    values[RADIUS_F], values[RADIUS_R] = car.radius
    values[INERTIA_F], values[INERTIA_R] = car.inertia
    return values


class ForceEkf(Estimator):
    """Force EKF; build it with :func:`estimators.create`.

    Attributes
    ----------
    state : array, shape (9,)
        Speed [m/s], wheel speeds front, rear [rad/s], force front [N], its rate [N/s], force rear, its rate, unmodelled
        force, its rate; a view.
    covariance : array, shape (9, 9)
        View of its covariance.
    """

    def __init__(self, vehicle: Mapping[str, float], settings: ForceEkfSettings, sample_time_s: float = 0.001) -> None:
        self.settings = settings
        tuning = _tuning(vehicle, settings, sample_time_s)
        self._memory = np.zeros((_MEMORY_ROWS, STATES))
        self._tuning = tuning
        inputs = force_inputs(settings)
        self._guard, positions = input_guard(inputs, settings.input_timeout)
        self.state = self._memory[_STATE]
        self.covariance = self._memory[_COVARIANCE:_TRANSITION]
        super().__init__("force_ekf", inputs, sample_time_s)
        rows = np.zeros(MEASUREMENTS + 1, dtype=np.int64)
        self._history = np.zeros((2, HISTORY_SIZE))
        self.tick = partial(_tick, self._memory, self._history, rows, tuning, self._guard, positions)
        self.reset()

    def reset(self) -> None:
        """Return to the state of a new filter."""
        self._memory[_STATUS] = 0.0
        _initialise(self._memory, self._tuning, 0.0, 0.0, 0.0)
        forget_changes(self._history)
        forget_inputs(self._guard)


def _tuning(vehicle: Mapping[str, float], settings: ForceEkfSettings, sample_time_s: float) -> FloatArray:
    car = longitudinal_car(vehicle)
    values = np.zeros(TUNING_SIZE)
    values[TEETH], values[WINDOW] = tone_ring(vehicle, settings.wheel_speed_teeth, settings.wheel_speed_window)
    values[:MODEL_PARAMETERS] = model_parameters(car, settings)
    values[PITCH_FACTOR] = 1.0 / (1.0 + GRAVITY_M_S2 * settings.pitch_gradient)
    values[SAMPLE_TIME] = sample_time_s
    values[BRAKE_GAIN_F], values[BRAKE_GAIN_R] = car.brake_gain
    values[BRAKE_IS_CAPACITY] = settings.brake_torque == "capacity"
    values[HOLD_INPUTS] = settings.input_rule == "hold"
    values[MINIMUM_SPEED], values[HYSTERESIS] = settings.minimum_speed, settings.speed_hysteresis
    values[BOUND_BY_WHEELS] = settings.speed_bound == "wheels"
    values[CONTRADICTION_WEIGHT] = 1.0 / settings.contradiction_samples
    values[CONTRADICTION_LIMIT] = settings.contradiction_limit
    values[ROLLING_TORQUE], values[RESTARTS] = ROLLING_SHARE * car.weight * min(car.radius), settings.restart
    # without the row of rolling axles nothing tells an offset from drag
    values[ROLLING_VARIANCE] = 0.0 if settings.rolling_speed == "none" else settings.measurement_rolling_speed**2
    values[OFFSET_RATE], values[LARGEST_OFFSET] = 1.0 / settings.offset_time_constant, settings.largest_offset
    values[RATE_DECAY] = math.exp(-sample_time_s / settings.locked_rate_time_constant)
    extra = float(settings.unmodelled_force)
    process = np.array(
        [
            settings.process_speed,
            *[settings.process_wheel_speed] * 2,
            *[settings.process_force, settings.process_force_rate] * 2,
            extra * settings.process_unmodelled,
            extra * settings.process_unmodelled_rate,
        ]
    )
    initial = np.array(
        [
            settings.initial_speed,
            *[settings.initial_wheel_speed] * 2,
            *[settings.initial_force, settings.initial_force_rate] * 2,
            extra * settings.initial_force,
            extra * settings.initial_force_rate,
        ]
    )
    # noise is given per millisecond
    values[PROCESS_VARIANCE:MEASUREMENT_VARIANCE] = process**2 * (sample_time_s / 1e-3)
    rows = [settings.measurement_acceleration, *[settings.measurement_wheel_speed] * 2]
    values[MEASUREMENT_VARIANCE:INITIAL_VARIANCE] = np.square(rows)
    values[INITIAL_VARIANCE:] = initial**2
    return values
