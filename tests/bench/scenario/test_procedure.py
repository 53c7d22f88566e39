"""Procedures: their language over results, their checks, and their verdict over made-up verdicts of runs."""

import math
from pathlib import Path
from typing import Any

import pytest

from bench.scenario.locate import find_scenario
from bench.scenario.procedure import _resolved, is_procedure, judge_procedure, read_procedure
from bench.scenario.procedure_expression import check, evaluate, half_width, names_used
from bench.scenario.procedure_file import ProcedureFile
from bench.verdict.result import CriterionResult, Verdict
from signals.errors import InputError

RESULTS = {"abs": {"s": [40.0, 41.0, 42.0]}, "locked": {"s": [50.0]}}


@pytest.mark.parametrize(
    ("text", "value"),
    [
        ("mean(abs.s)", 41.0),
        ("mean(abs.s) / mean(locked.s)", 0.82),
        ("max(abs.s) - min(abs.s)", 2.0),
        ("std(abs.s)", 1.0),
        ("variation(abs.s)", 1 / 41),
        ("count(abs.s)", 3.0),
        ("mean(abs.s ** 2)", (1600 + 1681 + 1764) / 3),
        ("mean(abs.s / locked.s)", 0.82),
        ("-locked.s + 1", -49.0),
        # Student's t for two degrees of freedom: 4.302653
        ("half_width(abs.s)", 4.302652729911275 / math.sqrt(3)),
    ],
)
def test_values(text: str, value: float) -> None:
    assert check(text, {"abs": {"s"}, "locked": {"s"}}) == []
    assert evaluate(text, RESULTS) == pytest.approx(value)


@pytest.mark.parametrize(
    "text",
    [
        "open('x')",
        "abs.s.real",
        "__import__('os')",
        "mean(abs.s, 2)",
        "abs.t",
        "abd.s",
        "mean(",
        "'a'",
        "abs.s if 1 else 2",
    ],
)
def test_refused(text: str) -> None:
    assert check(text, {"abs": {"s"}, "locked": {"s"}})


def test_a_value_per_run_needs_a_function() -> None:
    with pytest.raises(ValueError, match="take mean"):
        evaluate("abs.s", RESULTS)


def test_a_single_run_has_no_interval() -> None:
    assert math.isnan(half_width([3.0]))
    assert names_used("mean(abs.s) / mean(locked.s)") == {"abs", "locked"}


def verdict(distance_m: float | None, *, outcome: str = "pass", errors: list[str] | None = None) -> Verdict:
    criterion = CriterionResult("own", "", "", "x", None, 1.5, "1", (None, 2.0), 0.25, outcome)
    return Verdict(
        "s", [criterion], {"stopping_distance_m": distance_m, "lock_time_s": [0, 0.2, 0, 0]}, errors=errors or []
    )


def procedure(**changes: Any) -> ProcedureFile:
    data: dict[str, Any] = {
        "id": "p",
        "runs": [{"name": "abs", "scenario": "x", "repeat": 2}],
        "criteria": [{"id": "mean", "value": "mean(abs.stopping_distance)", "unit": "m", "at_most": "41 m"}],
    }
    return ProcedureFile.model_validate({**data, **changes})


@pytest.mark.acceptance("F-38")
def test_a_criterion_over_runs_is_judged_with_its_margin() -> None:
    result = judge_procedure(procedure(), {"abs": [verdict(40.0), verdict(41.0)]})
    assert (result.verdict, result.criteria[0].value) == ("pass", 40.5)
    assert result.criteria[0].margin == pytest.approx(0.5 / 41)
    assert judge_procedure(procedure(), {"abs": [verdict(42.0), verdict(41.0)]}).verdict == "fail"


def test_missing_values_and_inconclusive_runs_make_it_inconclusive() -> None:
    assert judge_procedure(procedure(), {"abs": [verdict(40.0), verdict(None)]}).verdict == "inconclusive"
    runs = {"abs": [verdict(40.0), verdict(40.0, outcome="inconclusive")]}
    assert judge_procedure(procedure(), runs).verdict == "inconclusive"
    # locked wheels: one criterion asks for ABS cycles, the run's figures are good all the same
    partly = verdict(40.0, outcome="inconclusive")
    partly.criteria += verdict(40.0).criteria
    assert judge_procedure(procedure(), {"abs": [verdict(40.0), partly]}).verdict == "pass"


def test_an_error_of_a_run_is_an_error_of_the_procedure() -> None:
    result = judge_procedure(procedure(), {"abs": [verdict(40.0), verdict(40.0, errors=["link lost"])]})
    assert result.verdict == "error"
    assert result.errors == ["abs 2: link lost"]


def test_runs_may_have_to_pass_themselves() -> None:
    runs = [{"name": "abs", "scenario": "x", "must_pass": True}]
    assert judge_procedure(procedure(runs=runs), {"abs": [verdict(40.0, outcome="fail")]}).verdict == "fail"


def test_per_wheel_metrics_and_criteria_are_quantities() -> None:
    criteria = [
        {"id": "lock", "value": "max(abs.wheel_lock)", "unit": "s", "at_most": "0.1 s"},
        {"id": "own", "value": "mean(abs.own)"},
    ]
    result = judge_procedure(procedure(criteria=criteria), {"abs": [verdict(40.0), verdict(40.0)]})
    assert [criterion.value for criterion in result.criteria] == [0.2, 1.5]


@pytest.mark.acceptance("F-38")
def test_shipped_procedures_are_recognised_and_checked() -> None:
    assert is_procedure("stops/abs_against_locked")
    assert not is_procedure("stops/dry")
    assert not is_procedure("nothing")


def test_what_a_run_sets_wins_over_the_command_line() -> None:
    path = find_scenario("stops/abs_against_locked")
    read = read_procedure(path)
    kinds = {
        entry.name: _resolved(entry, path, read, 0, {"ecu": "inprocess", "seed": 4, "sets": ["road.friction=0.9"]})
        for entry in read.runs[:2]
    }
    assert {name: scenario.ecu.kind for name, scenario in kinds.items()} == {
        "dry_abs": "inprocess",
        "dry_locked": "none",
    }
    assert all(scenario.seed == 4 and scenario.road.friction == 0.9 for scenario in kinds.values())
    assert all(scenario.pacing == "lockstep" for scenario in kinds.values())


def test_seeds_count_up() -> None:
    path = find_scenario("stops/dry_ten_runs")
    read = read_procedure(path)
    assert [_resolved(read.runs[0], path, read, number, {}).seed for number in range(3)] == [1, 2, 3]


def test_faults_of_a_procedure(tmp_path: Path) -> None:
    path = tmp_path / "p.yaml"
    path.write_text(
        "runs:\n- {name: a, scenario: stops/dry}\ncriteria:\n- {id: x, value: mean(a.stoping_distance)}\n"
        "- {id: y, value: mean(a.mfdd), unit: m/s^2, at_least: 3 m}\n"
    )
    with pytest.raises(InputError) as caught:
        read_procedure(path)
    text = str(caught.value)
    assert "p.yaml:4:18  criteria[0].value: runs have no quantity 'stoping_distance'" in text
    assert "did you mean stopping_distance?" in text
    assert "p.yaml:5:55  criteria[1].at_least: wrong dimension" in text
