"""The unknown: what the data show and no effect explains, as a formula, a name where it has one, and a part of the car.

>>> unknown = discover_unknown(replay, theta, equations=["longitudinal force"])
>>> unknown[0].term.formula, unknown[0].same_as
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from model_diagnosis.discovery.balances import Problem, problems_of
from model_diagnosis.discovery.build import found_term, term_of_answer
from model_diagnosis.discovery.disguise import disguised_as, effect_columns, term_columns
from model_diagnosis.discovery.search import DiscoveredTerm, discover
from model_diagnosis.extension.extended_vehicle import FoundTerm
from model_diagnosis.replay.replay import Replay
from model_diagnosis.result import DiscoveredTerm as TermOfAnswer

FloatArray = NDArray[np.float64]


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


def discover_unknown(
    replay: Replay, theta: FloatArray, equations: Sequence[str] | None = None, *, seed: int = 0
) -> list[Unknown]:
    """Terms of the first balance that lacks any.

    Parameters
    ----------
    theta : (p,) deviations at which the car is replayed: the nominal numbers within their scatter
    equations
        Balances to look at, the most violated first; by default all that the data allow.
    """
    for problem in problems_of(replay, theta, equations):
        terms = discover(problem.balance, problem.variables, seed=seed)
        if terms:
            effects = effect_columns(replay, theta, problem.balance)
            return [
                Unknown(
                    term,
                    problem,
                    disguised_as(
                        term, problem.balance, term_columns(term, problem.balance, problem.variables), effects
                    ),
                )
                for term in terms
            ]
    return []
