"""Scores of estimators against hand-made truths, disturbed signals, and the declared groups."""

import math
from pathlib import Path

import numpy as np
import pytest

import estimators
from bench.estimation.comparison import compare_group, quantity_labels, score_estimate
from bench.estimation.comparison_output import text_of, write_group_comparison
from bench.estimation.groups import GROUPS, Case, Group, group_of
from bench.estimation.offline import Request, run_offline
from bench.estimation.perturbations import Level, Perturbation, RobustnessPlan
from bench.estimation.robustness import disturb, try_all
from bench.estimation.robustness_output import draw, table
from bench.estimation.robustness_plans import PLANS, plan_of
from bench.scenario.estimator_names import kind_of
from bench.scenario.resolution import resolve
from bench.verdict.truth import truth_of
from signals.errors import InputError
from vehicle_model.vehicle_file import load_vehicle

ROOT = Path(__file__).resolve().parents[3]
CAR = load_vehicle("ekf_car").numbers()
CASE = Case("stop", "friction/e10_abs_grip_jump")


@pytest.mark.parametrize("name", GROUPS)
def test_groups_name_scenarios_and_estimators_that_exist(name):
    group = group_of(name)
    for case in group.cases:
        resolve(case.scenario, {"estimators": {}, "criteria": [], "valid_if": [], **case.set})
    kinds = [kind_of(label) for label in group.variants]
    assert {estimators.describe(kind).group for kind in kinds} == {name}
    labels = set(quantity_labels(kinds).values())
    assert {figure.quantity for figure in group.figures} <= labels


@pytest.mark.parametrize("name", PLANS)
def test_every_level_of_a_robustness_plan_can_be_run(name):
    plan = plan_of(name)
    for perturbation in plan.perturbations:
        for level in perturbation.levels:
            changes = {"estimators": {}, "criteria": [], "valid_if": [], **plan.set, **level.set}
            resolve(level.scenario or plan.scenario, changes)


def test_unknown_group_names_the_nearest():
    with pytest.raises(InputError, match="did you mean friction"):
        group_of("fricton")


def test_outputs_of_one_truth_are_one_quantity():
    labels = quantity_labels(["friction_ekf", "slip_slope_rls", "force_ekf"])
    limit = truth_of("slip_slope_rls.friction_limit")
    assert labels[limit] == "friction_limit_mean"
    assert "force_front" in labels.values()


def test_a_name_of_two_truths_is_two_quantities():
    """The friction in use of the filter is along the wheel, that of the cornering-stiffness method across."""
    labels = quantity_labels(["friction_ekf", "cornering_stiffness_rls"])
    assert labels[truth_of("friction_ekf.friction_used_front")] == "friction_used_front"
    across = truth_of("cornering_stiffness_rls.friction_used_front")
    assert labels[across] == "friction_used_front_cornering_stiffness_rls"


def test_scores_by_hand(source):
    """RMSE, relative error and spread of the front wheels' mean friction limit over the braking phase."""
    (estimate,) = run_offline(source, CAR, [Request("friction_ekf", "friction_ekf", {})])
    labels = quantity_labels(["friction_ekf"])
    scores = {score.quantity: score for score in score_estimate(CASE, source, estimate, labels)}
    pressed = int(np.argmax(source.data.array("driver_master_pressure") > 0))
    begin = pressed + 400
    end = begin + int(np.argmax(source.data.array("speed")[begin:] < 5.0))
    values = estimate.output("friction_limit_front")[begin:end]
    found = scores["friction_limit_front"]
    assert found.rmse == pytest.approx(np.sqrt(np.mean((values - 1.12) ** 2)), rel=1e-9)
    assert found.relative_error == pytest.approx(values.mean() / 1.12 - 1, rel=1e-6)
    assert found.spread == pytest.approx(np.ptp(values))
    assert 0.0 < found.settling_s < 0.4
    assert scores["speed"].rmse < 0.3


