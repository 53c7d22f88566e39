"""Heat of one direction: what white noise, a drifting sensitivity and a narrow scatter give, against closed forms."""

import numpy as np
import pytest
from linear_car import NOISE_STD, LinearCar, effect
from numpy.typing import NDArray

from model_diagnosis.evidence.base import fit_base
from model_diagnosis.evidence.fitting import Linearisation, Problem
from model_diagnosis.evidence.form_heat import BLOCK_SAMPLES, OwnDirection, own_direction
from model_diagnosis.evidence.hypotheses import hypotheses_of
from model_diagnosis.evidence.priors import Priors
from model_diagnosis.evidence.quadratic import Quadratic
from model_diagnosis.evidence.search import Search
from model_diagnosis.evidence.selection import Selector
from model_diagnosis.evidence.stage import ratios
from model_diagnosis.evidence.whitening import sensor_whitener

COLUMNS = (2,)
SAMPLES = 1200
EFFECTS = [effect(f"e{number}") for number in range(6)]


def _problem(seed: int, truth: NDArray[np.float64], drift: float = 0.0) -> tuple[Problem, Linearisation]:
    """A car in white noise; column 2's sensitivity changes at random from second to second by the share ``drift``."""
    car = LinearCar(EFFECTS, truth, seed, samples=SAMPLES)
    rng = np.random.default_rng([seed, 1])
    for manoeuvre, matrix in zip(car.manoeuvres, car.matrices, strict=True):
        of_a_second = drift * np.repeat(rng.standard_normal(SAMPLES // 100), 100)
        for number, channel in enumerate(manoeuvre.channels.values()):
            channel += of_a_second * matrix[:, number, COLUMNS[0]]
    problem = Problem(car, Priors.of(car.parameters), sensor_whitener(car))
    return problem, problem.linearise(truth)


def _direction(problem: Problem, linearisation: Linearisation, theta: NDArray[np.float64]) -> OwnDirection:
    wide = problem.priors.widths(COLUMNS) / problem.scale
    return own_direction(problem, linearisation, theta, COLUMNS, ratios(problem, ()), wide)


def test_white_noise_has_no_heat() -> None:
    """Scores of blocks of white noise scatter as the information says: 1 in the mean, never below 1 as it is used."""
    heats = []
    for seed in range(20):
        problem, linearisation = _problem(seed, np.zeros(6))
        heats.append(_direction(problem, linearisation, np.zeros(6)).heat)
    assert np.mean(heats) == pytest.approx(1.1, abs=0.1)  # the mean of max(1, x) for x of mean 1 and std 0.2
    assert max(heats) < 2.0


def test_a_drifting_sensitivity_heats_its_own_direction_as_blocks_say() -> None:
    """Shares a_b of a block's J: its score scatters by s^2 (J'J)_b^2 beyond (J'J)_b, so heat - 1 = s^2 sum (J'J)^2/J'J.

    Blocks of half a second see half of each second's, blocks of two seconds sum two independent ones.
    """
    drift, heats, expected = 0.05, [], []
    for seed in range(10):
        problem, linearisation = _problem(seed, np.zeros(6), drift)
        heats.append(_direction(problem, linearisation, np.zeros(6)).heat)
        added = []
        for length in BLOCK_SAMPLES:
            pieces = min(length, 100)
            sums = np.concatenate(
                [
                    (matrix[4:, :, COLUMNS[0]] ** 2).sum(axis=1)[: (SAMPLES - 4) // pieces * pieces]
                    .reshape(-1, pieces).sum(axis=1)
                    for matrix in problem.replay.matrices  # type: ignore[attr-defined]
                ]
            )  # fmt: skip
            added.append(drift**2 * np.sum(sums**2) / np.sum(sums) / NOISE_STD**2)
        expected.append(1.0 + np.mean(added))
    assert np.mean(expected) > 3.0
    assert np.mean(heats) == pytest.approx(np.mean(expected), rel=0.2)


def test_without_heat_the_evidence_is_that_of_the_marginal_likelihoods() -> None:
    truth = np.zeros(6)
    truth[COLUMNS[0]] = 0.03
    problem, linearisation = _problem(3, truth)
    narrow, wide = ratios(problem, ()), problem.priors.widths(COLUMNS) / problem.scale
    quadratic = problem.quadratic(linearisation, problem.rows(truth), truth)
    information = quadratic.information
    cost, fits = [], []
    for widths in (narrow, wide):
        mean, _ = quadratic.posterior(widths)
        fits.append(problem.priors.centre + problem.scale * mean)
        cost.append(float(mean @ information @ mean - 2.0 * mean @ quadratic.score + np.sum((mean / widths) ** 2)))
    cold = OwnDirection(
        problem.scaled(fits[1])[list(COLUMNS)],
        _direction(problem, linearisation, fits[1]).information,
        1.0,
        narrow[list(COLUMNS)],
        wide[list(COLUMNS)],
    )
    expected = quadratic.log_evidence(wide) - quadratic.log_evidence(narrow)
    assert cold.tempered(cost[0] - cost[1]) == pytest.approx(expected, abs=1e-6)


def test_heat_takes_what_rests_on_the_data_and_leaves_what_rests_on_the_scatter() -> None:
    """One deviation z with scatter r: at S -> inf the evidence is z^2 (1/r^2 - 1)/2 + log r, whatever the heat."""
    size, scatter = 1.2, 0.2
    limit = 0.5 * size**2 * (scatter**-2.0 - 1.0) + np.log(scatter)

    def evidence(information: float, heat: float) -> float:
        narrow, wide = np.array([scatter]), np.ones(1)
        score = (information + 1.0) * size
        gained = score**2 * (1.0 / (information + 1.0) - 1.0 / (information + scatter**-2.0))
        return OwnDirection(np.array([size]), np.array([[information]]), heat, narrow, wide).tempered(gained)

    assert evidence(1e5, 1.0) == pytest.approx(limit, rel=2e-3)
    assert evidence(1e5, 5.0) == pytest.approx(limit, rel=1e-2)
    exact = Quadratic(np.array([[4.0]]), np.array([[4.0]]) @ np.array([size * 21.0 / 20.0]))
    weak = Quadratic(exact.information * 5.0, exact.score * 5.0)
    seen = float(np.linalg.solve(weak.information + np.eye(1), weak.score)[0])
    narrow, wide = np.array([scatter]), np.ones(1)
    gained = float(
        weak.score @ np.linalg.solve(weak.information + np.eye(1), weak.score)
        - weak.score @ np.linalg.solve(weak.information + np.diag(narrow**-2.0), weak.score)
    )
    tempered = OwnDirection(np.array([seen]), weak.information, 5.0, narrow, wide).tempered(gained)
    assert tempered == pytest.approx(exact.log_evidence(wide) - exact.log_evidence(narrow), rel=1e-9)


def test_heat_refuses_an_exact_law_and_no_approximate_one() -> None:
    """An effect whose response changes by 40 % from second to second; 59 was the bar of a term at seed 1000004."""
    truth = np.zeros(6)
    truth[2] = 0.5
    problem, _ = _problem(3, truth, drift=0.4)
    car = problem.replay
    base = fit_base(car, Priors.of(car.parameters))
    named = {}
    for is_exact in (True, False):
        selector = Selector(Search(base.problem, hypotheses_of(car)), 59.0, is_exact=is_exact)
        found = selector.run(base.nothing, base.at_nothing)
        named[is_exact] = [car.effects[one.hypothesis.effect].name for one in found.accepted]
    assert named == {True: [], False: ["e2"]}
