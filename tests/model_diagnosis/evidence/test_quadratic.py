"""Evidence from sensitivities equals the exact Bayes factor of the Gaussian model, computed from its densities."""

import numpy as np
import pytest
from numpy.typing import NDArray
from scipy.stats import multivariate_normal

from model_diagnosis.evidence.quadratic import Quadratic, effect_evidence, widening

FloatArray = NDArray[np.float64]


def _model(seed: int, samples: int = 40, columns: int = 5) -> tuple[FloatArray, FloatArray, FloatArray]:
    rng = np.random.default_rng(seed)
    matrix = rng.standard_normal((samples, columns)) * rng.uniform(0.2, 6.0, columns)
    matrix[:, 1] = 0.95 * matrix[:, 0] + 0.1 * matrix[:, 1]
    widths = rng.uniform(0.05, 0.3, columns)
    data = matrix @ (rng.standard_normal(columns) * 0.5) + rng.standard_normal(samples)
    return matrix, widths, data


def _quadratic(matrix: FloatArray, data: FloatArray) -> Quadratic:
    return Quadratic(matrix.T @ matrix, matrix.T @ data)


def _log_marginal(matrix: FloatArray, data: FloatArray, widths: FloatArray) -> float:
    covariance = np.eye(len(data)) + matrix @ np.diag(widths**2) @ matrix.T
    return float(multivariate_normal(np.zeros(len(data)), covariance).logpdf(data))


@pytest.mark.parametrize("seed", range(5))
@pytest.mark.parametrize("columns", [(0,), (3,), (0, 1), (1, 2, 4)])
def test_log_bayes_factor_is_the_ratio_of_the_marginal_likelihoods(seed: int, columns: tuple[int, ...]) -> None:
    matrix, nuisance, data = _model(seed)
    present = nuisance.copy()
    present[list(columns)] = 1.0
    exact = _log_marginal(matrix, data, present) - _log_marginal(matrix, data, nuisance)
    found = effect_evidence(_quadratic(matrix, data), nuisance, np.ones(5), [columns])[0]
    assert found == pytest.approx(exact, abs=1e-8)


def test_log_bayes_factor_is_the_ratio_of_the_integrals_over_the_deviation() -> None:
    matrix, nuisance, data = _model(11, columns=2)
    grid = np.linspace(-6.0, 6.0, 4001)

    def integral(width: float) -> float:
        # the second deviation is integrated by its Gaussian, the first by plain summation
        covariance = np.eye(len(data)) + np.outer(matrix[:, 1], matrix[:, 1]) * nuisance[1] ** 2
        density = multivariate_normal(np.zeros(len(data)), covariance)
        logs = np.array([density.logpdf(data - matrix[:, 0] * value) for value in grid])
        logs += -0.5 * (grid / width) ** 2 - np.log(width * np.sqrt(2.0 * np.pi))
        return float(np.logaddexp.reduce(logs) + np.log(grid[1] - grid[0]))

    found = effect_evidence(_quadratic(matrix, data), nuisance, np.ones(2), [(0,)])[0]
    assert found == pytest.approx(integral(1.0) - integral(nuisance[0]), abs=1e-6)


def test_projected_score_and_information_are_those_of_the_marginal_covariance() -> None:
    matrix, nuisance, data = _model(3)
    covariance = np.eye(len(data)) + matrix @ np.diag(nuisance**2) @ matrix.T
    score, information = _quadratic(matrix, data).projected(nuisance)
    np.testing.assert_allclose(score, matrix.T @ np.linalg.solve(covariance, data), rtol=1e-9)
    np.testing.assert_allclose(information, matrix.T @ np.linalg.solve(covariance, matrix), rtol=1e-8, atol=1e-9)


def test_one_deviation_follows_the_score_test_formula() -> None:
    score, information, added = 4.0, 2.5, 0.9
    expected = 0.5 * score**2 * added / (1.0 + added * information) - 0.5 * np.log(1.0 + added * information)
    assert widening(np.array([score]), np.array([[information]]), np.array([added])) == pytest.approx(expected)


def test_posterior_is_the_ridge_estimate_and_evidence_differences_are_log_bayes_factors() -> None:
    matrix, nuisance, data = _model(7)
    quadratic = _quadratic(matrix, data)
    mean, covariance = quadratic.posterior(nuisance)
    stacked = np.vstack([matrix, np.diag(1.0 / nuisance)])
    expected, *_ = np.linalg.lstsq(stacked, np.concatenate([data, np.zeros(5)]), rcond=None)
    np.testing.assert_allclose(mean, expected, rtol=1e-8)
    np.testing.assert_allclose(covariance, np.linalg.inv(stacked.T @ stacked), rtol=1e-8)
    wider = nuisance.copy()
    wider[2] = 1.0
    assert quadratic.log_evidence(wider) - quadratic.log_evidence(nuisance) == pytest.approx(
        effect_evidence(quadratic, nuisance, np.ones(5), [(2,)])[0], abs=1e-8
    )
