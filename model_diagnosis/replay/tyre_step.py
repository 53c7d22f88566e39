"""Tyre of the replay inside the compiled step: tables of the vehicle's own tyre, combined by similarity."""

import math

import numpy as np
from numba import njit
from numpy.typing import NDArray

from model_diagnosis.replay.record import Record
from model_diagnosis.replay.tyre_table import CELLS

_LEAST_SHARE = 0.05
_SLIDING_SPAN = 4.0
"""Slips over the peak's within which three quarters of the falling branch's loss are reached."""


@njit(cache=True, nogil=True)
def _look_up(table: NDArray[np.float64], relative: float) -> tuple[float, float]:
    """Friction over its peak and its derivative by the relative slip, by cubic pieces."""
    whole = 1.0 + relative
    place = relative / whole * CELLS
    cell = min(int(place), CELLS - 1)
    t = place - cell
    value_0, slope_0, value_1, slope_1 = table[cell, 0], table[cell, 1], table[cell + 1, 0], table[cell + 1, 1]
    difference = value_1 - value_0
    third = slope_0 + slope_1 - 2.0 * difference
    second = difference - slope_0 - third
    value = value_0 + t * (slope_0 + t * (second + t * third))
    slope = slope_0 + t * (2.0 * second + t * 3.0 * third)
    return value, slope * CELLS / (whole * whole)


@njit(cache=True, nogil=True)
def tyre_forces(
    table_x: NDArray[np.float64],
    table_y: NDArray[np.float64],
    slip_x: float,
    slip_y: float,
    peak_slip_x: float,
    peak_slip_y: float,
    peak_force_x: float,
    peak_force_y: float,
) -> tuple[float, float, float, float]:
    """Forces [N] along and across at a slip vector, the slope of the first by ``slip_x``, and the relative slip."""
    x, y = slip_x / peak_slip_x, slip_y / peak_slip_y
    relative = math.sqrt(x * x + y * y)
    if relative < 1e-9:
        stiffness_x = peak_force_x * table_x[0, 1] * CELLS / peak_slip_x
        return stiffness_x * slip_x, peak_force_y * table_y[0, 1] * CELLS * y, stiffness_x, relative
    along, rise = _look_up(table_x, relative)
    across, _ = _look_up(table_y, relative)
    cosine, sine = x / relative, y / relative
    slope = peak_force_x / peak_slip_x * (rise * cosine * cosine + along / relative * (1.0 - cosine * cosine))
    return peak_force_x * along * cosine, peak_force_y * across * sine, slope, relative


@njit(cache=True, nogil=True)
def _sliding_share(relative: float) -> float:
    """Course of the falling branch's loss: 0 up to the peak, level there, towards 1 far beyond it."""
    if relative <= 1.0:
        return 0.0
    beyond = (relative - 1.0) / _SLIDING_SPAN
    square = 3.0 * beyond * beyond
    return square / (1.0 + square)


@njit(cache=True, nogil=True)
def reshape(base: NDArray[np.float64], loss: float, shift: float, peak_slip: float, table: NDArray[np.float64]) -> None:
    """Table of a tyre whose friction at slip 1 is less by ``loss`` and whose peak lies at a slip more by ``shift``.

    g'(rho) = g(w(rho)) - loss h(rho)/h(1/peak slip), w = rho (1 + q)/(1 + q rho^2) up to the peak: the stiffness stays
    and the peak moves by 1 + q.
    """
    normal = _sliding_share(1.0 / peak_slip)
    for k in range(CELLS + 1):
        variable = k / CELLS
        relative = variable / max(1.0 - variable, 1e-9)
        warped = relative
        if relative < 1.0:
            warped = relative * (1.0 + shift) / (1.0 + shift * relative * relative)
        value, _ = _look_up(base, warped)
        table[k, 0] = value - loss * _sliding_share(relative) / max(normal, 1e-9)
    table[0, 1] = base[0, 1] * (1.0 + shift)
    for k in range(1, CELLS):
        table[k, 1] = 0.5 * (table[k + 1, 0] - table[k - 1, 0])
    table[CELLS, 1] = 0.0


@njit(cache=True, nogil=True)
def load_share(loss: float, load: float, reference: float) -> float:
    """Friction or stiffness at a load over that at the reference load."""
    return max(1.0 - loss * (load / reference - 1.0), _LEAST_SHARE)


@njit(cache=True, nogil=True)
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
        friction *= max(1.0 - p.heat_fade * over_temperature * over_temperature, _LEAST_SHARE)
    return max(friction, _LEAST_SHARE)
