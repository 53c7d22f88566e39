"""Candidates, their refits and the forward selection with dropping and swapping.

Source: model discrepancy anchor, sections 3.5, 3.6 and 4.3.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from model_diagnosis.evidence.bounded import lowest_within, ways_left
from model_diagnosis.evidence.fitting import Fit, Linearisation, Problem
from model_diagnosis.evidence.hypotheses import Hypothesis
from model_diagnosis.evidence.quadratic import Quadratic, effect_evidence, total, widening
from model_diagnosis.evidence.trial_values import trial_values

FloatArray = NDArray[np.float64]

FROM_BASE, FROM_SATURATED, FROM_GRID = 3, 2, 3
CORRELATED_NUISANCES = 12
EQUAL_DIGITS = 3
"""Decimals to which log evidences are compared."""

FAR_BEHIND = 30.0
"""Cost by which a fit with the sensitivities at hand may lie above the best one's and still be fitted with new ones:
those gain some units, and a cause that is 15 less likely in the logarithm comes to nothing."""

RESTART_GAIN = 4.0
"""Cost that a restart of "nothing more" has to gain for everything to be fitted once more from there."""

EFFECTS_ON_GRID_FIRST, EFFECTS_ON_GRID = 20, 8
"""Effects, by linear evidence, whose grid is replayed in the first step and in later ones."""


@dataclass(frozen=True)
class Candidate:
    """A hypothesis worth a refit and the points to start it from."""

    hypothesis: Hypothesis
    starts: tuple[FloatArray, ...]


@dataclass(frozen=True)
class Refit:
    """A refitted hypothesis, its evidence against the answer without it, and each manoeuvre's quadratic at its fit."""

    hypothesis: Hypothesis
    fit: Fit
    evidence: float
    parts: list[Quadratic]


@dataclass
class Stage:
    """One step of the forward selection: what is accepted already, its fit, and what all others would add.

    Attributes
    ----------
    accepted : hypotheses taken as present
    nothing_more : fit with these alone
    linearisation : sensitivities at that fit
    linear : (h,) evidence of every hypothesis from the sensitivities alone
    refits : by hypothesis
    """

    accepted: tuple[Hypothesis, ...]
    nothing_more: Fit
    linearisation: Linearisation
    linear: FloatArray
    refits: list[Refit] = field(default_factory=list)

    @property
    def best(self) -> Refit | None:
        """Refit with the largest evidence."""
        return max(self.refits, key=lambda refit: refit.evidence, default=None)


def present_columns(accepted: Sequence[Hypothesis]) -> tuple[int, ...]:
    """Columns of all accepted hypotheses."""
    return tuple(sorted({column for hypothesis in accepted for column in hypothesis.columns}))


def fixed_columns(accepted: Sequence[Hypothesis]) -> tuple[int, ...]:
    """Columns whose value a discrete hypothesis states."""
    return tuple(column for hypothesis in accepted if hypothesis.value is not None for column in hypothesis.columns)


def _with_values(theta: FloatArray, accepted: Sequence[Hypothesis]) -> FloatArray:
    """Theta with the values that discrete hypotheses state."""
    changed = theta.copy()
    for hypothesis in accepted:
        if hypothesis.value is not None:
            changed[list(hypothesis.columns)] = hypothesis.value
    return changed


def _cost(fit: Fit) -> float:
    return fit.cost


def ratios(problem: Problem, accepted: Sequence[Hypothesis]) -> FloatArray:
    """Prior widths (p,) over effect widths with the accepted hypotheses present."""
    return problem.priors.widths(present_columns(accepted)) / problem.scale


def linear_evidence(
    problem: Problem,
    quadratic: Quadratic,
    hypotheses: Sequence[Hypothesis],
    accepted: Sequence[Hypothesis] = (),
) -> FloatArray:
    """Evidence (h,) of each hypothesis beside the accepted ones, from one linearisation."""
    return effect_evidence(
        quadratic, ratios(problem, accepted), np.ones(len(problem.scale)), [one.columns for one in hypotheses]
    )


