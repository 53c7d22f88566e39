"""The replay of one manoeuvre, compiled: pre-roll, steps of the car, samples, corrections of the observer."""

import numpy as np
from numba import njit
from numpy.typing import NDArray

from model_diagnosis.replay.brake_step import count_stop_energy
from model_diagnosis.replay.chassis_step import (
    load_wheels,
    look_ahead,
    move_body,
    move_in_plane,
    prepare_accelerometer,
)
from model_diagnosis.replay.disturb_step import NOWHERE, disturb
from model_diagnosis.replay.record import (
    CELLS,
    INPUT_BANK,
    INPUT_BRAKE_SHARE,
    INPUT_DRIVE_FRONT,
    INPUT_DRIVE_REAR,
    INPUT_FORCE_X,
    INPUT_FORCE_Y,
    INPUT_GRADE,
    INPUT_GRIP_SHARE,
    INPUT_STEER,
    INPUT_YAW_MOMENT,
    INPUTS,
    OUTPUTS,
    Record,
)
from model_diagnosis.replay.state import PAST_STEPS, SUBSTEPS
from model_diagnosis.replay.taken_step import CORRECTED_OUTPUTS, take_corrected, when_taken, write_last, write_taken
from model_diagnosis.replay.wheel_step import move_wheel, steer_wheels

PRE_ROLL_SAMPLES = 80
"""Time before the first sample in which its inputs and its measured speed and yaw rate hold: all else settles."""

GAIN_WHEEL, GAIN_SPEED, GAIN_YAW, GAIN_SPEED_BY_WHEELS, DEAD_BAND_WHEEL = range(5)
"""Fixed gains of the observer per sample; the last one acts where no speed is measured."""

_LEAST_GRIP = 0.05
_OUTPUTS = len(OUTPUTS)
_SPEED, _YAW_RATE, _ROLL_RATE = OUTPUTS.index("speed"), OUTPUTS.index("yaw_rate"), OUTPUTS.index("roll_rate")
_SLIP_ANGLE, _BODY_SLIP_ANGLE = OUTPUTS.index("slip_angle_fl"), OUTPUTS.index("side_slip_angle")


@njit(cache=True, nogil=True, error_model="numpy")
def move_car(p: Record, s: Record, step: float) -> None:
    """One step of the car: forces in its middle, then the motion at its end."""
    look_ahead(s, step)
    load_wheels(p, s, step)
    steer_wheels(p, s, step)
    for i in range(4):
        move_wheel(p, s, i, step)
    if p.in_stop_rise != 0.0:
        count_stop_energy(s, step)
    move_in_plane(p, s, step)
    move_body(p, s, step)


@njit(cache=True, nogil=True, error_model="numpy")
def take_tables(s: Record, tables: NDArray[np.float64]) -> None:
    for axle in range(2):
        for direction in range(2):
            for k in range(CELLS + 1):
                s.table[axle, direction, k, 0] = tables[axle, direction, k, 0]
                s.table[axle, direction, k, 1] = tables[axle, direction, k, 1]


@njit(cache=True, nogil=True, error_model="numpy")
def take_inputs(
    s: Record, before: NDArray[np.float64], after: NDArray[np.float64], share: float, beside: NDArray[np.float64]
) -> None:
    """Inputs of a step between two samples; pressures are ``beside`` (4,) the straight line."""
    for i in range(4):
        s.pressure[i] = max(before[i] + share * (after[i] - before[i]) + beside[i], 0.0)
    s.drive_front = before[INPUT_DRIVE_FRONT] + share * (after[INPUT_DRIVE_FRONT] - before[INPUT_DRIVE_FRONT])
    s.drive_rear = before[INPUT_DRIVE_REAR] + share * (after[INPUT_DRIVE_REAR] - before[INPUT_DRIVE_REAR])
    s.steer = before[INPUT_STEER] + share * (after[INPUT_STEER] - before[INPUT_STEER])
    s.grade = before[INPUT_GRADE] + share * (after[INPUT_GRADE] - before[INPUT_GRADE])
    s.bank = before[INPUT_BANK] + share * (after[INPUT_BANK] - before[INPUT_BANK])


