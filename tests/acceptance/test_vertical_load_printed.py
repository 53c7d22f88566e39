"""Corrections of the vertical-load document's model (its item 20): the printed form fails what the corrected one holds.

The filter here is an ordinary Kalman filter in numpy with the document's numbers (its Table 1): the document's finding
F1 says that the unscented one is the same. Corrections of the filter itself are tested in test_vertical_load_document.
"""

from collections.abc import Callable

import numpy as np
import pytest
from scipy.linalg import expm
from vertical_load_experiments import SAMPLE_S, document_record, drive, matrices, noisy, rmse

from estimators.vertical_load_model import wheel_loads

MASS, SPRUNG, YAW_INERTIA, ROLL_INERTIA = 1862.0, 1592.0, 2488.0, 614.0
TO_FRONT, TO_REAR, WHEELBASE, TRACK = 1.18, 1.77, 2.95, 1.575
STIFFNESS, ROLL_STIFFNESS, ROLL_DAMPING = 129487.0, 135206.0, 20651.0
ROLL_CENTRE, ROLL_ARM, HEIGHT, GRAVITY = 0.334, 0.385, 0.719, 9.81
SPEED = 70.0 / 3.6
SET_A = (1e-3, 1e-5, 1e-7, 1e-4)


def slip_signs(sign: float) -> np.ndarray:
    """A of (8) from F = C alpha with alpha = sign (v_y +- l r)/V: printed +, corrected - in (6) and (7)."""
    both = 4.0 * STIFFNESS
    apart, squares = 2.0 * STIFFNESS * (TO_FRONT - TO_REAR), 2.0 * STIFFNESS * (TO_FRONT**2 + TO_REAR**2)
    return np.array(
        [
            [sign * both / (MASS * SPEED), sign * apart / (MASS * SPEED) - SPEED],
            [sign * apart / (YAW_INERTIA * SPEED), sign * squares / (YAW_INERTIA * SPEED)],
        ]
    )


@pytest.mark.acceptance("L-20")
def test_slip_angles_as_printed_drive_the_car_away(record: Callable[..., None]) -> None:
    """(6) and (7) print the slip angles without their sign: the car then runs away from straight on."""
    used, _, _, _ = matrices(SPEED)
    assert slip_signs(-1.0) == pytest.approx(used[:2, :2], rel=1e-12)
    grows = float(np.linalg.eigvals(slip_signs(1.0)).real.min())
    record("slowest pole with the printed signs of (6), (7)", grows, "> 0: unstable")
    assert grows > 0.0 > np.linalg.eigvals(used[:2, :2]).real.max()


@pytest.mark.acceptance("L-20")
def test_slip_angle_as_printed_does_not_steer() -> None:
    """(6) has no steering angle, although (8) has b_11 = 2 C_af/m, b_21 = 2 l_f C_af/I_z: what it adds to alpha_f."""
    _, b, _, d = matrices(SPEED)
    front = 2.0 * STIFFNESS
    assert b[:2] == pytest.approx([front / MASS, front * TO_FRONT / YAW_INERTIA], rel=1e-12)
    assert d[0] == pytest.approx(front / MASS, rel=1e-12)


@pytest.mark.acceptance("L-20")
def test_roll_stiffness_counts_the_sprung_mass() -> None:
    """a43 of (16) is printed with the total mass: -208.752; (10) has the sprung mass: -210.412."""
    used, _, _, _ = matrices(SPEED)
    sprung, total = ((-ROLL_STIFFNESS + mass * GRAVITY * ROLL_ARM) / ROLL_INERTIA for mass in (SPRUNG, MASS))
    assert used[3, 2] == pytest.approx(sprung, rel=1e-12)
    assert total == pytest.approx(-208.752, abs=1e-3)
    assert abs(used[3, 2] - total) > 1.0


def filtered_loads(measured: dict[str, np.ndarray], roll_sign: float) -> np.ndarray:
    """Loads after (15c) of the three-sensor filter at 70 km/h with Q_A; ``roll_sign`` -1 is (10) instead of (10c)."""
    x, p, r = np.zeros(4), np.diag([0.1, 0.01, 1e-4, 1e-3]), np.diag(np.square([0.05, 0.002, 0.005]))
    angles = measured["steering_wheel_angle"] / 17.0
    before, loads = angles[0], np.zeros((len(angles), 4))
    a, b, c, d = matrices(SPEED)
    a[3, :2] *= roll_sign
    b[3] *= roll_sign
    augmented = np.zeros((5, 5))
    augmented[:4, :4], augmented[:4, 4] = a, b
    both = expm(augmented * SAMPLE_S)
    phi, gamma = both[:4, :4], both[:4, 4]
    for k, angle in enumerate(angles):
        x, p = phi @ x + gamma * before, phi @ p @ phi.T + np.diag(SET_A)
        gain = p @ c.T @ np.linalg.inv(c @ p @ c.T + r)
        y = np.array([measured[key][k] for key in ("lateral_acceleration", "yaw_rate", "roll_rate")])
        x, p, before = x + gain @ (y - c @ x - d * angle), p - gain @ c @ p, angle
        side = float(c[0] @ x + d[0] * angle)
        wheel_loads(document_record(), measured["longitudinal_acceleration"][k], side, x[2], x[3], True, loads[k])
    return loads


@pytest.mark.acceptance("L-20")
def test_roll_of_eq_10_leans_the_wrong_way(record: Callable[..., None]) -> None:
    """Finding F6: 561/388 N with the sign of (10) and the measured roll rate, 43/36 N with (10c)."""
    source = drive("E1")
    measured = noisy(source, 0)
    right = rmse(filtered_loads(measured, 1.0), source.loads)
    wrong = rmse(filtered_loads(measured, -1.0), source.loads)
    record("front RMSE, roll sign of (10c)", right[0], "43 N within 25 %")
    record("front RMSE, roll sign of (10)", wrong[0], "561 N within 25 %")
    assert right == pytest.approx((43.0, 36.0), rel=0.25)
    assert wrong == pytest.approx((561.0, 388.0), rel=0.25)


@pytest.mark.acceptance("L-6", "L-20")
def test_moment_of_the_loads_is_that_on_the_body(record: Callable[..., None]) -> None:
    """The wheels' moment is all that turns the body: m a_y h_r + m_s h_rc (a_y + g phi) - I_x phi_dd, no I_x twice.

    (11) prints I_x phi_dd on the axle's side too, which then has the moment of a body without inertia.
    """
    side, roll, roll_rate = 1.5, 0.004, -0.03
    loads = np.zeros(4)
    wheel_loads(document_record(), 0.0, side, roll, roll_rate, True, loads)
    found = 0.5 * TRACK * (loads[1] + loads[3] - loads[0] - loads[2])
    driving = SPRUNG * ROLL_ARM * (side + GRAVITY * roll)
    inertia = driving - ROLL_STIFFNESS * roll - ROLL_DAMPING * roll_rate  # I_x phi_dd of (10c)
    whole_car = MASS * side * ROLL_CENTRE + driving
    record("moment of the loads over that on the body", found / (whole_car - inertia), "1 within 1e-9", id="L-6")
    assert found == pytest.approx(whole_car - inertia, rel=1e-9)
    printed = found + inertia
    assert printed == pytest.approx(whole_car, rel=1e-9)
    assert abs(printed / (whole_car - inertia) - 1.0) > 0.1
