"""The replay of one manoeuvre, compiled: pre-roll, steps of the car, samples, corrections of the observer."""

import math
from typing import Any

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
from model_diagnosis.replay.lane_memory import at, put
from model_diagnosis.replay.lanes import cell_of, some, where
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
    if some(p.in_stop_rise != 0.0):
        count_stop_energy(s, step)
    move_in_plane(p, s, step)
    move_body(p, s, step)


@njit(cache=True, nogil=True, error_model="numpy")
def take_tables(s: Record, tables: NDArray[np.float64]) -> None:
    for axle in range(2):
        for direction in range(2):
            for k in range(CELLS + 1):
                row = (axle * 2 + direction) * (CELLS + 1) + k
                s.table[axle, direction, k, 0] = at(tables, row, 0)
                s.table[axle, direction, k, 1] = at(tables, row, 1)


@njit(cache=True, nogil=True, error_model="numpy")
def _on_line(values: NDArray[np.float64], column: int, row: int, share: float) -> float:
    """Value of a column on the straight line from the row before to ``row``."""
    before = at(values, row - 1, column)
    return before + share * (at(values, row, column) - before)


@njit(cache=True, nogil=True, error_model="numpy")
def take_inputs(
    s: Record, inputs: NDArray[np.float64], row: int, share: float, between: NDArray[np.float64], place: int
) -> None:
    """Inputs of a step between two samples; pressures are ``between``[place] beside the straight line."""
    for i in range(4):
        s.pressure[i] = max(_on_line(inputs, i, row, share) + at(between, place, i), 0.0)
    s.drive_front = _on_line(inputs, INPUT_DRIVE_FRONT, row, share)
    s.drive_rear = _on_line(inputs, INPUT_DRIVE_REAR, row, share)
    s.steer = _on_line(inputs, INPUT_STEER, row, share)
    s.grade = _on_line(inputs, INPUT_GRADE, row, share)
    s.bank = _on_line(inputs, INPUT_BANK, row, share)


@njit(cache=True, nogil=True, error_model="numpy")
def take_terms(s: Record, inputs: NDArray[np.float64], row: int, share: float) -> None:
    """Terms of a step between two samples, where the inputs have any."""
    for i in range(4):
        s.brake_share[i] = max(_on_line(inputs, INPUT_BRAKE_SHARE + i, row, share), 0.0)
        s.grip_share[i] = max(_on_line(inputs, INPUT_GRIP_SHARE + i, row, share), _LEAST_GRIP)
    s.term_force_x = _on_line(inputs, INPUT_FORCE_X, row, share)
    s.term_force_y = _on_line(inputs, INPUT_FORCE_Y, row, share)
    s.term_yaw_moment = _on_line(inputs, INPUT_YAW_MOMENT, row, share)


@njit(cache=True, nogil=True, error_model="numpy")
def _between_rows(values: NDArray[np.float64], column: int, place: float) -> float:
    """Value of a column on the straight line between rows, at a place counted in rows; the ends go on level."""
    place = min(max(place, 0.0), values.shape[0] - 1.0)
    row = min(int(place), values.shape[0] - 2)
    return _on_line(values, column, row + 1, place - row)


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
    place = cell_of(steps, PAST_STEPS - 2)
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
            out[_SLIP_ANGLE + i] = -math.atan(s.slip_y[i])
        out[_BODY_SLIP_ANGLE] = math.atan2(s.lateral_speed, max(s.speed, 0.1))


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
        band = where(least[i] <= gains[GAIN_WHEEL], gains[DEAD_BAND_WHEEL], 0.0)
        beyond = error - min(max(error, -band), band)
        moved = max(max(gains[GAIN_WHEEL], least[i]) * beyond, -s.spin[i])
        s.spin[i] += moved
        for k in range(PAST_STEPS):
            s.past_spin[k, i] += moved
        along += p.radius[i] * error
        count += valid[i]
        anew = max(anew, least[i])
    by_wheels = where(count > 0.0, max(gains[GAIN_SPEED_BY_WHEELS], anew) * along / count, 0.0)
    s.speed += where(valid[4] > 0.0, max(gains[GAIN_SPEED], least[4]) * (measured[4] - seen[4]), by_wheels)
    s.yaw_rate += valid[5] * max(gains[GAIN_YAW], least[5]) * (measured[5] - seen[5])


