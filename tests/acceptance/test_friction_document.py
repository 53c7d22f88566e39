"""Acceptance targets A1 to A18 and A21 of the friction document (4.8) on its own car, in the shipped scenarios.

The car is the document's single-track twin (2.4, 2.5), the ECU the emulated one over CAN frames, the limits are those
of the scenarios. The same criteria on the MuJoCo car are listed in docs/acceptance.md.
"""

from collections.abc import Callable
from typing import Any

import pytest

from bench.scenario.locate import find_scenario
from bench.scenario.procedure import judge_procedure, read_procedure
from bench.scenario.resolution import resolve

E6, E7 = "friction/e6_no_abs_high_grip", "friction/e7_no_abs_low_grip"
E8, E9 = "friction/e8_abs_high_grip", "friction/e9_abs_low_grip"
E10 = "friction/e10_abs_grip_jump"
E1, E2, E3 = "friction/e1_slip_slope_100", "friction/e2_double_lane_change_33", "friction/e3_force_ekf"
E14, TWO_STOPS = "friction/e14_friction_ekf", "friction/two_stops"
Z1, Z2 = "friction/e11_zero_torque_z1", "friction/e11_zero_torque_z2"
SIGNS = ("plus", "minus")
AXLES = ("front", "rear")
E11_VARIANTS = ("e6", "e7", None, "e9", "e10")  # without a variant the manoeuvre is that of E8

# Braking distances that the source's own simulation printed, Tables 12 and 13 (l. 1677-1701), in m.
ASPHALT = {"dry_mu115": 37.2, "dry_mu100": 40.3, "wet_mu100": 25.7, "wet_mu090": 28.1}

both_signs = pytest.mark.parametrize("sign", SIGNS)
both_axles = pytest.mark.parametrize("axle", AXLES)


@pytest.mark.parametrize(
    "scenario",
    [E1, E3, E6, E7, E8, E9, E10, E14, TWO_STOPS, Z1, Z2, *(f"friction/asphalt_sim_{case}" for case in ASPHALT)],
)
def test_the_document_s_own_car_is_the_plant(scenario: str) -> None:
    assert resolve(scenario).plant == "single_track"


@pytest.mark.acceptance("F-A1", "F-A2", "F-24")
@pytest.mark.parametrize(("scenario", "target"), [(E6, "A1"), (E8, "A1"), (E7, "A2"), (E9, "A2")])
def test_mean_deceleration(judged: Any, assert_passed: Any, scenario: str, target: str) -> None:
    assert_passed(judged(scenario), f"{target}_deceleration", id=f"F-{target}")


@pytest.mark.acceptance("F-A3", "F-24")
@pytest.mark.parametrize("scenario", [E6, E7])
def test_wheels_lock_without_abs(judged: Any, assert_passed: Any, scenario: str) -> None:
    assert_passed(judged(scenario), "A3_lock", id="F-A3", quantity="lock speed over start speed, later axle")


@pytest.mark.acceptance("F-A4", "F-10", "F-24")
@pytest.mark.parametrize("scenario", [E8, E9])
def test_slip_under_abs(judged: Any, assert_passed: Any, record: Callable[..., None], scenario: str) -> None:
    run = judged(scenario)
    assert_passed(run, "A4_slip_mean", id="F-A4", quantity="mean slip of the four wheels in braking")
    record("mean slip of the worst wheel", run.value("A4_slip_mean_worst_wheel"), "reported", id="F-A4")
    assert_passed(run, "A4_slip_high", id="F-A4", quantity="time share of slip above 0.4")


@pytest.mark.acceptance("F-A5", "F-24")
@both_signs
@pytest.mark.parametrize("scenario", [E6, E7, E8, E9, E10])
def test_speed(judged: Any, assert_passed: Any, scenario: str, sign: str) -> None:
    assert_passed(judged(scenario), f"A5_speed_{sign}", id="F-A5", quantity="speed RMSE")


