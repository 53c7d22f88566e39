"""Which equation is violated: an error of its own in each balance, one at a time, its variance by maximum likelihood.

Source: model discrepancy anchor, section 3.8. The error of an equation is a constant and a share of the force, torque
or signal that the equation is about, drawn anew in each manoeuvre. Two views of the same question:

- Equation error: the balance written with measured derivatives. What the car at its saturated fit leaves of it (every
  effect allowed) is what noise, derivatives and form make; the car within its ordinary scatter leaves more where
  something is wrong. Errors as large as draws of the scatter make them are no violation.
- Innovations: the observer replay is a filter, whose whitened residual e has covariance T (1 + J D J'), T the
  temperature and J D J' what the ordinary scatter of the nominal numbers does. An error of equation i of variance q
  adds q S S', where S holds the replay's answers to it. A residual of an observer is the measurement less what the
  older ones say, whatever its gains, so this is the likelihood that a Kalman filter with that process noise has.

LR = 2 (l(q) - l(0)) at the likeliest q; without a violation it is 0 in half of all cases and chi-squared of one degree
of freedom in the others.
"""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from model_diagnosis.evidence.fitting import Linearisation, Problem
from model_diagnosis.evidence.whitening import ORDER, fit_signal

FloatArray = NDArray[np.float64]

LEAST_SAMPLES = 25 * ORDER
GOLDEN_STEPS = 24
LEAST_SHARE, LARGEST_SHARE = 1e-4, 1e6
"""Range in which q is sought, times the variance of an error that the data would just show."""


@dataclass(frozen=True)
class Violation:
    """What the data say of one equation.

    Attributes
    ----------
    likelihood_ratio : of an error of its own against none
    std : of the likeliest error, in the equation's unit; 0 where there is none
    """

    likelihood_ratio: float
    std: float


@dataclass(frozen=True)
class EquationErrors:
    """Errors of the balances of one manoeuvre, equation -> (n,), nan where unknown.

    Attributes
    ----------
    nothing, saturated : of the car within its ordinary scatter, and with every effect allowed
    scattered : changes of the errors by draws of the ordinary scatter
    courses : equation -> courses (n,) that an error may have, root mean square 1
    """

    nothing: Mapping[str, FloatArray]
    saturated: Mapping[str, FloatArray]
    scattered: Sequence[Mapping[str, FloatArray]]
    courses: Mapping[str, Sequence[FloatArray]]


def violated_equations(errors: Sequence[EquationErrors], temperature: float) -> dict[str, Violation]:
    """Violations by equation error, the most violated first; one of ``errors`` per manoeuvre."""
    found = {}
    for name in dict.fromkeys(name for one in errors for name in one.nothing):
        parts = [part for one in errors if name in one.nothing and (part := _equation_part(one, name, temperature))]
        if parts:
            scores, informations, usual = zip(*parts, strict=True)
            score, information = np.concatenate(scores), block_diagonal(informations)
            found[name] = violation(score, information, float(np.mean(np.concatenate(usual))))
    return dict(sorted(found.items(), key=lambda item: -item[1].likelihood_ratio))


def _equation_part(
    errors: EquationErrors, name: str, temperature: float
) -> tuple[FloatArray, FloatArray, FloatArray] | None:
    """Score and information of one manoeuvre, and squares of what the scatter's draws make of the same numbers."""
    nothing, left = errors.nothing[name], errors.saturated[name]
    known = np.flatnonzero(np.isfinite(nothing) & np.isfinite(left))
    if len(known) < LEAST_SAMPLES:
        return None
    white = fit_signal(name, 0, known, left[known], 0.0)
    shown = np.stack([white.apply(course) for course in errors.courses.get(name, [np.ones(len(nothing))])], axis=1)
    information = shown.T @ shown / temperature
    solvable = information + 1e-9 * np.trace(information) * np.eye(len(information))
    usual = [
        np.linalg.solve(solvable, shown.T @ white.apply(np.nan_to_num(one[name])) / temperature) ** 2
        for one in errors.scattered
    ]
    return shown.T @ white.apply(nothing) / temperature, information, np.concatenate(usual)