class Search:
    """Search over the hypotheses of one prepared problem.

    Candidates whose evidence by sensitivities or grid stays below ``worth_a_refit`` are not refitted, but for the best.
    """

    def __init__(self, problem: Problem, hypotheses: Sequence[Hypothesis], worth_a_refit: float = -np.inf) -> None:
        self.problem = problem
        self.hypotheses = list(hypotheses)
        self.worth_a_refit = worth_a_refit
        self._to_try: dict[int, list[float]] = {}

    def stage(self, accepted: Sequence[Hypothesis], nothing_more: Fit, linearisation: Linearisation) -> Stage:
        """Linear evidence of everything beside ``accepted`` at its fit."""
        quadratic = self._quadratic(linearisation, nothing_more.theta)
        return Stage(
            tuple(accepted),
            nothing_more,
            linearisation,
            linear_evidence(self.problem, quadratic, self.hypotheses, accepted),
        )

    def candidates(self, stage: Stage, saturated: Linearisation | None = None) -> list[Candidate]:
        """Best of the sensitivities at the base and at the saturated fit, and of a coarse grid over every column."""
        starts: dict[int, list[FloatArray]] = {}
        open_ones = [number for number in range(len(self.hypotheses)) if self._is_open(stage, number)]
        base = self._quadratic(stage.linearisation, stage.nothing_more.theta)
        for number in self._worth(stage.linear, self._top(stage.linear, open_ones, FROM_BASE)):
            starts.setdefault(number, []).append(self._linear_start(base, stage, number))
        if saturated is not None:
            quadratic = self._quadratic(saturated, saturated.theta)
            linear = linear_evidence(self.problem, quadratic, self.hypotheses, stage.accepted)
            for number in self._worth(linear, self._top(linear, open_ones, FROM_SATURATED)):
                starts.setdefault(number, []).append(self._linear_start(quadratic, stage, number))
        linear = stage.linear if saturated is None else np.maximum(stage.linear, linear)
        count = EFFECTS_ON_GRID if stage.accepted else EFFECTS_ON_GRID_FIRST
        on_grid = {self.hypotheses[number].effect for number in self._top(linear, open_ones, count)}
        tried = [self.hypotheses[n].effect in on_grid or self._acts_in_pulses(self.hypotheses[n]) for n in open_ones]
        near = [number for number, one in zip(open_ones, tried, strict=True) if one]
        for number, start in self._grid(stage, near):
            starts.setdefault(number, []).append(start)
        return [Candidate(self.hypotheses[number], tuple(points)) for number, points in starts.items()]

    def refit(self, stage: Stage, candidates: Sequence[Candidate]) -> Stage:
        """Refit the candidates, restart "nothing more" from the best one's solution, and score all against it.

        Where the restart finds a better optimum, the candidates start from there too: all get the same chance.
        """
        fits: dict[Hypothesis, tuple[Fit, list[Quadratic], list[int]]] = {}
        for candidate in candidates:
            ahead = min((known[0].cost for known in fits.values()), default=np.inf)
            fits[candidate.hypothesis] = self._refit_one(stage, candidate, ahead)
        if not fits:
            return stage
        if self._restart(stage, fits):
            quadratic = self._quadratic(stage.linearisation, stage.nothing_more.theta)
            stage.linear = linear_evidence(self.problem, quadratic, self.hypotheses, stage.accepted)
            for hypothesis, known in fits.items():
                start = self._linear_start(quadratic, stage, self.hypotheses.index(hypothesis))
                ahead = min(known[0].cost for known in fits.values())
                again = self._refit_one(stage, Candidate(hypothesis, (start, known[0].theta)), ahead)
                fits[hypothesis] = min(known, again, key=lambda one: one[0].cost)
            self._restart(stage, fits)
        if self._catch_up(stage, fits) and self._restart(stage, fits):
            self._catch_up(stage, fits)
        stage.refits = [
            Refit(hypothesis, fit, self._score(stage, hypothesis, fit, parts), parts)
            for hypothesis, (fit, parts, _) in fits.items()
        ]
        return stage

    def polished(self, stage: Stage, refit: Refit) -> tuple[Refit, Linearisation]:
        """A refit with all sensitivities taken anew at it, against "nothing more" fitted from there by the same ones.

        A fit by chords can stop some units of cost short of its minimum, which would be evidence for whoever goes on.
        """
        chosen = (*stage.accepted, refit.hypothesis)
        linearisation = self.problem.linearise(refit.fit.theta)
        fit = self.fit_set(chosen, linearisation, refit.fit.theta)
        without = self.fit_set(stage.accepted, linearisation, fit.theta)
        without = min(without, self.fit_set(stage.accepted, stage.linearisation, without.theta), key=_cost)
        lowered = without.cost < stage.nothing_more.cost
        if lowered:
            stage.nothing_more = without
        if refit.hypothesis.value is None and self._cost_at_nothing_more(stage, refit.hypothesis) < fit.cost:
            fit = min(fit, self.fit_set(chosen, linearisation, stage.nothing_more.theta), key=_cost)
        again = self.judged(stage, refit.hypothesis, fit, linearisation)
        others = (self._followed(stage, one, linearisation) if lowered else one for one in stage.refits)
        stage.refits = [again if one.hypothesis == again.hypothesis else one for one in others]
        return again, linearisation

    def judged(self, stage: Stage, hypothesis: Hypothesis, fit: Fit, linearisation: Linearisation) -> Refit:
        """A fit with its evidence against "nothing more"."""
        parts = self.problem.quadratics(linearisation, self.problem.rows(fit.theta), fit.theta)
        return Refit(hypothesis, fit, self._score(stage, hypothesis, fit, parts), parts)

    def _followed(self, stage: Stage, refit: Refit, linearisation: Linearisation) -> Refit:
        """A refit after "nothing more" has found a lower minimum: from there where it is above it, scored anew."""
        fit, parts = refit.fit, refit.parts
        if refit.hypothesis.value is None and self._cost_at_nothing_more(stage, refit.hypothesis) < fit.cost:
            fit = self.fit_set((*stage.accepted, refit.hypothesis), linearisation, stage.nothing_more.theta)
            parts = self.problem.quadratics(linearisation, self.problem.rows(fit.theta), fit.theta)
        return Refit(refit.hypothesis, fit, self._score(stage, refit.hypothesis, fit, parts), parts)

    def fit_set(
        self, chosen: Sequence[Hypothesis], linearisation: Linearisation, start: FloatArray, is_rough: bool = False
    ) -> Fit:
        """Fit with these hypotheses present, from ``start``."""
        widths = self.problem.priors.widths(present_columns(chosen))
        return self.problem.fit(
            linearisation, widths, _with_values(start, chosen), fixed_columns(chosen), is_rough=is_rough
        )

    def _refit_one(
        self, stage: Stage, candidate: Candidate, ahead: float = np.inf
    ) -> tuple[Fit, list[Quadratic], list[int]]:
        """Best fit over the starts by chords, then again with fresh columns unless it is far behind the best cost."""
        chosen = (*stage.accepted, candidate.hypothesis)
        fits = (self.fit_set(chosen, stage.linearisation, start, is_rough=True) for start in candidate.starts)
        best = min(fits, key=_cost)
        columns = self.related(stage.linearisation, candidate.hypothesis, stage.accepted)
        if best.cost > ahead + FAR_BEHIND:
            rows = self.problem.rows(best.theta)
            return best, self.problem.quadratics(stage.linearisation, rows, best.theta), columns
        linearisation = self.problem.refreshed(stage.linearisation, best.theta, columns)
        fit = self.fit_set(chosen, linearisation, best.theta, is_rough=True)
        return fit, self.problem.quadratics(linearisation, self.problem.rows(fit.theta), fit.theta), columns

    def _catch_up(self, stage: Stage, fits: dict[Hypothesis, tuple[Fit, list[Quadratic], list[int]]]) -> bool:
        """Fit from the solution of "nothing more" what fits worse than that solution; True where anything did.

        A hypothesis allows all that "nothing more" allows: a worse fit has ended in another minimum.
        """
        worse = [
            hypothesis
            for hypothesis, known in fits.items()
            if hypothesis.value is None and self._cost_at_nothing_more(stage, hypothesis) < known[0].cost
        ]
        for hypothesis in worse:
            again = self._refit_one(stage, Candidate(hypothesis, (stage.nothing_more.theta,)))
            fits[hypothesis] = min(fits[hypothesis], again, key=lambda one: one[0].cost)
        return bool(worse)

    def _cost_at_nothing_more(self, stage: Stage, hypothesis: Hypothesis) -> float:
        """Cost of a hypothesis at the solution of "nothing more", without a replay."""
        priors, found = self.problem.priors, stage.nothing_more
        widths = priors.widths(present_columns((*stage.accepted, hypothesis)))
        return found.misfit + float(np.sum(((found.theta - priors.centre) / widths) ** 2))

    def _restart(self, stage: Stage, fits: Mapping[Hypothesis, tuple[Fit, list[Quadratic], list[int]]]) -> bool:
        """Fit "nothing more" from the winner's solution too: a better optimum found only there is no evidence.

        True where it is better by so much that the sensitivities were taken anew at it.
        """
        winner, _, columns = min(fits.values(), key=lambda one: one[0].cost)
        fresh = self.problem.refreshed(stage.linearisation, winner.theta, columns)
        again = self.fit_set(stage.accepted, fresh, winner.theta)
        again = min(again, self.fit_set(stage.accepted, stage.linearisation, again.theta), key=_cost)
        gained = stage.nothing_more.cost - again.cost
        if gained > 0.0:
            stage.nothing_more = again
        if gained < RESTART_GAIN:
            return False
        stage.linearisation = self.problem.linearise(again.theta)
        stage.nothing_more = min(again, self.fit_set(stage.accepted, stage.linearisation, again.theta), key=_cost)
        return True

    def _score(self, stage: Stage, hypothesis: Hypothesis, fit: Fit, parts: Sequence[Quadratic]) -> float:
        """Laplace log Bayes factor; both curvatures at the hypothesis' own solution, so only its columns count."""
        nothing = self.set_cost(stage.accepted, stage.nothing_more)
        chosen = (*stage.accepted, hypothesis)
        gained = -0.5 * (self.set_cost(chosen, fit) - nothing)
        return gained + self.occam(hypothesis, stage.accepted, total(parts))

    def set_cost(self, chosen: Sequence[Hypothesis], fit: Fit) -> float:
        """Cost of a fit; a value that a discrete hypothesis states is not estimated and pays no prior."""
        stated = [column for column in fixed_columns(chosen) if column in fit.fixed]
        prior = ((fit.theta - self.problem.priors.centre) / fit.widths)[stated]
        return fit.cost - float(np.sum(prior**2))

    def occam(self, hypothesis: Hypothesis, others: Sequence[Hypothesis], quadratic: Quadratic) -> float:
        """Log determinant part of the evidence of a hypothesis beside the others."""
        if hypothesis.value is not None:
            return 0.0
        nuisance = ratios(self.problem, others)
        _, information = quadratic.projected(nuisance)
        columns = list(hypothesis.columns)
        added = np.maximum(1.0 - nuisance[columns] ** 2, 0.0)
        return widening(np.zeros(len(columns)), information[np.ix_(columns, columns)], added)

    def _quadratic(self, linearisation: Linearisation, theta: FloatArray) -> Quadratic:
        return self.problem.quadratic(linearisation, self.problem.rows(theta), theta)

    def _is_open(self, stage: Stage, number: int) -> bool:
        taken = {hypothesis.effect for hypothesis in stage.accepted}
        return self.hypotheses[number].effect not in taken

    def _top(self, evidence: FloatArray, open_ones: Sequence[int], count: int) -> list[int]:
        """Best hypotheses of the ``count`` best effects; of a discrete effect every value."""
        best: dict[int, list[int]] = {}
        open_ones = [number for number in open_ones if np.isfinite(evidence[number])]
        # of equals the one with fewer deviations: a column that the data does not show adds nothing but its name
        fewest = [len(self.hypotheses[number].columns) for number in range(len(evidence))]
        for number in sorted(open_ones, key=lambda one: (-round(float(evidence[one]), EQUAL_DIGITS), fewest[one])):
            known = best.setdefault(self.hypotheses[number].effect, [])
            if not known or self.hypotheses[number].value is not None:
                known.append(number)
        return [number for known in list(best.values())[:count] for number in known]

    def _linear_start(self, quadratic: Quadratic, stage: Stage, number: int) -> FloatArray:
        """Lowest point of the parabola within the bounds; beyond them lies what no car is."""
        precision = ratios(self.problem, (*stage.accepted, self.hypotheses[number])) ** -2.0
        low, high = self._bounds(self.problem.priors.centre)
        mean = lowest_within(quadratic.information + np.diag(precision), quadratic.score, low, high)
        now = self.problem.scaled(stage.nothing_more.theta)
        gradient = quadratic.score - quadratic.information @ now - precision * now
        return stage.nothing_more.theta + self.problem.scale * self.problem.without_settled(gradient, mean - now)

    def _bounds(self, theta: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Ways (p,) that are left to the bounds, in units of the effect widths."""
        return ways_left(theta, self.problem.priors.low, self.problem.priors.high, self.problem.scale)

    def _grid(self, stage: Stage, open_ones: Sequence[int]) -> list[tuple[int, FloatArray]]:
        """Best grid points of the best effects: one replay per point, the other columns moved by their chords."""
        singles = [number for number in open_ones if len(self.hypotheses[number].columns) == 1]
        found: dict[int, tuple[float, FloatArray]] = {}
        for number in singles:
            column = self.hypotheses[number].columns[0]
            widths = self.problem.priors.widths(present_columns((*stage.accepted, self.hypotheses[number])))
            if column not in self._to_try:  # where pulses lie is the log's, whatever else is found
                self._to_try[column] = trial_values(self.problem, stage.nothing_more.theta, column, widths)
            for value in self._to_try[column]:
                theta = stage.nothing_more.theta.copy()
                theta[column] = value
                cost, start = self._grid_point(stage, theta, widths, column)
                if cost < found.get(number, (np.inf,))[0]:
                    found[number] = (cost, start)
        expected = np.full(len(self.hypotheses), -np.inf)
        for number, (cost, _) in found.items():
            expected[number] = -0.5 * (cost - stage.nothing_more.cost)
        chosen = self._worth(expected, self._top(expected, singles, FROM_GRID))
        return [(number, found[number][1]) for number in chosen]

    def _acts_in_pulses(self, hypothesis: Hypothesis) -> bool:
        """True where sensitivities at one value say nothing of a value some way off."""
        return any(self.problem.replay.parameters[column].trial_step > 0.0 for column in hypothesis.columns)

    def _worth(self, evidence: FloatArray, numbers: Sequence[int]) -> list[int]:
        """Those worth a refit; the first always."""
        return [number for k, number in enumerate(numbers) if k == 0 or evidence[number] > self.worth_a_refit]

    def _grid_point(self, stage: Stage, theta: FloatArray, widths: FloatArray, column: int) -> tuple[float, FloatArray]:
        """Cost expected after one step of all columns from a grid point, and the point it leads to."""
        rows = self.problem.rows(theta)
        quadratic = self.problem.quadratic(stage.linearisation, rows, theta)
        precision = (widths / self.problem.scale) ** -2.0
        scaled = self.problem.scaled(theta)
        gradient = quadratic.score - quadratic.information @ scaled - precision * scaled
        low, high = self._bounds(theta)
        low[column] = high[column] = 0.0
        curvature = quadratic.information + np.diag(precision)
        step = lowest_within(curvature, gradient, low, high)
        step = self.problem.without_settled(gradient, step)
        gained = float(2.0 * gradient @ step - step @ curvature @ step)
        return self.problem.cost(rows, theta, widths) - gained, theta + step * self.problem.scale

    def related(
        self, linearisation: Linearisation, hypothesis: Hypothesis, accepted: Sequence[Hypothesis]
    ) -> list[int]:
        """Columns to compute anew for a refit: its own, the accepted ones and those that look most like its own."""
        own = present_columns((*accepted, hypothesis))
        information = linearisation.information
        size = np.sqrt(np.maximum(np.diag(information), 1e-300))
        widths = self.problem.priors.widths(own) / self.problem.scale
        alike = np.zeros(len(size))
        for column in hypothesis.columns:
            alike = np.maximum(
                alike, np.abs(information[column]) / (size * size[column]) * np.minimum(1.0, widths * size)
            )
        order = [int(column) for column in np.argsort(-alike) if int(column) not in own]
        return sorted([*own, *order[:CORRELATED_NUISANCES]])
