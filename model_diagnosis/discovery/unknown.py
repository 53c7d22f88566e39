"""The unknown: what the data show and no effect explains, as a formula weighed against every effect of the catalogue.

Balances propose candidates, as their errors are linear in them; the replay weighs these by the same residuals, with the
same scatter of all numbers, as any effect. A term is the answer where it beats what the catalogue says.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from model_diagnosis.discovery.balances import LATERAL, LONGITUDINAL, WHEEL, YAW, problems_of, variables_of
from model_diagnosis.discovery.balances import Problem as BalanceProblem
from model_diagnosis.discovery.build import term_of_answer, term_of_the_car
from model_diagnosis.discovery.candidates import Candidate
from model_diagnosis.discovery.courses import WeighedTerm, course_of, target_of
from model_diagnosis.discovery.dimension import coefficient_exponents, unit_text
from model_diagnosis.discovery.search import LEAST_INCLUSION, DiscoveredTerm, contenders_of, inclusion_of
from model_diagnosis.effects.form import FORM_NAMES
from model_diagnosis.evidence.answer import INTERVAL_STD
from model_diagnosis.evidence.fitting import Fit, Linearisation, Problem
from model_diagnosis.evidence.groups import canonical_correlation
from model_diagnosis.evidence.hypotheses import Hypothesis
from model_diagnosis.evidence.priors import Priors
from model_diagnosis.evidence.quadratic import Quadratic
from model_diagnosis.evidence.search import Search, ratios
from model_diagnosis.evidence.selection import Selection, Selector
from model_diagnosis.extension.extended_vehicle import FoundTerm
from model_diagnosis.replay.replay import Replay
from model_diagnosis.result import DiscoveredTerm as TermOfAnswer

FloatArray = NDArray[np.float64]

_OF_EACH_BALANCE = 6
"""Candidates of a balance that are weighed."""

_REFIT_MARGIN = 3.0
MARGIN = 3.0
"""Log evidence by which a term has to beat what the catalogue says, its price paid."""

PRICE = float(np.log(500.0))
"""Log evidence that a term pays for having been sought among some 500 candidates of a balance."""

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
    replay : of the search, with columns of all candidates behind its own
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
        variables = variables_of(held_out, theta)
        name, target = self.weighed.course.name, self.weighed.target
        other = course_of(name, self.weighed.candidate, target, variables, held_out, theta)
        if other is None:
            return held_out
        # its own scale would give the coefficient another meaning
        parts = {
            part: tuple(self.weighed.unit_of[part] / other.unit_of[part] * one for one in courses)
            for part, courses in other.course.parts.items()
        }
        return held_out.with_terms([replace(other.course, parts=parts)])

    def theta_on(self, held_out: Replay, theta: FloatArray) -> FloatArray:
        """Deviations of the search's replay as those of ``on(held_out)``."""
        own = list(self.selection.accepted[0].hypothesis.columns)
        return np.concatenate([theta[: len(held_out.columns)], theta[own]])


def weigh_unknown(
    problem: Problem,
    replay: Replay,
    nothing: Fit,
    at_nothing: Linearisation,
    needed: float,
    equations: Sequence[str],
    seed: int = 0,
) -> FoundUnknown | None:
    """The term that explains most, where its evidence reaches ``needed`` beyond its price; None where none does.

    Parameters
    ----------
    nothing, at_nothing : fit of the nominal numbers within their scatter, and sensitivities there
    equations : balances to look at, the most violated first
    """
    proposed = _proposals(replay, nothing.theta, equations, seed)
    if not proposed:
        return None
    wider, whole, linearisation, fit = _with_columns(problem, replay, nothing, at_nothing, proposed)
    first = len(replay.effects)
    hypotheses = [
        Hypothesis(first + k, tuple(int(c) for c in np.flatnonzero(wider.owner == first + k)), 1.0)
        for k in range(len(proposed))
    ]
    search = Search(whole, hypotheses, needed + PRICE - _REFIT_MARGIN)
    selector = Selector(search, needed + PRICE)
    selection = selector.run(fit, linearisation, most=1)
    if not selection.accepted:
        return None
    own = selection.accepted[0].hypothesis
    weighed, balance = proposed[own.effect - first]
    inclusion = inclusion_of(weighed.candidate, balance.balance, balance.variables, seed)
    if inclusion < LEAST_INCLUSION:
        return None
    return FoundUnknown(
        term=_term(weighed, balance, selection, whole, inclusion),
        weighed=weighed,
        replay=wider,
        problem=whole,
        selection=selection,
        evidence=selector.evidence_of([own], selection.fit, selection.linearisation)
        - selector.evidence_of([], selection.nothing, selection.linearisation)
        - PRICE,
        same_as=_same_as(whole, selection, own, first),
    )


