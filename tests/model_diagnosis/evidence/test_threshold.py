"""Threshold, probabilities and detection limits against simulation of the data they speak of."""

import numpy as np
import pytest
from scipy.stats import chi2

from model_diagnosis.evidence.quadratic import Quadratic, effect_evidence
from model_diagnosis.evidence.threshold import bootstrap_maxima, detection_limits, probabilities, threshold


def test_bootstrap_from_the_information_equals_simulating_the_data() -> None:
    rng = np.random.default_rng(0)
    matrix = rng.standard_normal((60, 6)) * np.array([8.0, 5.0, 3.0, 2.0, 1.0, 0.5])
    nuisance = np.full(6, 0.15)
    hypotheses = [(0,), (1,), (2,), (3,), (4, 5)]
    simulated = []
    for _ in range(1500):
        data = matrix @ (nuisance * rng.standard_normal(6)) + rng.standard_normal(60)
        quadratic = Quadratic(matrix.T @ matrix, matrix.T @ data)
        simulated.append(float(np.max(effect_evidence(quadratic, nuisance, np.ones(6), hypotheses))))
    drawn = bootstrap_maxima(matrix.T @ matrix, nuisance, hypotheses, np.random.default_rng(1), draws=1500)
    for level in (0.5, 0.9, 0.975):
        # 4 standard errors of the share of 1500 draws below a quantile
        share = float(np.mean(np.array(simulated) <= np.quantile(drawn, level)))
        assert share == pytest.approx(level, abs=4.0 * np.sqrt(2.0 * level * (1.0 - level) / 1500) + 1e-9)


def test_columns_that_the_data_does_not_inform_change_no_draw() -> None:
    """A catalogue that grows by an effect of the brakes asks for the same evidence in a drive without braking."""
    matrix = np.random.default_rng(0).standard_normal((60, 4)) * np.array([8.0, 5.0, 3.0, 2.0])
    wide = np.zeros((60, 6))
    wide[:, [0, 2, 3, 5]] = matrix
    told = bootstrap_maxima(
        matrix.T @ matrix, np.full(4, 0.15), [(0,), (1, 2), (3,)], np.random.default_rng(1), draws=200
    )
    beside = bootstrap_maxima(
        wide.T @ wide, np.full(6, 0.15), [(0,), (1,), (2, 3, 4), (5,)], np.random.default_rng(1), draws=200
    )
    np.testing.assert_array_equal(beside, told)


def test_threshold_is_never_below_the_price_of_the_search() -> None:
    assert threshold(np.zeros(100), 75, 6) == pytest.approx(np.log(20.0) + 0.5 * np.log(75.0))
    assert threshold(np.full(100, 9.0), 75, 6) == pytest.approx(9.0)


def test_few_manoeuvres_ask_for_what_errors_of_form_make_of_healthy_cars() -> None:
    """Healthy cars of the generator reached 8.8 where the bootstrap asks for 5.5."""
    assert threshold(np.full(100, 5.5), 75, 3) < 8.8 < threshold(np.full(100, 5.5), 75, 2)


def test_probabilities_are_those_of_bayes_rule_with_equal_priors() -> None:
    found, nothing = probabilities(np.array([np.log(6.0), np.log(2.0), -np.inf]))
    # half the prior on nothing, a quarter on each effect that was tested: 0.25*6, 0.25*2, 0.5
    np.testing.assert_allclose(found, 0.95 * np.array([0.6, 0.2, 0.0]))
    assert nothing == pytest.approx(0.2)


def test_no_evidence_makes_a_cause_more_probable_than_the_catalogue_is_complete() -> None:
    """Evidence of 1605 for a step of friction was wrong on a published seed."""
    found, nothing = probabilities(np.array([1605.0, 3.0]))
    np.testing.assert_allclose(found, [0.95, 0.0], atol=1e-12)
    assert nothing == pytest.approx(0.0, abs=1e-12)


def test_a_precise_measurement_is_limited_by_the_scatter() -> None:
    # theta_min = s sqrt(2 (tau + log(e / s))): 9.4 % at s = 3 %, e = 20 %, tau = 3 (model discrepancy anchor, 4.3)
    nuisance = np.array([0.03 / 0.2])
    information = np.array([nuisance[0] ** -2.0])  # what is left of perfect data beside the nuisance
    assert 0.2 * detection_limits(information, nuisance, 3.0)[0] == pytest.approx(0.094, abs=0.001)
    assert 0.2 * detection_limits(information, nuisance, 6.0)[0] == pytest.approx(0.12, abs=0.002)


def test_an_effect_at_its_detection_limit_reaches_the_threshold_in_about_half_of_the_cases() -> None:
    rng = np.random.default_rng(3)
    matrix = rng.standard_normal((200, 3)) * 4.0
    nuisance = np.full(3, 0.1)
    quadratic = Quadratic(matrix.T @ matrix, np.zeros(3))
    needed = 4.0
    limit = detection_limits(np.diag(quadratic.projected(nuisance)[1]), nuisance, needed)[0]
    reached = 0
    for _ in range(400):
        truth = nuisance * rng.standard_normal(3)
        truth[0] = limit
        data = matrix @ truth + rng.standard_normal(200)
        one = Quadratic(matrix.T @ matrix, matrix.T @ data)
        reached += effect_evidence(one, nuisance, np.ones(3), [(0,)])[0] > needed
    assert 0.38 < reached / 400 < 0.62


def test_twice_the_log_likelihood_ratio_of_one_deviation_is_chi_squared() -> None:
    # the score test behind the evidence: z^2 = g^2 / G of data without an effect
    rng = np.random.default_rng(4)
    matrix = rng.standard_normal((80, 4))
    nuisance = np.full(4, 0.2)
    statistics = []
    for _ in range(2000):
        data = matrix @ (nuisance * rng.standard_normal(4)) + rng.standard_normal(80)
        score, information = Quadratic(matrix.T @ matrix, matrix.T @ data).projected(nuisance)
        statistics.append(score[1] ** 2 / information[1, 1])
    for level in (0.5, 0.9, 0.99):
        share = float(np.mean(np.array(statistics) <= chi2.ppf(level, 1)))
        assert share == pytest.approx(level, abs=4.0 * np.sqrt(level * (1.0 - level) / 2000))
