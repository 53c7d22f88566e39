"""Measurement updates: all rows at once with a full noise covariance, or row by row with independent noise.

Both give the same result where the noise of the rows is independent. Row by row needs no matrix inverse, and a row that
is missing or implausible is simply left out. The covariance is updated in Joseph form, which is valid for any gain
(Enisz 2015, eq. 50).
"""

import numpy as np
from numba import njit

from estimators.kalman.covariance import FloatArray, IntArray, cholesky, solve_cholesky, symmetrise

ROW_MISSING, ROW_USED, ROW_GATED = 0, 1, 2
ROW_STALE = -1
"""A row that is missing because its sensor cannot tell; every value below ``ROW_USED`` leaves a row out."""


@njit(cache=True)
def joseph(
    covariance: FloatArray, gain: FloatArray, design: FloatArray, noise: FloatArray, work: FloatArray, wide: FloatArray
) -> None:
    """P <- (I - K H) P (I - K H)' + K R K'.

    Parameters
    ----------
    covariance : array, shape (n, n)
        P, changed.
    gain, design, noise : arrays, shape (n, m), (m, n), (m, m)
        K, H, R.
    work, wide : arrays, shape (2, n, n) and (n, m)
        Scratch.
    """
    n, m = gain.shape
    left, product = work[0], work[1]
    for i in range(n):
        for j in range(n):
            total = 1.0 if i == j else 0.0
            for k in range(m):
                total -= gain[i, k] * design[k, j]
            left[i, j] = total
    for i in range(n):
        for j in range(n):
            total = 0.0
            for k in range(n):
                total += left[i, k] * covariance[k, j]
            product[i, j] = total
        for j in range(m):
            total = 0.0
            for k in range(m):
                total += gain[i, k] * noise[k, j]
            wide[i, j] = total
    for i in range(n):
        for j in range(n):
            total = 0.0
            for k in range(n):
                total += product[i, k] * left[j, k]
            for k in range(m):
                total += wide[i, k] * gain[j, k]
            covariance[i, j] = total
    symmetrise(covariance)


@njit(cache=True)
def correct(
    state: FloatArray,
    covariance: FloatArray,
    residual: FloatArray,
    design: FloatArray,
    noise: FloatArray,
    gain: FloatArray,
    work: FloatArray,
    wide: FloatArray,
    innovation: FloatArray,
) -> float:
    """Update with all rows at once; returns the normalised innovation squared, NaN if S is not positive definite.

    Parameters
    ----------
    state, covariance : arrays, shape (n,) and (n, n)
        x and P, changed (left alone where the result is NaN).
    residual : array, shape (m,)
        y - h(x).
    design, noise : arrays, shape (m, n) and (m, m)
        H and R.
    gain : array, shape (n, m)
        Receives K.
    work, wide, innovation : arrays, shape (2, n, n), (n, m) and (3, m, m)
        Scratch; ``innovation[0]`` receives S and ``innovation[1]`` its Cholesky factor.
    """
    n, m = gain.shape
    s, factor = innovation[0], innovation[1]
    for i in range(n):
        for j in range(m):
            total = 0.0
            for k in range(n):
                total += covariance[i, k] * design[j, k]
            gain[i, j] = total
    for i in range(m):
        for j in range(m):
            total = noise[i, j]
            for k in range(n):
                total += design[i, k] * gain[k, j]
            s[i, j] = total
    if not cholesky(s, factor):
        return np.nan
    weighted = innovation[2, 0]
    for i in range(m):
        weighted[i] = residual[i]
    solve_cholesky(factor, weighted)
    squared = 0.0
    for i in range(m):
        squared += residual[i] * weighted[i]
    for i in range(n):
        for j in range(m):
            wide[i, j] = gain[i, j]
        solve_cholesky(factor, gain[i])
        total = 0.0
        for j in range(m):
            total += wide[i, j] * weighted[j]
        state[i] += total
    joseph(covariance, gain, design, noise, work, wide)
    return squared


