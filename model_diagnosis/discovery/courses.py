"""Candidate terms as the replay carries them: what they add to the car over time, scaled to a usual size."""

from collections.abc import Mapping
from dataclasses import dataclass
from functools import cached_property, reduce

import numpy as np
from numpy.typing import NDArray

from model_diagnosis.discovery.candidates import Candidate, Variables
from model_diagnosis.discovery.variables import variables_of
from model_diagnosis.replay.replay import Replay
from model_diagnosis.replay.terms import FACTORS, TermCourse
from signals.wheels import WHEELS

FloatArray = NDArray[np.float64]
Courses = tuple[FloatArray, ...]

_FACTOR_WIDTH = 0.15
"""Prior width of a factor's change, as a mean square over where it acts: a usual effect of the brakes."""
_FORCE_WIDTH = 0.03
"""That of an added force, over the car's weight; of a moment, times one metre."""
_FACTOR_OF = {"brake_torque_factor": "brake_torque", "tyre_friction_factor": "longitudinal_force"}
"""State of the wheels that a factor acts on."""


@dataclass(frozen=True)
class WeighedTerm:
    """A candidate with its target, and its course in the replay.

    Attributes
    ----------
    unit_of : part -> what a coefficient of 1 of the course is in the term's own coefficient
    """

    candidate: Candidate
    target: str
    course: TermCourse
    unit_of: Mapping[str, float]


@dataclass(frozen=True)
class CourseMaker:
    """Courses of candidates in one replay.

    Attributes
    ----------
    theta : (p,) deviations at which variables are taken, and torques and forces tell how much each instant counts
    """

    replay: Replay
    theta: FloatArray

    @cached_property
    def variables(self) -> Variables:
        """Every variable that a term may depend on."""
        return variables_of(self.replay, self.theta)

    @cached_property
    def _at_work(self) -> dict[str, Courses]:
        """Target -> (n, 4) of each manoeuvre: how much a factor's change counts."""
        states = [self.replay.states(self.theta, m) for m in range(len(self.replay.manoeuvres))]
        return {
            target: tuple(np.stack([one[f"{name}_{wheel}"] for wheel in WHEELS], axis=1) for one in states)
            for target, name in _FACTOR_OF.items()
        }

    def of(self, name: str, candidate: Candidate, target: str) -> WeighedTerm | None:
        """A candidate as a term; None where its variables are lacking or still."""
        if any(shape.variable not in self.variables for shape in candidate.shapes):
            return None
        waves = [shape for shape in candidate.shapes if shape.function == "sine"]
        count = len(self.replay.manoeuvres)
        plain = tuple(_product(candidate, self.variables, m) for m in range(count))
        if waves:
            wave, values = waves[0].wave_number, self.variables[waves[0].variable].values
            parts = {
                "sine": tuple(_times(one, np.sin(wave * x)) for one, x in zip(plain, values, strict=True)),
                "cosine": tuple(_times(one, np.cos(wave * x)) for one, x in zip(plain, values, strict=True)),
            }
        else:
            parts = {"coefficient": plain}
        unit = 1.0 if target in FACTORS else _FORCE_WIDTH * 9.81 * float(self.replay.car.record[0]["mass"])
        scaled, unit_of, widths = {}, {}, {}
        for part, courses in parts.items():
            size = self._size(courses, target)
            if not size > 0.0:
                return None
            scaled[part] = tuple(unit / size * one for one in courses)
            unit_of[part], widths[part] = unit / size, _FACTOR_WIDTH if target in FACTORS else 1.0
        return WeighedTerm(candidate, target, TermCourse(name, target, scaled, widths), unit_of)

    def _size(self, courses: Courses, target: str) -> float:
        """Root mean square over where the target is at work."""
        square = weight = 0.0
        for m, course in enumerate(courses):
            if target in FACTORS:
                at_work = self._at_work[target][m]
                values = course if course.ndim == 2 else course[:, None]
            else:
                at_work = np.ones(len(course))
                values = course if course.ndim == 1 else course.sum(axis=1)
            square += float(np.sum((at_work * values) ** 2))
            weight += float(np.sum(at_work**2))
        return float(np.sqrt(square / weight)) if weight > 0.0 else 0.0


def _product(candidate: Candidate, variables: Variables, m: int) -> FloatArray:
    """All shapes but a sine, (n,) of the car or (n, 4) of the wheels."""
    courses = [
        variables[shape.variable].course(np.ones_like if shape.function == "sine" else shape.of, m)
        for shape in candidate.shapes
    ]
    return reduce(_times, courses)


def _times(one: FloatArray, other: FloatArray) -> FloatArray:
    if one.ndim == other.ndim:
        return one * other
    return one * other[:, None] if one.ndim == 2 else one[:, None] * other
