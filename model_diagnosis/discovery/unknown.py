"""The unknown: what the data show and no effect explains, as a formula, a name where it has one, and a part of the car.

>>> unknown = discover_unknown(replay, theta, equations=["longitudinal force"])
>>> unknown[0].term.formula, unknown[0].same_as
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.signal import savgol_coeffs

from model_diagnosis.discovery.balances import LATERAL, LONGITUDINAL, WHEEL, YAW, Problem, problems_of
from model_diagnosis.discovery.build import found_term, term_of_answer
from model_diagnosis.discovery.disguise import disguised_as, effect_columns, term_columns
from model_diagnosis.discovery.search import LEAST_SHARE, DiscoveredTerm, discover
from model_diagnosis.discovery.term_gain import signal_of, term_residuals
from model_diagnosis.evidence.priors import is_scattering
from model_diagnosis.extension.extended_vehicle import FoundTerm
from model_diagnosis.gain import is_proven, measure_gain
from model_diagnosis.replay.replay import Replay
from model_diagnosis.result import Diagnosis, Gain
from model_diagnosis.result import DiscoveredTerm as TermOfAnswer
from signals.errors import InputError

FloatArray = NDArray[np.float64]

SHARE_BESIDE_CAUSES = 0.25
_NOISE_LEFT = float(np.linalg.norm(savgol_coeffs(7, 2)))
"""Share of white noise that the quadratic fit over 70 ms of a balance's error leaves (Savitzky & Golay 1964): 0.577."""
_TELLING = 2
"""Manoeuvres on which a term is compared with the effects of the catalogue."""


@dataclass(frozen=True)
class Unknown:
    """A discovered term.

    Attributes
    ----------
    same_as : effects of the catalogue that it is in disguise, with canonical correlation; empty for something new
    """

    term: DiscoveredTerm
    problem: Problem
    same_as: Mapping[str, float]

    @property
    def answer(self) -> TermOfAnswer:
        """As diagnosis.json has it."""
        return term_of_answer(self.term)

    @property
    def for_the_car(self) -> FoundTerm:
        """As the extended vehicle has it."""
        return found_term(self.problem.balance, self.term)


def unknown_gain(
    replay: Replay, theta: FloatArray, found: Sequence[Unknown], held_out: Replay | None, seed: int = 0
) -> Gain | None:
    """Gain of the terms on held-out manoeuvres, or by leaving out each manoeuvre in turn; None with one manoeuvre only.

    Parameters
    ----------
    replay, held_out : Replay
        Of the search's manoeuvres and of others, of the same vehicle and effects.
    """
    name = found[0].problem.balance.name
    candidates = [one.term.candidate for one in found]
    car = replay.car_at(theta)
    scales = {LONGITUDINAL: float(car["mass"]), LATERAL: float(car["mass"]), YAW: float(car["yaw_inertia"])}
    scale = scales.get(name, 1.0)
    known = found[0].problem
    if held_out is not None and len(held_out.manoeuvres):
        others = problems_of(held_out, theta, [name])
        residuals = term_residuals(known, others[0], candidates, scale) if others else []
    else:
        residuals = []
        for m in range(len(known.balance.error) if len(known.balance.error) > 1 else 0):
            rest = [k for k in range(len(known.balance.error)) if k != m]
            residuals += term_residuals(known.part(rest), known.part([m]), candidates, scale)
    if not residuals:
        return None
    own = replay.sensor_std(signal_of(name)) if name in (LONGITUDINAL, LATERAL) else 0.0
    noise = {signal_of(name): own * _NOISE_LEFT}
    return measure_gain(residuals, noise, seed=seed, cross_validated=held_out is None)


def discover_unknown(
    replay: Replay,
    theta: FloatArray,
    equations: Sequence[str] | None = None,
    *,
    seed: int = 0,
    least_share: float = LEAST_SHARE,
) -> list[Unknown]:
    """Terms of the first balance that lacks any.

    Parameters
    ----------
    theta : (p,) deviations at which the car is replayed: the nominal numbers within their scatter
    equations
        Balances to look at, the most violated first; by default all that the data allow.
    """
    for problem in problems_of(replay, theta, equations):
        terms = discover(problem.balance, problem.variables, seed=seed, least_share=least_share)
        if terms:
            names = _disguises(replay, theta, problem, terms)
            return [Unknown(term, problem, same_as) for term, same_as in zip(terms, names, strict=True)]
    return []


