"""Screening of terms against the exact evidence of a linear car, by the dense normal distribution of its data."""

from collections.abc import Sequence

import numpy as np
import pytest
from linear_car import NOISE_STD, SIGNALS, LinearCar, effect
from numpy.typing import NDArray
from scipy.stats import multivariate_normal

from model_diagnosis.discovery.candidates import Candidate, Shape
from model_diagnosis.discovery.courses import WeighedTerm
from model_diagnosis.discovery.screening import Screen
from model_diagnosis.evidence.fitting import Problem
from model_diagnosis.evidence.priors import Priors
from model_diagnosis.evidence.whitening import sensor_whitener
from model_diagnosis.replay.terms import TermCourse

FloatArray = NDArray[np.float64]
EFFECTS = [effect(f"e{number}") for number in range(3)]
WIDTH = 0.15


class _CarWithTerms(LinearCar):
    """A linear car whose terms add their course to the first signal."""

    added: tuple[TermCourse, ...] = ()

    def with_terms(self, terms: Sequence[TermCourse]) -> "_CarWithTerms":
        wider = object.__new__(_CarWithTerms)
        wider.__dict__.update(self.__dict__)
        wider.added = tuple(terms)
        wider.columns = (*self.columns, *(f"{one.name}.{part}" for one in terms for part in one.parts))
        wider.parameters = (*self.parameters, *(one for term in terms for one in term.effect.parameters))
        return wider

    def sensitivities(self, theta: FloatArray, columns: Sequence[int] | None = None) -> list[FloatArray]:
        found = []
        for m, matrix in enumerate(self.matrices):
            courses = [course[m] for term in self.added for course in term.parts.values()]
            more = np.zeros((*matrix.shape[:2], len(courses)))
            for number, course in enumerate(courses):
                more[:, 0, number] = course
            whole = np.concatenate([matrix, more], axis=2)
            found.append(whole if columns is None else whole[:, :, list(columns)])
        return found


def _terms(car: LinearCar, count: int, seed: int, parts: int = 1) -> list[WeighedTerm]:
    """Smooth random courses, the names of their variables all different."""
    random = np.random.default_rng(seed)
    samples = len(car.manoeuvres[0].time)
    found = []
    for number in range(count):
        courses = {
            f"part_{part}": tuple(
                np.interp(np.arange(samples), np.arange(0, samples, 10), random.normal(size=len(range(0, samples, 10))))
                for _ in car.manoeuvres
            )
            for part in range(parts)
        }
        course = TermCourse(f"term_{number}", "body_longitudinal_force", courses, dict.fromkeys(courses, WIDTH))
        candidate = Candidate((Shape(f"variable_{number}"),))
        found.append(WeighedTerm(candidate, course.target, course, dict.fromkeys(courses, 1.0)))
    return found


def _screen(
    seed: int, samples: int, hidden: float = 0.0, manoeuvres: int = 2
) -> tuple[Screen, _CarWithTerms, list[WeighedTerm]]:
    """A car in noise that stays within two standard deviations, so that none of it is an outlier; ten terms."""
    random = np.random.default_rng([seed, 5])
    car = _CarWithTerms(EFFECTS, np.array([0.02, -0.03, 0.0]), seed, manoeuvres, samples)
    terms = _terms(car, 10, seed)
    for m, (manoeuvre, predicted) in enumerate(
        zip(car.manoeuvres, car._predicted(np.array([0.02, -0.03, 0.0])), strict=True)
    ):
        for place, name in enumerate(SIGNALS):
            noise = np.clip(random.normal(size=samples), -2.0, 2.0)
            manoeuvre.channels[name][:] = predicted[:, place] + NOISE_STD * noise  # type: ignore[index]
        manoeuvre.channels[SIGNALS[0]][:] += hidden * terms[3].course.parts["part_0"][m]  # type: ignore[index]
    problem = Problem(car, Priors.of(car.parameters), sensor_whitener(car))
    linearisation = problem.linearise(np.zeros(3))
    nothing = problem.fit(linearisation, problem.priors.nuisance, np.zeros(3))
    return Screen(problem, car, nothing, problem.linearise(nothing.theta)), car, terms  # type: ignore[arg-type]


@pytest.mark.parametrize("parts", [1, 2])
def test_evidence_is_the_ratio_of_the_datas_densities(parts: int) -> None:
    """y ~ N(0, I + A W A') without the term, + c c' w² with it (marginal likelihoods by scipy's dense normal)."""
    screen, car, _ = _screen(4, 80, hidden=0.06)
    terms = _terms(car, 5, 4, parts)
    whitener = screen.problem.whitener
    data = np.concatenate(screen.problem.rows(np.zeros(3)))
    known = np.concatenate(whitener.sensitivities(car.matrices)) * screen.problem.priors.nuisance
    without = np.eye(len(data)) + known @ known.T
    base = multivariate_normal(np.zeros(len(data)), without).logpdf(data)
    expected = []
    for term in terms:
        raw = car.with_terms([term.course]).sensitivities(np.zeros(3))
        columns = np.concatenate(whitener.sensitivities([one[:, :, 3:] for one in raw]))
        covariance = without + WIDTH**2 * columns @ columns.T
        expected.append(multivariate_normal(np.zeros(len(data)), covariance).logpdf(data) - base)
    assert whitener.temperature == 1.0
    assert screen.evidence(terms) == pytest.approx(np.array(expected), abs=1e-6)


def test_halves_of_the_data_choose_a_hidden_term_and_agree_on_none_where_nothing_is_hidden() -> None:
    """Complementary half-samples: a term of 0.6 noise standard deviations always; of ten false ones none in 80 %."""
    screen, _, terms = _screen(6, 600, hidden=0.06)
    prices = np.zeros(len(terms))
    assert int(np.argmax(screen.evidence(terms))) == 3
    assert screen.inclusion(terms, 3, prices, 0) == 1.0
    assert screen.inclusion(terms, 4, prices, 0) == 0.0
    shares = []
    for seed in range(5):
        clean, _, terms = _screen(20 + seed, 600)
        best = int(np.argmax(clean.evidence(terms)))
        shares.append(clean.inclusion(terms, best, prices + 6.0, 0))
    assert max(shares) < 0.8
