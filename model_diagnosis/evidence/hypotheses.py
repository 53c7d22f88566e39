"""Hypotheses: which deviations of an effect are present."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from model_diagnosis.effects.conditions import everywhere, only_in
from model_diagnosis.effects.form import FORM_NAMES
from model_diagnosis.evidence.replay_model import ReplayModel
from signals.wheels import WHEELS


@dataclass(frozen=True)
class Hypothesis:
    """An effect is present with these columns of theta.

    Attributes
    ----------
    effect : index into the replay's effects
    columns : the deviations that are present, all of the effect's or one of them
    share : prior probability within the effect
    value : the deviation itself where the effect takes separate values (a swap, a failed circuit); else None
    """

    effect: int
    columns: tuple[int, ...]
    share: float
    value: float | None = None


def hypotheses_of(replay: ReplayModel, available: Sequence[bool] | None = None) -> list[Hypothesis]:
    """Hypotheses of all effects: all deviations together where they may be, those of one wheel, each alone.

    ``available`` (p,) leaves out columns that this data cannot show at all.
    """
    found = []
    for index in range(len(replay.effects)):
        if replay.effects[index].name in FORM_NAMES:
            continue
        columns = [int(column) for column in np.flatnonzero(replay.owner == index)]
        if available is not None:
            columns = [column for column in columns if available[_shown_by(column, replay)]]
        if not columns:
            continue
        if replay.effects[index].discrete:
            found += _discrete(index, columns, replay)
            continue
        single = _of_one_manoeuvre(columns, replay)
        columns = [column for column in columns if only_in(replay.columns[column]) is None]
        alone = [column for column in columns if not replay.parameters[column].places]
        together = [] if replay.effects[index].one_at_a_time else [tuple(columns)]
        choices = [*together, *_wheels(columns, replay), *((column,) for column in alone)] if columns else []
        choices = list(dict.fromkeys(choices))
        # that it holds in one of the manoeuvres only is one more choice
        share = 1.0 / (len(choices) + bool(single))
        found += [Hypothesis(index, choice, share) for choice in choices]
        found += [Hypothesis(index, choice, share / len(single)) for choice in single]
    return found


def _shown_by(column: int, replay: ReplayModel) -> int:
    """The column itself; of a place that of what begins there: without it no place shows."""
    name, placed = replay.columns[column], replay.parameters[column].places
    if not placed:
        return column
    own = everywhere(replay.parameters[column].name)
    return replay.columns.index(name.replace(f".{own}", f".{placed}", 1))


def _of_one_manoeuvre(columns: Sequence[int], replay: ReplayModel) -> list[tuple[int, ...]]:
    """Columns that hold in one manoeuvre only, those of each together."""
    found: dict[int, list[int]] = {}
    for column in columns:
        manoeuvre = only_in(replay.columns[column])
        if manoeuvre is not None:
            found.setdefault(manoeuvre, []).append(column)
    return [tuple(members) for members in found.values()]


def _wheels(columns: Sequence[int], replay: ReplayModel) -> list[tuple[int, ...]]:
    """Columns of one wheel together, where an effect has several deviations for each (``fl_sine``, ``fl_cosine``)."""
    by_wheel: dict[str, list[int]] = {}
    for column in columns:
        wheel = replay.parameters[column].name.split("_")[0]
        if wheel in WHEELS:
            by_wheel.setdefault(wheel, []).append(column)
    return [tuple(members) for members in by_wheel.values()]


def _discrete(effect: int, columns: Sequence[int], replay: ReplayModel) -> list[Hypothesis]:
    """One hypothesis for each bound of each deviation that is not the neutral value."""
    values = [
        (column, value)
        for column in columns
        for value in (replay.parameters[column].low, replay.parameters[column].high)
        if value != 0.0
    ]
    return [Hypothesis(effect, (column,), 1.0 / len(values), value) for column, value in values]


def by_effect(hypotheses: Sequence[Hypothesis], evidence: NDArray[np.float64], effects: int) -> NDArray[np.float64]:
    """Log Bayes factor (effects,) of each effect, averaged over its hypotheses; -inf for an effect without any."""
    combined = np.full(effects, -np.inf)
    for hypothesis, value in zip(hypotheses, evidence, strict=True):
        combined[hypothesis.effect] = np.logaddexp(combined[hypothesis.effect], value + np.log(hypothesis.share))
    return combined
