"""Sensitivities of a fit: those of one point, mended by what its steps did."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from model_diagnosis.evidence.side_by_side import side_by_side

FloatArray = NDArray[np.float64]

FORESEEN = 0.1
"""Share of what a step should have done to the residuals by which it may do otherwise without teaching anything."""


@dataclass(frozen=True)
class ShortMatrix:
    """Sensitivities of one manoeuvre with seven digits, more than a finite difference has, where they are any.

    Attributes
    ----------
    columns : (q,) of those that act in this manoeuvre
    values : (N_m, q)
    """

    columns: NDArray[np.int64]
    values: NDArray[np.float32]

    @classmethod
    def of(cls, matrix: FloatArray) -> "ShortMatrix":
        """The columns of a matrix (N_m, p) that are not 0 throughout."""
        columns = np.flatnonzero(matrix.any(axis=0))
        return cls(columns, matrix[:, columns].astype(np.float32))

    def slope(self, row: FloatArray) -> NDArray[np.float32]:
        """J'r (q,) of a row (N_m,)."""
        return row.astype(np.float32) @ self.values

    def change(self, step: FloatArray) -> FloatArray:
        """J s (N_m,) of a step (p,)."""
        return (self.values @ step[self.columns].astype(np.float32)).astype(np.float64)


class Chords:
    """Slope and curvature of a cost by sensitivities that learn from every step (Broyden 1965).

    After a step s that should have changed the residuals by -J s, and did so by u less, J <- J + u s'/(s's): the
    smallest change of J with which the step would have been foreseen. A replay's sensitivities cost as much as a
    hundred replays; along the few directions that a fit goes, its own steps tell them for nothing.

    Parameters
    ----------
    matrices : (N_m, p) per manoeuvre, whitened sensitivities at one point
    weights : (N_m,) per manoeuvre, Huber's at that point
    information : (p, p) J'WJ / temperature there
    precision : (p,) of the prior
    temperature : divides every quadratic form

    Attributes
    ----------
    curvature : (p, p) half the cost's second derivative
    """

    def __init__(
        self,
        matrices: Sequence[ShortMatrix],
        weights: Sequence[FloatArray],
        information: FloatArray,
        precision: FloatArray,
        temperature: float,
    ) -> None:
        self._matrices, self._weights, self._temperature = matrices, weights, temperature
        self._missed: list[list[FloatArray]] = []
        self._along: list[FloatArray] = []
        self.curvature = information + np.diag(precision)

    def slope(self, weighted: Sequence[FloatArray]) -> FloatArray:
        """J'r / temperature (p,) of weighted residuals (N_m,) per manoeuvre."""
        total = np.zeros(len(self.curvature))
        slopes = side_by_side(lambda m: self._matrices[m].slope(weighted[m]), len(weighted))
        for matrix, slope in zip(self._matrices, slopes, strict=True):
            total[matrix.columns] += slope
        for missed, along in zip(self._missed, self._along, strict=True):
            total = total + along * sum(float(u @ row) for u, row in zip(missed, weighted, strict=True))
        return total / self._temperature

    def learn(self, step: FloatArray, before: Sequence[FloatArray], after: Sequence[FloatArray]) -> bool:
        """Mend the sensitivities by the residuals (N_m,) before and after a step (p,); True if there was need to."""
        length = float(step @ step)
        if length == 0.0 or not all(np.isfinite(row).all() for row in after):
            return False
        foreseen = self._change(step)
        missed = [first - last - one for first, last, one in zip(before, after, foreseen, strict=True)]
        if self._size(missed) <= FORESEEN**2 * self._size(foreseen):
            return False
        along = step / length
        slope = self.slope([weight * u for weight, u in zip(self._weights, missed, strict=True)])
        mixed = np.outer(along, slope)
        self.curvature = (
            self.curvature + mixed + mixed.T + np.outer(along, along) * (self._size(missed) / self._temperature)
        )
        self._missed.append(missed)
        self._along.append(along)
        return True

    def _change(self, step: FloatArray) -> list[FloatArray]:
        """J s (N_m,) per manoeuvre."""
        change = side_by_side(lambda m: self._matrices[m].change(step), len(self._matrices))
        for missed, along in zip(self._missed, self._along, strict=True):
            share = float(along @ step)
            change = [one + share * u for one, u in zip(change, missed, strict=True)]
        return change

    def _size(self, rows: Sequence[FloatArray]) -> float:
        return sum(float(weight @ row**2) for weight, row in zip(self._weights, rows, strict=True))
