"""Tyre of the replay inside the compiled step: tables of the vehicle's own tyre, combined by similarity."""

import math

import numpy as np
from numba import njit
from numpy.typing import NDArray

from model_diagnosis.replay.record import CELLS, Record

LEAST_SHARE = 0.05
_SLIDING_SPAN = 4.0
"""Slips over the peak's within which three quarters of the falling branch's loss are reached."""


@njit(cache=True, nogil=True, error_model="numpy")
def _look_up(s: Record, axle: int, direction: int, cell: int, t: float) -> tuple[float, float]:
    """Friction over its peak and its slope by the table's variable times a cell's width, by cubic pieces."""
    value_0, slope_0 = s.table[axle, direction, cell, 0], s.table[axle, direction, cell, 1]
    value_1, slope_1 = s.table[axle, direction, cell + 1, 0], s.table[axle, direction, cell + 1, 1]
    difference = value_1 - value_0
    third = slope_0 + slope_1 - 2.0 * difference
    second = difference - slope_0 - third
    return value_0 + t * (slope_0 + t * (second + t * third)), slope_0 + t * (2.0 * second + t * 3.0 * third)


@njit(cache=True, nogil=True, error_model="numpy")
def tyre_forces(
    s: Record,
    axle: int,
    x: float,
    y: float,
    peak_force_x: float,
    peak_force_y: float,
) -> tuple[float, float, float, float]:
    """Forces [N] along and across, the slope of the first by ``x``, and the length of (x, y).

    Parameters
    ----------
    x, y : slip over the slip at the peak, along and across
    """
    relative = math.sqrt(x * x + y * y)
    if relative < 1e-9:
        stiffness = peak_force_x * s.table[axle, 0, 0, 1] * CELLS
        return stiffness * x, peak_force_y * s.table[axle, 1, 0, 1] * CELLS * y, stiffness, relative
    share = 1.0 / (1.0 + relative)
    place = relative * share * CELLS
    cell = min(int(place), CELLS - 1)
    along, rise = _look_up(s, axle, 0, cell, place - cell)
    across, _ = _look_up(s, axle, 1, cell, place - cell)
    inverse = 1.0 / relative
    square = x * x * inverse * inverse
    slope = rise * CELLS * share * share * square + along * inverse * (1.0 - square)
    return peak_force_x * along * x * inverse, peak_force_y * across * y * inverse, peak_force_x * slope, relative


@njit(cache=True, nogil=True, error_model="numpy")
def _sliding_share(relative: float) -> float:
    """Course of the falling branch's loss: 0 up to the peak, level there, towards 1 far beyond it."""
    if relative <= 1.0:
        return 0.0
    beyond = (relative - 1.0) / _SLIDING_SPAN
    square = 3.0 * beyond * beyond
    return square / (1.0 + square)


@njit(cache=True, nogil=True, error_model="numpy")
def _reshape(s: Record, axle: int, direction: int, loss: float, shift: float, peak_slip: float) -> None:
    """Change a table to that of a tyre with less friction at slip 1 and its peak at a larger slip.

    g'(rho) = g(w(rho)) - loss h(rho)/h(1/peak slip), w = rho (1 + q)/(1 + q rho^2) up to the peak: the stiffness stays
    and the peak moves by 1 + q.
    """
    normal = max(_sliding_share(1.0 / peak_slip), 1e-9)
    values = np.empty(CELLS + 1)
    for k in range(CELLS + 1):
        variable = k / CELLS
        relative = variable / max(1.0 - variable, 1e-9)
        warped = relative
        if relative < 1.0:
            warped = relative * (1.0 + shift) / (1.0 + shift * relative * relative)
        place = warped / (1.0 + warped) * CELLS
        cell = min(int(place), CELLS - 1)
        value, _ = _look_up(s, axle, direction, cell, place - cell)
        values[k] = value - loss * _sliding_share(relative) / normal
    s.table[axle, direction, 0, 1] *= 1.0 + shift
    for k in range(1, CELLS):
        s.table[axle, direction, k, 0] = values[k]
        s.table[axle, direction, k, 1] = 0.5 * (values[k + 1] - values[k - 1])
    s.table[axle, direction, CELLS, 0], s.table[axle, direction, CELLS, 1] = values[CELLS], 0.0


@njit(cache=True, nogil=True, error_model="numpy")
def set_tables(p: Record, s: Record, base: NDArray[np.float64]) -> None:
    """The tyres' tables (2, 2, CELLS + 1, 2), reshaped where the record asks for it."""
    for axle in range(2):
        for direction in range(2):
            for k in range(CELLS + 1):
                s.table[axle, direction, k, 0] = base[axle, direction, k, 0]
                s.table[axle, direction, k, 1] = base[axle, direction, k, 1]
            if p.sliding_loss != 0.0 or p.peak_shift != 0.0:
                peak_slip = p.peak_slip_x[2 * axle] if direction == 0 else p.peak_slip_y[2 * axle]
                _reshape(s, axle, direction, p.sliding_loss, p.peak_shift, peak_slip)


@njit(cache=True, nogil=True, error_model="numpy")
def load_share(loss: float, rise: float) -> float:
    """Friction or stiffness over that at the reference load, ``rise`` the load over it less 1."""
    return max(1.0 - loss * rise, LEAST_SHARE)


@njit(cache=True, nogil=True, error_model="numpy")
def road_friction(p: Record, wheel: int, distance: float, speed: float, over_temperature: float) -> float:
    """Factor on the friction of a wheel: the tyre's own, a step or split of the road, speed, heat."""
    friction = p.friction[wheel]
    if p.friction_step != 0.0 and distance > p.friction_step_place:
        friction *= 1.0 + p.friction_step
    if p.friction_split != 0.0:
        friction *= 1.0 + (p.friction_split if wheel % 2 == 0 else -p.friction_split)
    if p.velocity_fade != 0.0:
        friction *= 1.0 - p.velocity_fade * speed
    if p.heat_fade != 0.0:
        friction *= max(1.0 - p.heat_fade * over_temperature * over_temperature, LEAST_SHARE)
    return max(friction, LEAST_SHARE)