@njit(cache=True, nogil=True, error_model="numpy")
def take_terms(s: Record, before: NDArray[np.float64], after: NDArray[np.float64], share: float) -> None:
    """Terms of a step between two samples, where the inputs have any."""
    for i in range(4):
        b, g = INPUT_BRAKE_SHARE + i, INPUT_GRIP_SHARE + i
        s.brake_share[i] = max(before[b] + share * (after[b] - before[b]), 0.0)
        s.grip_share[i] = max(before[g] + share * (after[g] - before[g]), _LEAST_GRIP)
    s.term_force_x = before[INPUT_FORCE_X] + share * (after[INPUT_FORCE_X] - before[INPUT_FORCE_X])
    s.term_force_y = before[INPUT_FORCE_Y] + share * (after[INPUT_FORCE_Y] - before[INPUT_FORCE_Y])
    s.term_yaw_moment = before[INPUT_YAW_MOMENT] + share * (after[INPUT_YAW_MOMENT] - before[INPUT_YAW_MOMENT])


@njit(cache=True, nogil=True, error_model="numpy")
def _between_rows(values: NDArray[np.float64], column: int, place: float) -> float:
    """Value of a column on the straight line between rows, at a place counted in rows; the ends go on level."""
    place = min(max(place, 0.0), values.shape[0] - 1.0)
    row = min(int(place), values.shape[0] - 2)
    return values[row, column] + (place - row) * (values[row + 1, column] - values[row, column])


@njit(cache=True, nogil=True, error_model="numpy")
def take_inputs_at(
    s: Record,
    inputs: NDArray[np.float64],
    phases: NDArray[np.float64],
    between: NDArray[np.float64],
    instant: float,
) -> None:
    """Inputs at an instant in samples, each channel taken at its own phase; ``between`` (n · SUBSTEPS, 4)."""
    for i in range(4):
        place = instant - phases[i]
        beside = _between_rows(between, i, (place + 1.0) * SUBSTEPS - 0.5)
        s.pressure[i] = max(_between_rows(inputs, i, place) + beside, 0.0)
    s.drive_front = _between_rows(inputs, INPUT_DRIVE_FRONT, instant - phases[INPUT_DRIVE_FRONT])
    s.drive_rear = _between_rows(inputs, INPUT_DRIVE_REAR, instant - phases[INPUT_DRIVE_REAR])
    s.steer = _between_rows(inputs, INPUT_STEER, instant - phases[INPUT_STEER])
    s.grade = _between_rows(inputs, INPUT_GRADE, instant - phases[INPUT_GRADE])
    s.bank = _between_rows(inputs, INPUT_BANK, instant - phases[INPUT_BANK])


@njit(cache=True, nogil=True, error_model="numpy")
def keep_spins(s: Record) -> None:
    """Put the wheels' speeds at the end of a step before those of the last ones."""
    for k in range(PAST_STEPS - 1, 0, -1):
        for i in range(4):
            s.past_spin[k, i] = s.past_spin[k - 1, i]
    for i in range(4):
        s.past_spin[0, i] = s.spin[i]


@njit(cache=True, nogil=True, error_model="numpy")
def lagging_spin(s: Record, i: int, steps: float) -> float:
    """Speed of a wheel so many steps ago; ahead of the last step and behind the first along their slopes."""
    place = min(max(int(steps), 0), PAST_STEPS - 2)
    after, before = s.past_spin[place, i], s.past_spin[place + 1, i]
    return after + (steps - place) * (before - after)


@njit(cache=True, nogil=True, error_model="numpy")
def write_outputs(p: Record, s: Record, step: float, with_angles: bool, out: NDArray[np.float64]) -> None:
    """All outputs (``OUTPUTS``) at this instant; sensors of speeds and turning rates lag by a constant time.

    Slip angles, five arc tangents, are left out unless ``with_angles``.
    """
    for i in range(4):
        out[i] = lagging_spin(s, i, p.wheel_speed_lag / step)
        out[4 + i] = s.load[i]
        out[8 + i], out[12 + i] = s.tyre_x[i], s.tyre_y[i]
        out[16 + i] = s.travel[i]
        out[20 + i] = s.slip_x[i]
        out[28 + i], out[32 + i], out[36 + i] = s.disc_temperature[i], s.brake_torque[i], s.drive_torque[i]
        out[40 + i] = s.angle[i]
    out[_SPEED], out[_SPEED + 1] = s.speed - p.speed_lag * s.speed_rate, s.lateral_speed
    out[_YAW_RATE] = s.yaw_rate - p.gyro_lag * s.yaw_acceleration
    out[_YAW_RATE + 1], out[_YAW_RATE + 2] = s.acceleration_x, s.acceleration_y
    out[_ROLL_RATE] = s.roll_rate - p.gyro_lag * s.roll_acceleration
    out[_ROLL_RATE + 1] = s.pitch_rate - p.gyro_lag * s.pitch_acceleration
    out[_ROLL_RATE + 2], out[_ROLL_RATE + 3] = s.roll, s.pitch
    out[_ROLL_RATE + 5], out[_ROLL_RATE + 6] = s.distance, s.yaw_acceleration
    if with_angles:
        for i in range(4):
            out[_SLIP_ANGLE + i] = -np.arctan(s.slip_y[i])
        out[_BODY_SLIP_ANGLE] = np.arctan2(s.lateral_speed, max(s.speed, 0.1))


