"""Errata of the friction document (its appendix A): the corrected form holds, the printed one fails the same test.

What a switch keeps selectable is tested with the part that has the switch; the list of all is docs/corrections.csv.
"""

import math

import numpy as np
import pytest
from friction_twin import AXLE_INERTIA, DRAG, FRONT, GRAVITY, HEIGHT, MASS, RADIUS, ROLLING, SET_T, TABLE_8, WHEELBASE

from estimators import force_model, friction_model
from estimators.force_ekf import model_parameters as force_parameters
from estimators.force_settings import ForceEkfSettings
from estimators.friction_jacobians import predict
from estimators.friction_settings import FrictionEkfSettings
from estimators.friction_setup import model_parameters
from estimators.kalman.filters import GaussianFilter
from estimators.slip_slope import least_squares_step
from estimators.vehicle_numbers import longitudinal_car
from vehicle_model.stopping_distance import BrakingDelays, stopping_distance
from vehicle_model.tyres.curves import magic_formula

T = 1e-3
CAR = longitudinal_car(TABLE_8)
DRY = (10.0, 1.9, 1.0, 0.97)  # B, C, D, E of Table 2


@pytest.mark.acceptance("F-41")
def test_2_the_inner_sign_of_eq_2_is_plus():
    """mu(s) = D sin(C arctan(B((1 - E) s + (E/B) arctan(B s)))) is eq. 7; with minus it is another curve."""
    b, c, d, e = DRY
    for slip in (0.02, 0.1, 0.4):
        expected = magic_formula(slip, b, c, d, e)[0]

        def eq_2(sign: float, s: float = slip) -> float:
            return d * math.sin(c * math.atan(b * ((1 - e) * s + sign * e / b * math.atan(b * s))))

        assert eq_2(+1.0) == pytest.approx(expected, rel=1e-12)
        assert eq_2(-1.0) < 0.5 * expected


@pytest.mark.acceptance("F-41")
def test_3_eq_20_ends_at_the_peak_only_with_the_slope():
    """TMEasy: F(s_M) = F_M with the slope dF0 in the denominator; with a force F0 in its place F_M is missed."""
    slope, peak, at = 1e5, 4000.0, 0.1

    def eq_20(inner: float) -> float:
        return at * slope / (1.0 + (1.0 + inner * at / peak - 2.0))

    assert eq_20(slope) == pytest.approx(peak)
    assert abs(eq_20(3000.0) - peak) > 0.3 * peak


@pytest.mark.acceptance("F-41")
def test_6_loads_of_eq_73_sum_to_the_weight_only_with_plus_in_the_rear():
    weight, acceleration = MASS * GRAVITY, -8.0
    front = weight * (WHEELBASE - FRONT) / WHEELBASE - MASS * acceleration * HEIGHT / WHEELBASE
    rear = {sign: weight * FRONT / WHEELBASE + sign * MASS * acceleration * HEIGHT / WHEELBASE for sign in (1, -1)}
    assert front + rear[+1] == pytest.approx(weight)
    assert front + rear[-1] > 1.3 * weight
    # the loads of the filter at that deceleration, drag and rolling resistance aside
    values = model_parameters(CAR, FrictionEkfSettings(exact_load_transfer=False))
    used = acceleration / GRAVITY
    assert friction_model.axle_loads(used, used, 0.0, values)[2:] == pytest.approx((front, rear[+1]))


@pytest.mark.acceptance("F-41")
def test_5_and_8_a_braked_wheel_is_turned_on_by_the_road():
    """eta = (M - F R)/Theta: with F = 0 and no torque the speed stays, a road force F < 0 speeds the wheel up."""
    force, brake = -5000.0, -1000.0
    found, _ = friction_model.wheel_acceleration(brake, False, force, RADIUS, AXLE_INERTIA, 80.0, T)
    assert found == pytest.approx((brake - force * RADIUS) / AXLE_INERTIA)
    assert found > 0.0
    printed = (force * RADIUS - brake) / AXLE_INERTIA  # eq. 81 and 84
    assert printed < 0.0
    # eq. 69 prints F_z where F_x belongs: a free-rolling wheel would be stopped by its load
    assert (-6000.0 * RADIUS) / AXLE_INERTIA < -1000.0
    assert friction_model.wheel_acceleration(0.0, False, 0.0, RADIUS, AXLE_INERTIA, 80.0, T)[0] == 0.0


