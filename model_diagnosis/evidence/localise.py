"""Which equation is violated: an error of its own in each balance, one at a time, its variance by maximum likelihood.

Source: model discrepancy anchor, section 3.8. The error of an equation is a constant and a share of the force, torque
or signal that the equation is about, drawn anew in each manoeuvre. Two views of the same question:

- Equation error: the balance written with measured derivatives. What the car at its saturated fit leaves of it (every
  effect allowed) is what noise, derivatives and form make; the car within its ordinary scatter leaves more where
  something is wrong. Errors as large as draws of the scatter make them are no violation.
- Innovations: the observer replay is a filter, whose whitened residual e has covariance T (1 + J D J'), T the
  temperature and J D J' what the ordinary scatter of the nominal numbers does. An error of equation i of variance q
  adds q S S', where S holds the replay's answers to it. A residual of an observer is the measurement less what the
  older ones say, whatever its gains, so this is the likelihood that a Kalman filter with that process noise has. Errors
  that last, the same in all manoeuvres, are asked for beside those drawn anew, and each kind (a constant, a share) by
  itself: what a violation needs fewer numbers for says more than the same with many (Occam). The likeliest form counts.

LR = 2 (l(q) - l(0)) at the likeliest q; without a violation it is 0 in half of all cases and chi-squared of one degree
of freedom in the others.
"""

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from model_diagnosis.evidence.fitting import Linearisation, Problem
from model_diagnosis.evidence.whitening import ORDER, fit_signal
from model_diagnosis.replay.disturbances import ErrorAnswers

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
    answers: Callable[[int], Mapping[str, ErrorAnswers]],
) -> dict[str, Violation]:
    """Violations by innovations, the most violated first.

    Parameters
    ----------
    linearisation : sensitivities to the nominal numbers near theta
    theta : (p,) where the residuals are taken; their scatter about the prior's centre is allowed for
    answers : of a manoeuvre's number, equation -> what the replay answers to its errors
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
    parts: dict[str, list[_Part]] = {}
    for m, (matrix, weight) in enumerate(zip(linearisation.matrices, linearisation.weights, strict=True)):
        unexplained = nominal[m] - matrix @ explained
        for name, answer in answers(m).items():
            shown = problem.whitener.whitened(m, answer.changes)
            weighted = shown * (weight / temperature)[:, None]
            part = _Part(weighted.T @ unexplained, weighted.T @ shown, weighted.T @ matrix, answer.kinds, answer.levels)
            parts.setdefault(name, []).append(part)
    found = {
        name: max((violation(*form) for form in _forms(mine, covariance)), key=lambda one: one.likelihood_ratio)
        for name, mine in parts.items()
    }
    return dict(sorted(found.items(), key=lambda item: -item[1].likelihood_ratio))


class _Part(NamedTuple):
    """What one manoeuvre says of k errors: score (k,), information (k, k) and (k, p) with the numbers."""

    score: FloatArray
    information: FloatArray
    crossing: FloatArray
    kinds: tuple[str, ...]
    levels: FloatArray

    def of_kind(self, kind: str) -> "_Part":
        """Of the errors of one kind only."""
        mine = np.array([one == kind for one in self.kinds])
        return _Part(
            self.score[mine],
            self.information[np.ix_(mine, mine)],
            self.crossing[mine],
            (kind,) * int(mine.sum()),
            self.levels[mine],
        )

    def in_units_of(self, sizes: FloatArray) -> "_Part":
        """Of errors given in ``sizes`` (k,) of theirs."""
        information = sizes[:, None] * self.information * sizes
        return _Part(sizes * self.score, information, sizes[:, None] * self.crossing, self.kinds, self.levels)


def _forms(parts: Sequence[_Part], covariance: NDArray[np.floating]) -> Iterator[tuple[FloatArray, FloatArray]]:
    """Score and information of errors of each form, with what the scatter of the numbers makes of them taken off."""
    kinds = dict.fromkeys(parts[0].kinds)
    for mine in (parts, *([part.of_kind(kind) for part in parts] for kind in kinds if len(kinds) > 1)):
        crossing = np.concatenate([part.crossing for part in mine])
        information = block_diagonal([part.information for part in mine])
        yield np.concatenate([part.score for part in mine]), information - crossing @ covariance @ crossing.T
        if len(mine) > 1:
            lasting = [part.in_units_of(size) for part, size in zip(mine, _same_share(mine), strict=True)]
            crossing = np.sum([part.crossing for part in lasting], axis=0)
            information = np.sum([part.information for part in lasting], axis=0)
            yield np.sum([part.score for part in lasting], axis=0), information - crossing @ covariance @ crossing.T


def _same_share(parts: Sequence[_Part]) -> FloatArray:
    """Sizes (manoeuvres, k), root mean square 1, of errors that are the same share of what they are a share of."""
    levels = np.array([part.levels for part in parts])
    overall = np.sqrt(np.mean(levels**2, axis=0))
    sizes: FloatArray = levels / np.where(overall > 0.0, overall, 1.0)
    return sizes


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
