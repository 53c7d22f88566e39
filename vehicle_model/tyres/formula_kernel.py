"""TMeasy, Dugoff, Fiala, LuGre and Dahl inside the compiled plant: which of them acts, and where their peaks are."""

import math

import numpy as np
from numba import njit
from numpy.typing import NDArray

from signals.record_memory import address_in, numbers_at
from vehicle_model.tyres.coefficients import DUGOFF, FIALA, TMEASY, TYRE_FORMULA, TYRE_KIND
from vehicle_model.tyres.dugoff import forces_dugoff, prepare_dugoff, trail_dugoff
from vehicle_model.tyres.fiala import forces_fiala, moment_fiala, prepare_fiala
from vehicle_model.tyres.lugre import forces_lugre, prepare_lugre, trail_lugre
from vehicle_model.tyres.prepared_row import (
    DIRECTION,
    KEPT,
    KIND,
    PEAK_FORCE_X,
    PEAK_FORCE_Y,
    PEAK_SLIP_X,
    PEAK_SLIP_Y,
    SPEED_OF_BRISTLES,
    STIFFNESS_X,
)
from vehicle_model.tyres.tmeasy import forces_tmeasy, prepare_tmeasy, trail_tmeasy

_GOLDEN = 0.6180339887498949
_SECTIONS = 14
_ALMOST_LOCKED, _LEAST_SLIP = 0.9999, 0.02
_FLAT, _MOST_STEPS = 1e-4, 16
"""Slope over that at zero slip which counts as that of a peak."""


@njit(cache=True)
def forces_of_formula(prepared: NDArray[np.float64], slip_x: float, slip_y: float) -> tuple[float, float, float]:
    """Longitudinal and side force [N], derivative of the first by ``slip_x``."""
    kept, direction, kind = numbers_at(address_in(prepared, KEPT)), prepared[DIRECTION], prepared[KIND]
    if kind == TMEASY:
        return forces_tmeasy(kept, slip_x, slip_y, direction)
    if kind == DUGOFF:
        return forces_dugoff(kept, slip_x, slip_y, direction)
    if kind == FIALA:
        return forces_fiala(kept, slip_x, slip_y, direction)
    return forces_lugre(kept, slip_x, slip_y, direction)


@njit(cache=True)
def moment_of_formula(prepared: NDArray[np.float64], slip_x: float, slip_y: float, force_y: float) -> float:
    """Aligning moment [N m] beside a side force [N]; it turns round with the direction of travel."""
    kept, direction, kind = numbers_at(address_in(prepared, KEPT)), prepared[DIRECTION], prepared[KIND]
    if kind == TMEASY:
        return -direction * trail_tmeasy(kept, slip_x, slip_y, direction) * force_y
    if kind == DUGOFF:
        return -direction * trail_dugoff(kept, slip_x, slip_y, direction) * force_y
    if kind == FIALA:
        return direction * moment_fiala(kept, slip_x, slip_y)
    return -direction * trail_lugre(kept, slip_x, slip_y, direction) * force_y


@njit(cache=True)
def _peak_along(prepared: NDArray[np.float64]) -> tuple[float, float]:
    """Slip and force of a braked wheel's peak; those of slip 1 where the force does not fall.

    The slope times the slip squared, over the slip squared, is nearly a straight line: the Illinois method finds its
    zero.
    """
    direction = prepared[DIRECTION]
    high = _ALMOST_LOCKED
    force, _, slope = forces_of_formula(prepared, -high * direction, 0.0)
    locked = abs(force)
    while slope >= 0.0:  # no peak, or one before the force rises again with the sliding speed
        high *= 0.5
        if high < _LEAST_SLIP:
            return 1.0, locked
        force, _, slope = forces_of_formula(prepared, -high * direction, 0.0)
    at_high = slope * high * high
    high *= high
    slip = 0.5 * abs(force) / max(prepared[STIFFNESS_X], 1e-9)  # where the force still rises steeply
    force, _, slope = forces_of_formula(prepared, -slip * direction, 0.0)
    low = slip * slip
    at_low = slope * low
    side = 0
    for _ in range(_MOST_STEPS):
        if at_low <= 0.0:
            break
        square = (low * at_high - high * at_low) / (at_high - at_low)
        slip = math.sqrt(square)
        force, _, slope = forces_of_formula(prepared, -slip * direction, 0.0)
        value = slope * square
        if value > 0.0:
            low, at_low = square, value
            if side == 1:
                at_high *= 0.5
            side = 1
        else:
            high, at_high = square, value
            if side == -1:
                at_low *= 0.5
            side = -1
        if abs(slope) < _FLAT * prepared[STIFFNESS_X]:
            break
    return (slip, abs(force)) if abs(force) > locked else (1.0, locked)


@njit(cache=True)
def _peak_across(prepared: NDArray[np.float64]) -> tuple[float, float]:
    """Slip and side force of the peak between no slip and slip 1 (golden section)."""
    low, high = 0.0, 1.0
    left, right = high - _GOLDEN, _GOLDEN
    at_left, at_right = forces_of_formula(prepared, 0.0, left)[1], forces_of_formula(prepared, 0.0, right)[1]
    for _ in range(_SECTIONS):
        if at_left >= at_right:
            high, right, at_right = right, left, at_left
            left = high - _GOLDEN * (high - low)
            at_left = forces_of_formula(prepared, 0.0, left)[1]
        else:
            low, left, at_left = left, right, at_right
            right = low + _GOLDEN * (high - low)
            at_right = forces_of_formula(prepared, 0.0, right)[1]
    at_end = forces_of_formula(prepared, 0.0, 1.0)[1]
    return (1.0, at_end) if at_end >= at_left else (left, at_left)


@njit(cache=True)
def prepare_formula(
    tyre: NDArray[np.float64],
    friction: float,
    load: float,
    speed: float,
    prepared: NDArray[np.float64],
) -> None:
    """Coefficients, peaks and slopes of the formula for one step; kind and direction are set already."""
    parameters, kept = numbers_at(address_in(tyre, TYRE_FORMULA)), numbers_at(address_in(prepared, KEPT))
    kind = tyre[TYRE_KIND]
    if kind == TMEASY:
        prepare_tmeasy(parameters, friction, load, prepared, kept)
        return
    if kind == DUGOFF:
        prepare_dugoff(parameters, friction, load, speed, prepared, kept)
    elif kind == FIALA:
        prepare_fiala(parameters, friction, load, prepared, kept)
    else:
        prepare_lugre(parameters, friction, load, speed, prepared, kept)
    prepared[PEAK_SLIP_X], prepared[PEAK_FORCE_X] = _peak_along(prepared)
    if speed < SPEED_OF_BRISTLES:  # only the bristles ask for it
        prepared[PEAK_SLIP_Y], prepared[PEAK_FORCE_Y] = _peak_across(prepared)
