"""One wheel on a rig, compiled: the slips that are set, their relaxation, the forces that follow."""

import math

import numpy as np
from numba import njit
from numpy.typing import NDArray

from model_diagnosis.replay.lag_step import followed
from model_diagnosis.replay.record import Record
from model_diagnosis.replay.run import take_tables
from model_diagnosis.replay.state import SUBSTEPS
from model_diagnosis.replay.tyre_step import LIGHTEST_N, warm_tread, wheel_forces

RATIO, ANGLE, LOAD, SPEED, DRIVING = range(5)
"""Columns of what drives a wheel on a rig, and their number: slip ratio, slip angle [rad], load [N], speed [m/s]."""

ROLLING, OFFSET_ALONG, OFFSET_ACROSS, LAG, ANGLE_ZERO, RATIO_ZERO, SENSING = range(7)
"""Columns of the rig's own sensors, and their number (``effects.form.FORM_RIG_EFFECTS``)."""

_LARGEST_RATIO = 0.9
"""Driving slip over the wheel's own speed at which it turns ten times as fast as it rolls; at 1 the belt would rest."""


@njit(cache=True, nogil=True, error_model="numpy")
def set_slips(s: Record, i: int, ratio: float, angle: float, speed: float) -> tuple[float, float]:
    """Put the slips of a wheel at a slip ratio and a slip angle; the speed along its plane, and that of the tread."""
    v_x, v_y = speed * math.cos(angle), speed * math.sin(angle)
    ratio = min(ratio, _LARGEST_RATIO)
    roll = v_x * (1.0 + ratio) if ratio < 0.0 else v_x / (1.0 - ratio)
    divisor = max(abs(v_x), abs(v_y), abs(roll))
    s.slip_x[i], s.slip_y[i] = (roll - v_x) / divisor, -v_y / divisor
    return v_x, divisor


@njit(cache=True, nogil=True, error_model="numpy")
def move_rig_wheel(
    p: Record, s: Record, i: int, ratio: float, angle: float, load: float, speed: float, step: float
) -> None:
    """One step: the slips, or the forces where ``lag_on_force`` says so, follow along the relaxation lengths."""
    v_x, divisor = set_slips(s, i, ratio, angle, speed)
    way, on_slip = step * divisor, 1.0 - p.lag_on_force
    share_x = way / (2.0 * on_slip * p.relaxation_x[i] + way)
    share_y = way / (2.0 * on_slip * p.relaxation_y[i] + way)
    slip_x = s.lagged_x[i] + share_x * (s.slip_x[i] - s.lagged_x[i])
    slip_y = s.lagged_y[i] + share_y * (s.slip_y[i] - s.lagged_y[i])
    force_x, force_y, _, _ = wheel_forces(p, s, i, slip_x, slip_y, load, abs(v_x))
    force_share_x = way / (2.0 * p.lag_on_force * p.relaxation_x[i] + way)
    force_share_y = way / (2.0 * p.lag_on_force * p.relaxation_y[i] + way)
    s.lagged_force_x[i] = followed(s.lagged_force_x[i], force_x, 0.0, force_share_x)
    s.lagged_force_y[i] = followed(s.lagged_force_y[i], force_y, 0.0, force_share_y)
    s.lagged_x[i] = followed(s.lagged_x[i], s.slip_x[i], 0.0, share_x)
    s.lagged_y[i] = followed(s.lagged_y[i], s.slip_y[i], 0.0, share_y)
    if p.heat_fade != 0.0:
        warm_tread(s, i, divisor * (abs(force_x * s.slip_x[i]) + abs(force_y * s.slip_y[i])), step)


@njit(cache=True, nogil=True, error_model="numpy")
def forces_now(p: Record, s: Record, i: int, load: float, speed: float) -> tuple[float, float]:
    """Forces at this instant."""
    if p.lag_on_force != 0.0:
        return s.lagged_force_x[i], s.lagged_force_y[i]
    force_x, force_y, _, _ = wheel_forces(p, s, i, s.lagged_x[i], s.lagged_y[i], load, speed)
    return force_x, force_y


@njit(cache=True, nogil=True, error_model="numpy")
def rig_run(
    cars: NDArray[np.void],
    memory: NDArray[np.void],
    tables: NDArray[np.float64],
    i: int,
    driving: NDArray[np.float64],
    sensing: NDArray[np.float64],
    sample_time: float,
    out: NDArray[np.float64],
) -> None:
    """Replay one manoeuvre of wheel ``i``.

    Parameters
    ----------
    cars : (1,) of ``REPLAY_RECORD``
    memory : shape (1,), zeros of ``STATE_RECORD``
    tables : (4 (CELLS + 1), 2) of the tyres: axle, direction, cell
    driving : (n, DRIVING) as measured, a straight line between samples
    sensing : (SENSING,) deviations of the rig's sensors, 0 neutral
    sample_time : s
    out : (n, 2) forces along and across as the rig's sensors report them [N]
    """
    p, s = cars[0], memory[0]
    take_tables(s, tables)
    s.grip_share[i] = 1.0
    step, now = sample_time / SUBSTEPS, np.zeros(DRIVING)
    ratio, angle = driving[0, RATIO] + sensing[RATIO_ZERO], driving[0, ANGLE] + sensing[ANGLE_ZERO]
    v_x, _ = set_slips(s, i, ratio, angle, driving[0, SPEED])
    s.lagged_x[i], s.lagged_y[i] = s.slip_x[i], s.slip_y[i]
    load = max(driving[0, LOAD], LIGHTEST_N)
    s.lagged_force_x[i], s.lagged_force_y[i], _, _ = wheel_forces(p, s, i, s.slip_x[i], s.slip_y[i], load, abs(v_x))
    last_x, last_y = s.lagged_force_x[i], s.lagged_force_y[i]
    for k in range(driving.shape[0]):
        for j in range(SUBSTEPS if k > 0 else 0):
            share = (j + 0.5) / SUBSTEPS
            for c in range(DRIVING):
                now[c] = driving[k - 1, c] + share * (driving[k, c] - driving[k - 1, c])
            ratio, angle = now[RATIO] + sensing[RATIO_ZERO], now[ANGLE] + sensing[ANGLE_ZERO]
            move_rig_wheel(p, s, i, ratio, angle, max(now[LOAD], LIGHTEST_N), now[SPEED], step)
        load = max(driving[k, LOAD], LIGHTEST_N)
        force_x, force_y = forces_now(p, s, i, load, abs(driving[k, SPEED] * math.cos(driving[k, ANGLE])))
        late = sensing[LAG] / sample_time
        out[k, 0] = force_x - late * (force_x - last_x) + sensing[ROLLING] * load + sensing[OFFSET_ALONG]
        out[k, 1] = force_y - late * (force_y - last_y) + sensing[OFFSET_ACROSS]
        last_x, last_y = force_x, force_y
