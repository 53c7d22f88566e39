"""What a step of the forward selection knows: hypotheses accepted, fits, refits, and the evidence of the rest.

Source: model discrepancy anchor, sections 3.5 and 3.6.
"""

from collections.abc import Sequence
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from model_diagnosis.evidence.fitting import Fit, Linearisation, Problem
from model_diagnosis.evidence.hypotheses import Hypothesis
from model_diagnosis.evidence.quadratic import Quadratic, effect_evidence

FloatArray = NDArray[np.float64]

SWAP_GAIN = 1.0
"""Log evidence that a swap has to gain: a fit by chords ends some units of cost, twice as many, above its minimum."""


@dataclass(frozen=True)
class Candidate:
    """A hypothesis worth a refit and the points to start it from."""

    hypothesis: Hypothesis
    starts: tuple[FloatArray, ...]


@dataclass(frozen=True)
class Refit:
    """A refitted hypothesis, its evidence against the answer without it, and each manoeuvre's quadratic at its fit."""

    hypothesis: Hypothesis
    fit: Fit
    evidence: float
    parts: list[Quadratic]


@dataclass
class Stage:
    """One step of the forward selection: what is accepted already, its fit, and what all others would add.

    Attributes
    ----------
    accepted : hypotheses taken as present
    nothing_more : fit with these alone
    linearisation : sensitivities at that fit
    linear : (h,) evidence of every hypothesis from the sensitivities alone
    refits : by hypothesis
    """

    accepted: tuple[Hypothesis, ...]
    nothing_more: Fit
    linearisation: Linearisation
    linear: FloatArray
    refits: list[Refit] = field(default_factory=list)

    @property
    def best(self) -> Refit | None:
        """Refit with the largest evidence."""
        return max(self.refits, key=lambda refit: refit.evidence, default=None)


def present_columns(accepted: Sequence[Hypothesis]) -> tuple[int, ...]:
    """Columns of all accepted hypotheses."""
    return tuple(sorted({column for hypothesis in accepted for column in hypothesis.columns}))


def fixed_columns(accepted: Sequence[Hypothesis]) -> tuple[int, ...]:
    """Columns whose value a discrete hypothesis states."""
    return tuple(column for hypothesis in accepted if hypothesis.value is not None for column in hypothesis.columns)


def with_values(theta: FloatArray, accepted: Sequence[Hypothesis]) -> FloatArray:
    """Theta with the values that discrete hypotheses state."""
    changed = theta.copy()
    for hypothesis in accepted:
        if hypothesis.value is not None:
            changed[list(hypothesis.columns)] = hypothesis.value
    return changed


def ratios(problem: Problem, accepted: Sequence[Hypothesis]) -> FloatArray:
    """Prior widths (p,) over effect widths with the accepted hypotheses present."""
    return problem.priors.widths(present_columns(accepted)) / problem.scale


def linear_evidence(
    problem: Problem,
    quadratic: Quadratic,
    hypotheses: Sequence[Hypothesis],
    accepted: Sequence[Hypothesis] = (),
) -> FloatArray:
    """Evidence (h,) of each hypothesis beside the accepted ones, from one linearisation."""
    return effect_evidence(
        quadratic, ratios(problem, accepted), np.ones(len(problem.scale)), [one.columns for one in hypotheses]
    )


def smaller_than_named(problem: Problem, hypothesis: Hypothesis, theta: FloatArray) -> str:
    """What a deviation in theta (p,) is too small for to be a cause, in words; "" where none is."""
    for column in hypothesis.columns:
        parameter = problem.replay.parameters[column]
        size = abs(float(theta[column] - problem.priors.centre[column]))
        if size < parameter.least_named:
            return f"{parameter.name} of {size:.3g}, and below {parameter.least_named:g} it is no cause"
    return ""
