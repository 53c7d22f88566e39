"""The gain of an answer on manoeuvres that took no part in the search, or by leaving out each manoeuvre in turn."""

from collections.abc import Callable, Sequence

import numpy as np
from numpy.typing import NDArray

from model_diagnosis.evidence.bounded import lowest_within
from model_diagnosis.evidence.car_numbers import refit_within_scatter, within_scatter
from model_diagnosis.evidence.fitting import Problem
from model_diagnosis.evidence.priors import Priors
from model_diagnosis.evidence.quadratic import Quadratic, total
from model_diagnosis.evidence.selection import Selection
from model_diagnosis.evidence.stage import ratios
from model_diagnosis.gain import HeldOut, held_out_residuals, measure_gain
from model_diagnosis.replay import ReplayBase
from model_diagnosis.result import Gain

FloatArray = NDArray[np.float64]


def gain_of(
    problem: Problem,
    selection: Selection,
    held_out: ReplayBase | None,
    seed: int,
    theta_on: Callable[[ReplayBase, FloatArray], FloatArray] | None = None,
) -> Gain | None:
    """Gain on the held-out replay; without one by cross-validation; None where neither is possible.

    ``theta_on`` turns deviations of the search's replay into the held-out one's where the latter has other columns.
    """
    neutral = np.zeros(len(problem.scale))
    if held_out is not None and len(held_out.manoeuvres):
        after = selection.fit.theta
        refit = refit_within_scatter(problem, selection.linearisation, selection.nothing.theta)
        if theta_on is not None:
            neutral, after, refit = (theta_on(held_out, one) for one in (neutral, after, refit))
        residuals = held_out_residuals(held_out, neutral, after, refit)
        return measure_gain(residuals, noise_std(held_out), seed=seed)
    if len(problem.replay.manoeuvres) < 2:
        return None
    residuals = _left_out(problem, selection)
    return measure_gain(residuals, noise_std(problem.replay), seed=seed, cross_validated=True)


def gain_of_numbers(refit: FloatArray | None, after: FloatArray, held_out: ReplayBase | None, seed: int) -> Gain | None:
    """Gain of numbers ``after`` (p,) on the held-out replay, beside a ``refit`` (p,) within the scatter if any."""
    if held_out is None or not len(held_out.manoeuvres):
        return None
    residuals = held_out_residuals(held_out, np.zeros(len(after)), after, refit)
    return measure_gain(residuals, noise_std(held_out), seed=seed)


def noise_std(replay: ReplayBase) -> dict[str, float]:
    """Signal -> own noise of its sensor."""
    return {
        signal: replay.sensor_std(signal)
        for number in range(len(replay.manoeuvres))
        for signal in replay.signals(number)
    }


def _left_out(problem: Problem, selection: Selection) -> list[HeldOut]:
    """Residuals of each manoeuvre with deviations estimated from all others (one step from the joint answer)."""
    chosen = [one.hypothesis for one in selection.accepted]
    rows = problem.rows(selection.fit.theta)
    parts = problem.quadratics(selection.linearisation, rows, selection.fit.theta)
    nothing_parts = problem.quadratics(
        selection.linearisation, problem.rows(selection.nothing.theta), selection.nothing.theta
    )
    before = problem.replay.residuals(np.zeros(len(problem.scale)))
    weights = problem.replay.weights()
    found = []
    for number, manoeuvre in enumerate(problem.replay.manoeuvres):
        after = _without(problem, parts, number, ratios(problem, chosen), problem.priors)
        refit = _without(problem, nothing_parts, number, ratios(problem, ()), within_scatter(problem))
        found.append(
            HeldOut(
                manoeuvre.name,
                problem.replay.signals(number),
                before[number],
                problem.replay.residuals(after)[number],
                weights[number],
                problem.replay.residuals(refit)[number],
            )
        )
    return found


def _without(
    problem: Problem, parts: Sequence[Quadratic], left_out: int, widths: FloatArray, bounds: Priors
) -> FloatArray:
    """Deviations (p,) from all manoeuvres but one, within bounds."""
    rest = total([part for number, part in enumerate(parts) if number != left_out])
    curvature = rest.information + np.diag(widths**-2.0)
    return bounds.centre + problem.scale * lowest_within(
        curvature, rest.score, problem.scaled(bounds.low), problem.scaled(bounds.high)
    )
