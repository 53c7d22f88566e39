"""Coefficients of a tyre and of a surface as rows of numbers for the compiled step."""

import math
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from vehicle_model.tyres.magic_formula_record import FIELDS
from vehicle_model.tyres.tyre_file import (
    AnyTyre,
    BurckhardtCurve,
    CurveTyre,
    DahlTyre,
    DugoffTyre,
    FialaTyre,
    LoadDependentCurve,
    LuGreTyre,
    MagicFormulaCurve,
    TirTyre,
    TMeasyTyre,
)

if TYPE_CHECKING:
    from vehicle_model.tyres.magic_formula_tyre import MagicFormulaTyre

# formulas; the load-dependent one becomes a Magic Formula for each step
MAGIC_FORMULA, BURCKHARDT, TIR, LOAD_DEPENDENT, TMEASY, DUGOFF, FIALA, LUGRE = range(8)
SIMILARITY, KAMM = 0, 1

# row of a tyre
TYRE_KIND, TYRE_COMBINED = 0, 1
TYRE_X, TYRE_Y = 2, 8  # starts of two curves, each in the layout CURVE_*
TYRE_LOAD_SENSITIVITY, TYRE_NOMINAL_LOAD, TYRE_TRAIL, TYRE_KIND_Y = 20, 21, 22, 23
# coefficients a0 to a8 of two load-dependent curves, or the parameters of another formula
TYRE_LOAD_X, TYRE_LOAD_Y, TYRE_FORMULA = 24, 33, 24
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


def write_tyre(tyre: AnyTyre, row: NDArray[np.float64], *, right: bool) -> None:
    """Fill the row of one tyre (shape ``(TYRE_SIZE,)``); ``right`` for one on the right side of the car."""
    row[:] = 0.0
    if isinstance(tyre, TirTyre):
        _write_tir(tyre, row, right)
    elif isinstance(tyre, CurveTyre):
        _write_curves(tyre, row)
    else:
        row[TYRE_KIND], values = _formula(tyre)
        row[TYRE_FORMULA : TYRE_FORMULA + len(values)] = values


def _formula(tyre: TMeasyTyre | DugoffTyre | FialaTyre | LuGreTyre | DahlTyre) -> tuple[int, tuple[float, ...]]:
    """Kind and parameters, in the order that the formula's own module declares."""
    if isinstance(tyre, TMeasyTyre):
        points = [point for side in (tyre.longitudinal, tyre.lateral) for point in (side.nominal, side.double)]
        forces = [(p.slope, p.peak_force, p.peak_slip, p.sliding_force, p.sliding_slip) for p in points]
        trails = [(t.at_zero_slip, t.zero_slip, t.sliding_slip) for t in (tyre.aligning.nominal, tyre.aligning.double)]
        return TMEASY, (tyre.nominal_load, *sum(forces, ()), tyre.aligning.contact_length, *sum(trails, ()))
    if isinstance(tyre, DugoffTyre):
        stiffness = tyre.slip_stiffness, tyre.cornering_stiffness
        return DUGOFF, (tyre.friction, tyre.friction_reduction, *stiffness, tyre.pneumatic_trail)
    if isinstance(tyre, FialaTyre):
        friction = tyre.static_friction, tyre.sliding_friction
        return FIALA, (*friction, tyre.slip_stiffness, tyre.cornering_stiffness, tyre.width)
    bristles = tyre.stiffness_longitudinal, tyre.stiffness_lateral, tyre.renewal, tyre.pneumatic_trail
    if isinstance(tyre, DahlTyre):
        return LUGRE, (tyre.friction, tyre.friction, 1.0, 0.0, *bristles)
    return LUGRE, (
        tyre.static_friction,
        tyre.coulomb_friction,
        tyre.stribeck_speed,
        tyre.viscous_friction,
        *bristles,
    )


def _write_direction(
    curve: MagicFormulaCurve | LoadDependentCurve | BurckhardtCurve,
    row: NDArray[np.float64],
    coefficients: NDArray[np.float64],
) -> int:
    if isinstance(curve, LoadDependentCurve):
        coefficients[:] = [getattr(curve, f"a{number}") for number in range(9)]
        return LOAD_DEPENDENT
    return write_curve(curve, row)


def _write_curves(tyre: CurveTyre, row: NDArray[np.float64]) -> None:
    row[TYRE_KIND] = _write_direction(
        tyre.longitudinal, row[TYRE_X : TYRE_X + CURVE_SIZE], row[TYRE_LOAD_X : TYRE_LOAD_X + 9]
    )
    row[TYRE_KIND_Y] = _write_direction(
        tyre.lateral, row[TYRE_Y : TYRE_Y + CURVE_SIZE], row[TYRE_LOAD_Y : TYRE_LOAD_Y + 9]
    )
    row[TYRE_COMBINED] = KAMM if tyre.combined_slip == "kamm" else SIMILARITY
    row[TYRE_LOAD_SENSITIVITY] = tyre.load_sensitivity
    row[TYRE_NOMINAL_LOAD] = tyre.nominal_load
    row[TYRE_TRAIL] = tyre.pneumatic_trail


def tir_tyre(tyre: TirTyre) -> "MagicFormulaTyre":
    """The tyre of a ``.tir`` file with the scales and the pressure of the file that names it."""
    from vehicle_model.tyres.magic_formula_tyre import read_tir

    scale = {
        "LMUX": tyre.longitudinal_friction_scale,
        "LMUY": tyre.lateral_friction_scale,
        "LKX": tyre.slip_stiffness_scale,
        "LKY": tyre.cornering_stiffness_scale,
    }
    read = read_tir(tyre.tir, combined_slip=tyre.combined_slip)
    for name, factor in scale.items():
        read.record[name] *= factor
    if tyre.inflation_pressure is not None:
        read.record["INFLPRES"] = tyre.inflation_pressure
    return read


def _write_tir(tyre: TirTyre, row: NDArray[np.float64], right: bool) -> None:
    read = tir_tyre(tyre)
    row[TYRE_KIND] = TIR
    row[TYRE_ELLIPSE] = float(read.uses_ellipse)
    measured_right = read.measured_side == "RIGHT"
    row[TYRE_MIRRORED] = float(right != measured_right)
    row[TYRE_RECORD : TYRE_RECORD + len(FIELDS)] = read.record.view(np.float64)
