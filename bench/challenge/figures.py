"""Figures of a challenge over its cases, each with what is required of it."""

import math
from collections import Counter
from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass
from statistics import median
from typing import Any

from bench.challenge.intervals import Bin, calibration_error, reliability, wilson
from bench.challenge.scoring import CaseScore

SMALLEST_UNITS = 4.0
PARAMETER_WITHIN = 0.10
GAIN_SHARE = 0.85
UNKNOWN_GAIN_SHARE = 0.80


@dataclass(frozen=True)
class Figure:
    """One figure.

    Attributes
    ----------
    value : None where no case speaks to it
    low, high : 95 % interval of a share (Wilson); None for other figures
    required : (lower limit, upper limit) that the issue asks for; None where it is only reported
    """

    name: str
    value: float | None
    count: int
    low: float | None = None
    high: float | None = None
    required: tuple[float, float] | None = None

    @property
    def met(self) -> bool | None:
        """Whether the requirement is met; None without one or without cases."""
        if self.required is None or self.value is None:
            return None
        return self.required[0] <= self.value <= self.required[1]

    def as_json(self) -> dict[str, Any]:
        """Plain data."""
        return {
            "name": self.name,
            "value": self.value,
            "cases": self.count,
            "interval": None if self.low is None else [self.low, self.high],
            "required": self.required,
            "met": self.met,
        }


@dataclass(frozen=True)
class Sizes:
    """Sizes of an effect in nominal scatters: measured detection limit; None where there is no such case."""

    cases: int
    smallest_seen: float | None
    largest_unseen: float | None


@dataclass(frozen=True)
class Figures:
    """All figures of a challenge."""

    shares: list[Figure]
    sizes: dict[str, Sizes]
    confusion: dict[str, dict[str, int]]
    bins: list[Bin]

    @property
    def missed(self) -> list[Figure]:
        """Required figures that are not reached."""
        return [figure for figure in self.shares if figure.met is False]


def figures_of(scores: Sequence[CaseScore]) -> Figures:
    """Figures, confusion matrix and reliability of scored cases."""
    singles = [s for s in scores if s.family == "single" and s.units >= SMALLEST_UNITS]
    stated = [pair for score in scores for pair in score.stated]
    shares = [
        _share("right cause first", singles, lambda s: s.first, (0.94, 1.0)),
        _share("first or in a justified group", singles, lambda s: s.in_group, (0.97, 1.0)),
        _share("answers that are groups", singles, lambda s: s.grouped, (0.0, 0.10)),
        _share("false alarms on clean cars", scores, lambda s: s.false_alarm, (0.0, 0.01)),
        _share("data fault invented on clean cars", scores, lambda s: s.fault_invented),
        _share("physical value within 10 %", singles, is_value_within, (0.95, 1.0)),
        _mean("the same at best, by the generator's theory", (_expected_within(s) for s in singles)),
        _median("median error of the physical value", (s.parameter_error for s in singles), (0.0, 0.015)),
        _share("90 % interval holds the value", singles, lambda s: s.covered, (0.85, 0.95)),
        _share("85 % of the true model's held-out gain", singles, is_gain_reached, (0.90, 1.0)),
        _share("both of a pair named", scores, lambda s: s.both, (0.85, 1.0)),
        _share("data fault named", scores, lambda s: s.fault_named, (0.95, 1.0)),
        _share("data fault taken for physics", scores, lambda s: s.physics_named, (0.0, 0.0)),
        _share("variables of an unknown term", scores, lambda s: s.variables, (0.85, 1.0)),
        _share("80 % of an unknown term's gain", _of(scores, "unknown"), is_gain_reached, (0.8, 1.0)),
        _share("look-alikes named as a group", _of(scores, "confounded"), lambda s: s.right_verdict),
        _share("proposed data separate look-alikes", scores, lambda s: s.separated),
        _share("unexcited effect told as such", _of(scores, "unexcited"), lambda s: s.right_verdict),
        _share("wrong vehicle told as such", _of(scores, "wrong_vehicle"), lambda s: s.right_verdict),
        _share("effect of one manoeuvre first", _of(scores, "one_manoeuvre"), lambda s: s.first),
        _share("small effects (below the limit) first", _of(scores, "detection"), lambda s: s.first),
        Figure("calibration error", calibration_error(stated), len(stated), required=(0.0, 0.05)),
        _mean("log score of the truth", (s.log_score for s in scores)),
        _median("seconds per case", (s.seconds for s in scores), None),
    ]
    return Figures(shares, _sizes(scores), _confusion(scores), reliability(stated))


def _of(scores: Sequence[CaseScore], family: str) -> list[CaseScore]:
    return [score for score in scores if score.family == family]


def is_value_within(score: CaseScore) -> bool | None:
    """Whether the physical value is near enough to the true one; None without one."""
    return None if score.parameter_error is None else score.parameter_error <= PARAMETER_WITHIN


def _expected_within(score: CaseScore) -> float | None:
    """Probability that an unbiased estimate with the smallest standard deviation there is lies near enough."""
    if score.parameter_error is None or score.value_std is None:
        return None
    return math.erf(PARAMETER_WITHIN / (math.sqrt(2.0) * score.value_std))


def is_gain_reached(score: CaseScore) -> bool | None:
    """Whether enough of the possible held-out gain is reached; None where none was measured."""
    needed = UNKNOWN_GAIN_SHARE if score.family == "unknown" else GAIN_SHARE
    return None if score.gain_share is None else score.gain_share >= needed


def _share(
    name: str,
    scores: Sequence[CaseScore],
    of: Callable[[CaseScore], bool | None],
    required: tuple[float, float] | None = None,
) -> Figure:
    known = [value for score in scores if (value := of(score)) is not None]
    low, high = wilson(sum(known), len(known))
    return Figure(name, sum(known) / len(known) if known else None, len(known), low, high, required)


def _median(name: str, values: Iterable[float | None], required: tuple[float, float] | None) -> Figure:
    known = [value for value in values if value is not None]
    return Figure(name, median(known) if known else None, len(known), required=required)


def _mean(name: str, values: Iterable[float | None]) -> Figure:
    known = [value for value in values if value is not None]
    return Figure(name, sum(known) / len(known) if known else None, len(known))


def _sizes(scores: Sequence[CaseScore]) -> dict[str, Sizes]:
    """Sizes of single effects that were named, alone or in a justified group, and of those that were not."""
    seen: dict[str, list[float]] = {}
    unseen: dict[str, list[float]] = {}
    for score in scores:
        if score.family in ("single", "detection"):
            (seen if score.in_group else unseen).setdefault(score.hidden, []).append(score.units)
    names = sorted(seen.keys() | unseen.keys())
    return {
        name: Sizes(
            len(seen.get(name, [])) + len(unseen.get(name, [])),
            min(seen.get(name, []), default=None),
            max(unseen.get(name, []), default=None),
        )
        for name in names
    }


def _confusion(scores: Sequence[CaseScore]) -> dict[str, dict[str, int]]:
    """Hidden to answered, counted."""
    rows: dict[str, Counter[str]] = {}
    for score in scores:
        rows.setdefault(score.hidden, Counter())[score.answer] += 1
    return {hidden: dict(rows[hidden].most_common()) for hidden in sorted(rows)}
