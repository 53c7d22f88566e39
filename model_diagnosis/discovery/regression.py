"""Forward orthogonal regression with forced columns (Chen, Billings & Luo 1989): how much each candidate would explain.

Everything is orthogonal to the forced columns and the terms already chosen, so that a candidate is paid only for what
mass, drag, rolling and the forces' scales cannot explain.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

FloatArray = NDArray[np.float64]

_COLLINEAR = 1e-3
"""Share of a column's own square that has to be left of it; less is what the forced columns say already."""


def orthonormal(columns: FloatArray) -> FloatArray:
    """Orthonormal basis (N, rank) of columns (N, d)."""
    scale = np.linalg.norm(columns, axis=0)
    used = columns[:, scale > 0.0] / scale[scale > 0.0]
    if used.shape[1] == 0:
        return np.zeros((len(columns), 0))
    left, singular, _ = np.linalg.svd(used, full_matrices=False)
    return left[:, singular > 1e-8 * singular[0]]


def without(basis: FloatArray, columns: FloatArray) -> FloatArray:
    """Columns (N, d) or (N,) less their part in an orthonormal basis."""
    return columns - basis @ (basis.T @ columns)


@dataclass(frozen=True)
class Pool:
    """Columns of many candidates side by side.

    Attributes
    ----------
    columns : (N, total), rows weighted
    starts : first column of each candidate; one more at the end
    """

    columns: FloatArray
    starts: NDArray[np.int64]

    @classmethod
    def of(cls, parts: Sequence[FloatArray]) -> "Pool":
        """Pool of the candidates' columns."""
        starts = np.concatenate([[0], np.cumsum([part.shape[1] for part in parts])]).astype(np.int64)
        return cls(np.concatenate(list(parts), axis=1) if parts else np.zeros((0, 0)), starts)

    def project(self, basis: FloatArray) -> tuple["Pool", NDArray[np.bool_]]:
        """The pool orthogonal to a basis, and which candidates have something left."""
        left = without(basis, self.columns)
        before, after = (self.columns**2).sum(axis=0), (left**2).sum(axis=0)
        alive = after > _COLLINEAR * np.maximum(before, 1e-300)
        usable = np.array([alive[a:b].all() for a, b in zip(self.starts[:-1], self.starts[1:], strict=True)], bool)
        return Pool(left, self.starts), usable

    def explained(self, residual: FloatArray) -> FloatArray:
        """Drop of the squared residual (already orthogonal to the basis) that each candidate would bring."""
        drops = (residual @ self.columns) ** 2 / np.maximum((self.columns**2).sum(axis=0), 1e-300)
        result = drops[self.starts[:-1]].copy()
        for number in np.flatnonzero(np.diff(self.starts) > 1):
            columns = self.columns[:, self.starts[number] : self.starts[number + 1]]
            result[number] = float(((orthonormal(columns).T @ residual) ** 2).sum())
        return result


def fit(columns: FloatArray, target: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Least-squares coefficients (d,) of columns (N, d), and the residual (N,)."""
    scale = np.maximum(np.linalg.norm(columns, axis=0), 1e-300)
    coefficients = np.linalg.lstsq(columns / scale, target, rcond=1e-10)[0] / scale
    return coefficients, target - columns @ coefficients


def predicted_squared_error(
    squares: float, largest_variance: float, terms: float, samples: float, effective: float
) -> float:
    """Predicted squared error of a fit (Klein & Morelli 2006): mean square plus a penalty for each fitted number.

    Parameters
    ----------
    squares : sum of squared residuals over ``samples``
    largest_variance : of the target before any term, which bounds the noise from above
    effective : number of independent samples
    """
    return squares / samples + largest_variance * terms / effective
