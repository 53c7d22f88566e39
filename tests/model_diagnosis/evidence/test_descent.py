"""The descent of a fit on costs that bend more than the sensitivities say, or have kinks."""

from collections.abc import Callable, Sequence

import numpy as np
import pytest
from numpy.typing import NDArray

from model_diagnosis.evidence.descent import Descent

Cost = Callable[[NDArray[np.float64]], float]
ALL = (np.ones(6, dtype=np.bool_),)
BOUND = 4.0


def _descent(
    cost: Cost,
    slope: Callable[[NDArray[np.float64]], NDArray[np.float64]],
    curvature: NDArray[np.float64],
    parts: Sequence[NDArray[np.bool_]] = ALL,
    rough: float = 0.0,
    taught: bool = False,
) -> tuple[Descent, list[int]]:
    """A descent on a function of six deviations; ``slope`` is the cost's, and the number of its replays."""
    replays = [0]

    def rows(theta: NDArray[np.float64]) -> list[NDArray[np.float64]]:
        replays[0] += 1
        return [theta]

    bounds = np.full(6, BOUND)
    return (
        Descent(
            rows,
            lambda _, theta: cost(theta),
            lambda _, theta: -0.5 * slope(theta),
            lambda: curvature,
            lambda *_: taught,
            np.ones(6),
            -bounds,
            bounds,
            parts,
            (),
            1e-6,
            rough,
        ),
        replays,
    )


@pytest.mark.parametrize("more", [1.0, 1.5, 5.0, 50.0])
def test_steps_are_shortened_where_the_cost_bends_more(more: float) -> None:
    """All directions bend ``more`` than known; the closed solution is the lowest point."""
    random = np.random.default_rng(7)
    known = np.diag(random.uniform(1.0, 3.0, 6))
    target = random.uniform(-1.0, 1.0, 6)

    def cost(theta: NDArray[np.float64]) -> float:
        return float((theta - target) @ (more * known) @ (theta - target))

    descent, replays = _descent(cost, lambda theta: 2.0 * more * known @ (theta - target), known)
    _, _, left = descent.run(np.zeros(6), 12)
    assert left < 1e-4
    assert replays[0] <= (2 if more == 1.0 else 20)


def test_a_kink_in_one_part_does_not_stop_the_other() -> None:
    """No step of the first three gets past the kink that they rest in; the last three go to their lowest point."""

    def cost(theta: NDArray[np.float64]) -> float:
        return float(20.0 * np.sum(np.abs(theta[:3])) + np.sum((theta[3:] - 1.0) ** 2))

    def slope(theta: NDArray[np.float64]) -> NDArray[np.float64]:
        return np.concatenate([np.full(3, -20.0), 2.0 * (theta[3:] - 1.0)])

    first = np.arange(6) < 3
    apart, replays = _descent(cost, slope, np.eye(6), (first, ~first))
    assert apart.run(np.zeros(6), 12)[2] < 1e-6
    # at the start, of all columns, three of the part that rests in its kink and is given up, one of the other
    assert replays[0] == 6


def test_a_part_that_has_nothing_to_gain_stays_where_it_is_to_the_bit() -> None:
    """A replay's part that depends on it is known then."""
    random = np.random.default_rng(3)
    root = np.tril(random.uniform(0.2, 1.0, (6, 6)))
    curvature = root @ root.T
    first = np.arange(6) < 3
    curvature[np.ix_(first, ~first)] = curvature[np.ix_(~first, first)] = 0.0
    target = random.uniform(-1.0, 1.0, 6)

    def cost(theta: NDArray[np.float64]) -> float:
        return float((theta - target) @ curvature @ (theta - target))

    descent, _ = _descent(cost, lambda theta: 2.0 * curvature @ (theta - target), curvature, (first, ~first))
    start = np.where(first, target + 1e-5, 0.0)
    found, _, left = descent.run(start, 12)
    assert np.array_equal(found[first], start[first])
    assert found[~first] == pytest.approx(target[~first], abs=1e-9)
    assert left < 1e-6


def test_a_rough_descent_leaves_what_little_a_shorter_step_would_gain() -> None:
    """The cost bends fifty times as much as known, so that only a shortened step gains, and there is little to gain."""
    known, target = np.eye(6), np.full(6, 0.5)

    def cost(theta: NDArray[np.float64]) -> float:
        return float(50.0 * (theta - target) @ (theta - target))

    def slope(theta: NDArray[np.float64]) -> NDArray[np.float64]:
        return 100.0 * (theta - target)

    promised = 0.25 * float(slope(np.zeros(6)) @ slope(np.zeros(6)))  # g'M^-1 g with half the slope
    thorough, of_thorough = _descent(cost, slope, known, taught=True)
    rough, of_rough = _descent(cost, slope, known, rough=2.0 * promised, taught=True)
    eager, _ = _descent(cost, slope, known, rough=0.01 * promised, taught=True)  # ends where a step promises less
    assert thorough.run(np.zeros(6), 12)[2] < 1e-4
    assert eager.run(np.zeros(6), 12)[2] < 0.01 * promised / 50.0  # a step promises fifty times what is to be gained
    assert rough.run(np.zeros(6), 12)[2] == cost(np.zeros(6))
    assert of_rough[0] < of_thorough[0]
