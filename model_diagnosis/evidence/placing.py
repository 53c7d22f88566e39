"""Where along the way something changes: a place has no sensitivity as long as nothing changes there.

A step of friction is told by what it does at each of some places, to first order, all other deviations fitted along.
One replay of a place stands for every manoeuvre that may have the step for itself, and for all together.
"""

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from model_diagnosis.effects.conditions import everywhere, only_in
from model_diagnosis.evidence.fitting import Problem
from model_diagnosis.evidence.hypotheses import Hypothesis
from model_diagnosis.evidence.quadratic import Quadratic, effect_evidence
from model_diagnosis.evidence.replay_model import ReplayModel
from model_diagnosis.evidence.stage import Stage, ratios
from model_diagnosis.huber import huber_weights

FloatArray = NDArray[np.float64]

TRIED_LEVEL = -0.2
"""Level, in widths of its prior, whose change of the residuals stands for the sensitivity at a place."""


_CLOSER = (0.5, 0.25, 0.125)
"""Shares of the distance between places at which the best one is looked at: a fit ends in a kink some metres off."""


@dataclass(frozen=True)
class PlacedPair:
    """Columns of a level and of the place it begins at, of all manoeuvres or one; and the columns that hold in all."""

    level: int
    place: int
    manoeuvre: int | None
    everywhere: tuple[int, int]


@dataclass(frozen=True)
class Place:
    """A place, the log evidence of a level there, and the log likelihood with the level's sensitivity there."""

    value: float
    evidence: float
    quadratic: Quadratic


@dataclass(frozen=True)
class _Change:
    """What a level at a place does in one manoeuvre: J'W d (p,), d'W d and d'W r over the temperature."""

    across: FloatArray
    own: float
    slope: float


def placed_pair(replay: ReplayModel, hypothesis: Hypothesis) -> PlacedPair | None:
    """The level and its place among the columns of a hypothesis; None where there are none."""
    for column in hypothesis.columns:
        if replay.parameters[column].places:
            level = next(one for one in hypothesis.columns if one != column)
            both = (everywhere(replay.columns[level]), everywhere(replay.columns[column]))
            in_all = (replay.columns.index(both[0]), replay.columns.index(both[1]))
            return PlacedPair(level, column, only_in(replay.columns[column]), in_all)
    return None


def best_places(
    problem: Problem, stage: Stage, pairs: Mapping[int, PlacedPair], worth: float = -np.inf
) -> dict[int, Place]:
    """For each pair the place from which a level explains most beside what is accepted; pairs of one effect.

    Places lie ``trial_step`` apart; where the best one's evidence is above ``worth`` they are looked at closer.
    """
    if not pairs:
        return {}
    level, place = next(iter(pairs.values())).everywhere
    theta, parameter = stage.nothing_more.theta.copy(), problem.replay.parameters[place]
    # what is left of a level by rounding would go away with its place
    levels = [level, *(pair.level for pair in pairs.values())]
    theta[levels] = problem.priors.centre[levels]
    rows = problem.rows(theta)
    base = problem.quadratic(stage.linearisation, rows, theta)
    found: dict[int, Place] = {}

    def look_at(value: float, numbers: Iterable[int]) -> None:
        tried = theta.copy()
        tried[level], tried[place] = theta[level] + TRIED_LEVEL * problem.scale[level], value
        changes = _changes(problem, stage, rows, problem.rows(tried))
        for number in numbers:
            pair = pairs[number]
            own = changes if pair.manoeuvre is None else changes[pair.manoeuvre : pair.manoeuvre + 1]
            if not any(change.own for change in own):
                continue
            best = _at_place(problem, stage, problem.scaled(theta), base, own, pair.level, value)
            if number not in found or best.evidence > found[number].evidence:
                found[number] = best

    for value in np.arange(parameter.low, parameter.high + 0.5 * parameter.trial_step, parameter.trial_step):
        look_at(float(value), pairs)
    for number in [one for one, coarse in found.items() if coarse.evidence > worth]:
        for closer in _CLOSER:
            middle = found[number].value
            for value in (middle - closer * parameter.trial_step, middle + closer * parameter.trial_step):
                look_at(float(np.clip(value, parameter.low, parameter.high)), [number])
    return found


def _changes(problem: Problem, stage: Stage, rows: Sequence[FloatArray], moved: Sequence[FloatArray]) -> list[_Change]:
    heat, found = problem.whitener.temperature, []
    for before, after, matrix in zip(rows, moved, stage.linearisation.short, strict=True):
        change = (before - after) / TRIED_LEVEL
        across = np.zeros(len(problem.scale))
        if not change.any():
            found.append(_Change(across, 0.0, 0.0))
            continue
        weighted = huber_weights(before) * change
        across[matrix.columns] = matrix.slope(weighted) / heat
        found.append(_Change(across, float(weighted @ change) / heat, float(weighted @ before) / heat))
    return found


def _at_place(
    problem: Problem,
    stage: Stage,
    scaled: FloatArray,
    base: Quadratic,
    changes: Sequence[_Change],
    level: int,
    value: float,
) -> Place:
    """The log likelihood with the level's sensitivities at a place, and its evidence."""
    across = np.sum([change.across for change in changes], axis=0)
    across[level] = sum(change.own for change in changes)
    information = base.information.copy()
    information[level] = information[:, level] = across
    score = base.score - base.information @ scaled
    score[level] = sum(change.slope for change in changes)
    quadratic = Quadratic(information, score + information @ scaled)
    evidence = effect_evidence(quadratic, ratios(problem, stage.accepted), np.ones(len(scaled)), [(level,)])
    return Place(value, float(evidence[0]), quadratic)
