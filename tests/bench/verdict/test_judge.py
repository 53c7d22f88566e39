"""Criteria, verdicts, margins, and the two files a run leaves about them."""

import json
import xml.etree.ElementTree as ElementTree

import numpy as np
import pytest
from pydantic import ValidationError
from synthetic_run import stop

from bench.verdict.criteria_file import CriteriaFile, Criterion, check_criteria
from bench.verdict.judge import judge
from bench.verdict.output_files import junit_xml, write_verdict
from bench.verdict.result import ORDER, worst

DISTANCE = 25.0**2 / 16  # of the synthetic stop: v²/2a


def criterion(**fields) -> Criterion:
    return Criterion.model_validate({"id": "x"} | fields)


def verdict_of(data=None, **fields):
    return judge(stop() if data is None else data, [criterion(**fields)], scenario="s").criteria[0]


def test_order_of_verdicts() -> None:
    assert ORDER == ("pass", "inconclusive", "fail", "error")
    assert worst(["pass", "fail", "inconclusive"]) == "fail"
    assert worst([]) == "pass"


@pytest.mark.parametrize(
    ("fields", "verdict", "margin"),
    [
        ({"value": "stopping_distance", "at_most": "50 m"}, "pass", 1 - DISTANCE / 50),
        ({"value": "stopping_distance", "at_most": 30}, "fail", 1 - DISTANCE / 30),
        ({"value": "mean_deceleration", "at_least": 7.5, "at_most": "8.2 m/s^2"}, "pass", 0.2 / 8.2),
        ({"value": "brake_start_speed", "at_least": "90 km/h"}, "pass", 0.0),
        ({"value": "max(abs(slip_ratio_fl)) - 0.12", "at_most": 0}, "pass", 0.0),
        ({"value": "wheel_lock", "at_most": "100 ms"}, "pass", 1.0),
        ({"value": "all(speed < 26)"}, "pass", 0.0),
        ({"value": "any(speed > 26)"}, "fail", -1.0),
        ({"value": "max(speed)"}, "pass", None),
        ({"value": "first_time(speed > 99)", "at_most": 3}, "fail", -np.inf),
        ({"value": "last(speed)", "phase": "hold", "at_least": 20}, "pass", 0.25),
    ],
)
def test_judges_by_limits(fields: dict, verdict: str, margin: float | None) -> None:
    result = verdict_of(**fields)
    assert result.verdict == verdict
    assert result.margin == (None if margin is None else pytest.approx(margin, abs=2e-4))


@pytest.mark.parametrize(
    ("fields", "reason"),
    [
        ({"value": "max(abs_cycles)", "at_least": 0, "valid_if": "max(abs_cycles) >= 3"}, "max(abs_cycles) >= 3 does"),
        (
            {"value": "max(speed)", "valid_if": [{"expression": "speed < 1", "reason": "ABS did not cycle"}]},
            "ABS did not cycle",
        ),
        ({"value": "friction_jump_time", "at_most": 1}, "does not jump"),
        ({"value": "max(speed)", "phase": "turn", "at_most": 1}, "step 'turn' was not reached"),
        ({"value": "speed", "at_most": 1}, "has 4625 values, not one"),
    ],
)
def test_inconclusive_says_why(fields: dict, reason: str) -> None:
    data = stop()
    data.phase_names = ("hold", "stop", "turn")
    result = verdict_of(data, **fields)
    assert result.verdict == "inconclusive"
    assert reason in result.reason


def test_a_signal_without_numbers_is_inconclusive() -> None:
    data = stop(true_yaw_rate=lambda t: np.full_like(t, np.nan))
    assert verdict_of(data, value="max_abs_yaw_rate", at_most=1).verdict == "inconclusive"


def test_the_worst_wheel_decides() -> None:
    data = stop(slip_ratio_rr=lambda t: np.where((t > 1.5) & (t < 1.7005), -1.0, -0.1))
    result = verdict_of(data, value="wheel_lock", at_most="0.1 s")
    assert (result.verdict, result.value) == ("fail", pytest.approx(0.2))
    assert result.values == pytest.approx([0, 0, 0, 0.2])
    assert result.source.startswith("FMVSS 135")


def test_parameters_of_a_metric_take_units() -> None:
    data = stop(slip_ratio_rr=lambda t: np.where((t > 1.5) & (t < 1.7005), -1.0, -0.1))
    assert verdict_of(data, value="wheel_lock", at_most=0.1, parameters={"above_speed": "85 km/h"}).value == 0.0


def test_a_condition_for_all_criteria() -> None:
    file = CriteriaFile.model_validate(
        {"criteria": [{"id": "a", "value": "max(speed)", "at_most": 30}], "valid_if": "max(abs_cycles) >= 3"}
    )
    assert judge(stop(), file.criteria, valid_if=file.valid_if).verdict == "inconclusive"


UNITS = {"speed": "m/s", "slip_ratio_fl": "1", "friction_ekf.speed": "m/s"}


