"""The replay of one manoeuvre, compiled: pre-roll, steps of the car, samples, corrections of the observer."""

import numpy as np
from numba import njit
from numpy.typing import NDArray

from model_diagnosis.replay.brake_step import count_stop_energy
from model_diagnosis.replay.chassis_step import move_body, move_in_plane
from model_diagnosis.replay.record import INPUTS, OUTPUTS, Record
from model_diagnosis.replay.state import (
    ACCELERATION_X,
    ACCELERATION_Y,
    BODY_STATES,
    BRAKE_TORQUE,
    CLAMPING,
    DISC_ANGLE,
    DISC_TEMPERATURE,
    DISTANCE,
    LATERAL_SPEED,
    LOAD,
    PITCH,
    PITCH_RATE,
    ROLL,
    ROLL_RATE,
    SLIP_X,
    SLIP_Y,
    SPEED,
    SPIN,
    SPIN_RATE,
    STOP_ENERGY,
    TRAVEL,
    TYRE_HEAT,
    TYRE_X,
    TYRE_Y,
    WHEEL_STATES,
    YAW_ACCELERATION,
    YAW_RATE,
)
from model_diagnosis.replay.tyre_step import reshape
from model_diagnosis.replay.wheel_step import move_wheel, steer_wheels

SUBSTEPS = 5
"""Steps of 2 ms within a sample of 10 ms."""

PRE_ROLL_SAMPLES = 80
"""Time before the first sample in which its inputs and its measured speed and yaw rate hold: all else settles."""

GAIN_WHEEL, GAIN_SPEED, GAIN_YAW, GAIN_SPEED_BY_WHEELS = range(4)
"""Fixed gains of the observer per sample; the last one acts where no speed is measured."""

_OUTPUTS = len(OUTPUTS)


@njit(cache=True, nogil=True)
def _step(
    p: Record,
    tables: NDArray[np.float64],
    body: NDArray[np.float64],
    wheels: NDArray[np.float64],
    inputs: NDArray[np.float64],
    step: float,
) -> None:
    move_body(p, body, wheels, step)
    steer_wheels(p, wheels, inputs, step)
    for i in range(4):
        move_wheel(p, tables, body, wheels, inputs, i, step)
    if p.in_stop_rise != 0.0:
        count_stop_energy(body, wheels, inputs, step)
    move_in_plane(p, body, wheels, inputs, step)


@njit(cache=True, nogil=True)
def _shape_tables(p: Record, base: NDArray[np.float64]) -> NDArray[np.float64]:
    """The tyres' tables, reshaped where the record asks for it."""
    if p.sliding_loss == 0.0 and p.peak_shift == 0.0:
        return base
    shaped = base.copy()
    for axle in range(2):
        reshape(base[axle, 0], p.sliding_loss, p.peak_shift, p.peak_slip_x[2 * axle], shaped[axle, 0])
        reshape(base[axle, 1], p.sliding_loss, p.peak_shift, p.peak_slip_y[2 * axle], shaped[axle, 1])
    return shaped


@njit(cache=True, nogil=True)
def _write_outputs(p: Record, body: NDArray[np.float64], wheels: NDArray[np.float64], out: NDArray[np.float64]) -> None:
    """All outputs (``OUTPUTS``) at this instant; sensors of wheel speeds and yaw rate lag by a constant time."""
    for i in range(4):
        out[i] = wheels[SPIN, i] - p.wheel_speed_lag * wheels[SPIN_RATE, i]
        out[4 + i] = wheels[LOAD, i]
        out[8 + i], out[12 + i] = wheels[TYRE_X, i], wheels[TYRE_Y, i]
        out[16 + i] = wheels[TRAVEL, i]
        out[20 + i], out[24 + i] = wheels[SLIP_X, i], -np.arctan(wheels[SLIP_Y, i])
        out[28 + i], out[32 + i] = wheels[DISC_TEMPERATURE, i], wheels[BRAKE_TORQUE, i]
    out[36], out[37] = body[SPEED], body[LATERAL_SPEED]
    out[38] = body[YAW_RATE] - p.gyro_lag * body[YAW_ACCELERATION]
    out[39], out[40] = body[ACCELERATION_X], body[ACCELERATION_Y]
    out[41], out[42], out[43], out[44] = body[ROLL_RATE], body[PITCH_RATE], body[ROLL], body[PITCH]
    out[45] = np.arctan2(body[LATERAL_SPEED], max(body[SPEED], 0.1))
    out[46] = body[DISTANCE]


