"""Violated equations: the likelihood of an error of its own, and where it is found."""

import numpy as np
import pytest
from linear_car import LinearCar, effect
from scipy.optimize import minimize_scalar
from scipy.stats import multivariate_normal

from model_diagnosis.evidence.fitting import Problem
from model_diagnosis.evidence.localise import (
    EquationErrors,
    block_diagonal,
    violated_by_innovations,
    violated_equations,
    violation,
)
from model_diagnosis.evidence.priors import Priors
from model_diagnosis.evidence.whitening import sensor_whitener
from model_diagnosis.replay.disturbances import ErrorAnswers


def test_violation_is_the_largest_likelihood_of_a_gaussian_with_the_error_in_its_covariance() -> None:
    """Against scipy's density: residual e ~ N(0, I + q S S'), here with S of 4 columns and an error of size 0.8."""
    rng = np.random.default_rng(0)
    answers = rng.standard_normal((30, 4))
    residual = rng.standard_normal(30) + answers @ (0.8 * rng.standard_normal(4))

    def minus_log_density(log_variance: float) -> float:
        covariance = np.eye(30) + np.exp(log_variance) * answers @ answers.T
        return -float(multivariate_normal(np.zeros(30), covariance).logpdf(residual))

    best = minimize_scalar(minus_log_density, bounds=(-10.0, 5.0), method="bounded")
    nothing = float(multivariate_normal(np.zeros(30), np.eye(30)).logpdf(residual))
    found = violation(answers.T @ residual, answers.T @ answers)
    assert found.likelihood_ratio == pytest.approx(2.0 * (-best.fun - nothing), rel=1e-3)
    assert found.std == pytest.approx(np.exp(0.5 * best.x), rel=0.02)


def test_a_share_that_all_manoeuvres_have_in_common_is_one_error_beside_the_scatter_of_the_numbers() -> None:
    """Against scipy's density of N(0, I + J D J' + q s s'), s an error of 0.05 of levels 1, 2 and 4 in one vector.

    A constant beside it and a draw for each manoeuvre would cost more numbers.
    """
    rng = np.random.default_rng(4)
    levels = np.array([1.0, 2.0, 4.0])
    car = LinearCar([effect("scattered", 2, nuisance=0.05)], np.array([0.04, -0.06]), 4, len(levels), samples=60)
    answers = [rng.standard_normal((60, 3, 2)) for _ in levels]
    for manoeuvre, answer, level in zip(car.manoeuvres, answers, levels, strict=True):
        for column, name in enumerate(car.signals(0)):
            manoeuvre.channels[name] = manoeuvre.channels[name] + 0.05 * level * answer[:, column, 1]
    problem = Problem(car, Priors.of(car.parameters), sensor_whitener(car))
    linearisation = problem.linearise(np.zeros(2))

    def told(m: int) -> dict[str, ErrorAnswers]:
        return {"share": ErrorAnswers(("constant", "torque"), np.array([1.0, levels[m]]), answers[m])}

    found = violated_by_innovations(problem, linearisation, np.zeros(2), told)["share"]

    root_weights = [np.sqrt(weight) for weight in linearisation.weights]
    residual = np.concatenate([w * r for w, r in zip(root_weights, problem.rows(np.zeros(2)), strict=True)])
    matrix = np.concatenate([w[:, None] * m for w, m in zip(root_weights, linearisation.matrices, strict=True)])
    error = np.concatenate(
        [
            w * level * problem.whitener.whitened(m, answers[m])[:, 1]
            for m, (w, level) in enumerate(zip(root_weights, levels, strict=True))
        ]
    )
    scatter = matrix @ np.diag((problem.priors.nuisance / problem.scale) ** 2) @ matrix.T

    def log_density(share: float) -> float:
        covariance = np.eye(len(residual)) + scatter + share**2 * np.outer(error, error)
        return float(multivariate_normal(np.zeros(len(residual)), covariance).logpdf(residual))

    best = minimize_scalar(lambda share: -log_density(share), bounds=(0.0, 0.5), method="bounded")
    assert best.x == pytest.approx(0.05, rel=0.1)
    assert found.likelihood_ratio == pytest.approx(2.0 * (-best.fun - log_density(0.0)), rel=1e-3)
    assert found.std == pytest.approx(best.x * np.sqrt(np.mean(levels**2)), rel=0.01)


def test_without_an_error_the_ratio_is_zero_in_half_of_all_cases_and_small_in_the_others() -> None:
    """Half a chi-squared of one degree of freedom (Self and Liang 1987): 99 % are below 5.4."""
    rng = np.random.default_rng(1)
    ratios = []
    for _ in range(400):
        answers = rng.standard_normal((60, 12))
        ratios.append(violation(answers.T @ rng.standard_normal(60), answers.T @ answers).likelihood_ratio)
    assert 0.4 < np.mean(np.array(ratios) == 0.0) < 0.75
    assert np.quantile(ratios, 0.99) < 5.4


def test_errors_up_to_the_usual_size_are_no_violation() -> None:
    rng = np.random.default_rng(2)
    answers = 5.0 * rng.standard_normal((60, 12))
    residual = rng.standard_normal(60) + answers @ (0.5 * rng.standard_normal(12))
    score, information = answers.T @ residual, answers.T @ answers
    assert violation(score, information).likelihood_ratio > 50.0
    assert violation(score, information, usual=1.0).likelihood_ratio == 0.0


def test_the_guilty_equation_comes_first_and_gaps_are_left_out() -> None:
    rng = np.random.default_rng(3)
    course = np.sin(np.arange(700) * 0.02)
    noise = {name: rng.standard_normal(700) for name in ("yaw moment", "wheel torque fl")}
    broken = noise["wheel torque fl"] + 1.5 * course
    broken[100:120] = np.nan
    errors = EquationErrors(
        nothing=noise | {"wheel torque fl": broken},
        saturated=noise,
        scattered=[dict.fromkeys(noise, 0.05 * course)],
        courses={name: [np.ones(700), course / np.sqrt(np.mean(course**2))] for name in noise},
    )
    found = violated_equations([errors, errors], temperature=2.0)
    assert list(found) == ["wheel torque fl", "yaw moment"]
    assert found["wheel torque fl"].likelihood_ratio > 50.0
    # constant 0 and share 1.5 of a course of rms 0.71: sqrt(1.06^2 / 2)
    assert found["wheel torque fl"].std == pytest.approx(0.75, abs=0.15)
    assert found["yaw moment"].likelihood_ratio < 5.0


def test_blocks_stand_on_the_diagonal() -> None:
    joined = block_diagonal([np.full((2, 2), 3.0), np.array([[7.0]])])
    np.testing.assert_array_equal(joined, [[3.0, 3.0, 0.0], [3.0, 3.0, 0.0], [0.0, 0.0, 7.0]])
