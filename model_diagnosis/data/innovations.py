"""Innovations: what of a residual its own past does not predict."""

from collections.abc import Sequence

import numpy as np

from model_diagnosis.data.samples import BoolArray, FloatArray

_ORDER = 4


def log_innovation(residual: FloatArray, present: BoolArray) -> float:
    """N log σ of what an autoregression of order 4 cannot predict, over samples with all four before them."""
    if present.sum() < 50:
        return 0.0
    values = np.where(present, residual, 0.0)
    lagged = np.stack([values[_ORDER - k - 1 : len(values) - k - 1] for k in range(_ORDER)], axis=1)
    rows = np.all(np.stack([present[_ORDER - k : len(values) - k] for k in range(_ORDER + 1)]), axis=0)
    if rows.sum() < 50:  # a slow channel: its samples stand alone
        return float(present.sum() * np.log(np.std(residual[present]) + 1e-12))
    design, target = lagged[rows], values[_ORDER:][rows]
    if not target.any():  # a replay that is driven by the channel itself says nothing of it
        return 0.0
    coefficients = np.linalg.solve(design.T @ design + 1e-5 * np.eye(_ORDER) * np.mean(target**2), design.T @ target)
    return float(present.sum() * np.log(np.std(target - design @ coefficients) + 1e-12))


def total_log_innovation(residuals: Sequence[FloatArray], weights: Sequence[FloatArray]) -> float:
    """Σ N log σ of all signals of some manoeuvres, residuals and weights (n, c) of each."""
    return sum(
        log_innovation(residual[:, k], weight[:, k] > 0.0)
        for residual, weight in zip(residuals, weights, strict=True)
        for k in range(residual.shape[1])
    )