@pytest.mark.acceptance("F-A6", "F-24")
@both_signs
@both_axles
@pytest.mark.parametrize("scenario", [E6, E7, E8, E9, E10])
def test_slip(judged: Any, assert_passed: Any, scenario: str, axle: str, sign: str) -> None:
    assert_passed(judged(scenario), f"A6_slip_{axle}_{sign}", id="F-A6", quantity="slip RMSE")


@pytest.mark.acceptance("F-A7", "F-A8", "F-24")
@both_signs
@both_axles
@pytest.mark.parametrize(("scenario", "target"), [(E6, "A7"), (E7, "A8")])
def test_friction_limits_with_locked_wheels(
    judged: Any, assert_passed: Any, scenario: str, target: str, axle: str, sign: str
) -> None:
    criterion = f"{target}_friction_limit_{axle}_{sign}"
    assert_passed(judged(scenario), criterion, id=f"F-{target}", quantity=f"k0 {axle}")


@pytest.mark.acceptance("F-A9", "F-24")
@both_signs
@both_axles
@pytest.mark.parametrize("scenario", [E8, E9])
def test_friction_limits_under_abs(
    judged: Any, assert_passed: Any, record: Callable[..., None], scenario: str, axle: str, sign: str
) -> None:
    run = judged(scenario)
    assert_passed(run, f"A9_friction_limit_{axle}_{sign}", id="F-A9", quantity=f"k0 {axle} / truth")
    record(f"k0 {axle} max - min", run.value(f"A9_jumps_{axle}_{sign}"), "reported", id="F-A9")


@pytest.mark.acceptance("F-A10", "F-24")
@both_signs
@both_axles
@pytest.mark.parametrize("scenario", [E6, E7, E8, E9])
def test_friction_in_use(judged: Any, assert_passed: Any, scenario: str, axle: str, sign: str) -> None:
    assert_passed(judged(scenario), f"A10_friction_{axle}_{sign}", id="F-A10", quantity="used friction RMSE")


@pytest.mark.acceptance("F-A11", "F-23")
@both_signs
def test_no_confidence_in_the_front_limit_while_accelerating(judged: Any, assert_passed: Any, sign: str) -> None:
    quantity = "share of the acceleration with front confidence"
    assert_passed(judged(E7), f"A11_confidence_{sign}", id="F-A11", quantity=quantity)


@pytest.mark.acceptance("F-A12", "F-25")
@both_signs
@both_axles
def test_a_jump_of_the_road_is_followed(judged: Any, assert_passed: Any, axle: str, sign: str) -> None:
    run = judged(E10)
    assert_passed(run, f"A12_settling_{axle}_{sign}", id="F-A12", quantity=f"time to +-10 % {axle}")
    assert_passed(run, f"A12_bounded_{axle}_{sign}", id="F-A12", quantity=f"largest k0 {axle}")


@pytest.mark.acceptance("F-A13", "F-26")
@pytest.mark.parametrize("variant", E11_VARIANTS)
@pytest.mark.parametrize(("scenario", "sign"), [(Z2, "plus"), (Z2, "minus"), (Z1, "minus")])
def test_without_torques(judged: Any, assert_passed: Any, scenario: str, sign: str, variant: str | None) -> None:
    run = judged(scenario, variant)
    mode = f"{scenario[-2:]}, sign {sign}"
    assert_passed(run, f"A13_friction_limit_mean_{sign}", id="F-A13", quantity=f"{mode}: load-weighted k0 / truth")
    assert_passed(run, f"A13_speed_{sign}", id="F-A13", quantity=f"{mode}: speed RMSE")


@pytest.mark.acceptance("F-26")
@pytest.mark.parametrize("variant", E11_VARIANTS)
def test_mode_z1_with_plus_sign_is_reported(judged: Any, record: Callable[..., None], variant: str | None) -> None:
    run = judged(Z1, variant)
    record("z1, sign plus: load-weighted k0 / truth", run.value("A13_friction_limit_mean_plus"), "reported")
    record("z1, sign plus: speed RMSE m/s", run.value("A13_speed_plus"), "reported")


