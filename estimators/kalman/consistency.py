"""Consistency of a filter: are its errors as large as it says?

Bar-Shalom, Li, Kirubarajan, Estimation with Applications to Tracking and Navigation, 5.4.
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray


def normalised_estimation_error(error: ArrayLike, covariance: ArrayLike) -> NDArray[np.float64]:
    """NEES: e' P^-1 e, for errors of shape (..., n) and covariances of shape (..., n, n)."""
    e = np.asarray(error, dtype=np.float64)
    p = np.asarray(covariance, dtype=np.float64)
    solved = np.linalg.solve(p, e[..., None])[..., 0]
    result: NDArray[np.float64] = np.sum(e * solved, axis=-1)
    return result


@dataclass(frozen=True)
class Consistency:
    """Mean of a chi-square statistic over runs and the band in which it lies if the filter is consistent."""

    mean: float
    low: float
    high: float

    @property
    def inside(self) -> bool:
        """True if the mean lies in the band."""
        return self.low <= self.mean <= self.high


def chi_square_band(statistic: ArrayLike, degrees: int, probability: float = 0.95) -> Consistency:
    """Mean of independent NEES or NIS values of ``degrees`` degrees of freedom, with its band."""
    from scipy.stats import chi2

    values = np.asarray(statistic, dtype=np.float64).ravel()
    total = len(values) * degrees
    tail = 0.5 * (1.0 - probability)
    low, high = chi2.ppf([tail, 1.0 - tail], total) / len(values)
    return Consistency(float(values.mean()), float(low), float(high))
