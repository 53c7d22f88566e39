"""A cause beside another one has to be more than what the other's law is off."""

import numpy as np
import pytest
from linear_car import LinearCar, effect
from numpy.typing import NDArray
from scipy.stats import multivariate_normal

from model_diagnosis.evidence.base import Base, fit_base
from model_diagnosis.evidence.hypotheses import Hypothesis, hypotheses_of
from model_diagnosis.evidence.law_errors import LAW_SHARE, evidence_beside_laws
from model_diagnosis.evidence.priors import Priors
from model_diagnosis.evidence.search import Search
from model_diagnosis.evidence.selection import Selector
from model_diagnosis.evidence.stage import ratios
from model_diagnosis.huber import huber_weights

EFFECTS = [*(effect(f"e{number}") for number in range(5)), effect("tight", nuisance=0.004)]
STRONG, TIGHT, YAW_RATE = 2, 5, 2


def _car(seed: int, **hidden: float) -> LinearCar:
    """A car whose last effect is what its third does to the yaw rate of the first manoeuvre, and nothing else."""
    truth = np.random.default_rng(seed).normal(0.0, 0.02, len(EFFECTS))
    truth[TIGHT] = 0.0
    for name, value in hidden.items():
        truth[int(name.removeprefix("c"))] = value
    car = LinearCar(EFFECTS, np.zeros(len(EFFECTS)), seed, samples=120)
    for number, matrix in enumerate(car.matrices):
        matrix[:, :, TIGHT] = 0.0
        if number == 0:
            matrix[:, YAW_RATE, TIGHT] = matrix[:, YAW_RATE, STRONG]
    for one, predicted in zip(car.manoeuvres, car._predicted(truth), strict=True):
        for column, name in enumerate(one.channels):
            one.channels[name][:] = one.channels[name] + predicted[:, column]
    return car


def _hypothesis(car: LinearCar, column: int) -> Hypothesis:
    (found,) = (one for one in hypotheses_of(car) if one.columns == (column,))
    return found


def _named(car: LinearCar, base: Base) -> set[int]:
    selection = Selector(Search(base.problem, hypotheses_of(car)), 5.0).run(base.nothing, base.at_nothing)
    return {one.hypothesis.effect for one in selection.accepted}


@pytest.mark.parametrize("seed", [3, 4])
def test_evidence_beside_errors_of_a_law_is_that_of_all_rows_together(seed: int) -> None:
    """Against the densities of all rows with every prior and error in one covariance matrix, by scipy."""
    car = _car(seed, c2=0.3, c5=0.05)
    base = fit_base(car, Priors.of(car.parameters))
    strong, tight = _hypothesis(car, STRONG), _hypothesis(car, TIGHT)
    problem, theta = base.problem, base.nothing.theta
    at = problem.linearise(theta)
    nuisance = ratios(problem, (strong,))
    rows = problem.rows(theta)
    seen, weights = np.concatenate(at.matrices), np.concatenate([huber_weights(row) for row in rows])
    data = np.concatenate(rows) + seen @ problem.scaled(theta)
    noise = np.diag(problem.whitener.temperature / weights)
    without = theta.copy()
    without[STRONG] = 0.0
    response = [before - now for before, now in zip(problem.rows(without), rows, strict=True)]
    errors = []
    for m in range(len(response)):
        errors.append(np.concatenate([v if k == m else 0.0 * v for k, v in enumerate(response)]))
    for signal in range(3):
        parts = [np.split(values, 3) for values in response]
        errors.append(np.concatenate([np.concatenate([v * (s == signal) for s, v in enumerate(p)]) for p in parts]))
    covariance_of_errors = LAW_SHARE**2 * np.stack(errors, axis=1) @ np.stack(errors, axis=1).T

    def density(widths: NDArray[np.float64], beside: NDArray[np.float64]) -> float:
        return float(multivariate_normal(cov=noise + (seen * widths**2) @ seen.T + beside).logpdf(data))

    wide = nuisance.copy()
    wide[TIGHT] = 1.0
    nothing = np.zeros_like(noise)
    expected = (
        density(wide, nothing) - density(nuisance, nothing),
        density(wide, covariance_of_errors) - density(nuisance, covariance_of_errors),
    )
    found = evidence_beside_laws(problem, at, theta, tight, (strong,))
    assert found == pytest.approx(expected, rel=1e-6)
    assert found[1] < found[0] - 1.0


def test_what_a_law_may_be_off_is_no_second_cause() -> None:
    """A tenth of a strong effect's response in one signal of one manoeuvre is twelve scatters of the last effect."""
    car = _car(1, c2=0.5, c5=0.05)
    assert _named(car, fit_base(car, Priors.of(car.parameters))) == {STRONG}


def test_the_same_without_the_strong_effect_is_a_cause() -> None:
    car = _car(1, c5=0.05)
    assert _named(car, fit_base(car, Priors.of(car.parameters))) == {TIGHT}


def test_another_cause_of_any_size_stands_beside_a_strong_one() -> None:
    car = _car(1, c2=0.5, c4=0.2)
    assert _named(car, fit_base(car, Priors.of(car.parameters))) == {STRONG, 4}