@pytest.mark.acceptance("F-41")
def test_9_and_10_the_derivative_of_the_cosine_drag_has_its_factor():
    """dF/dv of eq. 83 against differences; the print lacks -1/(2 (3 pi - 6))."""
    values = force_parameters(CAR, ForceEkfSettings(drag="cosine", cosine_speed=40.0))
    for speed in (5.0, 20.0, 38.0):
        _, derivative = force_model.resistance(speed, values)
        up, down = (force_model.resistance(speed + step, values)[0] for step in (1e-4, -1e-4))
        assert derivative == pytest.approx((up - down) / 2e-4, rel=1e-6)
        printed = 2 * DRAG * math.pi**2 * 40.0 * math.sin(math.pi * speed / 80.0)
        assert abs(printed / derivative) > 6.0


@pytest.mark.acceptance("F-41")
def test_10_the_rear_force_turns_the_rear_wheel():
    """F(3, 6) holds -R T/Theta; the print puts it into column 5, the rate of the front force."""
    state = np.array([20.0, 70.0, 71.0, -3000.0, 100.0, -1500.0, 50.0, 0.0, 0.0])
    transition = np.zeros((9, 9))
    values = force_parameters(CAR, ForceEkfSettings())
    force_model.predict(state, np.zeros(4), T, values, np.zeros(9), transition)
    assert transition[2, 5] == pytest.approx(-T * RADIUS / AXLE_INERTIA)
    assert transition[2, 4] == 0.0


@pytest.mark.acceptance("F-41")
def test_11_noise_of_the_force_filter_is_scaled_already():
    """L = I with Q per step: the covariance after one prediction grows by Q, not by T Q T."""
    from estimators import create

    settings = ForceEkfSettings()
    estimator = create("force_ekf", TABLE_8)
    names = estimator.inputs
    columns = {name: np.zeros(3) for name in names} | {
        name: np.full(3, 70.0) for name in names if name.startswith("wheel_speed")
    }
    ages = {"age_wheel_speed": np.array([0.0, 1e-3, 2e-3]), "age_inertial": np.array([0.0, 1e-3, 2e-3])}
    estimator.replay({key: value[:1] for key, value in columns.items()}, {k: v[:1] for k, v in ages.items()})
    before = estimator.covariance[4, 4]
    estimator.replay({key: value[1:2] for key, value in columns.items()}, {k: v[1:2] for k, v in ages.items()})
    assert estimator.covariance[4, 4] - before == pytest.approx(settings.process_force_rate**2, rel=1e-9)


@pytest.mark.acceptance("F-41")
def test_12_covariance_is_the_mean_product_of_errors():
    """Eqs 45 and 54 print a difference of the error and its transpose, which is antisymmetric: no variance at all."""
    errors = np.random.default_rng(1).standard_normal((1000, 2)) * [1.0, 2.0]
    product = np.mean([np.outer(e, e) for e in errors], axis=0)
    assert np.diag(product) == pytest.approx([1.0, 4.0], rel=0.1)
    grid = np.broadcast_to(errors[0][:, None], (2, 2))
    assert np.diag(grid - grid.T) == pytest.approx([0.0, 0.0])


@pytest.mark.acceptance("F-41")
def test_13_the_offset_of_the_linearised_measurement_adds():
    """Eq. 65: x + K (y - h(x)) equals x + K (y - H x - j) with j = h(x) - H x; with the printed -j it does not."""
    state, design, noise = np.array([1.2, -0.3]), np.array([[0.7, 0.1]]), np.array([[0.2]])
    expected, measured = np.array([state[0] ** 2]), np.array([1.5])
    own = GaussianFilter(state.copy(), np.eye(2))
    own.correct(measured, design, noise, expected)
    gain = design.T / (design @ design.T + noise)
    offset = expected - design @ state
    with_plus = state + (gain @ (measured - design @ state - offset)).ravel()
    with_minus = state + (gain @ (measured - design @ state + offset)).ravel()
    assert own.state == pytest.approx(with_plus, rel=1e-12)
    assert np.abs(own.state - with_minus).max() > 0.1


@pytest.mark.acceptance("F-14", "F-41")
def test_14_the_regression_needs_the_update_line():
    """With eqs 32 to 34 as printed the parameter would never move from its start."""
    regression = np.array([0.0, 1e4, 0.0])
    for _ in range(50):
        least_squares_step(regression, 0.02, 0.4, 0.98)
    assert regression[0] == pytest.approx(20.0, rel=5e-3)  # P0 pulls a little towards the start


def _state() -> np.ndarray:
    speed, rims = 20.0, (21.0, 17.0)  # front faster than the car (branch A), rear slower (branch B)
    slips = [(rim - speed) / max(rim, speed) for rim in rims]
    return np.array([speed, rims[0] / RADIUS, rims[1] / RADIUS, *slips, 0.9, 0.3, 0.8, -0.2])


