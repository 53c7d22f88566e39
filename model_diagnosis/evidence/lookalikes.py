"""Look-alikes of an accepted effect, refitted in its place, and the probabilities of all of them.

Source: model discrepancy anchor, section 3.7: the group of the winner is every effect with an expected separation below
3 at the winner's size and an evidence, after refit, less than 3 below the winner's. Beyond it, one that says as much as
the winner is in the group too, whatever was to be expected: this data did not tell them apart.
"""

from collections.abc import Collection, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from model_diagnosis.evidence.fitting import Fit
from model_diagnosis.evidence.groups import SEPARATION_NEEDED, canonical_correlation, separation
from model_diagnosis.evidence.hypotheses import Hypothesis, by_effect
from model_diagnosis.evidence.quadratic import Quadratic, total
from model_diagnosis.evidence.search import Search
from model_diagnosis.evidence.selection import Accepted, Selection
from model_diagnosis.evidence.stage import SWAP_GAIN, linear_evidence, ratios, smaller_than_named
from model_diagnosis.evidence.threshold import probabilities

FloatArray = NDArray[np.float64]

REFITTED = 6
"""Look-alikes refitted at most, those with the least expected separation first; and as many rivals by evidence."""


@dataclass(frozen=True)
class InPlace:
    """An effect refitted in the place of an accepted one: the best of its hypotheses.

    Attributes
    ----------
    evidence : log Bayes factor
    by_data : what the data says for it against the accepted one, with whatever all else does to suit it: the
        probability of its own size and Occam's factor left out
    theta : (p,) of the fit
    """

    hypothesis: Hypothesis
    evidence: float
    by_data: float
    theta: FloatArray


@dataclass(frozen=True)
class LookAlikes:
    """An accepted effect among those that could stand in its place.

    Attributes
    ----------
    group : effects not distinguishable from it on this data, itself first
    evidence : (effects,) log Bayes factor of each effect in its place; refitted where that matters, else linear
    probability : (effects,) of each in its place
    nothing : probability of none of them
    separations : effect -> expected log evidence that tells it from the accepted one
    correlations : member of the group -> largest canonical correlation with the accepted one
    refitted : member of the group -> its refit
    """

    group: tuple[int, ...]
    evidence: FloatArray
    probability: FloatArray
    nothing: float
    separations: dict[int, float]
    correlations: dict[int, float]
    refitted: dict[int, InPlace]

    @property
    def leader(self) -> InPlace | None:
        """The most probable member of the group if it is clearly more probable than the accepted one and fits as well:
        one that is grouped because no data tells the two apart may have a form that is wrong here."""
        own = self.group[0]
        best = self.refitted.get(max(self.group, key=lambda effect: float(self.probability[effect])))
        if best is None or self.evidence[own] - best.evidence >= SEPARATION_NEEDED:
            return None
        clearly = np.exp(SWAP_GAIN) * self.probability[own]
        return best if self.probability[best.hypothesis.effect] > clearly else None


def look_alikes(
    search: Search,
    selection: Selection,
    accepted: Accepted,
    forced: Sequence[int] = (),
) -> LookAlikes:
    """Group and probabilities of one accepted effect; ``forced`` effects are grouped whatever the data says."""
    problem = search.problem
    own = accepted.hypothesis
    rest = [one.hypothesis for one in selection.accepted if one.hypothesis is not own]
    parts = problem.quadratics(selection.linearisation, problem.rows(selection.fit.theta), selection.fit.theta)
    quadratic = total(parts)
    evidence = _evidence_in_place(search, quadratic, rest, selection)
    evidence[own.effect] = accepted.evidence
    separations = _separations(search, quadratic, rest, own, selection.fit.theta)
    close = sorted(
        (effect for effect, value in separations.items() if value < SEPARATION_NEEDED), key=lambda one: separations[one]
    )
    group, refitted = [own.effect], {}
    for effect in dict.fromkeys([*forced, *close[:REFITTED]]):
        refit = _refitted(search, selection, quadratic, rest, effect, accepted)
        evidence[effect] = -np.inf if refit is None else refit.evidence
        if effect in forced or accepted.evidence - evidence[effect] < SEPARATION_NEEDED:
            group.append(effect)
            if refit is None:
                continue
            refitted[effect] = refit
            # two laws that the data does not tell apart fit a wrong form differently well by chance: what it says
            # beyond what it can tell at this size is that form's, and all of it where no data of these channels tells
            # the two apart; sizes that an effect seldom has still count
            told = 0.0 if effect in forced else separations.get(effect, np.inf)
            evidence[effect] += float(np.clip(refit.by_data, -told, told)) - refit.by_data
    for effect in _rivals(evidence, accepted, {*group, *forced, *close[:REFITTED]}):
        refit = _refitted(search, selection, quadratic, rest, effect, accepted)
        evidence[effect] = -np.inf if refit is None else refit.evidence
        if refit is not None and abs(accepted.evidence - refit.evidence) < SEPARATION_NEEDED:
            group.append(effect)
            refitted[effect] = refit
    probability, nothing = probabilities(evidence)
    alike = _correlations(search, quadratic, rest, own, group[1:])
    return LookAlikes(tuple(group), evidence, probability, nothing, separations, alike, refitted)


