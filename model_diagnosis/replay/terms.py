"""Terms that no effect of the catalogue is, as columns of the replay: courses over time that a coefficient scales.

What a term is made of (a formula of measured variables) is evaluated once at some deviations; the replay is driven by
its course, so that the term is weighed, fitted and compared with every effect by the same residuals.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from model_diagnosis.effects.effect import Application, Effect, EffectParameter, Group
from model_diagnosis.replay.record import (
    INPUT_BRAKE_SHARE,
    INPUT_FORCE_X,
    INPUT_FORCE_Y,
    INPUT_GRIP_SHARE,
    INPUT_YAW_MOMENT,
    INPUTS,
    INPUTS_WITH_TERMS,
)

FloatArray = NDArray[np.float64]

FACTORS = {"brake_torque_factor": INPUT_BRAKE_SHARE, "tyre_friction_factor": INPUT_GRIP_SHARE}
"""Targets that a term changes by a factor 1 + term, of each wheel."""

FORCES = {
    "body_longitudinal_force": INPUT_FORCE_X,
    "body_lateral_force": INPUT_FORCE_Y,
    "yaw_moment": INPUT_YAW_MOMENT,
}
"""Targets that it is added to [N, N, N m]."""

TERM_TARGETS = (*FACTORS, *FORCES)


@dataclass(frozen=True)
class TermCourse:
    """A term as the replay carries it.

    Attributes
    ----------
    name : of its effect; its columns are ``<name>.<part>``
    target : one of ``TERM_TARGETS``
    parts : part (the coefficient; sine and cosine of a periodic term) -> its course in each manoeuvre, (n, 4) of the
        wheels or (n,) of the car
    widths : part -> prior width of its coefficient where the term is present
    """

    name: str
    target: str
    parts: Mapping[str, tuple[FloatArray, ...]]
    widths: Mapping[str, float]

    @property
    def effect(self) -> Effect:
        """The effect that its columns belong to."""
        parameters = tuple(
            EffectParameter(part, "1", -20.0 * width, 20.0 * width, 0.0, width, relative=False)
            for part, width in self.widths.items()
        )
        return Effect(self.name, Group.BODY, Application.PLANT, "a term of its own", parameters, (), "")


def with_terms(inputs: FloatArray, terms: Sequence[TermCourse], deviations: Mapping[str, float], m: int) -> FloatArray:
    """Inputs (n, INPUTS) of manoeuvre ``m`` with the terms that have a coefficient; the same array without any."""
    present = [
        (term.target, deviations[column], course[m])
        for term in terms
        for part, course in term.parts.items()
        if deviations.get(column := f"{term.name}.{part}", 0.0) != 0.0
    ]
    if not present:
        return inputs
    wider = np.zeros((len(inputs), INPUTS_WITH_TERMS))
    wider[:, :INPUTS] = inputs
    for first in FACTORS.values():
        wider[:, first : first + 4] = 1.0
    for target, coefficient, course in present:
        if target in FACTORS:
            first = FACTORS[target]
            wider[:, first : first + 4] += coefficient * (course if course.ndim == 2 else course[:, None])
        else:
            wider[:, FORCES[target]] += coefficient * (course if course.ndim == 1 else course.sum(axis=1))
    return wider
