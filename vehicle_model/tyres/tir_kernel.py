"""Tyres from ``.tir`` files inside the compiled plant: the same functions as ``Tyre.forces``, from rows of numbers."""

import math

import numpy as np
from numba import njit
from numpy.typing import NDArray

from signals.record_memory import address_in, record_at
from vehicle_model.tyres.coefficients import TYRE_ELLIPSE, TYRE_MIRRORED, TYRE_RECORD, TYRE_SIZE
from vehicle_model.tyres.curves import magic_formula_peak
from vehicle_model.tyres.magic_formula_coefficients import COEFFICIENT_RECORD, coefficients
from vehicle_model.tyres.magic_formula_forces import (
    aligning_moment,
    ellipse_forces,
    lateral_force,
    longitudinal_force_and_slope,
)
from vehicle_model.tyres.magic_formula_record import TIR_RECORD, VERSION_52
from vehicle_model.tyres.prepared_row import (
    PEAK_FORCE_X,
    PEAK_FORCE_Y,
    PEAK_SLIP_X,
    PEAK_SLIP_Y,
    STIFFNESS_X,
    STIFFNESS_Y,
)
from vehicle_model.tyres.slip_shares import shares

if TYRE_RECORD * 8 + TIR_RECORD.itemsize > TYRE_SIZE * 8:
    raise ImportError("the record of a .tir tyre is longer than the row that holds it")

_LIGHTEST = 0.05
"""Load over nominal load below which the coefficients stay and forces fall in proportion to the load."""


@njit(cache=True)
def _slips(
    version: float, mirrored: float, slip_x: float, slip_y: float, travelling: float
) -> tuple[float, float, float]:
    """Slip ratio, alpha* and slip angle of the Magic Formula from the plant's slip vector.

    ``travelling`` is the travelling speed over the faster of rolling and travelling, to which both slips refer here.
    """
    if travelling < 1.0:
        slip_x, slip_y = slip_x / travelling, slip_y / travelling
    tangent = slip_y if mirrored != 0.0 else -slip_y
    angle = math.atan(tangent) if tangent != 0.0 else 0.0
    return slip_x, (angle if version == VERSION_52 else tangent), angle


@njit(cache=True)
def prepare_tir(
    row: NDArray[np.float64],
    friction: float,
    load: float,
    camber: float,
    header: NDArray[np.float64],
    kept: NDArray[np.float64],
) -> None:
    """Coefficients for the coming step into ``kept``; peaks and slopes at zero slip into ``header``."""
    p = record_at(address_in(row, TYRE_RECORD), TIR_RECORD)
    c = record_at(address_in(kept, 0), COEFFICIENT_RECORD)
    lightest = _LIGHTEST * p.FNOMIN * p.LFZO
    evaluated = max(load, lightest)
    coefficients(p, c, evaluated, -camber if row[TYRE_MIRRORED] != 0.0 else camber, p.INFLPRES, friction)
    c.share = load / evaluated
    header[PEAK_FORCE_X], header[PEAK_FORCE_Y] = c.share * c.peak_x, c.share * c.peak_y
    header[PEAK_SLIP_X] = header[PEAK_SLIP_Y] = 0.0
    header[STIFFNESS_X], header[STIFFNESS_Y] = c.share * abs(c.stiffness_x), c.share * abs(c.stiffness_y)


@njit(cache=True)
def find_peak_slips_tir(header: NDArray[np.float64], kept: NDArray[np.float64]) -> None:
    """Slips of the peaks into ``header``: they cost as much as all forces, and few ask for them."""
    c = record_at(address_in(kept, 0), COEFFICIENT_RECORD)
    header[PEAK_SLIP_X] = magic_formula_peak(c.b_x, c.shape_x, min(c.e_x, 1.0))
    header[PEAK_SLIP_Y] = magic_formula_peak(c.b_y, c.shape_y, min(c.e_y, 1.0))


@njit(cache=True)
def along_tir(
    row: NDArray[np.float64], kept: NDArray[np.float64], slip_x: float, slip_y: float, direction: float
) -> tuple[float, float]:
    """Longitudinal force and its derivative by ``slip_x``."""
    p = record_at(address_in(row, TYRE_RECORD), TIR_RECORD)
    c = record_at(address_in(kept, 0), COEFFICIENT_RECORD)
    _, travelling = shares(slip_x, direction)
    kappa, alpha, angle = _slips(p.VERSION, row[TYRE_MIRRORED], slip_x, slip_y, travelling)
    growth = 1.0 / travelling**2 if travelling < 1.0 else 1.0
    if row[TYRE_ELLIPSE] != 0.0:
        force, _ = ellipse_forces(p, c, kappa, alpha, angle)
        _, slope = longitudinal_force_and_slope(p, c, kappa, 0.0)
    else:
        force, slope = longitudinal_force_and_slope(p, c, kappa, alpha)
    return c.share * force, c.share * slope * growth


@njit(cache=True)
def across_tir(
    row: NDArray[np.float64],
    kept: NDArray[np.float64],
    slip_x: float,
    slip_y: float,
    force_x: float,
    direction: float,
) -> tuple[float, float]:
    """Side force and aligning moment, which turns round with the direction of travel."""
    p = record_at(address_in(row, TYRE_RECORD), TIR_RECORD)
    c = record_at(address_in(kept, 0), COEFFICIENT_RECORD)
    _, travelling = shares(slip_x, direction)
    kappa, alpha, angle = _slips(p.VERSION, row[TYRE_MIRRORED], slip_x, slip_y, travelling)
    if row[TYRE_ELLIPSE] != 0.0:
        _, force_y = ellipse_forces(p, c, kappa, alpha, angle)
    else:
        force_y = lateral_force(p, c, kappa, alpha, angle)
    moment = aligning_moment(p, c, kappa, alpha, angle, force_x / c.share, force_y)
    side = -c.share if row[TYRE_MIRRORED] != 0.0 else c.share
    return side * force_y, side * direction * moment
