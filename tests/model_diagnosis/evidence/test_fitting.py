"""Fits within bounds against a solver that nobody here wrote."""

import numpy as np
import pytest
from linear_car import NOISE_STD, SIGNALS, LinearCar
from scipy.optimize import lsq_linear

from model_diagnosis.effects.effect import Application, Effect, EffectParameter, Group
from model_diagnosis.evidence.bounded import ROUNDS, lowest_within
from model_diagnosis.evidence.fitting import COST_TOLERANCE, Problem
from model_diagnosis.evidence.priors import Priors
from model_diagnosis.evidence.whitening import sensor_whitener

COLUMNS = 12


def _never_negative(number: int) -> Effect:
    parameter = EffectParameter("size", "1", 0.0, 1.0, 0.2, 0.2, "body.mass")
    return Effect(f"e{number}", Group.BODY, Application.PLANT, "y = S x", (parameter,), SIGNALS, "any")


@pytest.mark.parametrize("seed", range(6))
def test_fit_within_bounds_is_the_least_squares_solution(seed: int) -> None:
    """Columns that nearly repeat each other: what pushes one over its bound has to move the others."""
    truth = np.random.default_rng(seed).normal(0.0, 0.2, COLUMNS)
    car = LinearCar([_never_negative(number) for number in range(COLUMNS)], truth, seed)
    for matrix in car.matrices:
        matrix += 30.0 * matrix.mean(axis=2, keepdims=True) * COLUMNS**0.5
    priors = Priors.of(car.parameters)
    problem = Problem(car, priors, sensor_whitener(car))
    start = np.full(COLUMNS, 0.01)
    fit = problem.fit(problem.linearise(start), priors.nuisance, start)

    rows = np.concatenate([residual.ravel() for residual in car.residuals(np.zeros(COLUMNS))]) / NOISE_STD
    matrix = np.concatenate([values.reshape(-1, COLUMNS) for values in car.matrices]) / NOISE_STD
    prior = np.diag(1.0 / priors.nuisance)
    solved = lsq_linear(
        np.concatenate([matrix, prior]), np.concatenate([rows, np.zeros(COLUMNS)]), (priors.low, priors.high)
    ).x
    least = problem.cost(problem.rows(solved), solved, priors.nuisance)
    assert np.sum(solved < 1e-6) >= 3  # bounds that hold
    assert fit.cost < least + COST_TOLERANCE


@pytest.mark.parametrize("rounds", [ROUNDS, 0], ids=["pivoting", "one by one"])
@pytest.mark.parametrize("seed", range(20))
def test_lowest_point_within_bounds(seed: int, rounds: int, monkeypatch: pytest.MonkeyPatch) -> None:
    """Karush-Kuhn-Tucker: the slope is 0 inside and presses against every bound that holds."""
    monkeypatch.setattr("model_diagnosis.evidence.bounded.ROUNDS", rounds)
    random = np.random.default_rng(seed)
    root = random.standard_normal((30, 30)) + 5.0 * random.standard_normal((1, 30))
    curvature, gradient = root.T @ root + 0.1 * np.eye(30), 30.0 * random.standard_normal(30)
    low, high = -random.exponential(0.5, 30), random.exponential(0.5, 30)
    low[:5] = high[5:10] = low[10] = high[10] = 0.0
    point = lowest_within(curvature, gradient, low, high)
    slope = gradient - curvature @ point
    assert np.all((low <= point) & (point <= high))
    at_low, at_high = point - low < 1e-9, high - point < 1e-9
    assert np.abs(slope[~at_low & ~at_high]).max() < 1e-6 * np.abs(gradient).max()
    assert np.all(slope[at_low & ~at_high] <= 1e-6)
    assert np.all(slope[at_high & ~at_low] >= -1e-6)
