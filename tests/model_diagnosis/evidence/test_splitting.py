"""Two effects hidden behind a third whose two deviations look much like them, and the third itself."""

import numpy as np
import pytest
from linear_car import LinearCar, effect

from model_diagnosis.evidence.base import fit_base
from model_diagnosis.evidence.hypotheses import hypotheses_of
from model_diagnosis.evidence.priors import Priors
from model_diagnosis.evidence.search import Search
from model_diagnosis.evidence.selection import Selector

EFFECTS = [effect("both", 2), *(effect(f"e{number}") for number in range(8))]
ALIKE = 0.98
"""Correlation of each deviation of "both" with one of the others: a twenty-fifth of the evidence tells them apart."""

NUISANCE, SIZE, STRENGTH = 0.03, 0.3, 0.15
NEEDED = 8.0
"""Log evidence of a cause, near what bootstraps of such cars say."""

SEEDS = range(8)
BOTH_FIRST = (0, 6, 7)
"""Seeds at which "both" says more than either of the hidden two, and leaves less of them than a cause needs."""


def _found(seed: int, *hidden: int) -> tuple[set[str], list[str]]:
    """Names of the answer and its decisions for a car with these columns off by ``SIZE``."""
    truth = np.random.default_rng(seed).normal(0.0, NUISANCE, 10)
    truth[list(hidden)] = SIZE
    car = LinearCar(EFFECTS, truth, seed, strength=STRENGTH, alike=[(2, 0, ALIKE), (3, 1, ALIKE)])
    base = fit_base(car, Priors.of(car.parameters))
    selector = Selector(Search(base.problem, hypotheses_of(car)), NEEDED)
    selection = selector.run(base.nothing, base.at_nothing, base.at_saturated)
    return {car.effects[one.hypothesis.effect].name for one in selection.accepted}, selection.decisions


@pytest.mark.parametrize("seed", SEEDS)
def test_two_causes_behind_one_are_named(seed: int) -> None:
    names, decisions = _found(seed, 2, 3)
    assert names == {"e0", "e1"}
    split = [one for one in decisions if one.startswith("split into ")]
    assert bool(split) == (seed in BOTH_FIRST)


@pytest.mark.parametrize("seed", SEEDS)
def test_one_cause_with_two_deviations_stays_one(seed: int) -> None:
    assert _found(seed, 0, 1)[0] == {"both"}
