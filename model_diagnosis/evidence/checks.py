"""Checks of an accepted effect: manoeuvre by manoeuvre, without each manoeuvre, and by an information criterion.

Source: model discrepancy anchor, sections 3.6 and 4.3.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from model_diagnosis.evidence.quadratic import Quadratic, total, widening

FloatArray = NDArray[np.float64]

WORST_SINGLE_MANOEUVRE = -3.0
WORST_SHARE = 0.25
"""A strong effect shows form errors in some manoeuvre: it may lose this share of what it gains in all together. Where
any manoeuvre alone would prove it, none of them adds to the evidence of the others, and the sum too is that of form
errors."""

STD_ALLOWED = 4.5
"""Standard deviations of noise below its expectation that a difference may be if the effect is present: three, and half
as much again for a law that is right to some per cent."""

DRAWS = 100

EXCITED = 0.5
"""A manoeuvre excites an effect if it alone would give this expected log evidence at the size found."""


@dataclass(frozen=True)
class Consistency:
    """What each manoeuvre says of one deviation, the others held; in units of its effect width.

    Attributes
    ----------
    values, std : (m,) estimate of each manoeuvre; nan and inf where it says nothing
    statistic : sum over manoeuvres of the squared differences from the joint estimate in units of std
    """

    values: FloatArray
    std: FloatArray
    statistic: float

    @property
    def telling(self) -> int:
        """Number of manoeuvres that carry at least 5 % of the information."""
        information = np.where(np.isfinite(self.std), self.std**-2.0, 0.0)
        return int(np.sum(information > 0.05 * max(float(information.sum()), 1e-300)))


def consistency(parts: Sequence[Quadratic], scaled: FloatArray, column: int) -> Consistency:
    """Estimate of one column from each manoeuvre with all others at the joint solution ``scaled`` (p,)."""
    values, std = np.full(len(parts), np.nan), np.full(len(parts), np.inf)
    for number, part in enumerate(parts):
        own = float(part.information[column, column])
        if own <= 0.0:
            continue
        others = float(part.information[column] @ scaled) - own * scaled[column]
        values[number] = (part.score[column] - others) / own
        std[number] = own**-0.5
    said = np.isfinite(std)
    statistic = float(np.sum(((values[said] - scaled[column]) / std[said]) ** 2))
    return Consistency(values, std, statistic)


@dataclass(frozen=True)
class LeaveOneOut:
    """Gain of an effect in predicting each manoeuvre from all others.

    Attributes
    ----------
    differences : (m,) log predictive density with the effect minus without
    exciting : (m,) True where the manoeuvre excites the effect
    complete : log Bayes factor from all manoeuvres together
    least : (m,) differences that noise alone gives an effect which is present, ``STD_ALLOWED`` below the mean
    least_sum : the same of their sum
    """

    differences: FloatArray
    exciting: NDArray[np.bool_]
    complete: float
    least: FloatArray
    least_sum: float

    @property
    def gained(self) -> float:
        """Sum of the differences."""
        return float(self.differences.sum())

    @property
    def passed(self) -> bool:
        """Positive in sum but for a tenth of all, and in no exciting manoeuvre below -3 and a tenth of the sum.

        What noise does to an effect that is present is no contradiction: where a scatter is narrow, a few per cent of
        the size found change the evidence by more than all that one manoeuvre adds.
        """
        allowed = WORST_SHARE * max(self.gained, self.complete)
        lowest = np.minimum(WORST_SINGLE_MANOEUVRE - allowed, self.least)
        lowest_sum = min(-WORST_SHARE * max(self.complete, 0.0), self.least_sum)
        return self.gained > lowest_sum and not np.any((self.differences < lowest)[self.exciting])


def leave_one_out(
    parts: Sequence[Quadratic], nuisance: FloatArray, columns: Sequence[int], scaled: FloatArray
) -> LeaveOneOut:
    """Predictive log density of each manoeuvre given the others, with and without the effect, from the quadratics.

    log p(y_m | rest, effect) - log p(y_m | rest, nothing) = LBF(all) - LBF(all but m). What noise does to it if the
    effect is present as found comes from drawn data. Form errors scatter more, but they are what this check is for.
    """
    chosen = list(columns)
    added = np.maximum(1.0 - nuisance[chosen] ** 2, 0.0)
    drawn = _drawn_scores(parts, scaled)
    whole = total(parts)
    complete = _evidences(whole, nuisance, chosen, added, drawn.sum(axis=0))
    rest = [
        _evidences(whole - part, nuisance, chosen, added, drawn.sum(axis=0) - own)
        for part, own in zip(parts, drawn, strict=True)
    ]
    differences = complete - np.array(rest)
    size = scaled[chosen]
    exciting = np.array(
        [0.5 * float(size @ part.information[np.ix_(chosen, chosen)] @ size) > EXCITED for part in parts]
    )
    lowest = differences[:, 1:].mean(axis=1) - STD_ALLOWED * differences[:, 1:].std(axis=1)
    sums = differences[:, 1:].sum(axis=0)
    return LeaveOneOut(
        differences[:, 0],
        exciting,
        float(complete[0]),
        lowest,
        float(sums.mean() - STD_ALLOWED * sums.std()),
    )


def _drawn_scores(parts: Sequence[Quadratic], scaled: FloatArray) -> FloatArray:
    """Scores (m, 1 + draws, p) of each manoeuvre: the data's, then those of data with the deviations as found."""
    rng = np.random.default_rng(0)
    found = []
    for part in parts:
        values, vectors = np.linalg.eigh(part.information)
        root = vectors * np.sqrt(np.maximum(values, 0.0))
        noise = rng.standard_normal((DRAWS, len(scaled))) @ root.T
        found.append(np.vstack([part.score, part.information @ scaled + noise]))
    return np.stack(found)


def _evidences(
    whole: Quadratic, nuisance: FloatArray, columns: Sequence[int], added: FloatArray, scores: FloatArray
) -> FloatArray:
    """Log Bayes factors (n,) of widening these columns by ``added`` for each of the scores (n, p)."""
    projected, information = Quadratic(whole.information, scores.T).projected(nuisance)
    chosen = list(columns)
    block = information[np.ix_(chosen, chosen)]
    return np.array([widening(score, block, added) for score in projected[chosen].T])


def effective_bic(cost: float, parameters: int, effective_samples: float) -> float:
    """BIC_eff = -2 log L + n log N_eff, N_eff the samples over the temperature; the cost holds the scatter's prior."""
    return cost + parameters * float(np.log(max(effective_samples, 1.0)))
