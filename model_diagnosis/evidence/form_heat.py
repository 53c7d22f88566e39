"""How much more an effect's own direction scatters than the noise model lets it, and what is left of its evidence then.

The temperature of the whitening is the median over all columns. A wrong form scatters the scores of a few: steady turns
those of the steering, one stop those of the pads. What the data says of such an effect is worth less by that factor
(Kent, Robust properties of likelihood ratio tests, Biometrika 69 (1982) 19: where the model is wrong, likelihood ratios
follow the ratio of the scores' variance to the information; Chandler and Bate, Biometrika 94 (2007) 167, for clusters).
The prior is worth as much as before: an effect far beyond its scatter in exact data stays as it is.
"""

from collections.abc import Iterable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from model_diagnosis.evidence.fitting import Linearisation, Problem
from model_diagnosis.evidence.whitening import scatter

FloatArray = NDArray[np.float64]

BLOCK_SAMPLES = (50, 100, 200)
"""Blocks of 0.5, 1 and 2 s: form errors last as long as what a driver does."""


@dataclass(frozen=True)
class OwnDirection:
    """What the data says of some deviations beside all others, in units of their effect widths.

    Attributes
    ----------
    size : (k,) deviations found
    information : (k, k) of the data, the other columns projected out
    heat : factor by which block sums of the direction's score scatter more than white innovations, at least 1
    before, after : (k,) prior widths without and with the hypothesis
    """

    size: FloatArray
    information: FloatArray
    heat: float
    before: FloatArray
    after: FloatArray

    def tempered(self, cost_gained: float) -> float:
        """Log Bayes factor where the fits' costs differ by ``cost_gained``, with the data worth less by the heat."""
        cold, warm = self._expected_gain(1.0), self._expected_gain(self.heat)
        share = warm / cold if cold > 0.0 else 1.0
        return 0.5 * share * cost_gained + self._occam(self.heat)

    @property
    def covariance(self) -> FloatArray:
        """Posterior covariance (k, k) of the deviations with the hypothesis' widths."""
        return np.asarray(np.linalg.inv(self.information / self.heat + np.diag(self.after**-2.0)))

    def _expected_gain(self, heat: float) -> float:
        """Twice the log likelihood that the wider prior gains at its best: u'((S + A)^-1 - (S + B)^-1) u."""
        information = self.information / heat
        score = (self.information + np.diag(self.after**-2.0)) @ self.size / heat
        wide = np.linalg.solve(information + np.diag(self.after**-2.0), score)
        narrow = np.linalg.solve(information + np.diag(self.before**-2.0), score)
        return float(score @ (wide - narrow))

    def _occam(self, heat: float) -> float:
        return 0.5 * (self._volume(self.before, heat) - self._volume(self.after, heat))

    def _volume(self, widths: FloatArray, heat: float) -> float:
        inner = np.eye(len(widths)) + widths[:, None] * self.information * widths[None, :] / heat
        return float(np.linalg.slogdet(inner)[1])


def own_direction(
    problem: Problem,
    linearisation: Linearisation,
    theta: FloatArray,
    columns: Iterable[int],
    before: FloatArray,
    after: FloatArray,
) -> OwnDirection:
    """Direction in which some columns lie at a fit, and its heat there.

    Parameters
    ----------
    theta : (p,) the fit with the hypothesis, whose residuals are looked at
    before, after : (p,) prior widths of all columns without and with the hypothesis, in units of the effect widths
    """
    chosen = [int(column) for column in columns]
    others = [column for column in range(len(theta)) if column not in set(chosen)]
    information = linearisation.information
    explained = np.linalg.solve(
        information[np.ix_(others, others)] + np.diag(after[others] ** -2.0), information[np.ix_(others, chosen)]
    )
    projected = information[np.ix_(chosen, chosen)] - information[np.ix_(chosen, others)] @ explained
    size = problem.scaled(theta)[chosen]
    direction = np.zeros(len(theta))
    direction[chosen] = size if size.any() else 1.0
    direction[others] = -explained @ direction[chosen]
    return OwnDirection(
        size,
        0.5 * (projected + projected.T),
        heat_of(problem, linearisation, theta, direction),
        before[chosen],
        after[chosen],
    )


def heat_of(problem: Problem, linearisation: Linearisation, theta: FloatArray, direction: FloatArray) -> float:
    """Mean over the block lengths of the ratio of the scores' scatter to the information, at least 1."""
    rows = problem.rows(theta)
    seen = [matrix @ direction[:, None] for matrix in linearisation.matrices]
    ratios = []
    for samples in BLOCK_SAMPLES:
        observed, expected = scatter(rows, seen, problem.whitener.blocks(samples))
        ratios.append(float(observed[0] / expected[0]) if expected[0] > 0.0 else 0.0)
    return max(1.0, float(np.mean(ratios)) / problem.whitener.temperature)
