"""The scorer on answers made by hand: perfect, random, cheating by vague groups, and the figures over them."""

import math
import random
from collections.abc import Sequence
from typing import Any

import pytest

from bench.challenge.figures import Figures, figures_of
from bench.challenge.intervals import calibration_error, reliability, wilson
from bench.challenge.parameters import estimate_of
from bench.challenge.scoring import CaseScore, score_case

EFFECTS = ("mass_change", "brake_pad_friction", "aero_drag", "yaw_inertia", "tyre_friction", "road_grade")


def _label(family: str, *names: str, **more: Any) -> dict[str, Any]:
    effects = [
        {"name": name, "place": "", "units": 6.0, "unit": "1", "relative": True, "deviation": 0.18, "value": 1.2}
        for name in names
    ]
    base = {"data_fault": None, "unknown": None, "wrong_car": {}, "only_in": "", "missing": [], "clock_offset_s": 0.12}
    return {"family": family, "effects": effects, **base, **more}


def _cause(name: str, probability: float = 0.97, group: Sequence[str] = (), value: float = 1.21) -> dict[str, Any]:
    members = list(group) or [name]
    estimate = {"value": 1000.0 * value, "low": 1190.0, "high": 1230.0, "unit": "kg", "nominal": 1000.0}
    return {
        "effect": name,
        "probability": probability,
        "parameters": {"factor": estimate},
        "group": members,
        "group_probabilities": {member: probability if member == name else 0.02 for member in members},
    }


def _answer(*causes: dict[str, Any], verdict: str = "", **more: Any) -> dict[str, Any]:
    found = verdict or ("effect_found" if causes else "nothing_found")
    diagnosis = {
        "verdict": found,
        "causes": list(causes),
        "data_faults": [],
        "discovered_terms": [],
        "insufficient": [],
    }
    return {"diagnosis": diagnosis | more, "seconds": 3.0}


def _inseparable(_index: int, rivals: Sequence[str]) -> list[dict[str, float | None]]:
    return [dict.fromkeys(rivals, 0.4)] * 2


def _separable(_index: int, rivals: Sequence[str]) -> list[dict[str, float | None]]:
    return [dict.fromkeys(rivals, 20.0)] * 2


def _value(figures: Figures, name: str) -> float | None:
    return next(figure.value for figure in figures.shares if figure.name == name)


def test_perfect_answers_meet_every_figure_they_speak_to() -> None:
    scores = [
        score_case(
            f"s{i}", i, _label("single", EFFECTS[i % 6]), _answer(_cause(EFFECTS[i % 6], 1.0, value=1.201)), _separable
        )
        for i in range(60)
    ]
    for score in scores:  # intervals that hold the truth in 9 of 10
        score.covered = int(score.case[1:]) % 10 != 0
    scores += [score_case(f"c{i}", i, _label("clean"), _answer(), _separable) for i in range(30)]
    scores += [
        score_case(
            "p",
            0,
            _label("pair", "mass_change", "aero_drag"),
            _answer(_cause("aero_drag"), _cause("mass_change")),
            _separable,
        )
    ]
    figures = figures_of(scores)
    assert _value(figures, "right cause first") == 1.0
    assert _value(figures, "false alarms on clean cars") == 0.0
    assert _value(figures, "both of a pair named") == 1.0
    assert _value(figures, "median error of the physical value") == pytest.approx(0.001 / 1.2)
    assert figures.missed == []
    assert figures.confusion["mass_change"] == {"mass_change": 10}


def test_random_answers_score_at_chance_and_miss() -> None:
    chance = random.Random(4)
    scores = []
    for i in range(600):
        truth, said = chance.choice(EFFECTS), chance.choice(EFFECTS)
        scores.append(score_case(str(i), i, _label("single", truth), _answer(_cause(said)), _separable))
    figures = figures_of(scores)
    first = _value(figures, "right cause first")
    assert first == pytest.approx(1 / 6, abs=3.3 * math.sqrt(1 / 6 * 5 / 6 / 600))
    # 97 % stated, 17 % right
    assert _value(figures, "calibration error") == pytest.approx(0.97 - first, abs=1e-9)
    assert {figure.name for figure in figures.missed} >= {"right cause first", "calibration error"}