@njit(cache=True, nogil=True, error_model="numpy")
def _start_speed(p: Record, start: NDArray[np.float64]) -> float:
    """The measured speed, or that of the second fastest wheel with this car's radii: nominal ones would deny theirs."""
    known = at(start, 0, 0)
    growth = p.radius_speed * known * known
    fl, fr = (p.radius[0] + growth) * at(start, 0, 2), (p.radius[1] + growth) * at(start, 0, 3)
    rl, rr = (p.radius[2] + growth) * at(start, 0, 4), (p.radius[3] + growth) * at(start, 0, 5)
    second = max(min(max(fl, fr), max(rl, rr)), max(min(fl, fr), min(rl, rr)))
    return where(second > 0.0, second, known)


@njit(cache=True, nogil=True, error_model="numpy")
def settle(p: Record, s: Record, start: NDArray[np.float64], step: float) -> None:
    """Settle at the first sample's inputs, speed and yaw rate."""
    prepare_accelerometer(p, s, step)
    speed = _start_speed(p, start)
    for i in range(4):
        s.spin[i] = speed / p.radius[i]
        s.disc_temperature[i], s.disc_cosine[i] = p.start_temperature[i], 1.0
        s.angle[i], s.sine[i], s.cosine[i] = p.toe[i], math.sin(p.toe[i]), math.cos(p.toe[i])
    for _ in range(PRE_ROLL_SAMPLES * SUBSTEPS):
        s.speed, s.yaw_rate = speed, at(start, 0, 1)
        move_car(p, s, step)
    s.speed, s.yaw_rate = speed, at(start, 0, 1)
    s.distance = s.stop_energy = 0.0
    for _ in range(PAST_STEPS):
        keep_spins(s)
    for i in range(4):
        s.disc_temperature[i] = p.start_temperature[i]
        s.tyre_heat[i] = s.disc_sine[i] = 0.0
        s.disc_cosine[i] = 1.0
        s.clamping[i] = s.pressure[i]


@njit(cache=True, nogil=True, error_model="numpy")
def run_through(
    p: Record,
    s: Record,
    work: Any,
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
    """Replay one manoeuvre with one car, or with eight: arrays of the latter are as below or have an axis more.

    Parameters
    ----------
    p, s : the car and its state, zeros
    work : room for two sets of outputs and for what the observer sees, knows, counts and begins anew with, 6 of each
    tables : (4 (CELLS + 1), 2) of the tyres: axle, direction, cell
    inputs : (n, INPUTS), or (n, INPUTS_WITH_TERMS)
    between : (n SUBSTEPS, 4) pressures beside the straight line in the middle of the steps before each sample [Pa]
    measured, valid : (n, 6) signals of ``CORRECTED`` and 1 where they hold
    start : (1, 6) speed, yaw rate and spins of the wheels at the first sample (``inputs.start_of``)
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
    take_tables(s, tables)
    step = sample_time / SUBSTEPS
    full, before, seen, known, counts, anew = work
    restart = np.ones(5)
    restart[DEAD_BAND_WHEEL] = 0.0
    is_phased = bool(input_phases.any() or corrected_phases.any() or output_phases.any())
    taken, corrected = when_taken(output_phases), when_taken(corrected_phases)
    is_angle = (chosen >= _SLIP_ANGLE) & (chosen < _SLIP_ANGLE + 4) | (chosen == _BODY_SLIP_ANGLE)
    with_angles = bool(is_angle.any())
    for i in range(4):
        s.brake_share[i] = s.grip_share[i] = 1.0
    has_terms = inputs.shape[1] > INPUTS
    if has_terms:
        take_terms(s, inputs, 1, 0.0)
    take_inputs(s, inputs, 1, 0.0, between, 0)
    settle(p, s, start, step)
    write_outputs(p, s, step, with_angles, full)
    for k in range(inputs.shape[0]):
        for j in range(SUBSTEPS if k > 0 else 0):
            if is_phased:
                take_inputs_at(s, inputs, input_phases, between, k - 1.0 + (j + 0.5) / SUBSTEPS)
            else:
                take_inputs(s, inputs, k, (j + 0.5) / SUBSTEPS, between, k * SUBSTEPS + j)
            if has_terms:
                take_terms(s, inputs, k, (j + 0.5) / SUBSTEPS)
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
                put(out, k, c, full[chosen[c]])
        if (horizon > 0 and k % horizon == 0) or (horizon == 0 and not is_phased):
            for q in range(6):
                seen[q], known[q] = full[CORRECTED_OUTPUTS[q]], at(measured, k, q)
                counts[q], anew[q] = at(valid, k, q), at(least, k, q)
                if horizon > 0:
                    anew[q] = 0.0
            correct_states(p, s, seen, known, counts, restart if horizon > 0 else gains, anew)
    if is_phased:
        write_last(full, chosen, output_phases, out)