def _proposals(
    replay: Replay, theta: FloatArray, equations: Sequence[str], seed: int
) -> list[tuple[WeighedTerm, BalanceProblem]]:
    """Best candidates of the balances as terms of the replay, each once."""
    variables = variables_of(replay, theta)
    found: dict[tuple[str, Candidate], tuple[WeighedTerm, BalanceProblem]] = {}
    for balance in problems_of(replay, theta, equations):
        count = 0
        for candidate in contenders_of(balance.balance, balance.variables, seed):
            target = target_of(candidate, balance.balance)
            key = target, replace(candidate, force="")
            if not target or key in found or count == _OF_EACH_BALANCE:
                continue
            name = f"discovered_term_{len(found) + 1}"
            weighed = course_of(name, candidate, target, variables, replay, theta)
            if weighed is not None:
                found[key], count = (weighed, balance), count + 1
    return list(found.values())


def _with_columns(
    problem: Problem,
    replay: Replay,
    nothing: Fit,
    at_nothing: Linearisation,
    proposed: Sequence[tuple[WeighedTerm, BalanceProblem]],
) -> tuple[Replay, Problem, Linearisation, Fit]:
    """Replay, problem, sensitivities and fit of "nothing" with the columns of the proposed terms behind all others."""
    wider = replay.with_terms([weighed.course for weighed, _ in proposed])
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
    weighed: WeighedTerm, balance: BalanceProblem, selection: Selection, problem: Problem, inclusion: float
) -> DiscoveredTerm:
    """The term with its coefficients and their 90 % intervals in its own units."""
    accepted = selection.accepted[0]
    columns = list(accepted.hypothesis.columns)
    unit = np.array([weighed.unit_of[part] for part in weighed.course.parts])
    values = selection.fit.theta[columns] * unit
    std = np.sqrt(np.diag(accepted.direction.covariance)) * problem.scale[columns] * unit
    written = _WRITTEN[weighed.target]
    force = written if weighed.target.endswith("_factor") else ""
    exponents = coefficient_exponents(weighed.candidate, balance.balance, balance.variables)
    gained = selection.nothing.misfit - selection.fit.misfit
    return DiscoveredTerm(
        balance=written,
        candidate=replace(weighed.candidate, force=force),
        coefficients=values,
        low=values - INTERVAL_STD * std,
        high=values + INTERVAL_STD * std,
        unit=unit_text(exponents),
        inclusion=inclusion,
        explained=gained / selection.nothing.misfit,
        same_as=(),
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


def most_violated(guilty: Mapping[str, float]) -> list[str]:
    """Balances by how much they are violated, the most first, those of the wheels as one."""
    sizes: dict[str, float] = {}
    for name, value in guilty.items():
        key = WHEEL if name.startswith(WHEEL) else name
        if key in (LONGITUDINAL, LATERAL, YAW, WHEEL):
            sizes[key] = max(value, sizes.get(key, 0.0))
    return sorted(sizes, key=lambda name: -sizes[name]) or [LONGITUDINAL, LATERAL, YAW]
