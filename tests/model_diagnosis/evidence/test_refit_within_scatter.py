"""The refit that a gain is measured against: the best car whose numbers are all within two of their scatters."""

import numpy as np
import pytest
from linear_car import NOISE_STD, LinearCar, effect
from scipy.optimize import lsq_linear

from model_diagnosis.evidence.car_numbers import numbers_within_scatter, refit_within_scatter
from model_diagnosis.evidence.fitting import COST_TOLERANCE, Problem
from model_diagnosis.evidence.priors import Priors
from model_diagnosis.evidence.whitening import sensor_whitener

COLUMNS, NUISANCE = 8, 0.03


@pytest.mark.parametrize("seed", range(4))
def test_no_number_beyond_two_scatters_and_none_fits_better(seed: int) -> None:
    """One number is off by eight scatters; scipy's bounded least squares is the oracle."""
    truth = np.random.default_rng(seed).normal(0.0, NUISANCE, COLUMNS)
    truth[0] = 8.0 * NUISANCE
    car = LinearCar([effect(f"e{number}", nuisance=NUISANCE) for number in range(COLUMNS)], truth, seed)
    priors = Priors.of(car.parameters)
    problem = Problem(car, priors, sensor_whitener(car))
    linearisation = problem.linearise(np.zeros(COLUMNS))
    free = problem.fit(linearisation, priors.nuisance, np.zeros(COLUMNS))
    refit = refit_within_scatter(problem, linearisation, free.theta)
    numbers = numbers_within_scatter(problem, problem.linearise(free.theta), free.theta)
    assert numbers.theta == pytest.approx(refit, abs=0.02 * NUISANCE)
    assert list(numbers.columns) == list(range(COLUMNS))

    rows = np.concatenate([residual.ravel() for residual in car.residuals(np.zeros(COLUMNS))]) / NOISE_STD
    matrix = np.concatenate([values.reshape(-1, COLUMNS) for values in car.matrices]) / NOISE_STD
    prior = np.eye(COLUMNS) / NUISANCE
    assert free.theta[0] > 6.0 * NUISANCE  # with no more than a price it goes to the effect
    assert np.all(np.abs(refit) <= 2.0 * NUISANCE + 1e-12)
    assert refit[0] == pytest.approx(2.0 * NUISANCE)
    # what least squares leave open, its rows as independent as the whitener takes them
    open_ = np.sqrt(np.diag(np.linalg.inv(matrix.T @ matrix + prior.T @ prior)))
    assert numbers.std == pytest.approx(open_, rel=0.1)
    # the fit counts large residuals by Huber's loss, least squares does not: theirs may not be the lower cost
    solved = lsq_linear(
        np.concatenate([matrix, prior]), np.concatenate([rows, np.zeros(COLUMNS)]), (-2.0 * NUISANCE, 2.0 * NUISANCE)
    ).x
    least = problem.cost(problem.rows(solved), solved, priors.nuisance)
    assert problem.cost(problem.rows(refit), refit, priors.nuisance) < least + COST_TOLERANCE
