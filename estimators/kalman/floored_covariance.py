"""A covariance whose eigenvalues are kept positive, so that it has a Cholesky factor, compiled."""

import math

from numba import njit

from estimators.kalman.covariance import FloatArray, cholesky, symmetrise

_SMALLEST = 1e-12
_SMALLEST_SHARE = 1e-9
"""Of the largest eigenvalue: seven digits above the rounding of its factor."""


@njit(cache=True)
def floor_covariance(covariance: FloatArray, factor: FloatArray, work: FloatArray) -> None:
    """Raise eigenvalues that are not positive, so that the covariance has a Cholesky factor; ``factor`` receives it.

    A covariance from sigma points may lose its definiteness where the weight of the centre point is negative.
    """
    symmetrise(covariance)
    if cholesky(covariance, factor):
        return
    n = covariance.shape[0]
    for i in range(n):
        for j in range(n):
            factor[i, j] = 1.0 if i == j else 0.0
            work[i, j] = covariance[i, j]
    _jacobi(work, factor)
    largest = 0.0
    for i in range(n):
        largest = max(largest, abs(work[i, i]))
    floor = max(_SMALLEST, _SMALLEST_SHARE * largest)
    for i in range(n):
        for j in range(i + 1):
            total = 0.0
            for k in range(n):
                total += factor[i, k] * max(work[k, k], floor) * factor[j, k]
            covariance[i, j] = total
            covariance[j, i] = total
    cholesky(covariance, factor)


@njit(cache=True)
def _jacobi(matrix: FloatArray, vectors: FloatArray) -> None:
    """Eigenvalues on the diagonal of a symmetric matrix and eigenvectors in columns, by cyclic rotations."""
    n = matrix.shape[0]
    for _ in range(30):
        off = scale = 0.0
        for i in range(n):
            scale += matrix[i, i] * matrix[i, i]
            for j in range(i):
                off += matrix[i, j] * matrix[i, j]
        if off <= 1e-26 * scale:
            return
        for p in range(n - 1):
            for q in range(p + 1, n):
                if matrix[p, q] == 0.0:
                    continue
                ratio = (matrix[q, q] - matrix[p, p]) / (2.0 * matrix[p, q])
                tangent = 1.0 / (abs(ratio) + math.sqrt(ratio * ratio + 1.0))
                if ratio < 0.0:
                    tangent = -tangent
                cosine = 1.0 / math.sqrt(tangent * tangent + 1.0)
                sine = tangent * cosine
                for k in range(n):
                    a, b = matrix[k, p], matrix[k, q]
                    matrix[k, p], matrix[k, q] = cosine * a - sine * b, sine * a + cosine * b
                for k in range(n):
                    a, b = matrix[p, k], matrix[q, k]
                    matrix[p, k], matrix[q, k] = cosine * a - sine * b, sine * a + cosine * b
                for k in range(n):
                    a, b = vectors[k, p], vectors[k, q]
                    vectors[k, p], vectors[k, q] = cosine * a - sine * b, sine * a + cosine * b
