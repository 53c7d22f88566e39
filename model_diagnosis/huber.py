"""Huber's loss: squares of ordinary residuals, straight beyond, so that an outlier counts once."""

import numpy as np
from numpy.typing import NDArray

FloatArray = NDArray[np.float64]

HUBER_LIMIT = 3.0
"""Standard deviations from which a residual counts less."""


def huber_weights(whitened: FloatArray) -> FloatArray:
    """Weights of iteratively reweighted least squares with Huber's loss."""
    return np.minimum(1.0, HUBER_LIMIT / np.maximum(np.abs(whitened), 1e-12))


def huber_loss(whitened: FloatArray) -> float:
    """Sum of Huber's loss, scaled so that it is the sum of squares within the limit."""
    size = np.abs(whitened)
    return float(np.sum(np.where(size <= HUBER_LIMIT, size**2, HUBER_LIMIT * (2.0 * size - HUBER_LIMIT))))
