"""Likelihoods of the filters of a bank, weights that follow from them, the tuning aid (attitude document 3.4, 3.5)."""

import math

import numpy as np
from numba import njit

from estimators.kalman.covariance import FloatArray

LOG, SMOOTH, WEIGHT, OFFSET, GRID = range(5)
BANK_ROWS = 5
"""Rows of a bank: logarithm of the likelihood, low-passed likelihood or logarithm, weight, virtual offset [m/s^2], its
distance from the centre of the bank."""

FLOOR = -600.0
"""Smallest logarithm of a likelihood; exp(-745) is zero."""
LEAST = 1e-300
"""Added to every likelihood before they are normalised."""


@njit(cache=True)
def log_likelihood(squared: float, volume: float, rows: int, degrees: float) -> float:
    """Logarithm of (27): -(e' S^-1 e + ln det S)/2, or of a student density with the same S.

    Parameters
    ----------
    squared, volume : float
        e' S^-1 e and ln det S.
    rows : int
        Measurements in e.
    degrees : float
        Degrees of freedom of the student density; 0 for (27).
    """
    if degrees > 0.0:
        return -0.5 * volume - 0.5 * (degrees + rows) * math.log(1.0 + squared / degrees)
    return -0.5 * (volume + squared)


@njit(cache=True)
def smooth(bank: FloatArray, share: float, accumulated: bool) -> None:
    """Low-pass 58 of the likelihoods, or of their logarithms; ``share`` 1 lets the new value through."""
    for i in range(bank.shape[1]):
        value = max(bank[LOG, i], FLOOR)
        if not accumulated:
            value = math.exp(value)
        bank[SMOOTH, i] += share * (value - bank[SMOOTH, i])


@njit(cache=True)
def weigh(bank: FloatArray, samples: float) -> None:
    """Weights, of sum 1.

    Parameters
    ----------
    samples : float
        N_eff of the accumulated weighting, which takes the rows ``SMOOTH`` for logarithms; 0 for (28).
    """
    n = bank.shape[1]
    largest = -np.inf
    for i in range(n):
        largest = max(largest, bank[SMOOTH, i])
    total = 0.0
    for i in range(n):
        value = bank[SMOOTH, i] + LEAST
        if samples > 0.0:
            value = math.exp(samples * (bank[SMOOTH, i] - largest))
        bank[WEIGHT, i] = value
        total += value
    for i in range(n):
        bank[WEIGHT, i] /= total


@njit(cache=True)
def most_likely(bank: FloatArray) -> int:
    """Filter of the largest weight."""
    best = 0
    for i in range(1, bank.shape[1]):
        if bank[WEIGHT, i] > bank[WEIGHT, best]:
            best = i
    return best


@njit(cache=True)
def nearest_to_zero(bank: FloatArray) -> int:
    """Filter whose virtual offset is smallest."""
    best = 0
    for i in range(1, bank.shape[1]):
        if abs(bank[OFFSET, i]) < abs(bank[OFFSET, best]):
            best = i
    return best


@njit(cache=True)
def separation(bank: FloatArray) -> float:
    """k of 3.5: neighbouring filters have weights in the ratio exp(-k^2/2) where the middle one is right.

    Weights are about a Gauss curve of the virtual offset, whatever the true offset is: its curvature at the most likely
    filter that has two neighbours gives k for the mean distance of the three. 0 with less than three filters, and where
    a weight has vanished.
    """
    n = bank.shape[1]
    if n < 3:
        return 0.0
    i = min(max(most_likely(bank), 1), n - 2)
    low, middle, high = bank[WEIGHT, i - 1], bank[WEIGHT, i], bank[WEIGHT, i + 1]
    below, above = bank[OFFSET, i] - bank[OFFSET, i - 1], bank[OFFSET, i + 1] - bank[OFFSET, i]
    if min(low, middle, high) < 1e-250 or below <= 0.0 or above <= 0.0:
        return 0.0
    fall = (math.log(high) - math.log(middle)) / above - (math.log(middle) - math.log(low)) / below
    mean = 0.5 * (below + above)
    return math.sqrt(max(-fall * mean, 0.0))
