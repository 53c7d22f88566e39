"""Tables of tyres whose longitudinal curve has another form at the same stiffness and peak: effect ``tyre_peak_shape``.

The tables change by the difference of two Magic Formulas with peak 1: one with the stiffness, the slip at the peak and
the sliding friction of the tyre as it is, one with those asked for. A tyre that is a Magic Formula stays one.
"""

import math

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import brentq

from model_diagnosis.replay.record import CELLS

FloatArray = NDArray[np.float64]

_SHAPES = (1.02, 2.5)
_LARGEST_CURVATURE, _LEAST_CURVATURE = 0.995, -30.0


def _formula(relative: FloatArray, shape: float, slope: float) -> FloatArray:
    """Magic Formula with peak 1 at relative slip 1 and a slope at zero; its curvature follows from both."""
    stiffness = slope / shape
    curvature = (stiffness - math.tan(math.pi / (2.0 * shape))) / (stiffness - math.atan(stiffness))
    curvature = min(max(curvature, _LEAST_CURVATURE), _LARGEST_CURVATURE)
    scaled = stiffness * relative
    friction: FloatArray = np.sin(shape * np.arctan(scaled - curvature * (scaled - np.arctan(scaled))))
    return friction


def _shape_of(slope: float, sliding: float, locked: float) -> float:
    """Shape factor at which the friction at the relative slip ``locked`` is ``sliding``; the nearest where none is."""

    def excess(shape: float) -> float:
        return float(_formula(np.array([locked]), shape, slope)[0]) - sliding

    low, high = _SHAPES
    if excess(low) <= 0.0:
        return low
    if excess(high) >= 0.0:
        return high
    return float(brentq(excess, low, high, xtol=1e-10))


def reshaped(table: FloatArray, peak_slip: float, sliding_loss: float, peak_shift: float) -> FloatArray:
    """Table (CELLS + 1, 2) of a tyre with less friction at slip 1 and its peak at a larger slip.

    Parameters
    ----------
    table : (CELLS + 1, 2) of the tyre as it is
    peak_slip : slip at its peak
    sliding_loss : friction over the peak's that is lacking at slip 1
    peak_shift : relative
    """
    variable = np.arange(CELLS + 1) / CELLS
    slope, locked = float(table[0, 1]) * CELLS, 1.0 / peak_slip
    # beyond slip 1 a table stays level
    relative = np.minimum(variable / np.maximum(1.0 - variable, 1e-9), locked)
    sliding = float(np.interp(locked / (1.0 + locked), variable, table[:, 0]))
    before = _formula(relative, _shape_of(slope, sliding, locked), slope)
    steeper, nearer = slope * (1.0 + peak_shift), locked / (1.0 + peak_shift)
    after = _formula(np.minimum(relative, nearer), _shape_of(steeper, sliding - sliding_loss, nearer), steeper)
    values = table[:, 0] + after - before
    slopes = np.gradient(values, edge_order=2)
    slopes[0] = steeper / CELLS
    slopes[-1] = 0.0
    return np.stack([values, slopes], axis=1)


def shaped_tables(tables: FloatArray, peak_slips: FloatArray, sliding_loss: float, peak_shift: float) -> FloatArray:
    """Tables (axle, direction, CELLS + 1, 2) with the longitudinal ones reshaped; ``peak_slips`` (2,) of the axles."""
    changed = tables.copy()
    for axle in range(2):
        changed[axle, 0] = reshaped(tables[axle, 0], float(peak_slips[axle]), sliding_loss, peak_shift)
    return changed