@njit(cache=True, nogil=True)
def _correct(
    p: Record,
    body: NDArray[np.float64],
    wheels: NDArray[np.float64],
    full: NDArray[np.float64],
    measured: NDArray[np.float64],
    valid: NDArray[np.float64],
    gains: NDArray[np.float64],
) -> None:
    """Observer: wheel speeds, speed and yaw rate are drawn to the measured ones."""
    along = count = 0.0
    for i in range(4):
        error = valid[i] * (measured[i] - full[i])
        wheels[SPIN, i] = max(wheels[SPIN, i] + gains[GAIN_WHEEL] * error, 0.0)
        along += p.radius[i] * error
        count += valid[i]
    if valid[4] > 0.0:
        body[SPEED] += gains[GAIN_SPEED] * (measured[4] - full[36])
    elif count > 0.0:
        body[SPEED] += gains[GAIN_SPEED_BY_WHEELS] * along / count
    body[YAW_RATE] += valid[5] * gains[GAIN_YAW] * (measured[5] - full[38])


@njit(cache=True, nogil=True)
def _start(
    p: Record,
    tables: NDArray[np.float64],
    body: NDArray[np.float64],
    wheels: NDArray[np.float64],
    inputs: NDArray[np.float64],
    start: NDArray[np.float64],
    step: float,
) -> None:
    """Settle at the first sample's inputs, speed and yaw rate."""
    for i in range(4):
        wheels[SPIN, i] = start[0] / p.radius[i]
        wheels[DISC_TEMPERATURE, i] = p.start_temperature[i]
    for _ in range(PRE_ROLL_SAMPLES * SUBSTEPS):
        body[SPEED], body[YAW_RATE] = start[0], start[1]
        _step(p, tables, body, wheels, inputs, step)
    body[SPEED], body[YAW_RATE] = start[0], start[1]
    body[DISTANCE] = body[STOP_ENERGY] = 0.0
    for i in range(4):
        wheels[DISC_TEMPERATURE, i] = p.start_temperature[i]
        wheels[TYRE_HEAT, i] = wheels[DISC_ANGLE, i] = 0.0
        wheels[CLAMPING, i] = inputs[i]


@njit(cache=True, nogil=True)
def replay_run(
    cars: NDArray[np.void],
    car: int,
    base_tables: NDArray[np.float64],
    inputs: NDArray[np.float64],
    measured: NDArray[np.float64],
    valid: NDArray[np.float64],
    start: NDArray[np.float64],
    gains: NDArray[np.float64],
    horizon: int,
    sample_time: float,
    chosen: NDArray[np.int64],
    out: NDArray[np.float64],
) -> None:
    """Replay one manoeuvre with one car.

    Parameters
    ----------
    cars : (k,) of ``REPLAY_RECORD``, of which ``car`` runs
    base_tables : (2, 2, cells + 1, 2) tables of the tyres: axle, direction
    inputs : (n, INPUTS)
    measured, valid : (n, 6) signals of ``CORRECTED`` and 1 where they hold
    start : (2,) speed and yaw rate at the first sample
    gains : (4,) of the observer; zeros for a free run
    horizon : samples after which a free run restarts at the measured speeds; 0 never
    sample_time : s
    chosen : (c,) outputs to keep
    out : (n, c) predictions before each sample's correction
    """
    p = cars[car]
    tables = _shape_tables(p, base_tables)
    step = sample_time / SUBSTEPS
    body, wheels = np.zeros(BODY_STATES), np.zeros((WHEEL_STATES, 4))
    full, held = np.zeros(_OUTPUTS), np.zeros(INPUTS)
    restart = np.ones(4)
    _start(p, tables, body, wheels, inputs[0], start, step)
    for k in range(inputs.shape[0]):
        if k > 0:
            for j in range(SUBSTEPS):
                share = (j + 0.5) / SUBSTEPS
                for c in range(INPUTS):
                    held[c] = inputs[k - 1, c] + share * (inputs[k, c] - inputs[k - 1, c])
                _step(p, tables, body, wheels, held, step)
        _write_outputs(p, body, wheels, full)
        for c in range(chosen.shape[0]):
            out[k, c] = full[chosen[c]]
        if horizon > 0:
            if k % horizon == 0:
                _correct(p, body, wheels, full, measured[k], valid[k], restart)
        else:
            _correct(p, body, wheels, full, measured[k], valid[k], gains)
