"""Resampling of blocks of time: stability of a choice over half-samples, intervals of coefficients."""

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from model_diagnosis.discovery.quantities import Balance
from model_diagnosis.gain import CORRELATION_TIMES, SHORTEST_BLOCK_S
from model_diagnosis.manoeuvre import SAMPLE_TIME_S

FloatArray = NDArray[np.float64]

PAIRS = 50
"""Complementary pairs of half-samples."""
_DRAWS = 400
_RIDGE = 1e-10


@dataclass(frozen=True)
class Blocks:
    """Blocks of consecutive samples, none over the border of two manoeuvres.

    Attributes
    ----------
    starts : first row of each block; one more at the end
    """

    starts: NDArray[np.int64]

    @classmethod
    def of(cls, balance: Balance, correlation_s: float) -> "Blocks":
        """Blocks of 0.5 s or 1.5 correlation times, at most an eighth of a manoeuvre."""
        wanted = round(max(SHORTEST_BLOCK_S, CORRELATION_TIMES * correlation_s) / SAMPLE_TIME_S)
        starts, begin = [0], 0
        for error in balance.error:
            count = max(round(len(error) / max(min(wanted, len(error) // 8), 1)), 1)
            starts += [begin + round(len(error) * (number + 1) / count) for number in range(count)]
            begin += len(error)
        return cls(np.array(starts, np.int64))

    @property
    def count(self) -> int:
        """Number of blocks."""
        return len(self.starts) - 1

    def sums(self, values: FloatArray) -> FloatArray:
        """Sum of values (N,) in each block."""
        return np.add.reduceat(values, self.starts[:-1])

    def inner_products(self, columns: FloatArray, values: FloatArray) -> FloatArray:
        """Columnsᵀ values of each block, (blocks, columns)."""
        return np.stack([values[a:b] @ columns[a:b] for a, b in pairwise(self.starts)])

    def products(self, columns: FloatArray) -> FloatArray:
        """Columnsᵀ columns of each block, (blocks, d, d)."""
        return np.stack([columns[a:b].T @ columns[a:b] for a, b in pairwise(self.starts)])


def inclusion(
    blocks: Blocks,
    basis: FloatArray,
    candidates: Sequence[FloatArray],
    target: FloatArray,
    penalties: FloatArray,
    wanted: Sequence[int],
    random: np.random.Generator,
) -> float:
    """Share of complementary half-samples in which one of the ``wanted`` candidates is worth most, and worth anything.

    Parameters
    ----------
    basis : (N, k) what every half-sample fits along
    candidates : columns (N, d) of each
    penalties : drop of the squared residual that each reaches by chance on the whole data
    """
    scaled = [one / np.maximum(np.linalg.norm(one, axis=0), 1e-300) for one in candidates]
    products = blocks.products(np.concatenate([basis, *scaled, target[:, None]], axis=1))
    fixed, ends = basis.shape[1], np.cumsum([basis.shape[1], *[one.shape[1] for one in scaled]])
    places = [slice(a, b) for a, b in pairwise(ends)]
    hits = 0
    for _ in range(PAIRS):
        order = random.permutation(blocks.count)
        half = blocks.count // 2
        for chosen in (order[:half], order[half:]):
            drops = _drops(products[chosen].sum(axis=0), fixed, places)
            worth = drops - penalties * len(chosen) / blocks.count
            best = int(np.argmax(worth))
            hits += best in wanted and worth[best] > 0.0
    return hits / (2 * PAIRS)


def _drops(product: FloatArray, fixed: int, places: Sequence[slice]) -> FloatArray:
    """Drop of the squared residual by each candidate beside the fixed columns, from sums of products."""
    inner = product[:fixed, :fixed] + _RIDGE * np.trace(product[:fixed, :fixed]) * np.eye(fixed)
    rest = product[fixed:, fixed:] - product[fixed:, :fixed] @ np.linalg.solve(inner, product[:fixed, fixed:])
    drops = np.zeros(len(places))
    for number, place in enumerate(places):
        own = slice(place.start - fixed, place.stop - fixed)
        square, against = rest[own, own], rest[own, -1]
        square = square + _RIDGE * max(float(np.trace(square)), 1e-300) * np.eye(len(square))
        drops[number] = float(against @ np.linalg.solve(square, against))
    return drops


def interval_of(
    blocks: Blocks, columns: FloatArray, fixed: FloatArray, target: FloatArray, random: np.random.Generator
) -> tuple[FloatArray, FloatArray]:
    """Ends of the 90 % intervals of a term's coefficients (d,): blocks drawn with replacement, all columns refitted."""
    everything = np.concatenate([columns, fixed], axis=1)
    scale = np.maximum(np.linalg.norm(everything, axis=0), 1e-300)
    products = blocks.products(np.concatenate([everything / scale, target[:, None]], axis=1))
    count, size = columns.shape[1], everything.shape[1]
    drawn = np.empty((_DRAWS, count))
    for draw in range(_DRAWS):
        product = products[random.integers(0, blocks.count, blocks.count)].sum(axis=0)
        inner = product[:size, :size] + _RIDGE * np.eye(size)
        drawn[draw] = np.linalg.solve(inner, product[:size, -1])[:count] / scale[:count]
    low, high = np.quantile(drawn, [0.05, 0.95], axis=0)
    return low, high
