"""Whitening recovers known colours, and its factors answer what they are for."""

import numpy as np
import pytest
from linear_car import NOISE_STD, LinearCar, effect
from scipy.signal import lfilter

from model_diagnosis.evidence.whitening import (
    SignalFilter,
    fit_whitener,
    form_inflation,
    temperature,
)
from model_diagnosis.huber import huber_loss, huber_weights


def test_autoregression_of_known_coefficients_is_found_and_the_rest_is_white() -> None:
    car = LinearCar([effect("mass")], np.zeros(1), seed=1, samples=6000, manoeuvres=1, colour=0.6)
    whitener = fit_whitener(car, car.residuals(np.zeros(1)))
    for one in whitener.filters[0]:
        np.testing.assert_allclose(one.coefficients, [0.6, 0.0, 0.0, 0.0], atol=4.0 / np.sqrt(6000))
        # 4 standard errors of a standard deviation from 6000 samples, times the inflation that chance gives
        assert one.sigma == pytest.approx(NOISE_STD * np.sqrt(one.inflation), rel=4.0 / np.sqrt(2.0 * 6000))
        assert 1.0 <= one.inflation < 1.4
    rows = whitener.residuals(car.residuals(np.zeros(1)))[0]
    assert abs(np.corrcoef(rows[1:6000], rows[:5999])[0, 1]) < 4.0 / np.sqrt(6000)


def test_a_signal_held_between_samples_is_whitened_at_its_own_rate() -> None:
    samples = np.arange(0, 1000, 10)
    values = np.zeros(1000)
    values[samples] = np.arange(100.0)
    one = SignalFilter("speed", 0, samples, np.array([1.0, 0.0, 0.0, 0.0]), 0.5, 1.0)
    np.testing.assert_allclose(one.apply(values), 2.0)


def test_filter_of_sensitivities_is_that_of_residuals() -> None:
    rng = np.random.default_rng(0)
    one = SignalFilter("speed", 0, np.arange(50), np.array([0.5, -0.2, 0.1, 0.05]), 0.3, 1.0)
    matrix = rng.standard_normal((50, 3))
    together = one.apply(matrix)
    for column in range(3):
        expected = lfilter([1.0, -0.5, 0.2, -0.1, -0.05], [1.0], matrix[:, column])[4:] / 0.3
        np.testing.assert_allclose(together[:, column], expected)


def test_inflation_is_one_for_white_innovations_and_grows_with_drift_and_bursts() -> None:
    rng = np.random.default_rng(4)
    white = rng.standard_normal(20000)
    assert form_inflation(white) < 1.2
    drifting = white + np.repeat(rng.standard_normal(400), 50)
    # a constant of unit variance over 50 samples adds 50 to the variance of the sum over the root of 50 samples
    assert form_inflation(drifting) == pytest.approx(51.0, rel=0.25)
    burst = white.copy()
    burst[:2000] *= 6.0
    assert form_inflation(burst) > 6.0 / 1.5


def test_hubers_loss_is_the_square_within_three_and_its_weight_the_slope() -> None:
    assert huber_loss(np.array([2.0, -3.0])) == pytest.approx(13.0)
    assert huber_loss(np.array([5.0])) == pytest.approx(3.0 * (10.0 - 3.0))
    np.testing.assert_allclose(huber_weights(np.array([2.0, 6.0])), [1.0, 0.5])


def test_temperature_is_the_factor_between_scores_of_blocks_and_their_expectation() -> None:
    rng = np.random.default_rng(5)
    blocks = np.repeat(np.arange(800), 50)
    matrix = np.repeat(rng.standard_normal((800, 7)), 50, axis=0)
    white = rng.standard_normal(40000)
    assert temperature([white], [matrix], [blocks]) == pytest.approx(1.0, abs=0.12)
    # a common part of variance v in all 50 samples of a block: (1 + 50 v) times the variance; Huber's weight lowers it
    common = 0.6 * white + np.repeat(rng.standard_normal(800), 50) * 0.5
    assert temperature([common], [matrix], [blocks]) == pytest.approx(0.36 + 50 * 0.25, rel=0.12)


def test_a_residual_without_noise_is_whitened_as_one_with_half_of_its_sensors() -> None:
    car = LinearCar([effect("mass")], np.zeros(1), seed=1, samples=6000, manoeuvres=1)
    shape = car.residuals(np.zeros(1))[0].shape
    slow = np.repeat(10.0 * NOISE_STD * np.sin(2.0 * np.pi * np.arange(6000) / 300.0)[:, None], shape[1], axis=1)
    noise = 0.5 * NOISE_STD * np.random.default_rng(5).standard_normal(shape)
    quiet, noisy = fit_whitener(car, [slow]), fit_whitener(car, [slow + noise])
    for one, other in zip(quiet.filters[0], noisy.filters[0], strict=True):
        np.testing.assert_allclose(one.coefficients, other.coefficients, atol=4.0 / np.sqrt(6000))
