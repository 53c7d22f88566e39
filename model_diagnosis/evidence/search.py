"""Refits of the candidates and what is left of "nothing more" beside them.

Source: model discrepancy anchor, sections 3.5, 3.6 and 4.3.
"""

from collections.abc import Mapping, Sequence

import numpy as np
from numpy.typing import NDArray

from model_diagnosis.evidence.fitting import Fit, Linearisation, Problem
from model_diagnosis.evidence.hypotheses import Hypothesis
from model_diagnosis.evidence.quadratic import Quadratic, total, widening
from model_diagnosis.evidence.stage import (
    Candidate,
    Refit,
    Stage,
    fixed_columns,
    linear_evidence,
    present_columns,
    ratios,
    with_values,
)
from model_diagnosis.evidence.starting_points import StartingPoints

FloatArray = NDArray[np.float64]

CORRELATED_NUISANCES = 12

FAR_BEHIND = 30.0
"""Cost by which a fit with the sensitivities at hand may lie above the best one's and still be fitted with new ones:
those gain some units, and a cause that is 15 less likely in the logarithm comes to nothing."""

RESTART_GAIN = 4.0
"""Cost that a restart of "nothing more" has to gain for everything to be fitted once more from there."""


def _cost(fit: Fit) -> float:
    return fit.cost


class Search:
    """Search over the hypotheses of one prepared problem; ``worth_a_refit`` as in ``StartingPoints``."""

    def __init__(self, problem: Problem, hypotheses: Sequence[Hypothesis], worth_a_refit: float = -np.inf) -> None:
        self.problem = problem
        self.hypotheses = list(hypotheses)
        self.starts = StartingPoints(problem, hypotheses, worth_a_refit)

    def stage(self, accepted: Sequence[Hypothesis], nothing_more: Fit, linearisation: Linearisation) -> Stage:
        """Linear evidence of everything beside ``accepted`` at its fit."""
        quadratic = self.problem.quadratic_at(linearisation, nothing_more.theta)
        return Stage(
            tuple(accepted),
            nothing_more,
            linearisation,
            linear_evidence(self.problem, quadratic, self.hypotheses, accepted),
        )

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
            quadratic = self.problem.quadratic_at(stage.linearisation, stage.nothing_more.theta)
            stage.linear = linear_evidence(self.problem, quadratic, self.hypotheses, stage.accepted)
            for hypothesis, known in fits.items():
                start = self.starts.linear_start(quadratic, stage, self.hypotheses.index(hypothesis))
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
            linearisation, widths, with_values(start, chosen), fixed_columns(chosen), is_rough=is_rough
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
