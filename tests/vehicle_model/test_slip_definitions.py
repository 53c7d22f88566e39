"""The five slip definitions S1 to S5 (friction document 2.1) and the estimates of eq. 116, 122, 1, 23."""

from collections.abc import Callable

import numpy as np
import pytest

from vehicle_model import estimates
from vehicle_model.slip import slip_bicycle, slip_burckhardt, slip_friction_filter, slip_general, slip_tmeasy


@pytest.mark.acceptance("F-2")
def test_s1_is_positive_when_braking() -> None:
    s_x, s_y = slip_general(20.0, 0.0, 18.0)
    assert (float(s_x), float(s_y)) == pytest.approx((0.1, 0.0))
    s_x, s_y = slip_general(3.0, 4.0, 2.0)  # |v_p| = 5
    assert (float(s_x), float(s_y)) == pytest.approx((0.2, 0.8))


@pytest.mark.acceptance("F-2")
def test_s2_has_two_branches_that_meet() -> None:
    s_x, s_y, s = slip_burckhardt(20.0, 18.0, 0.1)
    along = 18.0 * np.cos(0.1)
    assert float(s_x) == pytest.approx((along - 20.0) / 20.0)
    assert float(s_y) == pytest.approx(18.0 * np.sin(0.1) / 20.0)
    assert float(s) == pytest.approx(np.hypot(float(s_x), float(s_y)))
    s_x, s_y, _ = slip_burckhardt(20.0, 25.0, 0.1)
    along = 25.0 * np.cos(0.1)
    assert float(s_x) == pytest.approx((along - 20.0) / along)
    assert float(s_y) == pytest.approx(np.tan(0.1))
    border = 20.0 / np.cos(0.1)
    below, above = (slip_burckhardt(20.0, border * f, 0.1) for f in (1 - 1e-12, 1 + 1e-12))
    np.testing.assert_allclose(below, above, atol=1e-10)


@pytest.mark.acceptance("F-2")
def test_s3_refers_to_the_wheel() -> None:
    s_x, s_y = slip_tmeasy(20.0, 2.0, 16.0)
    assert (float(s_x), float(s_y)) == pytest.approx((-0.25, -0.125))
    s_x, _ = slip_tmeasy(20.0, 0.0, 0.0)
    assert float(s_x) == -np.inf


@pytest.mark.acceptance("F-2")
def test_s4_is_unbounded_for_a_spinning_wheel() -> None:
    np.testing.assert_allclose(slip_bicycle([20.0, 20.0, 5.0], [0.0, 18.0, 20.0]), [-1.0, -0.1, 3.0])


@pytest.mark.acceptance("F-2")
def test_s5_stays_within_one(record: Callable[..., None]) -> None:
    generator = np.random.default_rng(1)
    speed, wheel = generator.uniform(0.0, 60.0, (2, 10_000))
    slip = slip_friction_filter(speed, wheel)
    record("S5, largest magnitude", np.abs(slip).max(), "1")
    record("S5, locked wheel", float(slip_friction_filter(20.0, 0.0)), "-1")
    assert np.all(np.abs(slip) <= 1.0)
    assert float(slip_friction_filter(20.0, 0.0)) == -1.0
    assert float(slip_friction_filter(0.0, 5.0)) == 1.0
    assert float(slip_friction_filter(0.0, 0.0)) == 0.0
    braking = wheel <= speed
    np.testing.assert_allclose(slip[braking], slip_bicycle(speed, wheel)[braking])


@pytest.mark.acceptance("F-6")
def test_inertia_and_area_estimates(record: Callable[..., None]) -> None:
    # by hand: 0.0625 * 1296 * (1.7^2 + 1.4^2), 0.0625 * 1296 * (4.3^2 + 1.4^2), 0.1269 * 1296 * 2.57 * (4.3 or 2.57)
    assert estimates.roll_inertia(1296.0, 1.7, 1.4) == pytest.approx(392.85)
    assert estimates.pitch_inertia(1296.0, 4.3, 1.4) == pytest.approx(1656.45)
    assert estimates.yaw_inertia(1296.0, 2.57, 4.3) == pytest.approx(1817.474, abs=0.001)
    assert estimates.yaw_inertia(1296.0, 2.57, 4.3, "wheelbase_squared") == pytest.approx(1086.258, abs=0.001)
    record("A_f of the asphalt car, m^2", estimates.frontal_area(1969.0), "2.27 (6.1.3)")
    # document 6.1.3: eq. 122 gives 2.27 m^2 for the asphalt car
    assert estimates.frontal_area(1969.0) == pytest.approx(2.27, abs=0.005)


@pytest.mark.acceptance("F-3")
def test_kamm_circle() -> None:
    assert float(estimates.friction_coefficient(3000.0, -4000.0, 5000.0)) == pytest.approx(1.0)
    assert float(estimates.maximum_friction(-4500.0, 5000.0)) == pytest.approx(0.9)
    assert float(estimates.largest_longitudinal_force(1.0, 5000.0, 3000.0)) == pytest.approx(4000.0)
    assert float(estimates.largest_longitudinal_force(0.5, 5000.0, 3000.0)) == 0.0


def test_typical_friction_is_table_1() -> None:
    assert estimates.typical_static_friction(90 / 3.6, "wet_0.2mm", "used") == pytest.approx(0.2)
    assert estimates.typical_static_friction(70 / 3.6, "dry", "new") == pytest.approx(0.825)
    assert estimates.typical_static_friction(200 / 3.6, "puddle_2mm") == 0.0
    assert estimates.typical_static_friction(10.0, "ice") == 0.1
