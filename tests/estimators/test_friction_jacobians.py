"""Model and Jacobians of the friction EKF against the document's equations, written here a second time.

The second writing is complex-valued, so that its derivatives come from complex steps, exact to rounding.
"""

import itertools

import friction_twin as twin
import numpy as np
import pytest

from estimators import friction_model as model
from estimators.friction_jacobians import (
    DESIGN_COLUMNS,
    MEASUREMENTS,
    TRANSITION_COLUMNS,
    measure,
    predict,
)
from estimators.friction_settings import FrictionEkfSettings
from estimators.friction_setup import model_parameters
from estimators.vehicle_numbers import longitudinal_car

T = 0.001
CASES = ["AA", "AB", "BA", "BB"]
SIGNS = [1, -1]
CAR = longitudinal_car(twin.TABLE_8)


def parameters(sign=1, exact=False):
    return model_parameters(CAR, FrictionEkfSettings(slip_rate_sign=sign, exact_load_transfer=exact))


def random_state(case: str, random: np.random.Generator) -> np.ndarray:
    """A state in one of the four cases: A wheel faster than the car, B slower."""
    v = random.uniform(5.0, 40.0)
    rim = [v * (random.uniform(1.02, 1.4) if side == "A" else random.uniform(0.1, 0.97)) for side in case]
    slip = [(r - v) / max(r, v) + random.uniform(-0.01, 0.01) for r in rim]
    w = [r / twin.RADIUS for r in rim]
    return np.array([v, *w, *slip, random.uniform(0.2, 1.3), random.uniform(-1, 1), random.uniform(0.2, 1.3), 0.1])


def document_forces(x, exact):
    """Axle forces, loads and acceleration, sections 3.6.3 (eqs 90-96)."""
    k1, k2 = twin.SET_T
    m, g, length, l_f, h = twin.MASS, twin.GRAVITY, twin.WHEELBASE, twin.FRONT, twin.HEIGHT
    mu_f = x[5] * np.sin(k1 * np.arctan(k2 * x[3]))
    mu_r = x[7] * np.sin(k1 * np.arctan(k2 * x[4]))
    d = length + h * (mu_f - mu_r)
    drag = twin.DRAG * x[0] ** 2
    roll = m * g * twin.ROLLING
    if exact:
        z_f = (m * g * (length - l_f - h * mu_r) + (roll + drag) * h - drag * h) / d
        z_r = m * g - z_f
    else:
        shift = twin.DRAG * h * x[0] ** 2 / length
        z_f = m * g * (length - l_f - h * mu_r) / d - shift
        z_r = m * g * (l_f + h * mu_f) / d + shift
    f_f, f_r = mu_f * z_f, mu_r * z_r
    return f_f, f_r, z_f, z_r, (f_f + f_r - roll - drag) / m


def document_step(x, torques, sign, exact, case):
    """x + T xdot, section 3.6.3 and 3.6.4; the branch is given, so that it holds for complex x."""
    f_f, f_r, _, _, a = document_forces(x, exact)
    r = twin.RADIUS
    eta = [(torques[0] - r * f_f) / twin.AXLE_INERTIA, (torques[1] - r * f_r) / twin.AXLE_INERTIA]
    rates = []
    for axle in range(2):
        w, s = x[1 + axle], x[3 + axle]
        if case[axle] == "B":
            rates.append(-(1 + s) * a / x[0] + sign * r * eta[axle] / x[0])
        else:
            rates.append((1 - s) * eta[axle] / w - a / (r * w))
    return x + T * np.array([a, *eta, *rates, x[6], 0.0, x[8], 0.0])


def document_measurement(x, exact, case):
    """h(x), section 3.6.2."""
    a = document_forces(x, exact)[4]
    rim = twin.RADIUS * x[1:3]
    slips = [(rim[axle] - x[0]) / (x[0] if case[axle] == "B" else rim[axle]) - x[3 + axle] for axle in range(2)]
    return np.array([a, x[1], x[2], *slips, x[5], x[7], x[0]])


def complex_jacobian(function, x, rows):
    result = np.zeros((rows, len(x)))
    for j in range(len(x)):
        moved = x.astype(complex)
        moved[j] += 1e-30j
        result[:, j] = function(moved).imag / 1e-30
    return result


def run_predict(x, torques, sign=1, exact=False, kinematic=False):
    predicted, transition = np.zeros(9), np.zeros((9, 9))
    four = np.array([torques[0], torques[1], 0.0, 0.0]) if len(torques) == 2 else np.array(torques)
    predict(x, four, T, parameters(sign, exact), kinematic, np.zeros((4, 6)), predicted, transition)
    return predicted, transition


