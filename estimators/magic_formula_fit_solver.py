"""Two-parameter fit of the reduced Magic Formula with absolute deviations (vehicle-state document 3.4), compiled.

min over (D, B) of J = sum |mu_i - D sin(C arctan(B x_i))|. For a given B the best D is a weighted median, exactly; what
is left is one-dimensional and is searched on a logarithmic grid and refined by golden section. The result needs no
start value, and J is never above that of a gradient method, which may stop at one of the kinks of the sum. The
document's own optimiser, SLSQP, is :func:`slsqp_fit`.
"""

import math
from typing import Any

import numpy as np
from numba import njit

from estimators.kalman.covariance import FloatArray

_GRID = 32
_GOLDEN = 0.6180339887498949
_REFINEMENTS = 28


@njit(cache=True)
def weighted_median(values: FloatArray, weights: FloatArray, count: int) -> float:
    """Value with at most half of the weight on either side; sorts both arrays' first ``count`` entries in place."""
    total = 0.0
    for k in range(count):
        total += weights[k]
    for k in range(1, count):
        value, weight, place = values[k], weights[k], k
        while place > 0 and values[place - 1] > value:
            values[place], weights[place] = values[place - 1], weights[place - 1]
            place -= 1
        values[place], weights[place] = value, weight
    below = 0.0
    for k in range(count):
        below += weights[k]
        if below >= 0.5 * total:
            return values[k]
    return values[count - 1]


@njit(cache=True)
def deviation(x: FloatArray, mu: FloatArray, count: int, d: float, b: float, c: float) -> float:
    """Objective J(D, B)."""
    total = 0.0
    for k in range(count):
        total += abs(mu[k] - d * math.sin(c * math.atan(b * x[k])))
    return total


@njit(cache=True)
def best_limit(
    x: FloatArray, mu: FloatArray, count: int, b: float, c: float, low: float, high: float, scratch: FloatArray
) -> tuple[float, float]:
    """Best D within its bounds for a given B, and J there."""
    used = 0
    for k in range(count):
        shape = math.sin(c * math.atan(b * x[k]))
        if abs(shape) > 1e-9:
            scratch[0, used], scratch[1, used] = mu[k] / shape, abs(shape)
            used += 1
    if used == 0:
        return low, deviation(x, mu, count, low, b, c)
    d = min(max(weighted_median(scratch[0], scratch[1], used), low), high)
    return d, deviation(x, mu, count, d, b, c)


@njit(cache=True)
def fit_curve(
    x: FloatArray,
    mu: FloatArray,
    count: int,
    c: float,
    d_low: float,
    d_high: float,
    b_low: float,
    b_high: float,
    scratch: FloatArray,
) -> tuple[float, float, float]:
    """D, B and J of the best curve.

    Parameters
    ----------
    x, mu : arrays, shape (n,)
        Slip or slip angle, friction; the first ``count`` entries count.
    c : float
        Shape factor, fixed.
    scratch : array, shape (2, n)
    """
    ratio = (b_high / b_low) ** (1.0 / (_GRID - 1))
    best, best_k, b = math.inf, 0, b_low
    for k in range(_GRID):
        j = best_limit(x, mu, count, b, c, d_low, d_high, scratch)[1]
        if j < best:
            best, best_k = j, k
        b *= ratio
    left = math.log(b_low) + max(best_k - 1, 0) * math.log(ratio)
    right = math.log(b_low) + min(best_k + 1, _GRID - 1) * math.log(ratio)
    first, second = right - _GOLDEN * (right - left), left + _GOLDEN * (right - left)
    j_first = best_limit(x, mu, count, math.exp(first), c, d_low, d_high, scratch)[1]
    j_second = best_limit(x, mu, count, math.exp(second), c, d_low, d_high, scratch)[1]
    for _ in range(_REFINEMENTS):
        if j_first <= j_second:
            right, second, j_second = second, first, j_first
            first = right - _GOLDEN * (right - left)
            j_first = best_limit(x, mu, count, math.exp(first), c, d_low, d_high, scratch)[1]
        else:
            left, first, j_first = first, second, j_second
            second = left + _GOLDEN * (right - left)
            j_second = best_limit(x, mu, count, math.exp(second), c, d_low, d_high, scratch)[1]
    b = math.exp(0.5 * (left + right))
    d, j = best_limit(x, mu, count, b, c, d_low, d_high, scratch)
    return d, b, j


@njit(cache=True)
def line_deviation(x: FloatArray, mu: FloatArray, count: int, scratch: FloatArray) -> float:
    """Least sum of absolute deviations of a straight line through the origin: what data that do not bend leave."""
    for k in range(count):
        scratch[0, k], scratch[1, k] = mu[k] / x[k], abs(x[k])
    slope = weighted_median(scratch[0], scratch[1], count)
    total = 0.0
    for k in range(count):
        total += abs(mu[k] - slope * x[k])
    return total


@njit(cache=True)
def r_squared(x: FloatArray, mu: FloatArray, count: int, d: float, b: float, c: float) -> float:
    """Coefficient of determination of a curve over its data (4.1)."""
    mean = 0.0
    for k in range(count):
        mean += mu[k] / count
    rest = spread = 0.0
    for k in range(count):
        rest += (mu[k] - d * math.sin(c * math.atan(b * x[k]))) ** 2
        spread += (mu[k] - mean) ** 2
    return 1.0 - rest / spread if spread > 0.0 else 0.0


def slsqp_fit(
    x: FloatArray,
    mu: FloatArray,
    shape: float,
    start: tuple[float, float],
    limits: tuple[tuple[float, float], tuple[float, float]],
) -> tuple[float, float, float]:
    """D, B and J by SLSQP, the document's optimiser (l. 2605-2629, 5709).

    Parameters
    ----------
    start : tuple
        D and B to start from.
    limits : tuple
        Bounds of D and of B.
    """
    from scipy.optimize import minimize

    scale = np.array([1.0, start[1]])

    def objective(p: Any) -> float:
        d, b = p * scale
        return float(np.sum(np.abs(mu - d * np.sin(shape * np.arctan(b * x)))))

    bounds = [(low / size, high / size) for (low, high), size in zip(limits, scale, strict=True)]
    result = minimize(
        objective, np.array(start) / scale, method="SLSQP", bounds=bounds, options={"ftol": 1e-12, "maxiter": 200}
    )
    d, b = result.x * scale
    return float(d), float(b), float(result.fun)
