"""The log likelihood as a quadratic form, and the evidence of every effect from it.

Source: model discrepancy anchor, section 3.5. Deviations are scaled by their effect width around the prior's centre,
z = (theta - centre) / e, so that a prior is a vector of ratios of width to effect width.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.linalg import cho_factor, cho_solve

FloatArray = NDArray[np.float64]


@dataclass(frozen=True)
class Quadratic:
    """Log likelihood b'z - z'Mz/2 (and a constant) of scaled deviations z (p,); of several data sets b is (p, n)."""

    information: FloatArray
    score: FloatArray

    def posterior(self, ratios: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Mean (p,) and covariance (p, p) of z under the prior N(0, diag(ratios^2))."""
        factor = cho_factor(self.information + np.diag(ratios**-2.0))
        covariance = cho_solve(factor, np.eye(len(ratios)))
        return covariance @ self.score, covariance

    def log_evidence(self, ratios: FloatArray) -> float:
        """Log marginal likelihood under the prior N(0, diag(ratios^2)), without the likelihood's own constant."""
        factor = cho_factor(self.information + np.diag(ratios**-2.0))
        log_determinant = 2.0 * float(np.sum(np.log(np.diag(factor[0]))))
        fit = float(self.score @ cho_solve(factor, self.score))
        return 0.5 * fit - 0.5 * log_determinant - float(np.sum(np.log(ratios)))

    def projected(self, ratios: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Score g (p,) and information G (p, p) of each deviation once the prior's nuisance is projected out.

        g = D^-1 C b and G = D^-1 - D^-1 C D^-1 with C = (M + D^-1)^-1 and D = diag(ratios^2), which equal
        J'V^-1 r and J'V^-1 J with V = I + J D J'.
        """
        precision = ratios**-2.0
        mean, covariance = self.posterior(ratios)
        # M - M C M loses digits where M is large, I - C D^-1 = C M does not
        left = np.eye(len(ratios)) - covariance * precision[None, :]
        information = precision[:, None] * left
        return (precision * mean.T).T, 0.5 * (information + information.T)

    def __add__(self, other: "Quadratic") -> "Quadratic":
        return Quadratic(self.information + other.information, self.score + other.score)

    def __sub__(self, other: "Quadratic") -> "Quadratic":
        return Quadratic(self.information - other.information, self.score - other.score)


def total(parts: Sequence[Quadratic]) -> Quadratic:
    """Sum over manoeuvres."""
    return Quadratic(
        np.sum([part.information for part in parts], axis=0), np.sum([part.score for part in parts], axis=0)
    )


def widening(score: FloatArray, information: FloatArray, added: FloatArray) -> float:
    """Log Bayes factor of adding the variances ``added`` (k,) to k deviations with projected g (k,) and G (k, k).

    For one deviation it is g^2 a / (1 + a G) / 2 - log(1 + a G) / 2.
    """
    root = np.sqrt(added)
    inner = np.eye(len(added)) + root[:, None] * information * root[None, :]
    sign, log_determinant = np.linalg.slogdet(inner)
    if sign <= 0.0:
        return -np.inf
    scaled = root * score
    return 0.5 * float(scaled @ np.linalg.solve(inner, scaled)) - 0.5 * float(log_determinant)


def effect_evidence(
    quadratic: Quadratic, nuisance: FloatArray, present: FloatArray, hypotheses: Sequence[Sequence[int]]
) -> FloatArray:
    """Log Bayes factors (h,) of widening each hypothesis' columns from ``nuisance`` to ``present`` ratios (p,)."""
    score, information = quadratic.projected(nuisance)
    added = np.maximum(present**2 - nuisance**2, 0.0)
    return np.array(
        [
            widening(score[list(columns)], information[np.ix_(columns, columns)], added[list(columns)])
            for columns in hypotheses
        ]
    )
