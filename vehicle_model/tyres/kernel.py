"""Tyre forces inside the compiled plant, in two stages.

``prepare`` turns a tyre, the surface under it and the load into a short row that holds for one tick; ``evaluate`` gives
the forces at a slip from that row and is called in every sub-step of the wheel's spin. A tyre formula joins the plant
with a branch in each of the two.

The slip vector is the sliding velocity of the tread over the road, turned round, over the larger of rolling and
travelling speed: ``slip_x = (R w - v_x) / V`` (slip S5 of the friction document), ``slip_y = -v_y / V``. Forces point
along it.
"""

import math

import numpy as np
from numba import njit
from numpy.typing import NDArray

from vehicle_model.tyres.coefficients import (
    BURCKHARDT,
    CURVE_B,
    CURVE_C,
    CURVE_D,
    CURVE_E,
    CURVE_PEAK_SLIP,
    CURVE_SIZE,
    KAMM,
    MAGIC_FORMULA,
    SURFACE_CURVE,
    SURFACE_FACTOR,
    SURFACE_KIND,
    SURFACE_REPLACES,
    TYRE_COMBINED,
    TYRE_KIND,
    TYRE_LOAD_SENSITIVITY,
    TYRE_NOMINAL_LOAD,
    TYRE_TRAIL,
    TYRE_X,
    TYRE_Y,
)
from vehicle_model.tyres.curves import burckhardt, magic_formula

# row that holds for one tick: what every formula gives ...
PEAK_FORCE_X, PEAK_FORCE_Y, PEAK_SLIP_X, PEAK_SLIP_Y, STIFFNESS_X, STIFFNESS_Y = range(6)
# ... and what the curve tyres keep for themselves
_RESULTANT, _COMBINED, _TRAIL, _SPEED, _SCALE = range(6, 11)
_X, _Y = 12, 18
PREPARED_SIZE = 32


@njit(cache=True)
def _curve_peak(kind: float, curve: NDArray[np.float64], speed: float) -> float:
    if kind == MAGIC_FORMULA:
        return curve[CURVE_D]
    return burckhardt(curve[CURVE_PEAK_SLIP], curve[0], curve[1], curve[2], curve[3], speed)[0]


@njit(cache=True)
def _curve_slope(kind: float, curve: NDArray[np.float64]) -> float:
    if kind == MAGIC_FORMULA:
        return curve[CURVE_B] * curve[CURVE_C] * curve[CURVE_D]
    return curve[0] * curve[1] - curve[2]


@njit(cache=True)
def prepare(
    tyre: NDArray[np.float64],
    surface: NDArray[np.float64],
    friction: float,
    load: float,
    speed: float,
    prepared: NDArray[np.float64],
) -> None:
    """Fill ``prepared`` (shape ``(PREPARED_SIZE,)``) for the coming tick.

    Parameters
    ----------
    tyre, surface
        Rows of coefficients.
    friction : float
        Factor of the road's place and the wheel.
    load : N
        Vertical load, not negative.
    speed : m/s
        Speed of the wheel centre.
    """
    scale = load * friction
    sensitivity = tyre[TYRE_LOAD_SENSITIVITY]
    if sensitivity != 0.0:
        scale *= max(1.0 - sensitivity * (load / tyre[TYRE_NOMINAL_LOAD] - 1.0), 0.05)
    if surface[SURFACE_REPLACES] != 0.0:
        kind = surface[SURFACE_KIND]
        resultant = True
        for k in range(CURVE_SIZE):
            prepared[_X + k] = surface[SURFACE_CURVE + k]
    else:
        scale *= surface[SURFACE_FACTOR]
        kind = tyre[TYRE_KIND]
        resultant = kind == BURCKHARDT
        for k in range(CURVE_SIZE):
            prepared[_X + k] = tyre[TYRE_X + k]
            prepared[_Y + k] = tyre[TYRE_Y + k]
    x = prepared[_X : _X + CURVE_SIZE]
    if kind == BURCKHARDT and x[4] != 0.0:
        scale *= max(1.0 - x[4] * load * load, 0.05)
    prepared[_RESULTANT] = 0.0 if not resultant else (2.0 if kind == BURCKHARDT else 1.0)
    prepared[_COMBINED] = tyre[TYRE_COMBINED]
    prepared[_TRAIL] = tyre[TYRE_TRAIL]
    prepared[_SPEED] = speed
    prepared[_SCALE] = scale
    prepared[PEAK_FORCE_X] = scale * _curve_peak(kind, x, speed)
    prepared[PEAK_SLIP_X] = x[CURVE_PEAK_SLIP]
    prepared[STIFFNESS_X] = scale * _curve_slope(kind, x)
    if resultant:
        prepared[PEAK_FORCE_Y] = prepared[PEAK_FORCE_X]
        prepared[PEAK_SLIP_Y] = prepared[PEAK_SLIP_X]
        prepared[STIFFNESS_Y] = prepared[STIFFNESS_X]
    else:
        y = prepared[_Y : _Y + CURVE_SIZE]
        prepared[PEAK_FORCE_Y] = scale * y[CURVE_D]
        prepared[PEAK_SLIP_Y] = y[CURVE_PEAK_SLIP]
        prepared[STIFFNESS_Y] = scale * _curve_slope(MAGIC_FORMULA, y)