@njit(cache=True, nogil=True, error_model="numpy")
def correct_states(
    p: Record,
    s: Record,
    seen: NDArray[np.float64],
    measured: NDArray[np.float64],
    valid: NDArray[np.float64],
    gains: NDArray[np.float64],
    least: NDArray[np.float64],
) -> None:
    """Observer: wheel speeds, speed and yaw rate are drawn to the measured ones, by ``least`` (6,) gains or more.

    ``seen`` (6,) are the predictions of ``CORRECTED``.
    """
    along = count = anew = 0.0
    for i in range(4):
        error = valid[i] * (measured[i] - seen[i])
        band = gains[DEAD_BAND_WHEEL] if least[i] <= gains[GAIN_WHEEL] else 0.0
        beyond = error - min(max(error, -band), band)
        moved = max(max(gains[GAIN_WHEEL], least[i]) * beyond, -s.spin[i])
        s.spin[i] += moved
        for k in range(PAST_STEPS):
            s.past_spin[k, i] += moved
        along += p.radius[i] * error
        count += valid[i]
        anew = max(anew, least[i])
    if valid[4] > 0.0:
        s.speed += max(gains[GAIN_SPEED], least[4]) * (measured[4] - seen[4])
    elif count > 0.0:
        s.speed += max(gains[GAIN_SPEED_BY_WHEELS], anew) * along / count
    s.yaw_rate += valid[5] * max(gains[GAIN_YAW], least[5]) * (measured[5] - seen[5])


@njit(cache=True, nogil=True, error_model="numpy")
def settle(p: Record, s: Record, start: NDArray[np.float64], step: float) -> None:
    """Settle at the first sample's inputs, speed and yaw rate."""
    prepare_accelerometer(p, s, step)
    for i in range(4):
        s.spin[i] = start[0] / p.radius[i]
        s.disc_temperature[i], s.disc_cosine[i] = p.start_temperature[i], 1.0
        s.angle[i], s.sine[i], s.cosine[i] = p.toe[i], np.sin(p.toe[i]), np.cos(p.toe[i])
    for _ in range(PRE_ROLL_SAMPLES * SUBSTEPS):
        s.speed, s.yaw_rate = start[0], start[1]
        move_car(p, s, step)
    s.speed, s.yaw_rate = start[0], start[1]
    s.distance = s.stop_energy = 0.0
    for _ in range(PAST_STEPS):
        keep_spins(s)
    for i in range(4):
        s.disc_temperature[i] = p.start_temperature[i]
        s.tyre_heat[i] = s.disc_sine[i] = 0.0
        s.disc_cosine[i] = 1.0
        s.clamping[i] = s.pressure[i]


