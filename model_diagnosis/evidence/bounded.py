"""Lowest point of a parabola within bounds."""

import numpy as np
from numpy.typing import NDArray
from scipy.linalg import cho_factor, cho_solve, cholesky, solve_triangular
from scipy.optimize import lsq_linear

FloatArray = NDArray[np.float64]

ROUNDS = 20
"""Rounds of pivoting; they nearly always suffice, and cannot be shown to."""


def ways_left(point: FloatArray, low: FloatArray, high: FloatArray, scale: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Ways (p,) from a point down and up to its bounds, in units of ``scale``; 0 where it lies beyond one."""
    return np.minimum((low - point) / scale, 0.0), np.maximum((high - point) / scale, 0.0)


def lowest_within(curvature: FloatArray, gradient: FloatArray, low: FloatArray, high: FloatArray) -> FloatArray:
    """Point s (p,) between ``low`` and ``high`` (p,) where s'Hs / 2 - g's is least.

    Block principal pivoting (Portugal, Judice and Vicente 1994): all columns beyond a bound are held at it, all held
    ones that the slope drives back inside are let go, until none is left. Where that goes round in circles, scipy's
    active set one by one.

    Parameters
    ----------
    curvature : (p, p), positive definite
    gradient : (p,)
    """
    at_low, at_high = (low >= 0.0) & (gradient < 0.0), (high <= 0.0) & (gradient > 0.0)
    for _ in range(ROUNDS):
        point = np.where(at_low, low, np.where(at_high, high, 0.0))
        held = at_low | at_high
        free, stuck = np.flatnonzero(~held), np.flatnonzero(held)
        rest = gradient[free] - curvature[np.ix_(free, stuck)] @ point[stuck]
        if len(free):
            point[free] = cho_solve(cho_factor(curvature[np.ix_(free, free)]), rest)
        slope = gradient - curvature @ point
        below, above = ~held & (point < low), ~held & (point > high)
        freed = (at_low & (slope > 0.0)) | (at_high & (slope < 0.0))
        freed &= low < high
        if not (below | above | freed).any():
            return point
        at_low, at_high = (at_low & ~freed) | below, (at_high & ~freed) | above
    return _one_by_one(curvature, gradient, low, high)


def _one_by_one(curvature: FloatArray, gradient: FloatArray, low: FloatArray, high: FloatArray) -> FloatArray:
    point = np.where(low < high, 0.0, low)
    free = np.flatnonzero(low < high)
    root = cholesky(curvature[np.ix_(free, free)])
    target = solve_triangular(root, gradient[free], trans="T")
    point[free] = lsq_linear(root, target, (low[free], high[free]), method="bvls").x
    return np.clip(point, low, high)
