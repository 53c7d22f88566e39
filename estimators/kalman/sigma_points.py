"""Sigma-point filters: unscented (scaled) and cubature transform, prediction and correction.

The caller runs its own model over the points; these kernels draw them and put mean and covariance together again.
Points that are passed on from prediction to correction, or drawn anew in between, are both possible.
"""

import math

import numpy as np
from numba import njit

from estimators.kalman.covariance import FloatArray, IntArray, cholesky, solve_cholesky, symmetrise


def unscented_weights(
    size: int, alpha: float = 1e-3, beta: float = 2.0, kappa: float = 0.0
) -> tuple[FloatArray, FloatArray, float]:
    """Weights of the scaled unscented transform (Merwe 2004).

    Parameters
    ----------
    size : int
        Number of states n.
    alpha, beta, kappa : float
        Spread, knowledge of the distribution (2 for a Gaussian one), secondary scaling.

    Returns
    -------
    mean, covariance : array, shape (2 n + 1,)
        Weights, the centre first.
    spread : float
        Distance of the outer points in standard deviations.
    """
    scaling = alpha**2 * (size + kappa) - size
    mean = np.full(2 * size + 1, 0.5 / (size + scaling))
    covariance = mean.copy()
    mean[0] = scaling / (size + scaling)
    covariance[0] = mean[0] + 1.0 - alpha**2 + beta
    return mean, covariance, math.sqrt(size + scaling)


def cubature_weights(size: int) -> tuple[FloatArray, FloatArray, float]:
    """Weights and spread of the third-degree cubature rule (Arasaratnam 2009); the centre has the weight 0."""
    weights = np.full(2 * size + 1, 0.5 / size)
    weights[0] = 0.0
    return weights, weights.copy(), math.sqrt(size)


@njit(cache=True)
def draw_points(
    state: FloatArray, covariance: FloatArray, spread: float, points: FloatArray, factor: FloatArray
) -> bool:
    """Centre and 2 n outer points; False if the covariance is not positive definite.

    Parameters
    ----------
    state, covariance : arrays, shape (n,) and (n, n)
    spread : float
        Distance in standard deviations.
    points : array, shape (2 n + 1, n)
        Filled.
    factor : array, shape (n, n)
        Receives the Cholesky factor.
    """
    n = state.shape[0]
    if not cholesky(covariance, factor):
        return False
    for i in range(n):
        points[0, i] = state[i]
    for k in range(n):
        for i in range(n):
            offset = spread * factor[i, k]
            points[1 + k, i] = state[i] + offset
            points[1 + n + k, i] = state[i] - offset
    return True


@njit(cache=True)
def weighted_mean(points: FloatArray, weights: FloatArray, mean: FloatArray) -> None:
    """Mean of points, a row each."""
    for i in range(points.shape[1]):
        total = 0.0
        for k in range(points.shape[0]):
            total += weights[k] * points[k, i]
        mean[i] = total


@njit(cache=True)
def weighted_covariance(
    left: FloatArray,
    left_mean: FloatArray,
    right: FloatArray,
    right_mean: FloatArray,
    weights: FloatArray,
    result: FloatArray,
) -> None:
    """Cross covariance of two sets of points, shapes (p, n) and (p, m), into an array of shape (n, m)."""
    n, m = left.shape[1], right.shape[1]
    for i in range(n):
        for j in range(m):
            result[i, j] = 0.0
    for k in range(left.shape[0]):
        for i in range(n):
            factor = weights[k] * (left[k, i] - left_mean[i])
            for j in range(m):
                result[i, j] += factor * (right[k, j] - right_mean[j])


@njit(cache=True)
def predict_points(
    points: FloatArray,
    mean_weights: FloatArray,
    covariance_weights: FloatArray,
    noise: FloatArray,
    state: FloatArray,
    covariance: FloatArray,
) -> None:
    """Mean and covariance of predicted points, plus process noise; state and covariance are filled."""
    weighted_mean(points, mean_weights, state)
    weighted_covariance(points, state, points, state, covariance_weights, covariance)
    for i in range(state.shape[0]):
        for j in range(state.shape[0]):
            covariance[i, j] += noise[i, j]
    symmetrise(covariance)


@njit(cache=True)
def correct_points(
    state: FloatArray,
    covariance: FloatArray,
    points: FloatArray,
    outputs: FloatArray,
    mean_weights: FloatArray,
    covariance_weights: FloatArray,
    noise: FloatArray,
    measured: FloatArray,
    rows: IntArray,
    expected: FloatArray,
    innovation: FloatArray,
    cross: FloatArray,
    gain: FloatArray,
) -> float:
    """Update from sigma points; returns the normalised innovation squared, NaN if S is not positive definite.

    Parameters
    ----------
    state, covariance : arrays, shape (n,) and (n, n)
        x and P, changed (left alone where the result is NaN).
    points, outputs : arrays, shape (p, n) and (p, m)
        Points and the measurement model at each.
    noise : array, shape (m, m)
        R.
    measured : array, shape (m,)
    rows : array of int, shape (m,)
        Values below 1 leave a row out.
    expected : array, shape (2, m)
        Receives the expected measurement; scratch.
    innovation : array, shape (2, m, m)
        Receives S and its Cholesky factor.
    cross, gain : arrays, shape (n, m)
        Receive the cross covariance and K.
    """
    n, m = cross.shape
    s, factor = innovation[0], innovation[1]
    mean, weighted = expected[0], expected[1]
    weighted_mean(outputs, mean_weights, mean)
    weighted_covariance(outputs, mean, outputs, mean, covariance_weights, s)
    weighted_covariance(points, state, outputs, mean, covariance_weights, cross)
    for i in range(m):
        for j in range(m):
            s[i, j] += noise[i, j]
    # a row that is left out becomes one of its own that tells nothing
    for r in range(m):
        if rows[r] < 1:
            for j in range(m):
                s[r, j] = 0.0
                s[j, r] = 0.0
            s[r, r] = 1.0
            for i in range(n):
                cross[i, r] = 0.0
    if not cholesky(s, factor):
        return np.nan
    for r in range(m):
        weighted[r] = measured[r] - mean[r] if rows[r] > 0 else 0.0
    solve_cholesky(factor, weighted)
    squared = 0.0
    for r in range(m):
        if rows[r] > 0:
            squared += (measured[r] - mean[r]) * weighted[r]
    for i in range(n):
        for r in range(m):
            state[i] += cross[i, r] * weighted[r]
            gain[i, r] = cross[i, r]
        solve_cholesky(factor, gain[i])
    for i in range(n):
        for j in range(n):
            for r in range(m):
                covariance[i, j] -= gain[i, r] * cross[j, r]
    symmetrise(covariance)
    return squared
