"""ABS against locked wheels on the same roads, and the car that stays steerable on split friction.

On dry and wet asphalt and on polished ice the friction falls behind a peak at small slip, so that the ABS stop has to
be shorter. On the snow and ice of Table 2 (friction document 2.2) a locked wheel has 95 % of the peak: the ratio is
reported, the gain there is steering. On the ice of Table 3 it has all of it: reported too.
"""

from collections.abc import Callable
from typing import Any

import pytest

from bench.scenario.locate import find_scenario
from bench.scenario.procedure import judge_procedure, read_procedure

PROCEDURE = "stops/abs_against_locked"
SHORTER, REPORTED = ("dry", "wet", "ice_polished"), ("snow", "ice", "burckhardt_ice")
SCENARIOS = ("dry", "wet", "ice_polished", "snow", "ice")


@pytest.fixture(scope="module")
def comparison(judged: Any) -> dict[str, Any]:
    """Criteria of the shipped procedure by id, over runs in this process."""
    procedure = read_procedure(find_scenario(PROCEDURE))
    verdicts = {entry.name: [judged(entry.scenario, entry.variant, entry.set).verdict] for entry in procedure.runs}
    return {criterion.id: criterion for criterion in judge_procedure(procedure, verdicts).criteria}


@pytest.mark.acceptance("F-10")
@pytest.mark.parametrize("road", SHORTER)
def test_shorter_than_with_locked_wheels(comparison: Any, record: Callable[..., None], road: str) -> None:
    ratio = comparison[road]
    record(f"{road}: stopping distance, ABS over locked", ratio.value, "at most 1")
    assert ratio.limits == (None, 1.0)
    assert ratio.verdict == "pass", ratio


@pytest.mark.acceptance("F-10")
@pytest.mark.parametrize("road", REPORTED)
def test_ratio_without_an_early_peak_is_reported(comparison: Any, record: Callable[..., None], road: str) -> None:
    ratio = comparison[road]
    record(f"{road}: stopping distance, ABS over locked", ratio.value, "reported")
    assert ratio.limits == (None, None)
    assert ratio.value > 0


@pytest.mark.parametrize("road", SCENARIOS)
def test_abs_keeps_the_wheels_turning_and_the_car_on_its_course(judged: Any, road: str) -> None:
    run = judged(f"stops/{road}")
    assert run["wheel_lock"].verdict == "pass"
    assert run["lateral_offset"].verdict == "pass"


@pytest.mark.acceptance("F-10")
def test_steerable_on_split_friction(judged: Any, assert_passed: Any) -> None:
    run = judged("stops/mu_split")
    assert_passed(run, "yaw", id="F-10", quantity="split friction: change of the yaw angle")
    assert_passed(run, "steering_first_2s", id="F-10", quantity="split friction: steering wheel in the first 2 s")
    assert_passed(run, "steering_in_all", id="F-10", quantity="split friction: steering wheel")
    assert_passed(run, "lateral_offset", id="F-10", quantity="split friction: lateral offset")


def test_the_turn_is_kept_while_braking(judged: Any) -> None:
    run = judged("stops/brake_in_turn")
    assert {identifier: run[identifier].verdict for identifier in ("side_slip", "path", "yaw_rate_peak")} == {
        "side_slip": "pass",
        "path": "pass",
        "yaw_rate_peak": "pass",
    }
