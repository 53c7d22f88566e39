"""Groups of effects that this data cannot tell apart at this size.

Source: model discrepancy anchor, section 3.7.
"""

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

FloatArray = NDArray[np.float64]

SEPARATION_NEEDED = 3.0
"""Expected log evidence that tells two causes apart."""

RIDGE = 1e-9


def canonical_correlation(information: FloatArray, first: Sequence[int], second: Sequence[int]) -> float:
    """Largest canonical correlation of two effects' projected sensitivities; 1 where they cannot be told apart."""
    left = _inverse_root(information[np.ix_(first, first)])
    right = _inverse_root(information[np.ix_(second, second)])
    across = left @ information[np.ix_(first, second)] @ right
    return float(np.clip(np.linalg.svd(across, compute_uv=False)[0], 0.0, 1.0))


def separation(information: FloatArray, size: FloatArray, first: Sequence[int], second: Sequence[int]) -> float:
    """Expected log evidence for ``first`` against ``second`` if ``first`` is true with deviations ``size``.

    size' (G_ii - G_ij G_jj^-1 G_ji) size / 2, for single deviations theta^2 G_ii (1 - rho^2) / 2.
    """
    own = information[np.ix_(first, first)]
    across = information[np.ix_(first, second)]
    other = information[np.ix_(second, second)]
    ridge = RIDGE * max(float(np.trace(other)) / len(second), 1e-300)
    explained = across @ np.linalg.solve(other + ridge * np.eye(len(second)), across.T)
    return max(0.0, 0.5 * float(size @ (own - explained) @ size))


def _inverse_root(block: FloatArray) -> FloatArray:
    values, vectors = np.linalg.eigh(0.5 * (block + block.T))
    floor = RIDGE * max(float(values.max(initial=0.0)), 1e-300)
    roots = np.where(values > floor, 1.0 / np.sqrt(np.maximum(values, floor)), 0.0)
    return (vectors * roots) @ vectors.T