def violated_by_innovations(
    problem: Problem,
    linearisation: Linearisation,
    theta: FloatArray,
    answers: Callable[[int], Mapping[str, FloatArray]],
) -> dict[str, Violation]:
    """Violations by innovations, the most violated first.

    Parameters
    ----------
    linearisation : sensitivities to the nominal numbers near theta
    theta : (p,) where the residuals are taken; their scatter about the prior's centre is allowed for
    answers : of a manoeuvre's number, equation -> (n, c, k) change of measured minus predicted per unit of k errors
    """
    temperature, z = problem.whitener.temperature, problem.scaled(theta)
    ratios = problem.priors.nuisance / problem.scale
    covariance = np.linalg.inv(linearisation.information + np.diag(ratios**-2.0))
    # residuals with all numbers at their nominal value, of which the scatter explains its part
    nominal = [row + matrix @ z for row, matrix in zip(problem.rows(theta), linearisation.matrices, strict=True)]
    gradient = np.zeros(len(z))
    for matrix, weight, row in zip(linearisation.matrices, linearisation.weights, nominal, strict=True):
        gradient += matrix.T @ (weight * row) / temperature
    explained = covariance @ gradient
    scores: dict[str, list[FloatArray]] = {}
    informations: dict[str, list[FloatArray]] = {}
    crossings: dict[str, list[FloatArray]] = {}
    for m, (matrix, weight) in enumerate(zip(linearisation.matrices, linearisation.weights, strict=True)):
        unexplained = nominal[m] - matrix @ explained
        for name, answer in answers(m).items():
            shown = problem.whitener.whitened(m, answer)
            weighted = shown * (weight / temperature)[:, None]
            scores.setdefault(name, []).append(weighted.T @ unexplained)
            informations.setdefault(name, []).append(weighted.T @ shown)
            crossings.setdefault(name, []).append(weighted.T @ matrix)
    found = {}
    for name, score in scores.items():
        crossing = np.concatenate(crossings[name])
        information = block_diagonal(informations[name]) - crossing @ covariance @ crossing.T
        found[name] = violation(np.concatenate(score), information)
    return dict(sorted(found.items(), key=lambda item: -item[1].likelihood_ratio))


def violation(score: FloatArray, information: FloatArray, usual: float = 0.0) -> Violation:
    """Likeliest variance of errors with this score (k,) and information (k, k) of the log likelihood at none.

    ``usual`` is the variance up to which errors are no violation.
    """
    values, vectors = np.linalg.eigh(information)
    values, score = np.maximum(values, 0.0), vectors.T @ score
    seen = float(values.max(initial=0.0))
    if seen <= 0.0:
        return Violation(0.0, 0.0)

    def twice_log_likelihood(variance: float) -> float:
        return float(np.sum(variance * score**2 / (1.0 + variance * values) - np.log1p(variance * values)))

    log_variance, best = golden_maximum(
        lambda logarithm: twice_log_likelihood(float(np.exp(logarithm))),
        float(np.log(LEAST_SHARE / seen)),
        float(np.log(LARGEST_SHARE / seen)),
    )
    variance = float(np.exp(log_variance))
    ratio = best - twice_log_likelihood(usual)
    return Violation(ratio, float(np.sqrt(variance))) if ratio > 0.0 and variance > usual else Violation(0.0, 0.0)


def block_diagonal(blocks: Sequence[FloatArray]) -> FloatArray:
    """One matrix with these on its diagonal and 0 elsewhere."""
    size, at = sum(len(block) for block in blocks), 0
    joined = np.zeros((size, size))
    for block in blocks:
        joined[at : at + len(block), at : at + len(block)] = block
        at += len(block)
    return joined


def golden_maximum(function: Callable[[float], float], low: float, high: float) -> tuple[float, float]:
    """Place and value of the largest value of a unimodal function on [low, high], by golden section."""
    share = (np.sqrt(5.0) - 1.0) / 2.0
    left, right = high - share * (high - low), low + share * (high - low)
    at_left, at_right = function(left), function(right)
    for _ in range(GOLDEN_STEPS):
        if at_left > at_right:
            high, right, at_right = right, left, at_left
            left = high - share * (high - low)
            at_left = function(left)
        else:
            low, left, at_left = left, right, at_right
            right = low + share * (high - low)
            at_right = function(right)
    return (left, at_left) if at_left > at_right else (right, at_right)