@pytest.mark.acceptance("F-A17")
@pytest.mark.parametrize("case", ASPHALT)
def test_braking_distance_of_the_asphalt_car(
    judged: Any, assert_passed: Any, record: Callable[..., None], case: str
) -> None:
    run = judged(f"friction/asphalt_sim_{case}")
    low, high = run["braking_distance"].limits
    assert (low, high) == pytest.approx((0.95 * ASPHALT[case], 1.05 * ASPHALT[case]))
    assert_passed(run, "braking_distance", id="F-A17", quantity=f"{case}: distance from 10 % of the deceleration")
    record(f"{case}: distance from brake start m", run.value("distance_from_brake_start"), "reported")


@pytest.mark.acceptance("F-A15", "F-14")
def test_slip_slope_on_dry_asphalt(judged: Any, assert_passed: Any, record: Callable[..., None]) -> None:
    run = judged(E1)
    assert_passed(run, "A15_reached", id="F-A15", quantity="time to 0.9 ... 1.1")
    assert_passed(run, "A15_after_one_second", id="F-A15", quantity="friction limit after 1 s")
    assert_passed(run, "A15_friction_limit", id="F-A15", quantity="friction limit in braking, mean")
    record("time outside the band after 1 s", run.value("A15_outside_later"), "reported", id="F-A15")


@pytest.mark.acceptance("F-A16", "F-15")
def test_cornering_stiffness_in_a_double_lane_change(judged: Any, assert_passed: Any) -> None:
    """On the MuJoCo car: the single-track car has no lateral motion."""
    run = judged(E2)
    for axle in AXLES:
        assert_passed(run, f"A16_slope_{axle}", id="F-A16", quantity=f"smallest slope {axle}, span of 2 deg")
    assert_passed(run, "A16_no_alarm", id="F-A16", quantity="alarms with a span of 2 deg")
    assert_passed(run, "A16_false_alarm", id="F-A16", quantity="share of false alarms with 0.05 deg")
    assert run["grip_kept"].verdict == "pass"
    assert run["span_seen"].verdict == "pass"


@pytest.mark.acceptance("F-A14", "F-17")
@pytest.mark.parametrize("criterion", ["A14_force_front", "A14_force_rear", "A14_force_front_cosine"])
def test_force_ekf_in_launch_and_locked_stop(judged: Any, assert_passed: Any, criterion: str) -> None:
    assert_passed(judged(E3), criterion, id="F-A14", quantity=f"{criterion}: RMSE over m g/2")


@pytest.mark.acceptance("F-A21", "F-28")
def test_noise_of_the_filter_and_of_the_simple_model(judged: Any, assert_passed: Any) -> None:
    run = judged(E14)
    assert_passed(run, "A21_noise", id="F-A21", quantity="std of friction, EKF over simple model, noisy accelerometer")
    assert run["E14_friction_is_negative"].verdict == "pass"


@pytest.mark.acceptance("F-22")
@pytest.mark.parametrize(
    "criterion",
    ["resets_plus", "resets_minus", "active_while_locked", "start_speed_first", "start_speed_second"],
)
def test_two_stops_with_locked_wheels_and_spinning_launches(judged: Any, assert_passed: Any, criterion: str) -> None:
    run = judged(TWO_STOPS)
    assert run["locked_at_speed"].verdict == "pass"
    assert run["launch_spins"].verdict == "pass"
    assert_passed(run, criterion, id="F-22", quantity=criterion)


@pytest.mark.acceptance("F-A18", "F-31")
def test_two_roads_4_percent_apart(judged: Any, record: Callable[..., None]) -> None:
    """The shipped procedure: five stops on each road, told by the filter without torques; none on the same road."""
    procedure = read_procedure(find_scenario("friction/e14_sensitivity"))
    verdicts = {
        entry.name: [
            judged(entry.scenario, entry.variant, entry.set, seed=entry.seed + number).verdict
            for number in range(entry.repeat)
        ]
        for entry in procedure.runs
    }
    for criterion in judge_procedure(procedure, verdicts).criteria:
        record(criterion.id, criterion.value, f"{criterion.limits[0]} ... {criterion.limits[1]}", id="F-A18")
        assert criterion.verdict == "pass", criterion
