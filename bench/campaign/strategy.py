"""Which runs are made: every one, a sample, or what the runs so far suggest.

A strategy gives batches of points. What it gives next depends on the campaign's file and on the results of the batches
before, not on the order in which workers return: the same campaign makes the same runs on any number of workers, and a
campaign that was killed comes to the same next batch again.
"""

from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from typing import Protocol

import numpy as np

from bench.campaign.campaign_file import Strategy
from bench.campaign.fault_space import FaultSpace, Point

MOST_MISSES = 200
"""Draws in a row that hit only known points: then the rest of a small space is not worth drawing for."""


@dataclass(frozen=True)
class Result:
    """What a strategy knows of a run."""

    severity: float
    hazardous: bool


class Batches(Protocol):
    """Gives the points of a campaign, batch by batch."""

    def next(self, known: Mapping[Point, Result]) -> list[Point]:
        """The next batch; an empty one ends the campaign. ``known`` has the results of all batches before."""


class Exhaustive:
    """Every single fault, in one batch."""

    def __init__(self, space: FaultSpace) -> None:
        self._points: list[Point] = list(space.every_single())

    def next(self, known: Mapping[Point, Result]) -> list[Point]:
        """All points, then nothing."""
        points, self._points = self._points, []
        return points


class Sampled:
    """Points drawn evenly, each at most once, in one batch."""

    def __init__(self, space: FaultSpace, settings: Strategy) -> None:
        drawn = distinct_draws(space, settings, np.random.default_rng([settings.seed, 1]), set())
        self._points = [point for point, _ in zip(drawn, range(settings.runs or 0), strict=False)]

    def next(self, known: Mapping[Point, Result]) -> list[Point]:
        """All points, then nothing."""
        points, self._points = self._points, []
        return points


def distinct_draws(
    space: FaultSpace, settings: Strategy, generator: np.random.Generator, taken: set[Point]
) -> Iterator[Point]:
    """Points drawn evenly that are not in ``taken``, which grows by them; ends when hardly any are left."""
    misses = 0
    while misses < MOST_MISSES:
        point = space.draw(generator, settings.faults_at_once)
        if point in taken:
            misses += 1
            continue
        misses = 0
        taken.add(point)
        yield point


def strategy_of(space: FaultSpace) -> Batches:
    """The strategy that a campaign asks for."""
    settings = space.campaign.strategy
    if settings.kind == "exhaustive":
        return Exhaustive(space)
    if settings.kind == "sampled":
        return Sampled(space, settings)
    from bench.campaign.adaptive import Adaptive

    return Adaptive(space, settings)
