"""Threshold of the evidence by parametric bootstrap, probabilities, and the size below which an effect is not seen.

Source: model discrepancy anchor, sections 3.6, 3.10 and 4.3.
"""

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from model_diagnosis.evidence.quadratic import widening

FloatArray = NDArray[np.float64]

DRAWS = 400
QUANTILE = 0.975
PRIOR_OF_NOTHING = 0.5

OUTSIDE = 0.05
"""Probability that what an effect of the catalogue explains comes from something that is in no catalogue. However large
the evidence, it compares an effect with "nothing" and with other effects only. On two seeds of the challenge that are
used up, 4 to 9 % of the causes that would be all but certain without it were wrong, look-alikes apart."""

FEW_MANOEUVRES, OF_FORM = 2, 4.0
"""Manoeuvres in which errors of the replay's form are not told from an effect by others that they do not fit, and the
log evidence that they can then add. Measured on healthy cars of the challenge's generator with one or two manoeuvres
(tuning seeds) and on drives of the bench's plant: where the bootstrap asks for 5.5, the largest were 8.8 and 7.8."""


def bootstrap_maxima(
    information: FloatArray,
    nuisance: FloatArray,
    hypotheses: Sequence[Sequence[int]],
    rng: np.random.Generator,
    draws: int = DRAWS,
) -> FloatArray:
    """Largest log Bayes factor (draws,) of data of ordinary cars, drawn from the information (p, p) directly.

    A data set enters only by b* = M theta* + M^(1/2) xi with theta* ~ N(0, diag(nuisance^2)): nothing is simulated.
    ``nuisance`` are ratios of widths to effect widths. A column that the data does not inform takes no draw: whatever
    the catalogue holds beside what the data shows, the maxima are the same.
    """
    told = np.flatnonzero(np.diag(information) > 0.0)
    place = {int(column): row for row, column in enumerate(told)}
    hypotheses = [[place[one] for one in hypothesis if one in place] for hypothesis in hypotheses]
    information, nuisance = information[np.ix_(told, told)], nuisance[told]
    values, vectors = np.linalg.eigh(information)
    root = vectors * np.sqrt(np.maximum(values, 0.0))
    size = len(nuisance)
    scores = (rng.standard_normal((draws, size)) * nuisance) @ information + rng.standard_normal((draws, size)) @ root.T
    covariance = np.linalg.inv(information + np.diag(nuisance**-2.0))
    precision = nuisance**-2.0
    projected_information = precision[:, None] * (np.eye(size) - covariance * precision[None, :])
    projected = (scores @ covariance) * precision
    added = np.maximum(1.0 - nuisance**2, 0.0)
    maxima = np.full(draws, -np.inf)
    for columns in filter(None, hypotheses):
        block = projected_information[np.ix_(columns, columns)]
        root_added = np.sqrt(added[columns])
        inner = np.eye(len(columns)) + root_added[:, None] * block * root_added[None, :]
        scaled = projected[:, columns] * root_added
        fit = 0.5 * np.einsum("ij,ij->i", scaled, np.linalg.solve(inner, scaled.T).T)
        maxima = np.maximum(maxima, fit + widening(np.zeros(len(columns)), block, added[columns]))
    return maxima


def threshold(maxima: FloatArray, parameters: int, manoeuvres: int) -> float:
    """Log Bayes factor that an effect must exceed: 97.5 % quantile, never below log 20 + log(p) / 2.

    With one or two manoeuvres it is more by what the replay's form makes of a healthy car (``OF_FORM``).
    """
    least = max(float(np.quantile(maxima, QUANTILE)), float(np.log(20.0) + 0.5 * np.log(parameters)))
    return least + (OF_FORM if manoeuvres <= FEW_MANOEUVRES else 0.0)


def probabilities(evidence: FloatArray, prior_of_nothing: float = PRIOR_OF_NOTHING) -> tuple[FloatArray, float]:
    """Posterior probability (h,) of each effect and of "nothing" from log Bayes factors (h,); equal priors.

    ``OUTSIDE`` of what the effects together have belongs to none of them.
    """
    count = max(int(np.sum(np.isfinite(evidence))), 1)
    logs = np.append(evidence + np.log((1.0 - prior_of_nothing) / count), np.log(prior_of_nothing))
    logs -= np.max(logs)
    weights = np.exp(logs)
    weights /= weights.sum()
    return (1.0 - OUTSIDE) * weights[:-1], float(weights[-1])


def detection_limits(information: FloatArray, nuisance: FloatArray, needed: float) -> FloatArray:
    """Smallest z (p,) whose expected log Bayes factor reaches ``needed``; inf where the data never shows it.

    ``information`` (p,) is the diagonal of the projected information G: with g = G z the evidence is
    G^2 z^2 a / (1 + a G) / 2 - log(1 + a G) / 2, a = 1 - nuisance^2.
    """
    added = np.maximum(1.0 - nuisance**2, 0.0)
    gain = information**2 * added / (1.0 + added * information)
    with np.errstate(divide="ignore"):
        return np.where(
            gain > 0.0, np.sqrt((2.0 * needed + np.log1p(added * information)) / np.maximum(gain, 1e-300)), np.inf
        )
