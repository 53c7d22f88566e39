"""The observer replay with a force, torque or moment that no equation of it has, compiled."""

import numpy as np
from numba import njit
from numpy.typing import NDArray

from model_diagnosis.replay.record import OUTPUTS, Record
from model_diagnosis.replay.run import (
    SUBSTEPS,
    correct_states,
    move_car,
    settle,
    take_inputs,
    take_tables,
    write_outputs,
)

FORCE_X, SLOPE, FORCE_Y, BANK, YAW, WHEEL, PITCH, ROLL = 0, 1, 2, 3, 4, 5, 9, 10
"""Where a disturbance acts: forces on the body along and across the car [N], each as one that an accelerometer feels
and one that it does not; moments about the vertical axis, at the four wheels, in pitch and in roll [N m]."""


@njit(cache=True, nogil=True, error_model="numpy")
def _disturb(p: Record, s: Record, place: int, size: float, step: float) -> None:
    """One step of a disturbance of ``size`` [N or N m]."""
    if place in (FORCE_X, SLOPE):
        s.speed += step * size * p.inverse_mass
    elif place in (FORCE_Y, BANK):
        s.lateral_speed += step * size * p.inverse_mass
    elif place == YAW:
        s.yaw_rate += step * size * p.inverse_yaw
    elif place == PITCH:
        s.pitch_rate += step * size * p.inverse_pitch
    elif place == ROLL:
        s.roll_rate += step * size * p.inverse_roll
    else:
        wheel = place - WHEEL
        s.spin[wheel] = max(s.spin[wheel] + step * size / p.spin_inertia[wheel], 0.0)
    felt = step / (p.accelerometer_lag + step) * size * p.inverse_mass
    if place == FORCE_X:
        s.acceleration_x += felt
    elif place == FORCE_Y:
        s.acceleration_y += felt


@njit(cache=True, nogil=True, error_model="numpy")
def disturbed_run(
    cars: NDArray[np.void],
    memory: NDArray[np.void],
    tables: NDArray[np.float64],
    inputs: NDArray[np.float64],
    measured: NDArray[np.float64],
    valid: NDArray[np.float64],
    start: NDArray[np.float64],
    gains: NDArray[np.float64],
    sample_time: float,
    chosen: NDArray[np.int64],
    place: int,
    disturbance: NDArray[np.float64],
    out: NDArray[np.float64],
) -> None:
    """Replay one manoeuvre under a disturbance.

    Parameters
    ----------
    cars : (1,) of ``REPLAY_RECORD``
    memory : (1,) zeros of ``STATE_RECORD``
    place : one of those above
    disturbance : (n,) N or N m, each in the step to its sample
    out : (n, c) predictions before each sample's correction; other arguments as in ``replay_run``
    """
    p, s = cars[0], memory[0]
    step, full = sample_time / SUBSTEPS, np.zeros(len(OUTPUTS))
    take_tables(s, tables)
    take_inputs(s, inputs[0], inputs[0], 0.0)
    settle(p, s, start, step)
    for k in range(inputs.shape[0]):
        if k > 0:
            for j in range(SUBSTEPS):
                take_inputs(s, inputs[k - 1], inputs[k], (j + 0.5) / SUBSTEPS)
                move_car(p, s, step)
                _disturb(p, s, place, disturbance[k], step)
        write_outputs(p, s, full)
        for c in range(chosen.shape[0]):
            out[k, c] = full[chosen[c]]
        correct_states(p, s, full, measured[k], valid[k], gains)