def _predict(state: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    predicted, transition = np.zeros(9), np.zeros((9, 9))
    values = model_parameters(CAR, FrictionEkfSettings(exact_load_transfer=False))
    predict(state, np.array([300.0, -400.0, 0.0, 0.0]), T, values, False, np.zeros((4, 6)), predicted, transition)
    return predicted, transition


@pytest.mark.acceptance("F-20", "F-41")
def test_18_the_limit_moves_by_its_rate():
    """k0' = k0 + T kappa, forced by the printed F; k0' = kappa as the appendix writes it would be another filter."""
    state = _state()
    predicted, transition = _predict(state)
    assert predicted[5] == pytest.approx(0.9 + T * 0.3)
    assert predicted[5] != pytest.approx(0.3)
    assert predicted[6] == 0.3
    assert transition[5, 6] == T


def _difference(row: int, column: int) -> float:
    state = _state()
    step = 1e-6 * max(1.0, abs(state[column]))
    ends = []
    for sign in (1.0, -1.0):
        moved = state.copy()
        moved[column] += sign * step
        ends.append(_predict(moved)[0][row])
    return (ends[0] - ends[1]) / (2.0 * step)


@pytest.mark.acceptance("F-19", "F-41")
def test_19_the_last_term_of_f_4_4_is_minus():
    """Branch A: -T eta/omega in F[4, 4]; with the printed plus the entry is wrong by twice that."""
    state = _state()
    _, transition = _predict(state)
    eta = (_predict(state)[0][1] - state[1]) / T
    numerical = _difference(3, 3)
    assert transition[3, 3] == pytest.approx(numerical, abs=1e-6)
    printed = transition[3, 3] + 2.0 * T * eta / state[1]
    assert abs(printed - numerical) > 1e-3


@pytest.mark.acceptance("F-19", "F-41")
@pytest.mark.parametrize(("row", "column"), [(3, 7), (3, 0), (3, 1), (4, 7), (4, 0)])
def test_20_to_25_entries_with_misprints_equal_differences(row, column):
    """F[5, 8], F[4, 1], F[4, 2], F[5, 3] and the lines with lost letters: the compact form (3.6.5) has none."""
    assert _predict(_state())[1][row, column] == pytest.approx(_difference(row, column), abs=2e-7, rel=1e-5)


@pytest.mark.acceptance("F-19", "F-41")
def test_20_the_minus_stands_before_the_whole_bracket():
    """F[5, 8] in branch A is -T/(R omega) times grad a plus (1 - s)/omega T grad eta; with the minus before the first
    product of grad a only, its second product has the wrong sign."""
    speed, rim = 20.0, 21.0
    slip = (rim - speed) / rim
    k1, k2 = SET_T
    state = np.array([speed, 17.0 / RADIUS, rim / RADIUS, -0.15, slip, 0.9, 0.0, 0.8, 0.0])
    _, transition = _predict(state)
    curve = [math.sin(k1 * math.atan(k2 * s)) for s in (-0.15, slip)]
    used = [0.9 * curve[0], 0.8 * curve[1]]
    lever = WHEELBASE + HEIGHT * (used[0] - used[1])
    weight = MASS * GRAVITY
    base = [weight * (WHEELBASE - FRONT - HEIGHT * used[1]) / lever, weight * (FRONT + HEIGHT * used[0]) / lever]
    shift = DRAG * HEIGHT * speed**2 / WHEELBASE
    front_by_rear = -used[0] * HEIGHT * base[1] / lever * curve[1]
    rear_by_rear = (base[1] + shift + used[1] * HEIGHT * base[1] / lever) * curve[1]
    eta_part = (1 - slip) / (rim / RADIUS) * (-RADIUS / AXLE_INERTIA) * rear_by_rear
    whole = T * (-(front_by_rear + rear_by_rear) / (MASS * rim) + eta_part)
    printed = T * (-(front_by_rear - rear_by_rear) / (MASS * rim) + eta_part)
    assert transition[4, 7] == pytest.approx(whole, rel=1e-9)
    assert abs(printed / whole - 1.0) > 1e-3


@pytest.mark.acceptance("F-29", "F-41")
def test_28_the_table_s_79_m_is_76_m():
    """1 s of delay at 100 km/h, then 8 m/s^2: 76 m; the 79 m of Table 9 belong to no deceleration of its row."""
    found = float(stopping_distance(100 / 3.6, 8.0, BrakingDelays(reaction_s=1.0)))
    assert round(found) == 76


def test_rolling_and_drag_are_those_of_the_twin():
    assert CAR.rolling_force == pytest.approx(ROLLING * MASS * GRAVITY)
