"""Separation is the expected log evidence between two causes; the plan picks the manoeuvre that has the most of it."""

import numpy as np
import pytest
from linear_car import LinearCar, effect
from numpy.typing import NDArray

from model_diagnosis.evidence.base import fit_base
from model_diagnosis.evidence.groups import canonical_correlation, separation
from model_diagnosis.evidence.manoeuvre_library import LIBRARY, PlannedManoeuvre
from model_diagnosis.evidence.plan import Pair, plan
from model_diagnosis.evidence.priors import Priors
from model_diagnosis.evidence.quadratic import Quadratic

FloatArray = NDArray[np.float64]


def test_separation_of_two_deviations_is_half_theta_squared_g_one_minus_rho_squared() -> None:
    information = np.array([[9.0, 4.0], [4.0, 5.0]])
    rho = 4.0 / np.sqrt(45.0)
    assert separation(information, np.array([1.3]), (0,), (1,)) == pytest.approx(0.5 * 1.69 * 9.0 * (1.0 - rho**2))
    assert canonical_correlation(information, (0,), (1,)) == pytest.approx(rho)


def test_separation_is_the_mean_difference_of_the_best_log_likelihoods() -> None:
    rng = np.random.default_rng(0)
    first, second = rng.standard_normal((50, 1)), rng.standard_normal((50, 2))
    second[:, :1] += 2.0 * first
    matrix = np.hstack([first, second])
    size = np.array([0.8])
    differences = []
    for _ in range(4000):
        data = first @ size + rng.standard_normal(50)
        left = [np.sum((data - part @ np.linalg.lstsq(part, data, rcond=None)[0]) ** 2) for part in (first, second)]
        differences.append(0.5 * (left[1] - left[0]))
    # each fitted deviation takes half a unit of log likelihood by chance: 1 of the first, 2 of the second
    expected = separation(matrix.T @ matrix, size, (0,), (1, 2)) - 0.5
    assert np.mean(differences) == pytest.approx(expected, abs=4.0 * np.std(differences) / np.sqrt(4000))


def test_separation_grows_with_the_size_and_vanishes_for_equal_sensitivities() -> None:
    information = np.array([[4.0, 3.9], [3.9, 4.0]])
    small, large = (separation(information, np.array([size]), (0,), (1,)) for size in (0.5, 5.0))
    assert large == pytest.approx(100.0 * small)
    assert separation(np.full((2, 2), 4.0), np.array([3.0]), (0,), (1,)) == pytest.approx(0.0, abs=1e-6)


def test_canonical_correlation_finds_the_shared_direction_of_two_subspaces() -> None:
    rng = np.random.default_rng(1)
    basis, _ = np.linalg.qr(rng.standard_normal((30, 5)))
    matrix = np.column_stack([basis[:, :2], basis[:, 2], 0.6 * basis[:, 1] + 0.8 * basis[:, 3]])
    assert canonical_correlation(matrix.T @ matrix, (0, 1), (2, 3)) == pytest.approx(0.6)


def _problem() -> tuple[LinearCar, FloatArray]:
    effects = [effect(name) for name in ("pads", "mass", "drag")]
    car = LinearCar(effects, np.array([0.3, 0.0, 0.0]), 3, same=[(0, 1, 1.0)])
    return car, np.array([0.3, 0.0, 0.0])


def test_the_plan_is_the_manoeuvre_that_separates_the_pair() -> None:
    car, theta = _problem()
    base = fit_base(car, Priors.of(car.parameters))
    useless = PlannedManoeuvre("same again", "", 20.0, 3.0)
    useful = PlannedManoeuvre("other", "", 20.0, 3.0)

    def simulate(planned: PlannedManoeuvre, _theta: FloatArray) -> LinearCar:
        same = [(0, 1, 1.0)] if planned is useless else []
        return LinearCar(car.effects, theta, 9, manoeuvres=1, same=same)

    pair = Pair("pads", "mass", (0,), base.problem.scaled(theta)[:1], (1,))
    ratios = base.problem.priors.nuisance / base.problem.scale
    known = base.at_nothing.information
    _, projected = Quadratic(known, np.zeros(3)).projected(ratios)
    assert separation(projected, pair.size, pair.columns, pair.other) < 0.1
    found = plan(base.problem, known, theta, [pair], ratios, (), simulate, (0, 1, 2), (useless, useful))
    assert found is not None
    assert found.name == "other"
    assert found.expected_evidence > 3.0
    nothing = plan(base.problem, known, theta, [pair], ratios, (), simulate, (0, 1, 2), (useless,))
    assert nothing is not None
    assert nothing.name == "none"


def test_a_column_of_a_single_manoeuvre_at_hand_does_not_act_in_a_planned_one() -> None:
    """A friction that one manoeuvre alone has stands behind the catalogue's columns; a planned replay has none such."""
    effects = [effect(name) for name in ("pads", "mass", "drag", "mu_step.m2")]
    theta = np.array([0.3, 0.0, 0.0, 0.2])
    car = LinearCar(effects, theta, 3, same=[(0, 1, 1.0)])
    base = fit_base(car, Priors.of(car.parameters))

    def simulate(_planned: PlannedManoeuvre, _theta: FloatArray) -> LinearCar:
        return LinearCar(effects[:3], theta[:3], 9, manoeuvres=1)

    pair = Pair("pads", "mass", (0,), base.problem.scaled(theta)[:1], (1,))
    ratios, known = base.problem.priors.nuisance / base.problem.scale, base.at_nothing.information
    other = PlannedManoeuvre("other", "", 20.0, 3.0)
    asked = {
        columns: plan(base.problem, known, theta, [pair], ratios, (), simulate, columns, (other,))
        for columns in ((0, 1, 2), (0, 1, 2, 3))
    }
    with_it, without = asked[0, 1, 2, 3], asked[0, 1, 2]
    assert with_it is not None
    assert without is not None
    assert with_it.name == "other"
    assert with_it.expected_evidence == without.expected_evidence


def test_the_library_has_thirty_manoeuvres_with_inputs_that_can_be_driven() -> None:
    assert len(LIBRARY) >= 30
    assert len({planned.name for planned in LIBRARY}) == len(LIBRARY)
    for planned in LIBRARY:
        time, inputs = planned.inputs("r")
        assert {len(values) for values in inputs.values()} == {len(time)}
        assert inputs["brake_pressure_fl"].min() >= 0.0
        assert inputs["brake_pressure_fl"].max() <= 120e5
        assert not inputs["drive_torque_f"].any()