def test_vague_groups_do_not_score() -> None:
    """All of the catalogue in the group; groups of three that the data can tell apart; groups never asked for."""
    truth = _label("single", "mass_change")
    everything = _answer(_cause("aero_drag", group=EFFECTS))
    assert score_case("a", 0, truth, everything, _inseparable).in_group is False
    three = _answer(_cause("aero_drag", group=("aero_drag", "mass_change", "road_grade")))
    told_apart = score_case("b", 0, truth, three, _separable)
    assert (told_apart.first, told_apart.in_group, told_apart.justified) == (False, False, False)
    honest = score_case("c", 0, truth, three, _inseparable)
    assert (honest.first, honest.in_group, honest.justified, honest.grouped) == (False, True, True, True)


def test_a_rival_that_the_generator_does_not_know_justifies_nothing() -> None:
    answer = _answer(_cause("aero_drag", group=("aero_drag", "mass_change")))
    score = score_case("a", 0, _label("single", "mass_change"), answer, lambda _i, rivals: [dict.fromkeys(rivals)])
    assert score.in_group is False


def test_too_many_groups_miss_their_figure() -> None:
    pair = ("brake_pad_friction", "mass_change")
    answer = _answer(_cause("mass_change", group=pair))
    scores = [score_case(str(i), i, _label("single", "mass_change"), answer, _inseparable) for i in range(20)]
    assert "answers that are groups" in {figure.name for figure in figures_of(scores).missed}


def test_an_improbable_first_cause_is_not_named() -> None:
    score = score_case("a", 0, _label("single", "mass_change"), _answer(_cause("mass_change", 0.3)), _separable)
    assert score.first is False
    assert score.log_score == pytest.approx(math.log(0.3))


@pytest.mark.parametrize("verdict", ["effect_found", "wrong_vehicle"])
def test_a_clean_car_with_a_named_cause_or_a_wrong_vehicle_is_a_false_alarm(verdict: str) -> None:
    causes = [_cause("aero_drag", 0.2)] if verdict == "effect_found" else []
    assert score_case("a", 0, _label("clean"), _answer(*causes, verdict=verdict), _separable).false_alarm is True


def _fault(kind: str, channel: str, value: float | None = None) -> dict[str, Any]:
    return {"kind": kind, "channel": channel, "value": value}


def test_the_second_loggers_lag_is_no_invented_fault() -> None:
    lag = _answer(data_faults=[_fault("clock_offset", "speed", 0.118)])
    assert score_case("a", 0, _label("clean"), lag, _separable).fault_invented is False
    swap = _answer(data_faults=[_fault("channel_swap", "wheel_speed_fl", 1.0)])
    assert score_case("a", 0, _label("clean"), swap, _separable).fault_invented is True


def test_a_data_fault_must_be_named_on_its_channel_and_not_as_physics() -> None:
    hidden = {"kind": "channel_sign", "channels": ["yaw_rate"], "value": -1.0, "unit": "1"}
    label = _label("data_fault", data_fault=hidden)
    right = score_case("a", 0, label, _answer(data_faults=[_fault("channel_sign", "yaw_rate")]), _separable)
    assert (right.fault_named, right.physics_named) == (True, False)
    elsewhere = score_case("a", 0, label, _answer(data_faults=[_fault("channel_sign", "speed")]), _separable)
    assert elsewhere.fault_named is False
    physics = score_case("a", 0, label, _answer(_cause("steering_ratio")), _separable)
    assert (physics.fault_named, physics.physics_named) == (False, True)


@pytest.mark.parametrize(("value", "named"), [(0.8, True), (0.12, False), (0.75, False)])
def test_a_lag_counts_by_its_size_the_usual_offset_included(value: float, named: bool) -> None:
    hidden = {"kind": "clock_offset", "channels": ["speed"], "value": 0.68, "unit": "s"}
    answer = _answer(data_faults=[_fault("can_latency", "REFERENCE", value)])
    assert score_case("a", 0, _label("data_fault", data_fault=hidden), answer, _separable).fault_named is named


