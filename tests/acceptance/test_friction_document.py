"""Acceptance targets A1 to A13 and A17 of the friction document (4.8) on its own car, in the shipped scenarios.

The car is the document's single-track twin (2.4, 2.5), the ECU the emulated one over CAN frames, the limits are those
of the scenarios. The same criteria on the MuJoCo car are listed in docs/acceptance.md.
"""

from collections.abc import Callable
from typing import Any

import pytest

from bench.scenario.resolution import resolve

E6, E7 = "friction/e6_no_abs_high_grip", "friction/e7_no_abs_low_grip"
E8, E9 = "friction/e8_abs_high_grip", "friction/e9_abs_low_grip"
E10 = "friction/e10_abs_grip_jump"
Z1, Z2 = "friction/e11_zero_torque_z1", "friction/e11_zero_torque_z2"
SIGNS = ("plus", "minus")
AXLES = ("front", "rear")
E11_VARIANTS = ("e6", "e7", None, "e9", "e10")  # without a variant the manoeuvre is that of E8

# Braking distances that the source's own simulation printed, Tables 12 and 13 (l. 1677-1701), in m.
ASPHALT = {"dry_mu115": 37.2, "dry_mu100": 40.3, "wet_mu100": 25.7, "wet_mu090": 28.1}

both_signs = pytest.mark.parametrize("sign", SIGNS)
both_axles = pytest.mark.parametrize("axle", AXLES)


@pytest.mark.parametrize(
    "scenario", [E6, E7, E8, E9, E10, Z1, Z2, *(f"friction/asphalt_sim_{case}" for case in ASPHALT)]
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