@njit(cache=True)
def _along(prepared: NDArray[np.float64], start: int, slip: float) -> tuple[float, float]:
    """Magic Formula in one direction: force and slope."""
    return magic_formula(
        slip,
        prepared[start + CURVE_B],
        prepared[start + CURVE_C],
        prepared[_SCALE] * prepared[start + CURVE_D],
        prepared[start + CURVE_E],
    )


@njit(cache=True)
def _resultant(prepared: NDArray[np.float64], slip: float) -> tuple[float, float]:
    """Curve of the resultant slip: force and slope."""
    if prepared[_RESULTANT] == 1.0:
        return _along(prepared, _X, slip)
    value, slope = burckhardt(
        slip, prepared[_X], prepared[_X + 1], prepared[_X + 2], prepared[_X + 3], prepared[_SPEED]
    )
    return prepared[_SCALE] * value, prepared[_SCALE] * slope


@njit(cache=True)
def evaluate(prepared: NDArray[np.float64], slip_x: float, slip_y: float) -> tuple[float, float, float, float]:
    """Forces at a slip.

    Returns
    -------
    force_x, force_y : N
        Along the wheel's heading and to its left.
    slope : N
        Derivative of ``force_x`` by ``slip_x``.
    moment_z : N m
        Aligning moment.
    """
    relative_x, relative_y = slip_x / prepared[PEAK_SLIP_X], slip_y / prepared[PEAK_SLIP_Y]
    relative = math.sqrt(relative_x * relative_x + relative_y * relative_y)
    if relative < 1e-9:
        force_x, slope = prepared[STIFFNESS_X] * slip_x, prepared[STIFFNESS_X]
        force_y = prepared[STIFFNESS_Y] * slip_y
    elif prepared[_RESULTANT] != 0.0:
        slip = math.sqrt(slip_x * slip_x + slip_y * slip_y)
        force, along = _resultant(prepared, slip)
        cosine = slip_x / slip
        force_x, force_y = force * cosine, force * slip_y / slip
        slope = along * cosine * cosine + force / slip * (1.0 - cosine * cosine)
    elif prepared[_COMBINED] == KAMM:
        force_x, slope = _along(prepared, _X, slip_x)
        force_y, _ = _along(prepared, _Y, slip_y)
        used = force_x / max(prepared[PEAK_FORCE_X], 1e-9)
        force_y *= math.sqrt(max(1.0 - used * used, 0.0))
    else:
        # similarity: both curves at the same share of their peak slip, the force along the normalised slip vector
        cosine = relative_x / relative
        force, along = _along(prepared, _X, relative * prepared[PEAK_SLIP_X])
        force_x = force * cosine
        slope = along * cosine * cosine + force / (relative * prepared[PEAK_SLIP_X]) * (1.0 - cosine * cosine)
        if slip_y == 0.0:
            force_y = 0.0
        else:
            force, _ = _along(prepared, _Y, relative * prepared[PEAK_SLIP_Y])
            force_y = force * relative_y / relative
    return force_x, force_y, slope, -prepared[_TRAIL] * max(1.0 - relative, 0.0) * force_y
