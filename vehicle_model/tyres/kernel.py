"""Tyre forces inside the compiled plant, in three stages.

``prepare`` turns a tyre, the surface under it and the load into a short row that holds for one step of the car;
``along`` gives the longitudinal force at a slip from that row in every sub-step of the wheel's spin; ``across`` gives
the side force and the aligning moment, once per step. A tyre formula joins the plant with a branch in each of these.

The slip vector is the sliding velocity of the tread over the road, turned round, over the larger of rolling and
travelling speed: ``slip_x = (R w - v_x) / V`` (slip S5 of the friction document), ``slip_y = -v_y / V``. Forces point
along it, also when the wheel travels backwards.
"""

import math

import numpy as np
from numba import njit
from numpy.typing import NDArray

from signals.record_memory import address_in, numbers_at
from vehicle_model.tyres.coefficients import (
    BURCKHARDT,
    CURVE_B,
    CURVE_C,
    CURVE_D,
    CURVE_E,
    CURVE_PEAK_SLIP,
    CURVE_SIZE,
    KAMM,
    LOAD_DEPENDENT,
    MAGIC_FORMULA,
    SURFACE_CURVE,
    SURFACE_FACTOR,
    SURFACE_KIND,
    SURFACE_REPLACES,
    TIR,
    TYRE_COMBINED,
    TYRE_KIND,
    TYRE_KIND_Y,
    TYRE_LOAD_SENSITIVITY,
    TYRE_LOAD_X,
    TYRE_LOAD_Y,
    TYRE_NOMINAL_LOAD,
    TYRE_TRAIL,
    TYRE_X,
    TYRE_Y,
)
from vehicle_model.tyres.curves import burckhardt, load_dependent, magic_formula, magic_formula_peak
from vehicle_model.tyres.formula_kernel import forces_of_formula, moment_of_formula, prepare_formula
from vehicle_model.tyres.prepared_row import (
    DIRECTION,
    KEPT,
    KIND,
    PEAK_FORCE_X,
    PEAK_FORCE_Y,
    PEAK_SLIP_X,
    PEAK_SLIP_Y,
    PREPARED_SIZE,
    STIFFNESS_X,
    STIFFNESS_Y,
)
from vehicle_model.tyres.tir_kernel import across_tir, along_tir, find_peak_slips_tir, prepare_tir

__all__ = [
    "PEAK_FORCE_X",
    "PEAK_FORCE_Y",
    "PEAK_SLIP_X",
    "PEAK_SLIP_Y",
    "PREPARED_SIZE",
    "STIFFNESS_X",
    "STIFFNESS_Y",
    "across",
    "along",
    "peak_slips",
    "prepare",
]

# what the curve tyres keep for themselves
_RESULTANT, _COMBINED, _TRAIL, _SPEED, _SCALE = range(KEPT, KEPT + 5)
_X, _Y = KEPT + 5, KEPT + 11


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
    camber: float,
    prepared: NDArray[np.float64],
) -> None:
    """Fill ``prepared`` (shape ``(PREPARED_SIZE,)``) for the coming step.

    Parameters
    ----------
    tyre, surface
        Rows of coefficients.
    friction : float
        Factor of the road's place and the wheel.
    load : N
        Vertical load, not negative.
    speed : m/s
        Speed of the wheel centre, negative when it travels backwards.
    camber : rad
        Inclination, top to the right positive; only tyres from ``.tir`` files use it.
    """
    prepared[DIRECTION] = -1.0 if speed < 0.0 else 1.0
    speed = abs(speed)
    kind = tyre[TYRE_KIND]
    if surface[SURFACE_REPLACES] != 0.0 or kind in (MAGIC_FORMULA, BURCKHARDT, LOAD_DEPENDENT):
        prepared[KIND] = MAGIC_FORMULA
        _prepare_curves(tyre, surface, friction, load, speed, prepared)
        return
    prepared[KIND] = kind
    friction *= surface[SURFACE_FACTOR]
    if kind == TIR:
        prepare_tir(tyre, friction, load, camber, prepared, numbers_at(address_in(prepared, KEPT)))
    else:
        prepare_formula(tyre, friction, load, speed, prepared)


@njit(cache=True)
def peak_slips(prepared: NDArray[np.float64]) -> tuple[float, float]:
    """Slips of the peaks along and across the wheel's heading."""
    if prepared[PEAK_SLIP_X] == 0.0:
        find_peak_slips_tir(prepared, numbers_at(address_in(prepared, KEPT)))
    return prepared[PEAK_SLIP_X], prepared[PEAK_SLIP_Y]


@njit(cache=True)
def _at_load(coefficients: NDArray[np.float64], load: float, curve: NDArray[np.float64]) -> None:
    """A load-dependent curve as a Magic Formula that holds at the load."""
    stiffness, shape, peak, curvature = load_dependent(coefficients, load)
    curve[CURVE_B], curve[CURVE_C], curve[CURVE_D], curve[CURVE_E] = stiffness, shape, peak, curvature
    curve[CURVE_PEAK_SLIP] = magic_formula_peak(stiffness, shape, curvature)


