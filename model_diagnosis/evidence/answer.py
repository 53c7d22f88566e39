"""From a selection to the causes of the answer: physical values with intervals, groups, probabilities, remarks."""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from model_diagnosis.effects.effect import EffectParameter
from model_diagnosis.evidence.checks import Consistency, consistency
from model_diagnosis.evidence.groups import SEPARATION_NEEDED
from model_diagnosis.evidence.law_errors import LAW_SHARE
from model_diagnosis.evidence.lookalikes import LookAlikes
from model_diagnosis.evidence.priors import with_commons
from model_diagnosis.evidence.replay_model import ReplayModel
from model_diagnosis.evidence.search import Search
from model_diagnosis.evidence.selection import Accepted, Selection
from model_diagnosis.result import Cause, ParameterEstimate

FloatArray = NDArray[np.float64]

INTERVAL_STD = 1.6449
"""Half width of a 90 % interval in standard deviations."""

INCONSISTENT_PER_MANOEUVRE = 6.0
"""Mean squared difference between manoeuvres, in units of their own std, beyond which a remark is made."""

LEAST_PROBABLE = 0.05
"""Probability in its own place, look-alikes included, below which an accepted effect is no cause: odds of 19 to 1
are against it."""

Physical = Callable[[int, float], tuple[float, str, float]]
"""Column and deviation to physical value, unit and nominal value."""


@dataclass(frozen=True)
class CauseDetail:
    """An accepted cause with what stands behind it.

    Attributes
    ----------
    consistency : column -> what each manoeuvre says of it
    held_out : manoeuvre -> log predictive density with the effect minus without
    """

    cause: Cause
    accepted: Accepted
    alike: LookAlikes
    consistency: Mapping[int, Consistency] = field(default_factory=dict)
    held_out: Mapping[str, float] = field(default_factory=dict)

    @property
    def is_improbable(self) -> bool:
        """True where others explain better what it explains, though none of them could be accepted."""
        return sum(self.cause.group_probabilities.values()) < LEAST_PROBABLE


def causes(search: Search, selection: Selection, alike: Sequence[LookAlikes], physical: Physical) -> list[CauseDetail]:
    """Accepted effects as causes, the most probable first."""
    problem = search.problem
    parts = problem.quadratics(selection.linearisation, problem.rows(selection.fit.theta), selection.fit.theta)
    std = problem.scale.copy()
    for one in selection.accepted:
        std[list(one.hypothesis.columns)] *= np.sqrt(np.diag(one.direction.covariance))
    scaled = problem.scaled(selection.fit.theta)
    deviations = with_commons(selection.fit.theta, problem.replay.parameters)
    names = [manoeuvre.name for manoeuvre in problem.replay.manoeuvres]
    found = []
    for accepted, other in zip(selection.accepted, alike, strict=True):
        if accepted.hypothesis.value is not None:
            std[list(accepted.hypothesis.columns)] = 0.0  # stated by the hypothesis, not estimated
        effect = problem.replay.effects[accepted.hypothesis.effect]
        agreement = {column: consistency(parts, scaled, column) for column in accepted.hypothesis.columns}
        own = {column: problem.replay.parameters[column] for column in accepted.hypothesis.columns}
        estimates = {
            parameter.name: _estimate(physical, column, deviations[column], std[column], parameter)
            for column, parameter in own.items()
        }
        at_end = [
            parameter.name
            for column, parameter in own.items()
            if accepted.hypothesis.value is None and _is_at_end(deviations[column], parameter)
        ]
        held_out = dict(zip(names, (float(value) for value in accepted.held_out.differences), strict=True))
        group = [problem.replay.effects[number].name for number in other.group]
        cause = Cause(
            effect=effect.name,
            probability=float(other.probability[accepted.hypothesis.effect]),
            parameters=estimates,
            group=group,
            group_probabilities={
                problem.replay.effects[number].name: float(other.probability[number]) for number in other.group
            },
            equation=effect.equation,
            evidence=float(accepted.evidence),
            remarks=[
                *(f"{name} is at the end of its range: the cause is larger, or another" for name in at_end),
                *_remarks(agreement, accepted, names),
                *_alike(other, problem.replay),
            ],
        )
        found.append(CauseDetail(cause, accepted, other, agreement, held_out))
    # a cause that shares its probability with a look-alike is no less certain for that
    return sorted(found, key=lambda one: (-round(sum(one.cause.group_probabilities.values()), 2), -one.cause.evidence))


def _estimate(
    physical: Physical, column: int, deviation: float, std: float, parameter: EffectParameter
) -> ParameterEstimate:
    value, unit, nominal = physical(column, deviation)
    std = float(np.hypot(std, LAW_SHARE * deviation)) if std > 0.0 else 0.0
    # what both axles have in common may lie on top of a deviation that is at its bound
    low, high = min(parameter.low, deviation), max(parameter.high, deviation)
    ends = sorted(
        physical(column, float(np.clip(deviation + side * INTERVAL_STD * std, low, high)))[0] for side in (-1.0, 1.0)
    )
    return ParameterEstimate(value=value, low=ends[0], high=ends[1], unit=unit, nominal=nominal)


def _is_at_end(deviation: float, parameter: EffectParameter) -> bool:
    """True where only its bound, which is not the neutral value, keeps a deviation; a place may end where it will."""
    return deviation != 0.0 and not parameter.places and not parameter.low < deviation < parameter.high


def _alike(other: LookAlikes, replay: ReplayModel) -> list[str]:
    remarks = []
    for member, correlation in other.correlations.items():
        name, expected = replay.effects[member].name, other.separations.get(member)
        if expected is None:
            continue
        if expected < SEPARATION_NEEDED:
            told = (
                f"looks the same: canonical correlation {correlation:.3f}, {expected:.1f} expected to tell them apart"
            )
        else:
            told = f"explains this data as well, though {expected:.1f} of log evidence should tell them apart"
        remarks.append(f"{name} {told}")
    return remarks


def _remarks(agreement: Mapping[int, Consistency], accepted: Accepted, names: Sequence[str]) -> list[str]:
    remarks = []
    for one in agreement.values():
        if one.telling <= 1:
            carrier = names[int(np.nanargmin(np.where(np.isfinite(one.std), one.std, np.inf)))]
            remarks.append(f"carried by one manoeuvre only: {carrier}")
        said = int(np.sum(np.isfinite(one.std)))
        if said > 1 and one.statistic > INCONSISTENT_PER_MANOEUVRE * (said - 1):
            worst = int(np.nanargmax(np.abs((one.values - np.nanmedian(one.values)) / one.std)))
            remarks.append(f"manoeuvres differ on its size, {names[worst]} the most")
    differences = accepted.held_out.differences
    if accepted.held_out.exciting.any() and float(np.min(differences)) < 0.0:
        remarks.append(f"does not help to predict {names[int(np.argmin(differences))]}")
    return list(dict.fromkeys(remarks))