def test_a_group_on_a_stop_writes_table_picture_and_page(tmp_path):
    """Two estimators on one short stop through the whole command's path."""
    sets = {"initial_speed": "40 km/h", "manoeuvre.steps.hold.hold_speed.speed": "40 km/h", "road.jumps": []}
    sets["manoeuvre.steps.hold.until"] = {"distance": "4 m"}
    group = Group("a test", (Case("stop", "friction/e10_abs_grip_jump", sets),), {"friction_ekf": {}, "force_ekf": {}})
    result = compare_group("friction", group)
    write_group_comparison(tmp_path, result)
    assert {path.name for path in tmp_path.iterdir()} == {"comparison.json", "comparison.png", "comparison.html"}
    assert set(result.step_time_us) == {"friction_ekf", "force_ekf"}
    assert "simple_braking" in result.skipped
    text = text_of(result)
    assert "force front in N" in text
    assert text.count("time to ±10 %") == text.count("jumps, largest less smallest") == 3
    assert "friction_ekf" in text
    page = (tmp_path / "comparison.html").read_text("utf-8")
    assert page.count("<h2>") == len(result.quantities()) + 1


def test_latency_moves_signals_and_nobody_is_told(source):
    late = disturb(source.data, 20, 0.0)
    before, after = source.data.array("wheel_speed_fl"), late.array("wheel_speed_fl")
    assert np.array_equal(after[20:], before[:-20])
    assert late.array("age_wheel_speed")[500] == source.data.array("age_wheel_speed")[480]
    assert np.array_equal(late.array("speed"), source.data.array("speed"))  # the truth is left alone


def test_lost_frames_hold_values_and_their_age_goes_on(source):
    lossy = disturb(source.data, 0, 0.05)
    ages, before = lossy.array("age_inertial"), source.data.array("age_inertial")
    arrivals = int(np.sum(np.diff(before) < 0))
    lost = int(np.sum((np.diff(before) < 0) & ~(np.diff(ages) < 0)))
    assert lost / arrivals == pytest.approx(0.05, abs=0.025)
    held = np.flatnonzero(ages > before + 1e-9)
    assert len(held) > 0
    accelerations = lossy.array("longitudinal_acceleration")
    assert np.array_equal(accelerations[held], accelerations[held - 1])
    assert disturb(source.data, 0, 0.0) is source.data


def test_a_robustness_study_has_a_row_per_estimator_and_quantity(tmp_path):
    stop = {"initial_speed": "40 km/h", "manoeuvre.steps.hold.hold_speed.speed": "40 km/h", "road.jumps": []}
    stop["manoeuvre.steps.hold.until"] = {"distance": "4 m"}
    plan = RobustnessPlan(
        "friction/e10_abs_grip_jump",
        stop,
        {"friction_ekf": {}, "simple_braking": {}},
        {"speed": "rmse", "friction_used_mean": "rmse"},
        (
            Perturbation("latency", "late", (Level("none"), Level("20 ms", latency_ticks=20))),
            Perturbation("left_out", "not wanted", (Level("none"),)),
        ),
    )
    (result,) = try_all(plan, ["latency"])
    lines = table(plan, result).splitlines()
    assert lines[0] == "| Estimator | Quantity | none | 20 ms |"
    assert len(lines) == 5  # the simple evaluation has no speed that is compared
    assert lines[2].startswith("| `friction_ekf` | speed, RMSE in m/s |")
    assert lines[3].startswith("| `friction_ekf` | friction used mean, RMSE |")
    draw(tmp_path / "chart.png", plan, result)
    assert (tmp_path / "chart.png").stat().st_size > 5000
    speed = {
        label: next(s.rmse for s in scores if s.estimator == "friction_ekf" and s.quantity == "speed")
        for label, scores in result.scores.items()
    }
    # a car that decelerates by 10 m/s^2 is 0.2 m/s slower after 20 ms
    assert speed["20 ms"] - speed["none"] == pytest.approx(0.2, abs=0.07)
    assert all(math.isfinite(value) for value in speed.values())


@pytest.mark.parametrize("group", PLANS)
def test_the_robustness_pages_have_a_section_and_a_chart_for_each_perturbation(group):
    """docs/generate_robustness.py writes them."""
    name, folder = ("", "robustness") if group == "friction" else (f"_{group}", f"robustness/{group}")
    page = (ROOT / "docs" / f"estimators_robustness{name}.md").read_text("utf-8")
    for perturbation in plan_of(group).perturbations:
        title = perturbation.title
        assert f"## {title[0].upper()}{title[1:]}" in page
        assert f"images/{folder}/{perturbation.name}.png" in page
        assert (ROOT / "docs" / "images" / folder / f"{perturbation.name}.png").stat().st_size > 5000
        labels = " | ".join(level.label for level in perturbation.levels)
        assert f"| Estimator | Quantity | {labels} |" in page