@pytest.mark.parametrize(
    ("fields", "path", "message"),
    [
        ({"value": "max(sped)"}, (0, "value"), "column 5: no signal or metric 'sped'; did you mean speed?"),
        ({"value": "max(speed)", "at_most": "3 bar"}, (0, "at_most"), "m/s"),
        ({"value": "stopping_distance", "at_most": "3 s"}, (0, "at_most"), "found '3 s'"),
        ({"value": "max(speed)", "phase": "hld"}, (0, "phase"), "did you mean hold?"),
        ({"value": "stopping_distance", "phase": "hold"}, (0, "phase"), "has its own instants"),
        ({"value": "max(speed)", "unit": "m"}, (0, "unit"), "allowed: m/s"),
        ({"value": "2 * max(speed)", "unit": "km/h"}, (0, "unit"), "allowed: SI units"),
        ({"value": "2 * max(speed)", "at_most": "3 m/s"}, (0, "at_most"), "write `unit:` beside it"),
        ({"value": "max(speed)", "at_least": 5, "at_most": 3}, (0, "at_least"), "allowed: at most 3"),
        ({"value": "wheel_lock", "parameters": {"above_sped": 3}}, (0, "parameters", "above_sped"), "above_speed?"),
        ({"value": "wheel_lock", "parameters": {"above_speed": "3 m"}}, (0, "parameters", "above_speed"), "m/s"),
        ({"value": "max(speed)", "parameters": {"p": 3}}, (0, "parameters", "p"), "only a metric by itself"),
        ({"value": "speed + slip_ratio_fl"}, (0, "value"), "found m/s beside 1"),
        ({"value": "max(speed)", "valid_if": "sped > 1"}, (0, "valid_if", 0, "expression"), "speed?"),
    ],
)
def test_checking_names_field_and_remedy(fields: dict, path: tuple, message: str) -> None:
    problems = check_criteria([criterion(**fields)], UNITS, ("hold",))
    assert [problem.path for problem in problems] == [path]
    assert message in problems[0].message


def test_two_criteria_of_one_name_are_refused() -> None:
    twice = [criterion(value="max(speed)")] * 2
    assert check_criteria(twice, UNITS, ())[0].path == (1, "id")


def test_an_unknown_field_is_refused() -> None:
    with pytest.raises(ValidationError):
        criterion(value="max(speed)", at_mos=3)


def test_verdict_json_has_the_agreed_fields(tmp_path) -> None:
    data = stop(**{"friction_ekf.speed": lambda t: np.full_like(t, 3.0)})
    data.timing = {"mode": "lockstep", "real_time_factor": 40.0}
    criteria = [
        criterion(value="stopping_distance", at_most=50, requirement="R-1"),
        Criterion(id="y", value="first_time(speed > 99)", at_most=1),
    ]
    verdict = judge(data, criteria, scenario="stops/dry", seed=7, versions={"bench": "0.1"})
    write_verdict(tmp_path, verdict)
    content = json.loads((tmp_path / "verdict.json").read_text("utf-8"))
    assert list(content)[:8] == [
        "scenario", "verdict", "criteria", "metrics", "estimators", "timing", "seed", "versions",
    ]  # fmt: skip
    assert content["verdict"] == "fail"
    first, second = content["criteria"]
    assert {"id", "requirement", "value", "unit", "limits", "margin", "verdict"} <= set(first)
    assert (first["requirement"], first["unit"], first["limits"]) == ("R-1", "m", [None, 50.0])
    assert (second["value"], second["reason"]) == (None, "never reached")
    assert content["metrics"]["stopping_distance_m"] == pytest.approx(DISTANCE, abs=1e-3)
    assert len(content["metrics"]["lock_time_s"]) == 4
    assert content["metrics"]["max_abs_yaw_rate_rad_s"] == pytest.approx(0.1, rel=1e-4)
    assert set(content["estimators"]["friction_ekf"]) >= {"rmse", "settling_s"}
    assert content["estimators"]["friction_ekf"]["rmse"]["speed"] > 0
    assert json.loads(json.dumps(content, allow_nan=False)) == content


def test_junit_maps_the_verdicts(tmp_path) -> None:
    criteria = [
        Criterion(id="good", value="stopping_distance", at_most=50),
        Criterion(id="bad", value="stopping_distance", at_most=30),
        Criterion(id="open", value="friction_jump_time"),
    ]
    verdict = judge(stop(), criteria, scenario="stops/dry", seed=1, errors=["the link vcan0 was lost"])
    assert (verdict.verdict, verdict.exit_code) == ("error", 4)
    suite = ElementTree.fromstring(junit_xml(verdict))[0]
    cases = {
        case.get("name"): [child.tag for child in case if child.tag != "properties"] for case in suite.iter("testcase")
    }
    assert cases == {"good": [], "bad": ["failure"], "open": ["skipped"], "bench-1": ["error"]}
    assert (suite.get("tests"), suite.get("failures"), suite.get("errors"), suite.get("skipped")) == (
        "4",
        "1",
        "1",
        "1",
    )
    skipped = suite.find(".//skipped")
    assert skipped is not None
    assert skipped.get("message", "").startswith("inconclusive: ")


@pytest.mark.parametrize(("verdict", "code"), [("pass", 0), ("fail", 1), ("inconclusive", 3), ("error", 4)])
def test_exit_codes(verdict: str, code: int) -> None:
    from bench.verdict.result import EXIT_CODES

    assert EXIT_CODES[verdict] == code
