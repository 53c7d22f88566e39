"""Shares with Wilson intervals, and how well probabilities are calibrated."""

import math
from collections.abc import Sequence
from dataclasses import dataclass

NORMAL_95 = 1.959963984540054
BINS = 10


def wilson(right: int, count: int) -> tuple[float, float]:
    """95 % interval of a share (Wilson 1927): no count gives (0, 1)."""
    if count == 0:
        return 0.0, 1.0
    share, z2 = right / count, NORMAL_95**2
    centre = (share + z2 / (2 * count)) / (1 + z2 / count)
    half = NORMAL_95 / (1 + z2 / count) * math.sqrt(share * (1 - share) / count + z2 / (4 * count**2))
    low = 0.0 if right == 0 else centre - half
    return low, 1.0 if right == count else centre + half


@dataclass(frozen=True)
class Bin:
    """One bin of the reliability diagram: stated probabilities in it, and the share that was right."""

    count: int
    stated: float
    right: float


def reliability(stated: Sequence[tuple[float, bool]]) -> list[Bin]:
    """Ten equal bins of stated probability; empty bins are left out."""
    bins: list[list[tuple[float, bool]]] = [[] for _ in range(BINS)]
    for probability, right in stated:
        bins[min(int(probability * BINS), BINS - 1)].append((probability, right))
    return [
        Bin(len(part), sum(p for p, _ in part) / len(part), sum(right for _, right in part) / len(part))
        for part in bins
        if part
    ]


def calibration_error(stated: Sequence[tuple[float, bool]]) -> float | None:
    """Expected calibration error: mean distance of stated and seen over the bins, by their counts."""
    if not stated:
        return None
    return sum(part.count * abs(part.stated - part.right) for part in reliability(stated)) / len(stated)