@njit(cache=True)
def _prepare_curves(
    tyre: NDArray[np.float64],
    surface: NDArray[np.float64],
    friction: float,
    load: float,
    speed: float,
    prepared: NDArray[np.float64],
) -> None:
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
        if kind == LOAD_DEPENDENT:
            kind = float(MAGIC_FORMULA)
            _at_load(numbers_at(address_in(tyre, TYRE_LOAD_X)), load, numbers_at(address_in(prepared, _X)))
        if tyre[TYRE_KIND_Y] == LOAD_DEPENDENT:
            _at_load(numbers_at(address_in(tyre, TYRE_LOAD_Y)), load, numbers_at(address_in(prepared, _Y)))
    x = numbers_at(address_in(prepared, _X))
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
        y = numbers_at(address_in(prepared, _Y))
        prepared[PEAK_FORCE_Y] = scale * y[CURVE_D]
        prepared[PEAK_SLIP_Y] = y[CURVE_PEAK_SLIP]
        prepared[STIFFNESS_Y] = scale * _curve_slope(MAGIC_FORMULA, y)


@njit(cache=True)
def _curve(prepared: NDArray[np.float64], start: int, slip: float) -> tuple[float, float]:
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
        return _curve(prepared, _X, slip)
    value, slope = burckhardt(
        slip, prepared[_X], prepared[_X + 1], prepared[_X + 2], prepared[_X + 3], prepared[_SPEED]
    )
    return prepared[_SCALE] * value, prepared[_SCALE] * slope


@njit(cache=True)
def _relative(prepared: NDArray[np.float64], slip_x: float, slip_y: float) -> float:
    """Length of the slip vector whose parts are divided by the slips at the peaks."""
    x, y = slip_x / prepared[PEAK_SLIP_X], slip_y / prepared[PEAK_SLIP_Y]
    return math.sqrt(x * x + y * y)


@njit(cache=True)
def along(
    tyre: NDArray[np.float64], prepared: NDArray[np.float64], slip_x: float, slip_y: float
) -> tuple[float, float]:
    """Longitudinal force [N] along the wheel's heading, and its derivative by ``slip_x``."""
    kind = prepared[KIND]
    if kind == TIR:
        return along_tir(tyre, numbers_at(address_in(prepared, KEPT)), slip_x, slip_y, prepared[DIRECTION])
    if kind != MAGIC_FORMULA:
        force_x, _, slope = forces_of_formula(prepared, slip_x, slip_y)
        return force_x, slope
    relative = _relative(prepared, slip_x, slip_y)
    if relative < 1e-9:
        return prepared[STIFFNESS_X] * slip_x, prepared[STIFFNESS_X]
    if prepared[_RESULTANT] != 0.0:
        slip = math.sqrt(slip_x * slip_x + slip_y * slip_y)
        force, rise = _resultant(prepared, slip)
        cosine = slip_x / slip
        return force * cosine, rise * cosine * cosine + force / slip * (1.0 - cosine * cosine)
    if prepared[_COMBINED] == KAMM:
        return _curve(prepared, _X, slip_x)
    # similarity: both curves at the same share of their peak slip, the force along the normalised slip vector
    slip = relative * prepared[PEAK_SLIP_X]
    force, rise = _curve(prepared, _X, slip)
    cosine = slip_x / slip
    return force * cosine, rise * cosine * cosine + force / slip * (1.0 - cosine * cosine)


@njit(cache=True)
def across(
    tyre: NDArray[np.float64], prepared: NDArray[np.float64], slip_x: float, slip_y: float, force_x: float
) -> tuple[float, float]:
    """Side force [N] to the left of the wheel's heading, and aligning moment [N m], beside a longitudinal force [N]."""
    kind = prepared[KIND]
    if kind == TIR:
        return across_tir(tyre, numbers_at(address_in(prepared, KEPT)), slip_x, slip_y, force_x, prepared[DIRECTION])
    if kind != MAGIC_FORMULA:
        _, force_y, _ = forces_of_formula(prepared, slip_x, slip_y)
        return force_y, moment_of_formula(prepared, slip_x, slip_y, force_y)
    if slip_y == 0.0:
        return 0.0, 0.0
    relative = _relative(prepared, slip_x, slip_y)
    if relative < 1e-9:
        force_y = prepared[STIFFNESS_Y] * slip_y
    elif prepared[_RESULTANT] != 0.0:
        slip = math.sqrt(slip_x * slip_x + slip_y * slip_y)
        force_y = _resultant(prepared, slip)[0] * slip_y / slip
    elif prepared[_COMBINED] == KAMM:
        used = _curve(prepared, _X, slip_x)[0] / max(prepared[PEAK_FORCE_X], 1e-9)
        force_y = _curve(prepared, _Y, slip_y)[0] * math.sqrt(max(1.0 - used * used, 0.0))
    else:
        slip = relative * prepared[PEAK_SLIP_Y]
        force_y = _curve(prepared, _Y, slip)[0] * slip_y / slip
    return force_y, -prepared[DIRECTION] * prepared[_TRAIL] * max(1.0 - relative, 0.0) * force_y
