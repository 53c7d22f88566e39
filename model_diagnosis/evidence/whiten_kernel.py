"""Whitening of one signal, compiled and without Python's lock: one pass over samples and columns."""

import numpy as np
from numba import njit
from numpy.typing import NDArray


@njit(cache=True, nogil=True, error_model="numpy")
def whiten(
    values: NDArray[np.float64],
    column: int,
    samples: NDArray[np.int64],
    rows: NDArray[np.int64],
    coefficients: NDArray[np.float64],
    sums: NDArray[np.float64],
    of_memory: NDArray[np.float64],
    sigma: float,
    out: NDArray[np.float64],
) -> None:
    """Innovations of one signal in units of sigma.

    Parameters
    ----------
    values : (n, c, p) residuals or sensitivities
    column : of the signal
    samples : (k,) its valid samples
    rows : (r,) places in ``samples`` that are predicted
    coefficients : (4,) autoregression
    sums : (n, s, p) of the observer's corrections
    of_memory : (s,) their coefficients, or none
    sigma : standard deviation of the innovations
    out : (r, p)
    """
    count = values.shape[2]
    for r in range(rows.shape[0]):
        place = rows[r]
        now = samples[place]
        for p in range(count):
            out[r, p] = values[now, column, p]
        for lag in range(coefficients.shape[0]):
            before, coefficient = samples[place - lag - 1], coefficients[lag]
            for p in range(count):
                out[r, p] -= coefficient * values[before, column, p]
        for state in range(of_memory.shape[0]):
            for p in range(count):
                out[r, p] -= of_memory[state] * sums[now, state, p]
        for p in range(count):
            out[r, p] /= sigma
