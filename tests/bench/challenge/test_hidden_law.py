"""The true law of an unknown term, as the gain of an answer is measured against it."""

import json
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from bench.challenge.generator import generate, torque_courses
from bench.challenge.hidden_law import LAW_NAME, Courses
from bench.challenge.true_gain import HeldOutErrors, fit_of_truth, gain_share, replays_of
from model_diagnosis.discovery.candidates import Candidate, Shape
from model_diagnosis.discovery.courses import CourseMaker

DRAWN_WITH: dict[str, Any] = {"seed": 10_007, "family": "unknown", "generator": "first"}  # a hysteresis
MANOEUVRES = 6 + 2  # those for the search and those held out


@pytest.fixture(scope="module")
def hidden(tmp_path_factory: pytest.TempPathFactory) -> tuple[Path, dict[str, Any], Courses]:
    """A case with an unknown term, its label, and the courses of the term."""
    folder = tmp_path_factory.mktemp("unknown")
    (case,) = generate(folder / "cases", folder / "sealed", count=1, **DRAWN_WITH)
    label = json.loads((folder / "sealed" / f"{case.name}.json").read_text())["label"]
    return case, label, torque_courses(index=0, **DRAWN_WITH)


def test_courses_are_those_of_the_label(hidden: tuple[Path, dict[str, Any], Courses]) -> None:
    _, label, courses = hidden
    assert label["unknown"]["kind"] == "hysteresis"
    assert len(courses) == MANOEUVRES
    # T_b (1 + a sign(dp/dt)): never more than a to either side, and both sides where a driver brakes and lets go
    size = label["unknown"]["size"]
    assert max(float(np.abs(course).max()) for course in courses.values()) == pytest.approx(size, rel=1e-6)
    assert courses["gentle_stops"].min() < -0.9 * size < 0.9 * size < courses["gentle_stops"].max()
    assert np.abs(courses["sine_steer"]).max() == 0.0


def test_a_case_without_an_unknown_term_has_no_courses() -> None:
    assert torque_courses(seed=10_007, index=0, family="clean", generator="first") == {}


def test_the_law_is_a_column_of_the_replay_behind_all_others(hidden: tuple[Path, dict[str, Any], Courses]) -> None:
    case, _, courses = hidden
    replay, plain = replays_of(case, courses)[1], replays_of(case, None)[1]
    assert replay.columns == (*plain.columns, f"{LAW_NAME}.share")
    theta = np.zeros(len(replay.columns))
    assert np.array_equal(replay.predict(theta, 0), plain.predict(theta[:-1], 0))
    theta[-1] = 1.0
    assert not np.array_equal(replay.predict(theta, 0), plain.predict(theta[:-1], 0))


def test_a_law_of_the_pressures_rate_follows_the_hidden_one_through_every_pulse(
    hidden: tuple[Path, dict[str, Any], Courses],
) -> None:
    """The course that a discovered term has in the replay, fitted to the generator's, which nobody measured.

    What valves do within a sample is in it: of the pressures' rate over 50 ms the same law has 0.5 of the course in the
    ABS stop, and half its size.
    """
    case, label, courses = hidden
    size = label["unknown"]["size"]
    replay, _ = replays_of(case, None)
    maker = CourseMaker(replay, np.zeros(len(replay.columns)))
    law = maker.of("law", Candidate((Shape("brake_pressure_rate", "limited", width=5e6),)), "brake_torque_factor")
    assert law is not None
    for m, manoeuvre in enumerate(replay.manoeuvres):
        hidden_course = courses[manoeuvre.name] / size
        if not hidden_course.any():
            continue
        known, at = 0.01 * np.arange(len(hidden_course)), manoeuvre.start_s + manoeuvre.time
        true = np.stack([np.interp(at, known, wheel) for wheel in hidden_course.T], axis=1)
        course = law.course.parts["coefficient"][m] / law.unit_of["coefficient"]
        share = np.sum(course * true) / np.sum(course**2)
        explained = 1.0 - np.sum((true - share * course) ** 2) / np.sum(true**2)
        assert share == pytest.approx(1.0, abs=0.1), manoeuvre.name
        assert explained > (0.8 if manoeuvre.name == "abs_stop" else 0.95), manoeuvre.name


def test_a_gain_is_measured_from_the_same_refit_for_the_answer_and_the_truth() -> None:
    """By the definition, (E_refit - E_answer) / (E_refit - E_true)."""
    errors = HeldOutErrors(refit=0.25, truth=0.05)
    assert errors.share_reached(0.05) == pytest.approx(1.0)
    assert errors.share_reached(0.08) == pytest.approx(0.85)
    assert errors.share_reached(0.25) == 0.0
    assert HeldOutErrors(refit=0.05, truth=0.0495).share_reached(0.0) is None  # 1 %: nothing to be gained


@pytest.mark.nightly
def test_the_true_law_is_fitted_with_the_size_that_is_hidden(hidden: tuple[Path, dict[str, Any], Courses]) -> None:
    case, label, courses = hidden
    found = fit_of_truth(replays_of(case, courses)[0], label)
    assert found is not None
    # a tenth: what is required of physical values
    assert found[1].theta[-1] == pytest.approx(1.0, abs=0.1)
    drawn_with = {"index": 0, **DRAWN_WITH}
    assert gain_share(case, label, {"gain": None}, drawn_with) == 0.0
    # an error as large as that of the vehicle as given is larger than the refit's, whatever the answer compares it with
    as_given = {"gain": {"overall": {"ratio": 1.0}, "against_refit": {"ratio": 0.1}}}
    share = gain_share(case, label, as_given, drawn_with)
    assert share is not None
    assert share < 0.0
