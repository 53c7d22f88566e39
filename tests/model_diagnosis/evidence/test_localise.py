"""Violated equations: a drifting disturbance is found in the equation that has it."""

import numpy as np
import pytest
from scipy.stats import multivariate_normal

from model_diagnosis.evidence.localise import _log_likelihood, likelihood_ratio, violated_equations


def test_likelihood_of_a_random_walk_under_noise_is_its_gaussian_density() -> None:
    rng = np.random.default_rng(0)
    series = rng.standard_normal(12)
    noise, ratio = 0.7, 0.4
    steps = np.minimum.outer(np.arange(1, 13), np.arange(1, 13))
    covariance = ratio * noise * steps + noise * np.eye(12)
    exact = multivariate_normal(np.zeros(12), covariance).logpdf(series)
    assert _log_likelihood(series, noise, ratio) - 6.0 * np.log(2.0 * np.pi) == pytest.approx(exact)


def test_white_errors_give_no_ratio_and_a_drift_a_large_one() -> None:
    rng = np.random.default_rng(1)
    white = [rng.standard_normal(900) for _ in range(3)]
    drifting = [values + 0.15 * np.cumsum(rng.standard_normal(900)) for values in white]
    # chi-squared with one degree of freedom at its bound: 99.9 % below 9.6; the noise variance is estimated
    assert likelihood_ratio(white) < 12.0
    assert likelihood_ratio(drifting) > 100.0


def test_the_guilty_equation_comes_first_and_gaps_are_left_out() -> None:
    rng = np.random.default_rng(2)
    clean, broken = rng.standard_normal(700), rng.standard_normal(700)
    broken[200:500] += 3.0
    broken[100:120] = np.nan
    errors = [{"yaw moment": clean, "wheel torque fl": broken}]
    found = violated_equations(errors, temperature=2.0)
    assert list(found) == ["wheel torque fl", "yaw moment"]
    assert found["wheel torque fl"] > 20.0 * max(found["yaw moment"], 1.0)