@njit(cache=True, inline="always")
def _correct_row_of(
    states: int,
    correction: FloatArray,
    covariance: FloatArray,
    residual: float,
    row: FloatArray,
    columns: IntArray,
    variance: float,
    gate: float,
    work: FloatArray,
) -> float:
    cross, gain = work[0], work[1]
    error = residual
    for i in range(states):
        cross[i] = 0.0
    used = 0
    for c in range(columns.shape[0]):
        k = columns[c]
        if k < 0:
            break
        used += 1
        factor = row[k]
        error -= factor * correction[k]
        for i in range(states):
            cross[i] += factor * covariance[k, i]
    total = variance
    for c in range(used):
        k = columns[c]
        total += row[k] * cross[k]
    squared = error * error / total
    if gate > 0.0 and squared > gate:
        return -squared
    inverse = 1.0 / total
    for i in range(states):
        gain[i] = cross[i] * inverse
        correction[i] += gain[i] * error
    # both factors of the Joseph form row by row: the second needs of (I - K H) P only the row itself
    for i in range(states):
        own = gain[i]
        for j in range(states):
            covariance[i, j] -= own * cross[j]
        moved = 0.0
        for c in range(used):
            k = columns[c]
            moved += row[k] * covariance[i, k]
        share = variance * own - moved
        for j in range(states):
            covariance[i, j] += share * gain[j]
    return squared


@njit(cache=True)
def correct_row(
    correction: FloatArray,
    covariance: FloatArray,
    residual: float,
    row: FloatArray,
    columns: IntArray,
    variance: float,
    gate: float,
    work: FloatArray,
) -> float:
    """Update with one row of the measurement, whose noise is independent of the others'.

    Parameters
    ----------
    correction : array, shape (n,)
        Sum of the corrections so far in this step (x minus the predicted x), changed.
    covariance : array, shape (n, n)
        P, changed; not symmetrised here.
    residual : float
        y - h(predicted x) of this row.
    row : array, shape (n,)
        H of this row, taken at the predicted x.
    columns : array of int, shape (k,)
        Columns in which the row may be non-zero; ends with -1 if it is shorter.
    variance : float
        Noise variance of this row.
    gate : float
        A row whose normalised innovation squared is above it is left out; 0 uses every row.
    work : array, shape (2, n)
        Scratch.

    Returns
    -------
    float
        Normalised innovation squared; negative if the row was left out.
    """
    return _correct_row_of(covariance.shape[0], correction, covariance, residual, row, columns, variance, gate, work)


@njit(cache=True, inline="always")
def correct_rows_of(
    states: int,
    state: FloatArray,
    covariance: FloatArray,
    residual: FloatArray,
    design: FloatArray,
    variances: FloatArray,
    rows: IntArray,
    gate: float,
    columns: IntArray,
    work: FloatArray,
) -> float:
    """:func:`correct_rows` for a number of states that is a constant of the caller: its loops are unrolled."""
    correction = work[2]
    for i in range(states):
        correction[i] = 0.0
    total = 0.0
    for r in range(residual.shape[0]):
        if rows[r] < ROW_USED:
            continue
        squared = _correct_row_of(
            states, correction, covariance, residual[r], design[r], columns[r], variances[r], gate, work
        )
        if squared < 0.0:
            rows[r] = ROW_GATED
        else:
            rows[r] = ROW_USED
            total += squared
    symmetrise(covariance)
    for i in range(states):
        state[i] += correction[i]
    return total


@njit(cache=True)
def correct_rows(
    state: FloatArray,
    covariance: FloatArray,
    residual: FloatArray,
    design: FloatArray,
    variances: FloatArray,
    rows: IntArray,
    gate: float,
    columns: IntArray,
    work: FloatArray,
) -> float:
    """Update row by row with independent noise; returns the sum of the normalised innovations squared.

    Parameters
    ----------
    state, covariance : arrays, shape (n,) and (n, n)
        x and P, changed.
    residual, design, variances : arrays, shape (m,), (m, n), (m,)
        y - h(x), H and the diagonal of R.
    rows : array of int, shape (m,)
        In: values below ``ROW_USED`` leave a row out. Out: ``ROW_GATED`` where the gate did so.
    gate : float
        Largest normalised innovation squared of a row; 0 uses every row.
    columns : array of int, shape (m, k)
        Columns in which H may be non-zero, each row ended by -1 if it has fewer than k.
    work : array, shape (3, n)
        Scratch.
    """
    return correct_rows_of(
        covariance.shape[0], state, covariance, residual, design, variances, rows, gate, columns, work
    )
