"""The unknown: what the data show and no effect explains, as a formula weighed against every effect of the catalogue.

Terms are weighed by the same residuals, with the same scatter of all numbers, as any effect, so that mass, drag,
rolling resistance and pads stand beside every term. A term is the answer where it beats what the catalogue says.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from itertools import islice

import numpy as np
from numpy.typing import NDArray

from model_diagnosis.discovery.build import term_of_answer, term_of_the_car
from model_diagnosis.discovery.candidates import Variables
from model_diagnosis.discovery.courses import CourseMaker, WeighedTerm
from model_diagnosis.discovery.dimension import coefficient_exponents, unit_text
from model_diagnosis.discovery.proposals import Proposal, Proposer, simplest_first
from model_diagnosis.discovery.screening import Screen
from model_diagnosis.discovery.term import DiscoveredTerm
from model_diagnosis.effects.form import FORM_NAMES
from model_diagnosis.evidence.answer import INTERVAL_STD
from model_diagnosis.evidence.fitting import Fit, Linearisation, Problem
from model_diagnosis.evidence.groups import canonical_correlation
from model_diagnosis.evidence.hypotheses import Hypothesis
from model_diagnosis.evidence.priors import Priors
from model_diagnosis.evidence.quadratic import Quadratic
from model_diagnosis.evidence.search import Search
from model_diagnosis.evidence.selection import Selection, Selector
from model_diagnosis.evidence.stage import ratios
from model_diagnosis.extension.extended_vehicle import FoundTerm
from model_diagnosis.replay.base import ReplayBase
from model_diagnosis.replay.replay import Replay
from model_diagnosis.replay.terms import FACTORS
from model_diagnosis.result import DiscoveredTerm as TermOfAnswer

FloatArray = NDArray[np.float64]

LEAST_INCLUSION = 0.8
LEAST_EVIDENCE = 50.0
"""Log evidence that a term needs in any case: on healthy cars the best one reached 40 (docs/diagnosis_extension.md)."""
MARGIN = 3.0
"""Log evidence by which a term has to beat what the catalogue says, its price paid."""

_REFITTED = 2
"""Proposals that are fitted together with all nominal numbers."""
_LINEAR = 0.8
"""Share of the evidence needed that a term's sensitivities have to show before it is fitted."""

_SAME = 0.95
"""Canonical correlation from which a term is an effect of the catalogue in disguise."""

_WRITTEN = {
    "brake_torque_factor": "brake_torque",
    "tyre_friction_factor": "tyre_friction",
    "body_longitudinal_force": "longitudinal force",
    "body_lateral_force": "lateral force",
    "yaw_moment": "yaw moment",
}
"""What a formula calls a target."""


@dataclass(frozen=True)
class FoundUnknown:
    """A term that explains the data better than the catalogue.

    Attributes
    ----------
    term : its formula with the coefficient's interval
    weighed : its course
    replay : of the search, with the term's columns behind its own
    selection : with the term present, and the fits beside it
    problem : the evidence's, of that replay
    evidence : log Bayes factor against "nothing", the price paid
    same_as : effects of the catalogue that say the same, with canonical correlation
    """

    term: DiscoveredTerm
    weighed: WeighedTerm
    replay: Replay
    problem: Problem
    selection: Selection
    evidence: float
    same_as: Mapping[str, float]

    @property
    def answer(self) -> TermOfAnswer:
        """As diagnosis.json has it."""
        return term_of_answer(self.term)

    @property
    def for_the_car(self) -> FoundTerm:
        """As the extended vehicle has it."""
        return term_of_the_car(self.weighed.target, self.term)

    def on(self, held_out: Replay) -> Replay:
        """Another replay of the same vehicle with the term, its course taken from that replay's own drives."""
        theta = np.array(self.selection.nothing.theta[: len(held_out.columns)])
        other = CourseMaker(held_out, theta).of(self.weighed.course.name, self.weighed.candidate, self.weighed.target)
        if other is None:
            return held_out
        # its own scale would give the coefficient another meaning
        parts = {
            part: tuple(self.weighed.unit_of[part] / other.unit_of[part] * one for one in courses)
            for part, courses in other.course.parts.items()
        }
        return held_out.with_terms([replace(other.course, parts=parts)])

    def theta_on(self, held_out: ReplayBase, theta: FloatArray) -> FloatArray:
        """Deviations of the search's replay as those of ``on(held_out)``, given with or without the term."""
        own = list(self.selection.accepted[0].hypothesis.columns)
        added = {self.replay.columns[column] for column in own}
        known = sum(column not in added for column in held_out.columns)
        return np.concatenate([theta[:known], theta[own]])


def weigh_unknown(
    problem: Problem,
    replay: Replay,
    nothing: Fit,
    at_nothing: Linearisation,
    needed: float,
    seed: int = 0,
) -> FoundUnknown | None:
    """The term that explains most, where its evidence reaches ``needed`` beyond its price; None where none does.

    Parameters
    ----------
    nothing, at_nothing : fit of the nominal numbers within their scatter, and sensitivities there
    needed : log evidence, that of what the catalogue says with a margin or the threshold
    """
    needed = max(needed, LEAST_EVIDENCE)
    screen = Screen(problem, replay, nothing, at_nothing)
    maker = CourseMaker(replay, nothing.theta)
    proposals = Proposer(screen, maker).best(needed)
    worth_a_fit = [one for one in proposals if one.worth > _LINEAR * needed]
    for proposal in islice(simplest_first(worth_a_fit), _REFITTED):
        found = _fitted(proposal, proposals, screen, maker.variables, needed, seed)
        if found is not None:
            return found
    return None


