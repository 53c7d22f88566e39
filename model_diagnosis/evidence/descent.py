"""Descent to the lowest cost within bounds by Newton steps, shortened where the cost bends more than they know."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from model_diagnosis.evidence.bounded import lowest_within, ways_left

FloatArray = NDArray[np.float64]

SHORTENINGS = 2
SHORTEST, LONGEST = 0.1, 0.6
"""Least and largest share of a step that did not lower the cost, tried next."""

SETTLED = 0.5
"""Share of the tolerance that a part promises at most whose columns stay where they are: its part of a replay is known
then."""

LENGTHENED = 2.0
"""Times the share that the last step was shortened to, with which the next one begins."""

LITTLE, STILL = 0.01, 0.5
"""A part that gained less than the first share of what it had promised, and still promises more than the second, gets
no further by the sensitivities at hand; what a replay more would gain, new ones gain better."""

LESSONS = 1
"""Steps in a row that may fail before they are shortened, as long as each has taught the sensitivities something."""

KEPT = 0.5
"""Share of what a step of all columns promised that it must gain, or teach, for the next one to be one of all, too."""


def unsettled(
    gradient: FloatArray, step: FloatArray, parts: Sequence[NDArray[np.bool_]], tolerance: float
) -> NDArray[np.bool_]:
    """Columns (p,) of the parts that gain more by their part of a step than is worth leaving out of it."""
    moving = np.ones(len(step), dtype=np.bool_)
    for part in parts:
        if float(gradient[part] @ step[part]) < SETTLED * tolerance:
            moving[part] = False
    return moving


@dataclass
class _Part:
    """Columns (p,) that take steps together; the share of the last step that was taken, what it promised and gained."""

    columns: NDArray[np.bool_]
    share: float = 1.0
    promised: float = 0.0
    gained: float = 0.0
    is_stuck: bool = False


@dataclass
class Descent:
    """Where a fit stands, and what it knows of the way on.

    Steps count deviations in units of their effect width (z, as in ``quadratic``).

    Attributes
    ----------
    rows_at : whitened residuals at theta; one replay
    cost_of : cost of rows at theta
    gradient_of : (p,) half the cost's slope by z, downhill, of rows at theta
    curvature_of : (p, p) half the cost's second derivative by z, as far as it is known
    learn : told of a step, the rows before and those after it; True if slope and curvature are others now
    scale, low, high : (p,) effect width and bounds of theta
    parts : columns (p,) that take steps apart once a step of all has gained little
    fixed : columns held at their value
    tolerance : cost below which a step is not worth a replay
    rough : promised cost up to which a step that fails is tried anew once only, part by part, and never shortened
    theta, rows, cost : where it stands
    """

    rows_at: Callable[[FloatArray], list[FloatArray]]
    cost_of: Callable[[list[FloatArray], FloatArray], float]
    gradient_of: Callable[[list[FloatArray], FloatArray], FloatArray]
    curvature_of: Callable[[], FloatArray]
    learn: Callable[[FloatArray, list[FloatArray], list[FloatArray]], bool]
    scale: FloatArray
    low: FloatArray
    high: FloatArray
    parts: Sequence[NDArray[np.bool_]]
    fixed: Sequence[int]
    tolerance: float
    rough: float
    theta: FloatArray = field(init=False)
    rows: list[FloatArray] = field(init=False)
    cost: float = field(init=False)

    def run(self, start: FloatArray, steps: int) -> tuple[FloatArray, list[FloatArray], float]:
        """Theta, rows and cost after at most ``steps`` steps from ``start``."""
        self.theta = np.clip(start, self.low, self.high)
        self.rows = self.rows_at(self.theta)
        self.cost = self.cost_of(self.rows, self.theta)
        together, failed = len(self.parts) > 1, 0
        going = [_Part(columns) for columns in self.parts]
        for _ in range(steps):
            before, gradient = self.cost, self.gradient_of(self.rows, self.theta)
            if together:
                step = self._step_of_all(gradient)
                promised = float(gradient @ step)
                if promised < self.tolerance:
                    break
                has_taught = self._tried(step)[1]
                failed = failed + 1 if self.cost == before else 0
                together = before - self.cost > KEPT * promised or (
                    has_taught and failed <= LESSONS and promised > self.rough
                )
                if self.cost < before or together:
                    continue
            # what one part's way is blocked by need not stop the other
            for part in going:
                self._descend(part)
            going = [part for part in going if not part.is_stuck]
            if before - self.cost < self.tolerance:
                break
        return self.theta, self.rows, self.cost

    def _descend(self, part: _Part) -> None:
        """First of ever shorter steps of a part's columns that lowers the cost.

        The next length is the lowest point of the parabola through the cost, its slope and what the last length gave;
        a step that has taught the sensitivities another way is followed by one that goes it.
        """
        share = min(LENGTHENED * part.share, 1.0)
        for attempt in range(SHORTENINGS + 1):
            gradient = self.gradient_of(self.rows, self.theta)
            step = self._step(gradient, part.columns)
            promised = float(gradient @ step)
            if attempt == 0:
                part.is_stuck = part.gained < LITTLE * part.promised and promised > STILL * part.promised
                part.promised, part.gained = promised, 0.0
            if part.is_stuck or share * promised < self.tolerance:
                return
            change, has_taught = self._tried(step * share)
            if change < 0.0:
                part.share, part.gained = share, -change
                return
            if attempt >= LESSONS and promised < self.rough:
                break
            if not has_taught or attempt >= LESSONS:
                bend = change + 2.0 * share * promised
                lowest = share * promised / bend if np.isfinite(bend) else SHORTEST
                share *= min(max(lowest, SHORTEST), LONGEST)
        part.is_stuck = True

    def _step_of_all(self, gradient: FloatArray) -> FloatArray:
        """Newton step (p,) of all parts but those that are settled."""
        step = self._step(gradient, np.ones(len(gradient), dtype=np.bool_))
        moving = unsettled(gradient, step, self.parts, self.tolerance)
        return step if moving.all() or not moving.any() else self._step(gradient, moving)

    def _step(self, gradient: FloatArray, part: NDArray[np.bool_]) -> FloatArray:
        """Newton step (p,) of a part's columns to the lowest point of the parabola within the bounds.

        Columns that the step would carry over a bound go to it, and the others follow that; cut off afterwards, what
        moves together would be torn apart and the step lead uphill.
        """
        low, high = ways_left(self.theta, self.low, self.high, self.scale)
        held = ~part
        held[list(self.fixed)] = True
        low[held] = high[held] = 0.0
        return lowest_within(self.curvature_of(), gradient, low, high)

    def _tried(self, step: FloatArray) -> tuple[float, bool]:
        """Change of the cost by a step, which is taken if that is negative, and whether it has taught anything.

        Where two columns act as a product a step leads up a curved valley's side. What that has taught leads the next
        one along the valley, as a second-order correction from its end would (Fletcher 1982).
        """
        theta, rows, cost = self._at(self.theta + step * self.scale)
        has_taught = self.learn((theta - self.theta) / self.scale, self.rows, rows)
        change = cost - self.cost
        if change < 0.0:
            self.theta, self.rows, self.cost = theta, rows, cost
        return change, has_taught

    def _at(self, theta: FloatArray) -> tuple[FloatArray, list[FloatArray], float]:
        """Theta within its bounds, rows and cost there; one replay."""
        theta = np.clip(theta, self.low, self.high)
        rows = self.rows_at(theta)
        return theta, rows, self.cost_of(rows, theta)
