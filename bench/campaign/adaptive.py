"""Adaptive search: near what hurt so far, and from sets of faults that hurt to the smallest ones that still do.

Each batch has three parts: sets to be made smaller, neighbours of the runs with the greatest severity, and points drawn
evenly, which find what the neighbours do not lead to. A neighbour differs in one place: a value of a fault by one
step, its time by one step, the seed, the variant, or, where several faults may act at once, one fault more. The
severity of a candidate is guessed from the runs next to it.
"""

import heapq
from collections.abc import Iterator, Mapping
from itertools import combinations

import numpy as np

from bench.campaign.campaign_file import Strategy
from bench.campaign.fault_space import FaultSpace, Point
from bench.campaign.strategy import Result, distinct_draws

SMALLER_SHARE = 0.3
"""Largest share of a batch that goes into making sets of faults smaller."""
PARTNERS = 6
"""Faults with the greatest severity that others are combined with."""
HAZARD_BONUS = 1.0
"""Severity that a hazardous neighbour counts for beyond its own: many small hazards outweigh one near miss."""


class Adaptive:
    """Batches of an adaptive campaign.

    Parameters
    ----------
    space : FaultSpace
    settings : Strategy
    """

    def __init__(self, space: FaultSpace, settings: Strategy) -> None:
        self._space = space
        self._settings = settings
        self._taken: set[Point] = set()
        self._draws = distinct_draws(space, settings, np.random.default_rng([settings.seed, 2]), self._taken)
        self._guesses: dict[Point, tuple[float, int]] = {}
        self._read: set[Point] = set()
        self._left = settings.runs or 0

    def next(self, known: Mapping[Point, Result]) -> list[Point]:
        """The next batch."""
        for point in [point for point in known if point not in self._read]:
            self._learn(point, known[point])
        size = min(self._settings.batch, self._left)
        batch = self._smaller_sets(known, round(SMALLER_SHARE * size))
        evenly = max(1, round(self._settings.explore * size)) if self._read else size
        self._take_best(batch, size - evenly)
        for point in self._draws:
            if len(batch) >= size:
                self._taken.discard(point)  # drawn, but not run now
                break
            batch.append(point)
        if len(batch) < size:
            self._take_best(batch, size)
        self._left -= len(batch)
        return batch

    def _learn(self, point: Point, result: Result) -> None:
        self._read.add(point)
        weight = result.severity + (HAZARD_BONUS if result.hazardous else 0.0)
        for neighbour in self._neighbours(point):
            if neighbour not in self._taken:
                total, count = self._guesses.get(neighbour, (0.0, 0))
                self._guesses[neighbour] = (total + weight, count + 1)

    def _take_best(self, batch: list[Point], size: int) -> None:
        """Fill a batch with the candidates that promise most; of equals those with more known neighbours."""
        wanted = size - len(batch)
        if wanted <= 0:
            return
        for point in [point for point in self._guesses if point in self._taken]:
            del self._guesses[point]
        best = heapq.nlargest(wanted, self._guesses.items(), key=lambda item: (*_promise(*item[1]), item[0]))
        for point, _ in best:
            self._taken.add(point)
            batch.append(point)

    def _neighbours(self, point: Point) -> Iterator[Point]:
        variant, injections, seed = point
        for place, number in enumerate(injections):
            others = set(injections[:place] + injections[place + 1 :])
            for near in self._space.neighbours(number):
                if near not in others:
                    yield variant, tuple(sorted({*others, near})), seed
        for near in _beside(variant, len(self._space.variants)):
            yield near, injections, seed
        for near in _beside(seed, len(self._space.seeds)):
            yield variant, injections, near
        if len(injections) < self._settings.faults_at_once:
            for partner in self._partners():
                if partner not in injections:
                    yield variant, tuple(sorted((*injections, partner))), seed

    def _partners(self) -> list[int]:
        """Injections of the most promising candidates, which others are combined with."""
        singles = ((guess, point[1][0]) for point, guess in self._guesses.items() if len(point[1]) == 1)
        best = heapq.nlargest(PARTNERS, ((_promise(*guess), number) for guess, number in singles))
        return [number for _, number in best]

    def _smaller_sets(self, known: Mapping[Point, Result], most: int) -> list[Point]:
        """Subsets, one fault smaller, of hazardous sets none of whose subsets is known to be hazardous."""
        batch: list[Point] = []
        hurting = sorted(
            (point for point, result in known.items() if result.hazardous and len(point[1]) > 1),
            key=lambda point: (len(point[1]), -known[point].severity, point),
        )
        for point in hurting:
            subsets = smaller(point)
            if any(subset in known and known[subset].hazardous for subset in subsets):
                continue
            for subset in subsets:
                if subset not in self._taken and len(batch) < most:
                    self._taken.add(subset)
                    batch.append(subset)
        return batch


def _promise(total: float, count: int) -> tuple[float, int]:
    """Mean severity around a candidate, drawn a little towards nothing while few neighbours are known."""
    return total / (count + 0.5), count


def _beside(number: int, size: int) -> list[int]:
    return [near for near in (number - 1, number + 1) if 0 <= near < size]


def smaller(point: Point) -> list[Point]:
    """The sets of faults that are smaller by one fault, none for a single fault."""
    variant, injections, seed = point
    size = len(injections) - 1
    return [(variant, subset, seed) for subset in combinations(injections, size)] if size else []


def smallest_failing_sets(known: Mapping[Point, Result]) -> list[Point]:
    """Hazardous points none of whose subsets with one fault less is hazardous, all of which were run; fewest first."""
    found = []
    for point, result in known.items():
        subsets = smaller(point)
        if result.hazardous and all(subset in known and not known[subset].hazardous for subset in subsets):
            found.append(point)
    return sorted(found, key=lambda point: (len(point[1]), -known[point].severity, point))