def _disguises(
    replay: Replay, theta: FloatArray, problem: Problem, terms: Sequence[DiscoveredTerm]
) -> list[dict[str, float]]:
    """Effects that each term is in disguise, on the manoeuvres that show the first term best."""
    columns, start = term_columns(terms[0], problem.balance, problem.variables), 0
    energy = np.zeros(len(replay.manoeuvres))
    for m, error in enumerate(problem.balance.error):
        energy[m % len(energy)] += float(np.sum(columns[start : start + len(error)] ** 2))
        start += len(error)
    telling = sorted(np.argsort(energy)[::-1][:_TELLING])
    part = Replay(replay.vehicle, [replay.manoeuvres[m] for m in telling], replay.effects)
    problems = problems_of(part, theta, [problem.balance.name])
    if not problems:
        return [{} for _ in terms]
    balance, variables = problems[0].balance, problems[0].variables
    if any(shape.variable not in variables for term in terms for shape in term.candidate.shapes):
        return [{} for _ in terms]
    effects = effect_columns(part, theta, balance)
    return [disguised_as(term, balance, term_columns(term, balance, variables), effects) for term in terms]


def with_unknown(
    answer: Diagnosis, replay: Replay, theta: FloatArray, held_out: Replay | None, seed: int = 0
) -> tuple[Diagnosis, list[FoundTerm]]:
    """An answer with the terms that the data show beyond its causes; the same answer where there are none.

    Terms without a gain on data that took no part are told in a remark and not kept, nor are those that look like a
    number of the vehicle file which the search has weighed and not named. Beside named causes a term has to
    take a quarter of what they leave: less is their form, which never fits quite.

    Parameters
    ----------
    theta : (p,) deviations of the answer: of its causes, or of the nominals within their scatter where it has none
    """
    least = SHARE_BESIDE_CAUSES if answer.causes else LEAST_SHARE
    found = discover_unknown(replay, theta, _equations(answer.guilty_equations), seed=seed, least_share=least)
    remarks = [*answer.remarks, *[_remark(one) for one in found if one.same_as]]
    known = [one for one in found if _is_weighed_already(one, answer, replay)]
    found = [one for one in found if one not in known]
    remarks += [f"{one.term.formula} is not kept: a number of the car that was weighed and not named" for one in known]
    if not found:
        return answer.model_copy(update={"remarks": remarks}), []
    gain = unknown_gain(replay, theta, found, held_out, seed)
    if gain is None or not is_proven(gain):
        formulas = "; ".join(one.term.formula for one in found)
        remarks.append(f"an unknown term ({formulas}) shows no gain on data that took no part and is not kept")
        return answer.model_copy(update={"remarks": remarks}), []
    terms = []
    for one in found:
        try:
            terms.append(one.for_the_car)
        except InputError as error:
            remarks.append(error.message)
    changes: dict[str, object] = {"discovered_terms": [one.answer for one in found]}
    if answer.causes:
        remarks.append(f"beside the causes the discovered terms leave {gain.overall.ratio:.0%} of the balance's error")
    else:
        verdict = "effect_found" if answer.verdict == "nothing_found" else answer.verdict
        changes |= {"verdict": verdict, "gain": gain}
    return answer.model_copy(update=changes | {"remarks": remarks}), terms


def _is_weighed_already(one: Unknown, answer: Diagnosis, replay: Replay) -> bool:
    """True for a term that looks like a number of the vehicle file which scatters, where no such effect is named.

    The search has weighed that number against its scatter with all signals; one balance alone does not know better.
    """
    named = {cause.effect for cause in answer.causes}
    ordinary = {
        replay.effects[int(replay.owner[column])].name
        for column, parameter in enumerate(replay.parameters)
        if is_scattering(parameter)
    }
    return bool(ordinary & set(one.same_as)) and not named & set(one.same_as)


def _equations(guilty: Mapping[str, float]) -> list[str]:
    """Balances of the car, the most violated first; the wheels' only where they are more violated than all of these."""
    ranked = sorted((name for name in guilty if name in (LONGITUDINAL, LATERAL, YAW)), key=lambda name: -guilty[name])
    wheels = max((value for name, value in guilty.items() if name.startswith(WHEEL)), default=0.0)
    of_the_car = max((guilty[name] for name in ranked), default=0.0)
    order = ranked or [LONGITUDINAL, LATERAL, YAW]
    return [*order, WHEEL] if wheels > of_the_car else order


def _remark(one: Unknown) -> str:
    names = ", ".join(f"{name} ({correlation:.2f})" for name, correlation in one.same_as.items())
    return f"{one.term.formula}: on this data the same as {names}"