def run_measure(x, exact=False):
    expected, design = np.zeros(MEASUREMENTS), np.zeros((MEASUREMENTS, 9))
    measure(x, parameters(exact=exact), np.zeros((4, 6)), expected, design)
    return expected, design


@pytest.mark.acceptance("F-18", "F-19")
@pytest.mark.parametrize(("case", "sign", "exact"), list(itertools.product(CASES, SIGNS, [False, True])))
def test_step_and_jacobian_equal_the_document(case, sign, exact, record):
    random = np.random.default_rng(hash_of(case) + sign)
    worst = 0.0
    for _ in range(25):
        x = random_state(case, random)
        torques = random.uniform(-3000, 2000, 2)
        predicted, transition = run_predict(x, torques, sign, exact)
        assert predicted == pytest.approx(document_step(x, torques, sign, exact, case), rel=1e-12, abs=1e-12)
        exactly = complex_jacobian(lambda z, u=torques: document_step(z, u, sign, exact, case), x, 9)
        # what the step changes, F - I, is small against the identity: it is compared by itself
        own, theirs = (transition - np.eye(9)) / T, (exactly - np.eye(9)) / T
        worst = max(worst, (np.abs(own - theirs) / np.maximum(np.abs(theirs), 1.0)).max())
    record("F - I against complex steps, relative", worst, "1e-6", id="F-19")
    assert worst < 1e-9


@pytest.mark.acceptance("F-18", "F-19")
@pytest.mark.parametrize(("case", "exact"), list(itertools.product(CASES, [False, True])))
def test_measurement_and_jacobian_equal_the_document(case, exact, record):
    random = np.random.default_rng(hash_of(case))
    worst = 0.0
    for _ in range(25):
        x = random_state(case, random)
        expected, design = run_measure(x, exact)
        assert expected == pytest.approx(document_measurement(x, exact, case), rel=1e-12, abs=1e-12)
        exactly = complex_jacobian(lambda z: document_measurement(z, exact, case), x, MEASUREMENTS)
        worst = max(worst, (np.abs(design - exactly) / np.maximum(np.abs(exactly), 1.0)).max())
    record("H against complex steps, relative", worst, "1e-6", id="F-19")
    assert worst < 1e-9


@pytest.mark.acceptance("F-19")
@pytest.mark.parametrize(("case", "sign"), list(itertools.product(CASES, SIGNS)))
def test_jacobians_equal_finite_differences(case, sign, record):
    random = np.random.default_rng(7)
    worst = 0.0
    for _ in range(10):
        x = random_state(case, random)
        torques = random.uniform(-3000, 2000, 2)
        transition = run_predict(x, torques, sign)[1]
        design = run_measure(x)[1]
        for j in range(9):
            step = 1e-6 * max(abs(x[j]), 0.1)
            up, down = x.copy(), x.copy()
            up[j] += step
            down[j] -= step
            column = (run_predict(up, torques, sign)[0] - run_predict(down, torques, sign)[0]) / (up[j] - down[j])
            worst = max(worst, (np.abs(column - transition[:, j]) / np.maximum(np.abs(column), 1.0)).max())
            column = (run_measure(up)[0] - run_measure(down)[0]) / (up[j] - down[j])
            worst = max(worst, (np.abs(column - design[:, j]) / np.maximum(np.abs(column), 1.0)).max())
    record("F and H against finite differences, relative", worst, "1e-6")
    assert worst < 1e-6


@pytest.mark.acceptance("F-20")
@pytest.mark.parametrize("case", CASES)
def test_non_zero_pattern(case, record):
    """The pattern of 3.6.5, counted from 1 as there; columns 2 and 3 of rows 4 and 5 only in branch A."""
    random = np.random.default_rng(3)
    found = np.zeros((9, 9), dtype=bool)
    for _ in range(10):
        found |= run_predict(random_state(case, random), random.uniform(-3000, 2000, 2))[1] != 0.0
    pattern = [
        {1, 4, 5, 6, 8},
        {1, 2, 4, 5, 6, 8},
        {1, 3, 4, 5, 6, 8},
        {1, 4, 5, 6, 8} | ({2} if case[0] == "A" else set()),
        {1, 4, 5, 6, 8} | ({3} if case[1] == "A" else set()),
        {6, 7},
        {7},
        {8, 9},
        {9},
    ]
    for row, columns in enumerate(pattern):
        assert set(np.flatnonzero(found[row]) + 1) == columns
    transition = run_predict(random_state(case, random), (0.0, 0.0))[1]
    record("F[6,7]", transition[5, 6], "T = 0.001")
    record("F[8,9]", transition[7, 8], "T = 0.001")
    assert transition[5, 6] == transition[7, 8] == T


