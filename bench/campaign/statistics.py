"""Intervals of shares: how sure a campaign may be of what it counted."""

from dataclasses import dataclass


@dataclass(frozen=True)
class Share:
    """A share of runs with its interval."""

    count: int
    total: int
    low: float
    high: float

    @property
    def value(self) -> float:
        """The share, 0 of none."""
        return self.count / self.total if self.total else 0.0

    def __str__(self) -> str:
        if not self.total:
            return "– (no runs)"
        return f"{100 * self.value:.3g} % [{100 * self.low:.3g}, {100 * self.high:.3g}] ({self.count}/{self.total})"


def share(count: int, total: int, confidence: float = 0.95) -> Share:
    """Share with Wilson's two-sided score interval; everything from 0 to 1 where nothing was counted.

    Source: E. B. Wilson, J. Am. Stat. Assoc. 22 (1927) 209-212, computed by ``scipy.stats``.
    """
    if total == 0:
        return Share(0, 0, 0.0, 1.0)
    from scipy.stats import binomtest

    interval = binomtest(count, total).proportion_ci(confidence, "wilson")
    return Share(count, total, float(interval.low), float(interval.high))
