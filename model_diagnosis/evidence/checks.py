"""Checks of an accepted effect: manoeuvre by manoeuvre, without each manoeuvre, and by an information criterion.

Source: model discrepancy anchor, sections 3.6 and 4.3.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from model_diagnosis.evidence.quadratic import Quadratic, effect_evidence

FloatArray = NDArray[np.float64]

WORST_SINGLE_MANOEUVRE = -3.0
WORST_SHARE = 0.1
"""A strong effect shows form errors in some manoeuvre: it may lose this share of what it gains in all together. Where
any manoeuvre alone would prove it, none of them adds to the evidence of the others, and the sum too is that of form
errors."""

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
    """

    differences: FloatArray
    exciting: NDArray[np.bool_]
    complete: float

    @property
    def passed(self) -> bool:
        """Positive in sum but for a tenth of all, and in no exciting manoeuvre below -3 and a tenth of the sum."""
        worst = float(np.min(self.differences[self.exciting], initial=0.0))
        gained = float(self.differences.sum())
        allowed = WORST_SHARE * max(gained, self.complete)
        return gained > -WORST_SHARE * max(self.complete, 0.0) and worst >= WORST_SINGLE_MANOEUVRE - allowed


def leave_one_out(
    parts: Sequence[Quadratic], nuisance: FloatArray, columns: Sequence[int], scaled: FloatArray
) -> LeaveOneOut:
    """Predictive log density of each manoeuvre given the others, with and without the effect, from the quadratics.

    log p(y_m | rest, effect) - log p(y_m | rest, nothing) = LBF(all) - LBF(all but m).
    """
    present = np.ones(len(nuisance))
    total = parts[0]
    for part in parts[1:]:
        total = total + part
    complete = effect_evidence(total, nuisance, present, [columns])[0]
    differences = np.array(
        [complete - effect_evidence(total - part, nuisance, present, [columns])[0] for part in parts]
    )
    chosen = list(columns)
    size = scaled[chosen]
    exciting = np.array(
        [0.5 * float(size @ part.information[np.ix_(chosen, chosen)] @ size) > EXCITED for part in parts]
    )
    return LeaveOneOut(differences, exciting, float(complete))


def effective_bic(cost: float, parameters: int, effective_samples: float) -> float:
    """BIC_eff = -2 log L + n log N_eff, N_eff the samples over the temperature; the cost holds the scatter's prior."""
    return cost + parameters * float(np.log(max(effective_samples, 1.0)))
