"""Covariance matrices in place: propagation, symmetry, Cholesky factor."""

import numpy as np
from numba import njit
from numpy.typing import NDArray

FloatArray = NDArray[np.float64]
IntArray = NDArray[np.int64]


@njit(cache=True)
def symmetrise(matrix: FloatArray) -> None:
    """Replace a square matrix by the mean of itself and its transpose."""
    for i in range(matrix.shape[0]):
        for j in range(i):
            mean = 0.5 * (matrix[i, j] + matrix[j, i])
            matrix[i, j] = mean
            matrix[j, i] = mean


@njit(cache=True)
def propagate(covariance: FloatArray, transition: FloatArray, noise: FloatArray, work: FloatArray) -> None:
    """P <- F P F' + Q (Enisz 2015, eq. 64, with L = I).

    Parameters
    ----------
    covariance, transition, noise : array, shape (n, n)
        P (changed), F, Q.
    work : array, shape (n, n)
        Scratch.
    """
    n = covariance.shape[0]
    for i in range(n):
        for j in range(n):
            work[i, j] = 0.0
        for k in range(n):
            factor = transition[i, k]
            if factor != 0.0:
                for j in range(n):
                    work[i, j] += factor * covariance[k, j]
    for i in range(n):
        for j in range(i + 1):
            total = 0.5 * (noise[i, j] + noise[j, i])
            for k in range(n):
                total += work[i, k] * transition[j, k]
            covariance[i, j] = total
            covariance[j, i] = total


@njit(cache=True)
def propagate_sparse(
    covariance: FloatArray, transition: FloatArray, columns: IntArray, variances: FloatArray, work: FloatArray
) -> None:
    """P <- F P F' + diag(q) where row i of F is zero outside ``columns[i]``.

    Parameters
    ----------
    columns : array of int, shape (n, m)
        Columns that may be non-zero; a row with fewer than m of them repeats -1 at its end.
    variances : array, shape (n,)
        Diagonal of the process noise covariance.
    """
    n = covariance.shape[0]
    m = columns.shape[1]
    for i in range(n):
        first = columns[i, 0]
        factor = transition[i, first]
        for j in range(n):
            work[i, j] = factor * covariance[first, j]
        for c in range(1, m):
            k = columns[i, c]
            if k < 0:
                break
            factor = transition[i, k]
            for j in range(n):
                work[i, j] += factor * covariance[k, j]
    for i in range(n):
        for j in range(i + 1):
            total = 0.0
            for c in range(m):
                k = columns[j, c]
                if k < 0:
                    break
                total += work[i, k] * transition[j, k]
            covariance[i, j] = total
            covariance[j, i] = total
        covariance[i, i] += variances[i]


@njit(cache=True)
def cholesky(matrix: FloatArray, factor: FloatArray) -> bool:
    """Lower triangular factor of a symmetric matrix; False if it is not positive definite."""
    n = matrix.shape[0]
    for i in range(n):
        for j in range(i + 1):
            total = matrix[i, j]
            for k in range(j):
                total -= factor[i, k] * factor[j, k]
            if i == j:
                if not total > 0.0:
                    return False
                factor[i, i] = np.sqrt(total)
            else:
                factor[i, j] = total / factor[j, j]
                factor[j, i] = 0.0
    return True


@njit(cache=True)
def solve_cholesky(factor: FloatArray, right: FloatArray) -> None:
    """Solve L L' x = b in place of b, a vector."""
    n = factor.shape[0]
    for i in range(n):
        total = right[i]
        for k in range(i):
            total -= factor[i, k] * right[k]
        right[i] = total / factor[i, i]
    for i in range(n - 1, -1, -1):
        total = right[i]
        for k in range(i + 1, n):
            total -= factor[k, i] * right[k]
        right[i] = total / factor[i, i]


@njit(cache=True)
def all_finite(values: FloatArray) -> bool:
    """True if no entry of a vector is infinite or not a number."""
    total = 0.0
    for i in range(values.shape[0]):
        total += values[i] * 0.0
    return total == 0.0