@njit(cache=True, nogil=True, error_model="numpy")
def replay_run(
    cars: NDArray[np.void],
    car: int,
    memory: NDArray[np.void],
    tables: NDArray[np.float64],
    inputs: NDArray[np.float64],
    between: NDArray[np.float64],
    measured: NDArray[np.float64],
    valid: NDArray[np.float64],
    start: NDArray[np.float64],
    gains: NDArray[np.float64],
    least: NDArray[np.float64],
    horizon: int,
    sample_time: float,
    chosen: NDArray[np.int64],
    input_phases: NDArray[np.float64],
    corrected_phases: NDArray[np.float64],
    output_phases: NDArray[np.float64],
    place: int,
    disturbance: NDArray[np.float64],
    out: NDArray[np.float64],
) -> None:
    """Replay one manoeuvre with one car.

    Parameters
    ----------
    cars : (k,) of ``REPLAY_RECORD``, of which ``car`` runs
    memory : shape (1,), zeros of ``STATE_RECORD``
    tables : (2, 2, CELLS + 1, 2) of the tyres: axle, direction
    inputs : (n, INPUTS), or (n, INPUTS_WITH_TERMS)
    between : (n, SUBSTEPS, 4) pressures beside the straight line in the middle of the steps before each sample [Pa]
    measured, valid : (n, 6) signals of ``CORRECTED`` and 1 where they hold
    start : (2,) speed and yaw rate at the first sample
    gains : (5,) of the observer, the last the dead band of the wheel speeds [rad/s]; zeros for a free run
    least : (n, 6) least gains of the observer: where it begins anew behind a gap of the inputs
    horizon : samples after which a free run restarts at the measured speeds; 0 never
    sample_time : s
    chosen : (c,) outputs to keep
    input_phases, corrected_phases, output_phases : (INPUTS,), (6,), (c,) in samples, see ``phases``
    place : where a disturbance acts (``disturb_step``), or ``NOWHERE``
    disturbance : (n,) N or N m, each in the step to its sample
    out : (n, c) predictions before each sample's correction
    """
    p, s = cars[car], memory[0]
    take_tables(s, tables)
    step = sample_time / SUBSTEPS
    full, before, seen = np.zeros(_OUTPUTS), np.zeros(_OUTPUTS), np.zeros(6)
    restart, nothing = np.ones(5), np.zeros(6)
    restart[DEAD_BAND_WHEEL] = 0.0
    is_phased = bool(input_phases.any() or corrected_phases.any() or output_phases.any())
    taken, corrected = when_taken(output_phases), when_taken(corrected_phases)
    known, counts, anew = np.zeros(6), np.zeros(6), np.zeros(6)  # of the signals taken in a step
    is_angle = (chosen >= _SLIP_ANGLE) & (chosen < _SLIP_ANGLE + 4) | (chosen == _BODY_SLIP_ANGLE)
    with_angles = bool(is_angle.any())
    courses = np.ascontiguousarray(between).reshape(between.shape[0] * SUBSTEPS, 4)
    for i in range(4):
        s.brake_share[i] = s.grip_share[i] = 1.0
    has_terms = inputs.shape[1] > INPUTS
    if has_terms:
        take_terms(s, inputs[0], inputs[0], 0.0)
    take_inputs(s, inputs[0], inputs[0], 0.0, between[0, 0])
    settle(p, s, start, step)
    write_outputs(p, s, step, with_angles, full)
    for k in range(inputs.shape[0]):
        for j in range(SUBSTEPS if k > 0 else 0):
            if is_phased:
                take_inputs_at(s, inputs, input_phases, courses, k - 1.0 + (j + 0.5) / SUBSTEPS)
            else:
                take_inputs(s, inputs[k - 1], inputs[k], (j + 0.5) / SUBSTEPS, between[k, j])
            if has_terms:
                take_terms(s, inputs[k - 1], inputs[k], (j + 0.5) / SUBSTEPS)
            move_car(p, s, step)
            if place != NOWHERE:
                disturb(p, s, place, disturbance[k], step)
            keep_spins(s)
            if is_phased:
                before, full = full, before
                write_outputs(p, s, step, with_angles, full)
                write_taken(k, j, before, full, chosen, taken, out)
                if horizon == 0 and take_corrected(
                    k, j, before, full, measured, valid, least, corrected, seen, known, counts, anew
                ):
                    correct_states(p, s, seen, known, counts, gains, anew)
                    write_outputs(p, s, step, with_angles, full)
        if not is_phased:
            write_outputs(p, s, step, with_angles, full)
        if not is_phased or k == 0:
            for c in range(chosen.shape[0]):
                out[k, c] = full[chosen[c]]
        if horizon > 0:
            if k % horizon == 0:
                _see(full, seen)
                correct_states(p, s, seen, measured[k], valid[k], restart, nothing)
        elif not is_phased:
            _see(full, seen)
            correct_states(p, s, seen, measured[k], valid[k], gains, least[k])
    if is_phased:
        write_last(full, chosen, output_phases, out)


@njit(cache=True, nogil=True, error_model="numpy")
def _see(full: NDArray[np.float64], seen: NDArray[np.float64]) -> None:
    """Predictions of the signals that the observer corrects on."""
    for q in range(6):
        seen[q] = full[CORRECTED_OUTPUTS[q]]