def _fitted(
    proposal: Proposal, rivals: Sequence[Proposal], screen: Screen, variables: Variables, needed: float, seed: int
) -> FoundUnknown | None:
    """The proposal fitted with all nominal numbers; None where it is not stable or not worth what is needed."""
    prices = np.array([one.evidence - one.worth for one in rivals])
    inclusion = screen.inclusion([one.term for one in rivals], rivals.index(proposal), prices, seed)
    if inclusion < LEAST_INCLUSION:
        return None
    course = replace(proposal.term.course, name="discovered_term")
    weighed, paid = replace(proposal.term, course=course), proposal.evidence - proposal.worth
    problem, nothing = screen.problem, screen.nothing
    wider, whole, linearisation, fit = _with_columns(problem, screen.replay, nothing, screen.at_nothing, weighed)
    catalogue = len(screen.replay.effects)
    own = Hypothesis(catalogue, tuple(int(c) for c in np.flatnonzero(wider.owner == catalogue)), 1.0)
    selector = Selector(Search(whole, [own]), needed + paid, is_exact=False)
    selection = selector.run(fit, linearisation, most=1)
    if not selection.accepted:
        return None
    evidence = selector.evidence_of([own], selection.fit, selection.linearisation) - selector.evidence_of(
        [], selection.nothing, selection.linearisation
    )
    return FoundUnknown(
        term=_term(weighed, variables, selection, whole, inclusion),
        weighed=weighed,
        replay=wider,
        problem=whole,
        selection=selection,
        evidence=evidence - paid,
        same_as=_same_as(whole, selection, own, catalogue),
    )


def _with_columns(
    problem: Problem,
    replay: Replay,
    nothing: Fit,
    at_nothing: Linearisation,
    weighed: WeighedTerm,
) -> tuple[Replay, Problem, Linearisation, Fit]:
    """Replay, problem, sensitivities and fit of "nothing" with a term's columns behind all others."""
    wider = replay.with_terms([weighed.course])
    known, added = problem.priors, Priors.of(wider.parameters[len(replay.columns) :])
    priors = Priors(
        *(
            np.concatenate([getattr(known, name), getattr(added, name)])
            for name in ("centre", "nuisance", "effect", "low", "high")
        )
    )
    whole = Problem(wider, priors, problem.whitener)
    count = len(added.centre)
    theta = np.concatenate([at_nothing.theta, np.zeros(count)])
    columns = list(range(len(replay.columns), len(wider.columns)))
    raw = wider.sensitivities(theta, columns)
    fresh = whole.whitener.sensitivities([values * added.effect for values in raw])
    matrices = tuple(np.hstack([old, new]) for old, new in zip(at_nothing.matrices, fresh, strict=True))
    informations = tuple(
        (matrix * weight[:, None]).T @ matrix / whole.whitener.temperature
        for matrix, weight in zip(matrices, at_nothing.weights, strict=True)
    )
    linearisation = Linearisation(theta, matrices, at_nothing.weights, informations)
    fit = replace(
        nothing,
        theta=np.concatenate([nothing.theta, np.zeros(count)]),
        widths=np.concatenate([nothing.widths, added.nuisance]),
    )
    return wider, whole, linearisation, fit


def _term(
    weighed: WeighedTerm, variables: Variables, selection: Selection, problem: Problem, inclusion: float
) -> DiscoveredTerm:
    """The term with its coefficients and their 90 % intervals in its own units."""
    accepted = selection.accepted[0]
    columns = list(accepted.hypothesis.columns)
    unit = np.array([weighed.unit_of[part] for part in weighed.course.parts])
    values = selection.fit.theta[columns] * unit
    std = np.sqrt(np.diag(accepted.direction.covariance)) * problem.scale[columns] * unit
    gained = selection.nothing.misfit - selection.fit.misfit
    return DiscoveredTerm(
        target=_WRITTEN[weighed.target],
        is_factor=weighed.target in FACTORS,
        candidate=weighed.candidate,
        coefficients=values,
        low=values - INTERVAL_STD * std,
        high=values + INTERVAL_STD * std,
        unit=unit_text(coefficient_exponents(weighed.candidate, weighed.target, variables)),
        inclusion=inclusion,
        explained=gained / selection.nothing.misfit,
    )


def _same_as(problem: Problem, selection: Selection, own: Hypothesis, catalogue: int) -> dict[str, float]:
    """Effects of the catalogue whose sensitivities say the same as a term's, the closest first."""
    information = selection.linearisation.information
    _, projected = Quadratic(information, np.zeros(len(information))).projected(ratios(problem, ()))
    found = {}
    for number, effect in enumerate(problem.replay.effects[:catalogue]):
        columns = [int(c) for c in np.flatnonzero(problem.replay.owner == number) if projected[c, c] > 0.0]
        if effect.name in FORM_NAMES or not columns:
            continue
        value = max(canonical_correlation(projected, own.columns, [column]) for column in columns)
        if value > _SAME:
            found[effect.name] = value
    return dict(sorted(found.items(), key=lambda entry: -entry[1]))
