"""Coefficients of a tyre and of a surface as rows of numbers for the compiled step."""

import math

import numpy as np
from numpy.typing import NDArray

from vehicle_model.tyres.magic_formula_record import FIELDS
from vehicle_model.tyres.tyre_file import BurckhardtCurve, CurveTyre, MagicFormulaCurve, TirTyre

MAGIC_FORMULA, BURCKHARDT, TIR = 0, 1, 2
SIMILARITY, KAMM = 0, 1

# row of a tyre
TYRE_KIND, TYRE_COMBINED = 0, 1
TYRE_X, TYRE_Y = 2, 8  # starts of two curves, each in the layout CURVE_*
TYRE_LOAD_SENSITIVITY, TYRE_NOMINAL_LOAD, TYRE_TRAIL = 20, 21, 22
# of a tyre from a .tir file: which combination, side of the car it was measured for, then its record
TYRE_ELLIPSE, TYRE_MIRRORED, TYRE_RECORD = 1, 2, 24
TYRE_SIZE = 256

# row of a surface
SURFACE_REPLACES, SURFACE_FACTOR, SURFACE_KIND, SURFACE_CURVE = 0, 1, 2, 3
SURFACE_SIZE = 16

# a curve: six numbers; Magic Formula B C D E, Burckhardt c1 to c5
CURVE_B, CURVE_C, CURVE_D, CURVE_E, CURVE_PEAK_SLIP = 0, 1, 2, 3, 5
CURVE_SIZE = 6

_MONOTONE_PEAK_SLIP = 1.0
"""Slip taken as that of the peak where a curve has none."""


def magic_formula_peak_slip(curve: MagicFormulaCurve) -> float:
    """Slip at which the curve is largest: B s - E (B s - arctan(B s)) = tan(pi / (2 C)); 1 if there is none below 1."""
    if curve.shape <= 1.0:
        return _MONOTONE_PEAK_SLIP
    wanted = math.tan(math.pi / (2.0 * curve.shape))

    if curve.curvature == 0.0:
        return min(wanted / curve.stiffness, _MONOTONE_PEAK_SLIP)

    def left(x: float) -> float:
        return x - curve.curvature * (x - math.atan(x))

    low, high = 0.0, curve.stiffness * _MONOTONE_PEAK_SLIP
    if left(high) < wanted:
        return _MONOTONE_PEAK_SLIP
    for _ in range(80):
        middle = 0.5 * (low + high)
        low, high = (middle, high) if left(middle) < wanted else (low, middle)
    return high / curve.stiffness


def burckhardt_peak_slip(curve: BurckhardtCurve) -> float:
    """Slip at which eq. 9 is largest; 1 for a curve without falling branch."""
    if curve.c3 <= 0.0:
        return _MONOTONE_PEAK_SLIP
    return min(math.log(curve.c1 * curve.c2 / curve.c3) / curve.c2, _MONOTONE_PEAK_SLIP)


def write_curve(curve: MagicFormulaCurve | BurckhardtCurve, row: NDArray[np.float64]) -> int:
    """Write a curve into six numbers; returns its kind."""
    if isinstance(curve, MagicFormulaCurve):
        row[:4] = curve.stiffness, curve.shape, curve.peak_friction, curve.curvature
        row[4] = 0.0
        row[CURVE_PEAK_SLIP] = magic_formula_peak_slip(curve)
        return MAGIC_FORMULA
    row[:5] = curve.c1, curve.c2, curve.c3, curve.c4, curve.c5
    row[CURVE_PEAK_SLIP] = burckhardt_peak_slip(curve)
    return BURCKHARDT


def write_tyre(tyre: CurveTyre | TirTyre, row: NDArray[np.float64], *, right: bool) -> None:
    """Fill the row of one tyre (shape ``(TYRE_SIZE,)``); ``right`` for one on the right side of the car."""
    row[:] = 0.0
    if isinstance(tyre, TirTyre):
        _write_tir(tyre, row, right)
    else:
        _write_curves(tyre, row)


def _write_curves(tyre: CurveTyre, row: NDArray[np.float64]) -> None:
    row[TYRE_KIND] = write_curve(tyre.longitudinal, row[TYRE_X : TYRE_X + CURVE_SIZE])
    write_curve(tyre.lateral, row[TYRE_Y : TYRE_Y + CURVE_SIZE])
    row[TYRE_COMBINED] = KAMM if tyre.combined_slip == "kamm" else SIMILARITY
    row[TYRE_LOAD_SENSITIVITY] = tyre.load_sensitivity
    row[TYRE_NOMINAL_LOAD] = tyre.nominal_load
    row[TYRE_TRAIL] = tyre.pneumatic_trail


def _write_tir(tyre: TirTyre, row: NDArray[np.float64], right: bool) -> None:
    from vehicle_model.tyres.magic_formula_tyre import read_tir

    scale = {
        "LMUX": tyre.longitudinal_friction_scale,
        "LMUY": tyre.lateral_friction_scale,
        "LKX": tyre.slip_stiffness_scale,
        "LKY": tyre.cornering_stiffness_scale,
    }
    read = read_tir(tyre.tir, combined_slip=tyre.combined_slip)
    record = read.record.copy()
    for name, factor in scale.items():
        record[name] *= factor
    if tyre.inflation_pressure is not None:
        record["INFLPRES"] = tyre.inflation_pressure
    row[TYRE_KIND] = TIR
    row[TYRE_ELLIPSE] = float(read.uses_ellipse)
    measured_right = read.measured_side == "RIGHT"
    row[TYRE_MIRRORED] = float(right != measured_right)
    row[TYRE_RECORD : TYRE_RECORD + len(FIELDS)] = record.view(np.float64)
