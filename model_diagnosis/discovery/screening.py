"""Weighs many terms at once by the replay's own residuals, every nominal number free within its scatter beside them."""

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray
from scipy.linalg import cho_factor, cho_solve

from model_diagnosis.discovery.courses import WeighedTerm
from model_diagnosis.evidence.fitting import Fit, Linearisation, Problem
from model_diagnosis.evidence.groups import canonical_correlation
from model_diagnosis.evidence.quadratic import widening
from model_diagnosis.evidence.stage import ratios
from model_diagnosis.huber import huber_weights
from model_diagnosis.replay.replay import Replay

FloatArray = NDArray[np.float64]

PAIRS = 50
"""Complementary pairs of half-samples."""
SAME = 0.97
"""Canonical correlation from which two terms are one: which of them a half-sample prefers is chance."""
_AT_ONCE = 120


@dataclass(frozen=True)
class Screen:
    """The fit of "nothing" that terms are weighed against, with its sensitivities.

    Attributes
    ----------
    problem, replay : without the terms
    """

    problem: Problem
    replay: Replay
    nothing: Fit
    at_nothing: Linearisation

    @cached_property
    def _rows(self) -> list[FloatArray]:
        return self.problem.rows(self.nothing.theta)

    @cached_property
    def _nuisance(self) -> FloatArray:
        """Prior widths (p,) of the nominal numbers over their effect widths."""
        return ratios(self.problem, ())

    @cached_property
    def _known(self) -> tuple[NDArray[np.float64], FloatArray]:
        """Factor of the nominal numbers' information with their prior, and their score (p,) at the fit."""
        quadratic = self.problem.quadratic(self.at_nothing, self._rows, self.nothing.theta)
        return cho_factor(quadratic.information + np.diag(self._nuisance**-2.0)), quadratic.score

    def matrices(self, terms: Sequence[WeighedTerm]) -> list[FloatArray]:
        """Whitened sensitivities (N_m, d) of the terms' parts, in units of their prior widths."""
        wider = self.replay.with_terms([term.course for term in terms])
        added = wider.parameters[len(self.replay.columns) :]
        scale = np.array([one.effect_std for one in added])
        theta = np.concatenate([self.at_nothing.theta, np.zeros(len(added))])
        raw = wider.sensitivities(theta, list(range(len(self.replay.columns), len(wider.columns))))
        return self.problem.whitener.sensitivities([values * scale for values in raw])

    def evidence(self, terms: Sequence[WeighedTerm]) -> FloatArray:
        """Log Bayes factor (k,) of each term against "nothing", by sensitivities; its price is not paid yet."""
        found = [self._evidence(terms[k : k + _AT_ONCE]) for k in range(0, len(terms), _AT_ONCE)]
        return np.concatenate(found) if found else np.zeros(0)

    def _evidence(self, terms: Sequence[WeighedTerm]) -> FloatArray:
        heat, scaled = self.problem.whitener.temperature, self.problem.scaled(self.nothing.theta)
        factor, known_score = self._known
        places = _places(terms)
        ends = places[-1].stop
        across = np.zeros((len(known_score), ends))
        score, own = np.zeros(ends), np.zeros((ends, ends))
        for known, fresh, row in zip(self.at_nothing.matrices, self.matrices(terms), self._rows, strict=True):
            weights = huber_weights(row)
            weighted = fresh * weights[:, None]
            across += known.T @ weighted / heat
            own += fresh.T @ weighted / heat
            score += weighted.T @ row / heat
        score += across.T @ scaled
        explained = cho_solve(factor, across)
        score -= explained.T @ known_score
        own -= across.T @ explained
        return _evidences(score, own, places)

    def inclusion(self, terms: Sequence[WeighedTerm], wanted: int, prices: FloatArray, seed: int) -> float:
        """Share of complementary half-samples in which a term, or one that says the same, is worth most.

        Halves are drawn by blocks of 0.5 s. Stability selection: Meinshausen and Bühlmann, JRSS B 72 (2010) 417, in
        complementary pairs as Shah and Samworth, JRSS B 75 (2013) 55.
        """
        blocks, places = self._of_blocks(self.matrices(terms)), _places(terms)
        _, information = self._projected(blocks.sum(axis=0))
        alike = _alike(terms, wanted, information, places)
        random, hits = np.random.default_rng(seed), 0
        for _ in range(PAIRS):
            order = random.permutation(len(blocks))
            half = len(blocks) // 2
            for chosen in (order[:half], order[half:]):
                found = _evidences(*self._projected(blocks[chosen].sum(axis=0)), places)
                best = int(np.argmax(found - 0.5 * prices))
                hits += best in alike and found[best] > 0.0
        return hits / (2 * PAIRS)

    def _projected(self, product: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Score (d,) and information (d, d) of the terms beside the nominal numbers, from products of columns."""
        p = len(self._nuisance)
        factor = cho_factor(product[:p, :p] + np.diag(self._nuisance**-2.0))
        across = product[:p, p:-1]
        explained = cho_solve(factor, across)
        return product[p:-1, -1] - explained.T @ product[:p, -1], product[p:-1, p:-1] - across.T @ explained

    def _of_blocks(self, fresh: Sequence[FloatArray]) -> FloatArray:
        """Products (b, p + d + 1, p + d + 1) of all columns, and of the working residual behind them, of each block."""
        heat, scaled = self.problem.whitener.temperature, self.problem.scaled(self.nothing.theta)
        found = []
        numbers = self.problem.whitener.blocks()
        for known, added, row, block in zip(self.at_nothing.matrices, fresh, self._rows, numbers, strict=True):
            if not len(row):
                continue
            order = np.argsort(block, kind="stable")
            root = np.sqrt(huber_weights(row) / heat)
            everything = np.column_stack([known, added, row + known @ scaled]) * root[:, None]
            starts = [0, *(np.flatnonzero(np.diff(block[order])) + 1), len(order)]
            found += [everything[order[a:b]].T @ everything[order[a:b]] for a, b in pairwise(starts)]
        return np.stack(found)


def _evidences(score: FloatArray, information: FloatArray, places: Sequence[slice]) -> FloatArray:
    return np.array([widening(score[one], information[one, one], np.ones(one.stop - one.start)) for one in places])


def _alike(terms: Sequence[WeighedTerm], wanted: int, information: FloatArray, places: Sequence[slice]) -> list[int]:
    """Terms of the same variables, or that say the same beside the nominal numbers."""
    columns = [list(range(one.start, one.stop)) for one in places]
    return [
        k
        for k, own in enumerate(columns)
        if terms[k].candidate.variables == terms[wanted].candidate.variables
        or canonical_correlation(information, columns[wanted], own) > SAME
    ]


def _places(terms: Sequence[WeighedTerm]) -> list[slice]:
    ends = np.cumsum([0, *(len(term.course.parts) for term in terms)])
    return [slice(int(a), int(b)) for a, b in pairwise(ends)]
