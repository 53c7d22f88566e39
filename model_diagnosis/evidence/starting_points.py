"""Where fits of the hypotheses begin: by sensitivities, by a coarse grid, by places along the way.

Source: model discrepancy anchor, sections 3.5 and 4.3.
"""

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from model_diagnosis.evidence.bounded import lowest_within, ways_left
from model_diagnosis.evidence.fitting import Linearisation, Problem
from model_diagnosis.evidence.hypotheses import Hypothesis
from model_diagnosis.evidence.placing import best_places, placed_pair
from model_diagnosis.evidence.quadratic import Quadratic
from model_diagnosis.evidence.stage import Candidate, Stage, linear_evidence, present_columns, ratios
from model_diagnosis.evidence.trial_values import trial_values

FloatArray = NDArray[np.float64]

FROM_BASE, FROM_SATURATED, FROM_GRID = 3, 2, 3

EQUAL_DIGITS = 3
"""Decimals to which log evidences are compared."""

EFFECTS_ON_GRID_FIRST, EFFECTS_ON_GRID = 20, 8
"""Effects, by linear evidence, whose grid is replayed in the first step and in later ones."""


class StartingPoints:
    """Candidates of each step of the selection, with the points that their fits start from.

    Those whose evidence by sensitivities or grid stays below ``worth_a_refit`` are left out, but for the best.
    """

    def __init__(self, problem: Problem, hypotheses: Sequence[Hypothesis], worth_a_refit: float) -> None:
        self.problem = problem
        self.hypotheses = list(hypotheses)
        self.worth_a_refit = worth_a_refit
        self._to_try: dict[int, list[float]] = {}

    def candidates(self, stage: Stage, saturated: Linearisation | None = None) -> list[Candidate]:
        """Best of the sensitivities at the base and at the saturated fit, and of a coarse grid over every column."""
        starts: dict[int, list[FloatArray]] = {}
        open_ones = [number for number in range(len(self.hypotheses)) if self._is_open(stage, number)]
        base = self.problem.quadratic_at(stage.linearisation, stage.nothing_more.theta)
        for number in self._worth(stage.linear, self._top(stage.linear, open_ones, FROM_BASE)):
            starts.setdefault(number, []).append(self.linear_start(base, stage, number))
        if saturated is not None:
            quadratic = self.problem.quadratic_at(saturated, saturated.theta)
            linear = linear_evidence(self.problem, quadratic, self.hypotheses, stage.accepted)
            for number in self._worth(linear, self._top(linear, open_ones, FROM_SATURATED)):
                starts.setdefault(number, []).append(self.linear_start(quadratic, stage, number))
        linear = stage.linear if saturated is None else np.maximum(stage.linear, linear)
        count = EFFECTS_ON_GRID if stage.accepted else EFFECTS_ON_GRID_FIRST
        on_grid = {self.hypotheses[number].effect for number in self._top(linear, open_ones, count)}
        tried = [self.hypotheses[n].effect in on_grid or self._acts_in_pulses(self.hypotheses[n]) for n in open_ones]
        near = [number for number, one in zip(open_ones, tried, strict=True) if one]
        for number, start in self._grid(stage, near):
            starts.setdefault(number, []).append(start)
        for number, start in self._placed(stage, open_ones):
            starts.setdefault(number, []).append(start)
        return [Candidate(self.hypotheses[number], tuple(points)) for number, points in starts.items()]

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

    def linear_start(self, quadratic: Quadratic, stage: Stage, number: int) -> FloatArray:
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

    def _placed(self, stage: Stage, open_ones: Sequence[int]) -> list[tuple[int, FloatArray]]:
        """Starts of what changes somewhere along the way, at the place where it explains most."""
        pairs = {number: placed_pair(self.problem.replay, self.hypotheses[number]) for number in open_ones}
        pairs_there = {number: pair for number, pair in pairs.items() if pair is not None}
        found = []
        for number, best in best_places(self.problem, stage, pairs_there, self.worth_a_refit).items():
            if best.evidence > self.worth_a_refit:
                start = self.linear_start(best.quadratic, stage, number)
                start[pairs_there[number].place] = best.value
                found.append((number, start))
        return found

    def _acts_in_pulses(self, hypothesis: Hypothesis) -> bool:
        """True where sensitivities at one value say nothing of a value some way off."""
        parameters = [self.problem.replay.parameters[column] for column in hypothesis.columns]
        return any(one.trial_step > 0.0 and not one.places for one in parameters)

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