def test_an_unknown_term_needs_its_variables_in_the_formula() -> None:
    hidden = {"kind": "product", "formula": "", "variables": ["speed", "brake_torque"], "size": 0.2}
    label = _label("unknown", unknown=hidden)

    def judged(formula: str, target: str) -> bool | None:
        term = {"formula": formula, "target": target}
        return score_case("a", 0, label, _answer(discovered_terms=[term]), _separable).variables

    assert judged("-2.2e-4 brake_torque speed^2", "wheel torque") is True
    assert judged("-2.2e-4 yaw_rate", "wheel torque") is False
    assert score_case("a", 0, label, _answer(), _separable).variables is False


def test_look_alikes_want_both_in_one_group() -> None:
    label = _label("confounded", "brake_pad_friction", twin="pressure_sensor_scale")
    both = _answer(_cause("pressure_sensor_scale", group=("brake_pad_friction", "pressure_sensor_scale")))
    assert score_case("a", 0, label, both, _inseparable).right_verdict is True
    assert score_case("a", 0, label, _answer(_cause("brake_pad_friction")), _inseparable).right_verdict is False


def test_an_answer_that_broke_off_counts_as_wrong() -> None:
    score = score_case("a", 0, _label("single", "mass_change"), {"error": "defect", "seconds": 1.0}, _separable)
    assert (score.first, score.error) == (False, "defect")


@pytest.mark.parametrize(
    ("right", "count", "expected"), [(188, 200, (0.898, 0.965)), (3, 300, (0.003, 0.029)), (0, 100, (0.0, 0.037))]
)
def test_wilson_intervals(right: int, count: int, expected: tuple[float, float]) -> None:
    """Values of the closed form, Wilson 1927, to three digits."""
    assert wilson(right, count) == pytest.approx(expected, abs=6e-4)


def test_calibration_error_of_hand_made_statements() -> None:
    """0.9 stated ten times and right nine times is calibrated; 0.65 stated and never right is off by 0.65."""
    good = [(0.9, True)] * 9 + [(0.9, False)]
    bad = [(0.65, False)] * 4
    assert calibration_error(good) == pytest.approx(0.0)
    assert calibration_error(good + bad) == pytest.approx(4 * 0.65 / 14)
    assert [part.count for part in reliability(good + bad)] == [4, 10]
    assert calibration_error([]) is None


@pytest.mark.parametrize(
    ("name", "place", "parameters", "expected"),
    [
        ("wheel_radius_change", "rl", {"fl": (0.278, 0.278), "rl": (0.2836, 0.278)}, 1.02014),
        ("tyre_friction", "", {"front": (0.8, 1.0), "rear": (0.7, 1.0)}, 0.8),
        ("mass_change", "", {"factor": (1500.0, 1296.0)}, 1.15741),
        ("wheel_brake_weak", "fl", {"rr": (0.8, 1.0)}, None),
        ("mu_step", "", {"level_in_manoeuvre_2": (-0.2, 0.0), "place_in_manoeuvre_2": (15.0, 0.0)}, 0.8),
    ],
)
def test_the_parameter_that_was_changed_is_the_one_that_is_scored(
    name: str, place: str, parameters: dict[str, tuple[float, float]], expected: float | None
) -> None:
    found = estimate_of(
        {"name": name, "place": place, "relative": True},
        {key: {"value": v, "low": v, "high": v, "nominal": n} for key, (v, n) in parameters.items()},
    )
    assert (None if found is None else found.value) == (None if expected is None else pytest.approx(expected, rel=1e-5))


def test_an_absolute_label_is_compared_with_the_value_itself() -> None:
    """An exponent's healthy value is 1: what is stated is the exponent, and not what it is more than that."""
    stated = {"exponent": {"value": 1.005, "low": 1.004, "high": 1.006, "nominal": 1.0, "unit": "1"}}
    found = estimate_of({"name": "brake_pad_pressure", "place": "", "unit": "1", "relative": False}, stated)
    assert found is not None
    assert (found.value, found.low, found.high) == (1.005, 1.004, 1.006)


def test_cases_below_four_scatters_do_not_count_for_the_required_figures() -> None:
    small = CaseScore("a", "single", "mass_change", 2.0, "nothing", first=False)
    assert next(f for f in figures_of([small]).shares if f.name == "right cause first").count == 0