def _rivals(evidence: FloatArray, accepted: Accepted, known: Collection[int]) -> list[int]:
    """Effects that sensitivities alone put near or above an accepted one: far from it they promise too much."""
    order = [int(effect) for effect in np.argsort(-evidence) if int(effect) not in known]
    return [effect for effect in order[:REFITTED] if accepted.evidence - evidence[effect] < SEPARATION_NEEDED]


def _correlations(
    search: Search, quadratic: Quadratic, rest: Sequence[Hypothesis], own: Hypothesis, others: Sequence[int]
) -> dict[int, float]:
    """Largest canonical correlation of the accepted effect with each of the others, over their hypotheses."""
    _, information = quadratic.projected(ratios(search.problem, rest))
    found: dict[int, float] = {}
    for hypothesis in search.hypotheses:
        if hypothesis.effect in others:
            value = canonical_correlation(information, own.columns, hypothesis.columns)
            found[hypothesis.effect] = max(value, found.get(hypothesis.effect, 0.0))
    return found


def _evidence_in_place(
    search: Search, quadratic: Quadratic, rest: Sequence[Hypothesis], selection: Selection
) -> FloatArray:
    """Linear evidence of every effect beside ``rest``, replaced by refits made in the same company."""
    effects = len(search.problem.replay.effects)
    linear = by_effect(search.hypotheses, linear_evidence(search.problem, quadratic, search.hypotheses, rest), effects)
    for stage in selection.stages:
        if set(stage.accepted) == set(rest):
            for effect in {refit.hypothesis.effect for refit in stage.refits}:
                linear[effect] = max(one.evidence for one in stage.refits if one.hypothesis.effect == effect)
    for hypothesis in rest:
        linear[hypothesis.effect] = -np.inf
    return linear


def _separations(
    search: Search, quadratic: Quadratic, rest: Sequence[Hypothesis], own: Hypothesis, theta: FloatArray
) -> dict[int, float]:
    """Expected log evidence of the accepted effect against each other one, at its size."""
    problem = search.problem
    _, information = quadratic.projected(ratios(problem, rest))
    size = problem.scaled(theta)[list(own.columns)]
    taken = {own.effect, *(hypothesis.effect for hypothesis in rest)}
    found: dict[int, float] = {}
    for hypothesis in search.hypotheses:
        if hypothesis.effect not in taken:
            value = separation(information, size, own.columns, hypothesis.columns)
            found[hypothesis.effect] = min(value, found.get(hypothesis.effect, np.inf))
    return found


def _refitted(
    search: Search,
    selection: Selection,
    quadratic: Quadratic,
    rest: Sequence[Hypothesis],
    effect: int,
    accepted: Accepted,
) -> InPlace | None:
    """Another effect in the accepted one's place, the best of its hypotheses that are large enough to be named."""
    problem = search.problem
    mine = -0.5 * search.set_cost([*rest, accepted.hypothesis], selection.fit) + search.occam(
        accepted.hypothesis, rest, quadratic
    )
    found = []
    for hypothesis in (one for one in search.hypotheses if one.effect == effect):
        chosen = [*rest, hypothesis]
        mean, _ = quadratic.posterior(ratios(problem, chosen))
        start = problem.priors.centre + problem.scale * mean
        fit = search.fit_set(chosen, selection.linearisation, start)
        value = -0.5 * search.set_cost(chosen, fit) + search.occam(hypothesis, rest, quadratic)
        by_data = 0.5 * (
            _without_own_size(search, selection.fit, accepted.hypothesis) - _without_own_size(search, fit, hypothesis)
        )
        if not smaller_than_named(problem, hypothesis, fit.theta):
            found.append(InPlace(hypothesis, accepted.evidence + value - mine, by_data, fit.theta))
    return max(found, key=lambda one: (one.evidence, one.by_data), default=None)


def _without_own_size(search: Search, fit: Fit, own: Hypothesis) -> float:
    """Cost of a fit but for the prior of the hypothesis' own deviations."""
    columns = list(own.columns)
    size = ((fit.theta - search.problem.priors.centre) / fit.widths)[columns]
    return fit.cost - float(np.sum(size**2))
