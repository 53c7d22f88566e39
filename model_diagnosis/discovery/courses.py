"""Candidate terms as the replay carries them: what they add to the car over time, scaled to a usual size."""

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from model_diagnosis.discovery.candidates import Candidate, Variables
from model_diagnosis.discovery.quantities import Balance
from model_diagnosis.replay.replay import Replay
from model_diagnosis.replay.terms import FACTORS, TERM_TARGETS, TermCourse
from signals.wheels import WHEELS

FloatArray = NDArray[np.float64]
Courses = tuple[FloatArray, ...]

_FACTOR_WIDTH = 0.15
"""Prior width of a factor's change, as a mean square over where it acts: a usual effect of the brakes."""
_FORCE_WIDTH = 0.03
"""That of an added force, over the car's weight; of a moment, times one metre."""


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


def target_of(candidate: Candidate, balance: Balance) -> str:
    """What a candidate of a balance changes in the car; empty where the replay has no place for it."""
    target = balance.forces[candidate.force].target if candidate.force else balance.target
    return target if target in TERM_TARGETS else ""


def course_of(
    name: str, candidate: Candidate, target: str, variables: Variables, replay: Replay, theta: FloatArray
) -> WeighedTerm | None:
    """A candidate as a term of the replay; None where its variables are lacking, or a wave's phase has no meaning.

    Parameters
    ----------
    theta : (p,) deviations at which torques and forces tell how much each instant counts
    """
    if any(shape.variable not in variables for shape in candidate.shapes):
        return None
    waves = [shape for shape in candidate.shapes if shape.function == "sine"]
    if any(variables[shape.variable].cumulative for shape in waves):
        return None
    count = len(replay.manoeuvres)
    plain = tuple(_product(candidate, variables, m) for m in range(count))
    if waves:
        angles = [waves[0].wave_number * variables[waves[0].variable].values[m] for m in range(count)]
        parts = {
            "sine": tuple(_times(one, np.sin(angle)) for one, angle in zip(plain, angles, strict=True)),
            "cosine": tuple(_times(one, np.cos(angle)) for one, angle in zip(plain, angles, strict=True)),
        }
    else:
        parts = {"coefficient": plain}
    scaled, unit_of, widths = {}, {}, {}
    for part, courses in parts.items():
        size = _size(courses, target, replay, theta)
        if size == 0.0:
            return None
        unit = _unit(target, replay)
        scaled[part] = tuple(unit / size * one for one in courses)
        unit_of[part], widths[part] = unit / size, _FACTOR_WIDTH if target in FACTORS else 1.0
    return WeighedTerm(candidate, target, TermCourse(name, target, scaled, widths), unit_of)


def _unit(target: str, replay: Replay) -> float:
    return 1.0 if target in FACTORS else _FORCE_WIDTH * 9.81 * float(replay.car.record[0]["mass"])


def _product(candidate: Candidate, variables: Variables, m: int) -> FloatArray:
    """All shapes but a sine, (n,) of the car or (n, 4) of the wheels."""
    value = np.ones(len(variables[candidate.shapes[0].variable].values[m]))
    for shape in candidate.shapes:
        if shape.function != "sine":
            value = _times(value, shape.of(variables[shape.variable].values[m]))
    if candidate.wheel >= 0:
        only = np.zeros(len(WHEELS))
        only[candidate.wheel] = 1.0
        value = (value if value.ndim == 2 else value[:, None]) * only
    return value


def _times(one: FloatArray, other: FloatArray) -> FloatArray:
    if one.ndim == other.ndim:
        return one * other
    return one * other[:, None] if one.ndim == 2 else one[:, None] * other


def _size(courses: Courses, target: str, replay: Replay, theta: FloatArray) -> float:
    """Root mean square over where the target is at work."""
    square = weight = 0.0
    for m, course in enumerate(courses):
        at_work = _at_work(target, replay, theta, m)
        values = course if course.ndim <= at_work.ndim else course.sum(axis=1)
        values = values[:, None] * np.ones_like(at_work) if values.ndim < at_work.ndim else values
        square += float(np.sum((at_work * values) ** 2))
        weight += float(np.sum(at_work**2))
    return float(np.sqrt(square / weight)) if weight > 0.0 else 0.0


def _at_work(target: str, replay: Replay, theta: FloatArray, m: int) -> FloatArray:
    if target not in FACTORS:
        return np.ones(replay.manoeuvres[m].samples)
    states = replay.states(theta, m)
    name = "brake_torque" if target == "brake_torque_factor" else "longitudinal_force"
    return np.stack([states[f"{name}_{wheel}"] for wheel in WHEELS], axis=1)