def test_declared_columns_cover_all_entries():
    random = np.random.default_rng(4)
    for case in CASES:
        x = random_state(case, random)
        for matrix, columns in (
            (run_predict(x, (-500.0, 300.0))[1], TRANSITION_COLUMNS),
            (run_measure(x)[1], DESIGN_COLUMNS),
        ):
            for row, declared in zip(matrix, columns, strict=True):
                assert set(np.flatnonzero(row)) <= set(declared)


@pytest.mark.acceptance("F-21")
@pytest.mark.parametrize("case", CASES)
def test_slip_rate_is_the_derivative_of_the_slip_only_with_plus(case, record):
    """Eq. 98 against the derivative of eq. 97 along a motion; -1 is the printed sign, wrong where v >= R w."""
    random = np.random.default_rng(5)
    for _ in range(10):
        x = random_state(case, random)
        v, wheels = x[0], x[1:3]
        a, eta = random.uniform(-11, 5), random.uniform(-300, 300, 2)
        for axle, wheel in enumerate(wheels):
            h = 1e-6
            later = model.slip_ratio(v + a * h, twin.RADIUS * (wheel + eta[axle] * h))
            before = model.slip_ratio(v - a * h, twin.RADIUS * (wheel - eta[axle] * h))
            numeric = (later - before) / (2 * h)
            slip = model.slip_ratio(v, twin.RADIUS * wheel)
            own = {sign: model.slip_rate(v, wheel, slip, a, eta[axle], twin.RADIUS, float(sign)) for sign in SIGNS}
            assert own[1] == pytest.approx(numeric, rel=1e-6, abs=1e-6)
            if case[axle] == "B":
                assert abs(own[-1] - numeric) == pytest.approx(2 * twin.RADIUS * abs(eta[axle]) / v, rel=1e-3)
    record("slip rate against numeric derivative, sign +1", abs(own[1] - numeric), "1e-6 relative; -1 differs")


def test_loads_of_the_document_at_95_kmh():
    """3.6.3 [CHK]: eq. 95 gives 9302/3412 N, exact 9412/3301 N at 95 km/h with used friction 1.1/1.0."""
    for exact, front, rear in ((False, 9302.0, 3412.0), (True, 9412.0, 3301.0)):
        k1, k2 = twin.SET_T
        peak = -np.tan(np.pi / 2 / k1) / k2
        x = np.array([95 / 3.6, 90.0, 90.0, peak, peak, 1.1, 0.0, 1.0, 0.0])
        forces = np.zeros((4, 6))
        model.axle_forces(x, parameters(exact=exact), forces)
        # friction used is negative in braking
        assert forces[model.AXLES, model.USED_F] == pytest.approx(-1.1)
        assert forces[model.AXLES, model.LOAD_F] == pytest.approx(front, abs=1.0)
        assert forces[model.AXLES, model.LOAD_R] == pytest.approx(rear, abs=1.0)


def test_a_brake_stops_a_wheel_but_never_turns_it_backwards():
    """A locked wheel with far more brake torque than the road can turn it: it stays, and its row tells nothing."""
    x = np.array([20.0, 0.0, 0.0, -1.0, -1.0, 1.0, 0.0, 1.0, 0.0])
    predicted, transition = run_predict(x, (0.0, 0.0, 5000.0, 5000.0))
    assert predicted[1] == predicted[2] == 0.0
    assert predicted[3] == pytest.approx(-1.0)
    assert not transition[1].any()
    # just before: finite differences of the stopped branch
    x[1], x[3] = 0.5, 0.5 * twin.RADIUS / 20.0 - 1.0
    transition = run_predict(x, (0.0, 0.0, 5000.0, 5000.0))[1]
    for j in range(9):
        up, down = x.copy(), x.copy()
        up[j] += 1e-6
        down[j] -= 1e-6
        step = [run_predict(z, (0.0, 0.0, 5000.0, 5000.0))[0] for z in (up, down)]
        assert (step[0] - step[1]) / 2e-6 == pytest.approx(transition[:, j], rel=1e-6, abs=1e-6)


def test_kinematic_wheels_are_random_walks():
    x = random_state("BB", np.random.default_rng(6))
    predicted, transition = run_predict(x, (-900.0, -400.0), kinematic=True)
    assert np.array_equal(predicted[1:5], x[1:5])
    assert np.array_equal(transition[1:5], np.eye(9)[1:5])


def hash_of(text: str) -> int:
    return sum(ord(c) << (8 * i) for i, c in enumerate(text))
