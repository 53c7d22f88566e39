"""The unknown term that the generator hid, as the replay of a diagnosis carries it: what the true model would give."""

from collections.abc import Mapping
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

if TYPE_CHECKING:
    from model_diagnosis.replay import Replay

Courses = Mapping[str, NDArray[np.float64]]
"""Manoeuvre -> (n, 4): relative change of each wheel's brake torque by what is hidden, every 10 ms from its start."""

LAW_NAME = "hidden_law"


def with_hidden_law(replay: "Replay", courses: Courses) -> "Replay":
    """The replay with what is hidden as a column behind all others; a deviation of 1 is its true size."""
    from model_diagnosis.manoeuvre import SAMPLE_TIME_S
    from model_diagnosis.replay.terms import TermCourse

    driven = []
    for manoeuvre in replay.manoeuvres:
        course = courses[manoeuvre.name.partition(" ")[0]]  # a part of a cut drive has its begin behind the name
        known, at = SAMPLE_TIME_S * np.arange(len(course)), manoeuvre.start_s + manoeuvre.time
        driven.append(np.stack([np.interp(at, known, wheel) for wheel in course.T], axis=1))
    return replay.with_terms([TermCourse(LAW_NAME, "brake_torque_factor", {"share": tuple(driven)}, {"share": 1.0})])
