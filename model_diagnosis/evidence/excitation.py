"""What this data can show: detection limits, and the effects that it does not excite."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from model_diagnosis.effects.effect import Group
from model_diagnosis.effects.form import FORM_NAMES
from model_diagnosis.evidence.fitting import Problem
from model_diagnosis.evidence.quadratic import Quadratic
from model_diagnosis.evidence.threshold import detection_limits

FloatArray = NDArray[np.float64]

DATA_GROUPS = (Group.CLOCK, Group.CAN, Group.CONTROLLER)
"""Groups whose effects the checks of the data and of the controller answer, not the sensitivities."""


@dataclass(frozen=True)
class Excitation:
    """Detection limits of all columns.

    Attributes
    ----------
    limits : (p,) smallest deviation whose expected evidence reaches the threshold; inf where the data never shows it
    shown : (p,) True where that lies within the column's bounds
    insufficient : names of effects none of whose deviations is shown
    by_column : name of a shown column -> its limit
    """

    limits: FloatArray
    shown: NDArray[np.bool_]
    insufficient: tuple[str, ...] = ()
    by_column: Mapping[str, float] = field(default_factory=dict)


def excitation(problem: Problem, information: FloatArray, needed: float) -> Excitation:
    """Detection limits at one linearisation, for the evidence ``needed``."""
    nuisance = problem.priors.nuisance / problem.scale
    _, projected = Quadratic(information, np.zeros(len(nuisance))).projected(nuisance)
    limits = problem.scale * detection_limits(np.diag(projected), nuisance, needed)
    limits[_out_of_reach(problem)] = np.inf
    reach = np.maximum(np.abs(problem.priors.low), np.abs(problem.priors.high))
    shown = limits <= reach
    replay = problem.replay
    insufficient = tuple(
        effect.name
        for index, effect in enumerate(replay.effects)
        if effect.group not in DATA_GROUPS and effect.name not in FORM_NAMES and _none(shown, replay.owner == index)
    )
    by_column = {
        replay.columns[column]: float(limits[column])
        for column in np.flatnonzero(shown)
        if replay.effects[int(replay.owner[column])].name not in FORM_NAMES
    }
    return Excitation(limits, shown, insufficient, by_column)


def _none(shown: NDArray[np.bool_], own: NDArray[np.bool_]) -> bool:
    return bool(own.any()) and not bool(shown[own].any())


def excited_columns(problem: Problem, information: Sequence[FloatArray]) -> NDArray[np.bool_]:
    """Columns (p,) that any manoeuvre reacts to, but for those that need a torque or limit that is not there."""
    diagonal = np.sum([np.diag(part) for part in information], axis=0)
    excited: NDArray[np.bool_] = (diagonal > 1e-6) & ~_out_of_reach(problem)
    return excited


def _out_of_reach(problem: Problem) -> NDArray[np.bool_]:
    """Columns (p,) of effects that need a torque where none was measured, or a limit that no drive came near."""
    replay = problem.replay
    torque, limit = replay.torque_measured, replay.limit_approached
    lacks = [(one.needs_torque and not torque) or (one.needs_limit and not limit) for one in replay.effects]
    return np.array(lacks)[replay.owner]
