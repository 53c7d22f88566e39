"""Whitening of residuals and sensitivities: AR(4) per signal, the observer's memory, inflation where the form is wrong.

Source: model discrepancy anchor, section 3.4. The filter runs over the valid samples of a signal one after the other,
so that a signal held for ten samples out of eleven is whitened at its own rate.

The observer draws the predicted speed to the measured one, and with it the sensor's noise comes into all wheels: they
err by the same slow error, and what they say is not said four times. A leaky sum of the past residuals times the
observer's gain is what it has put there; the regressions of speed and wheel speeds have it beside their own past (an
autoregression with an exogenous input), so that the innovations of different signals are free of it. The filter is
linear and causal, so residuals and sensitivities pass through it alike.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from functools import cached_property
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray
from scipy.signal import lfilter
from scipy.sparse import csr_array

from model_diagnosis.evidence.replay_model import ReplayModel
from model_diagnosis.evidence.side_by_side import side_by_side
from model_diagnosis.evidence.whiten_kernel import whiten
from model_diagnosis.huber import huber_weights
from model_diagnosis.replay.gaps import GAP_STEPS, ends_of_gaps, pieces_of
from model_diagnosis.replay.smoothing import noise_of
from signals.wheels import WHEELS

FloatArray = NDArray[np.float64]
IntArray = NDArray[np.int64]

ORDER = GAP_STEPS
RIDGE = 1e-5
LEAKS = (0.05, 0.0125, 0.003, 0.0008)
"""Shares of the observer's corrections that are forgotten per sample, tried: after 0.2 s, 0.8 s, 3 s and 12 s.

A perfect model's lasts for ever; where the model's form drifts, the sum of its corrections drifts with it."""

OF_SPEED = ("speed", *(f"wheel_speed_{wheel}" for wheel in WHEELS))
"""Signals that the observer's speed is predicted in. Others err by its rate at most, and a regression on a slow sum
finds what is not there."""

TEMPERATURE_BLOCK_SAMPLES = 50
INFLATION_BLOCKS_SAMPLES = (20, 50)
LOCAL_VARIANCES = 10
LOCAL_VARIANCE_ALLOWANCE = 1.5

NO_SUMS, NO_COEFFICIENTS = np.zeros((0, 0, 0)), np.zeros(0)


@dataclass(frozen=True)
class Memory:
    """What the observer has put on its states in one manoeuvre, from the residuals that it saw.

    Attributes
    ----------
    corrections : (c, k) change of each of k states by one unit of each signal's residual
    leak : share that is forgotten from sample to sample
    begins : samples with which the observer began anew behind a gap: what it had put there before is gone
    """

    corrections: FloatArray
    leak: float
    begins: tuple[int, ...] = ()

    def of(self, values: FloatArray, filters: Sequence["SignalFilter"]) -> FloatArray:
        """Leaky sums (n, k, …) of the corrections before each sample, of residuals or sensitivities (n, c, …)."""
        moved = np.zeros((len(values), self.corrections.shape[1], *values.shape[2:]))
        for one in filters:
            for state in np.flatnonzero(self.corrections[one.column]):
                moved[one.samples, state] += self.corrections[one.column, state] * values[one.samples, one.column]
        sums = np.zeros_like(moved)
        for begin, end in pairwise([0, *self.begins, len(moved)]):
            sums[begin:end] = lfilter([0.0, 1.0], [1.0, self.leak - 1.0], moved[begin:end], axis=0)
        return sums

    def variance(self, of_signals: FloatArray) -> FloatArray:
        """Variances (k,) of the sums where white residuals have these variances (c,)."""
        return np.asarray((self.corrections**2).T @ of_signals / (1.0 - (1.0 - self.leak) ** 2))


@dataclass(frozen=True)
class SignalFilter:
    """Whitening filter of one signal in one manoeuvre.

    Attributes
    ----------
    signal : its name
    column : its column in the manoeuvre's arrays
    samples : (k,) indices of the valid samples
    coefficients : (4,) autoregression of the residual
    sigma : standard deviation of the innovations, inflation included, in the signal's unit
    inflation : variance factor for form errors, at least 1
    of_memory : coefficients of the observer's sums; empty where they are left out
    """

    signal: str
    column: int
    samples: IntArray
    coefficients: FloatArray
    sigma: float
    inflation: float
    of_memory: FloatArray = field(default_factory=lambda: np.zeros(0))

    @cached_property
    def rows(self) -> IntArray:
        """Places in ``samples`` of those that the filter predicts: with four before them and no gap in between."""
        return rows_of(self.samples)

    def apply(self, values: FloatArray, memory: FloatArray | None = None) -> FloatArray:
        """Whiten (n, …) samples of this signal: (rows, …) innovations in units of sigma; ``memory`` (n, k, …)."""
        shape = values.shape[1:]
        count = int(np.prod(shape))
        white = np.empty((len(self.rows), count))
        sums = NO_SUMS if memory is None else memory.reshape(len(memory), -1, count)
        self.apply_to(values.reshape(len(values), 1, count), 0, sums, white)
        return white.reshape(len(self.rows), *shape)

    def apply_to(self, values: FloatArray, column: int, sums: FloatArray, out: FloatArray) -> None:
        """Whiten a column of (n, c, p) values into ``out`` (rows, p); ``sums`` (n, k, p) are the memory's."""
        of_memory = self.of_memory if len(sums) else NO_COEFFICIENTS
        whiten(values, column, self.samples, self.rows, self.coefficients, sums, of_memory, self.sigma, out)


def rows_of(samples: IntArray) -> IntArray:
    """Places (r,) in the valid samples (k,) that have as many before them as the filter is long, without a gap.

    A gap is longer than the filter at the signal's usual rate: behind it nothing that the filter knows is of use.
    """
    piece = pieces_of(samples)
    return np.asarray(np.flatnonzero(piece[ORDER:] == piece[:-ORDER]) + ORDER, dtype=np.int64)


@dataclass(frozen=True)
class Whitener:
    """All filters, by manoeuvre, and the temperature that divides every quadratic form.

    Attributes
    ----------
    memories : of the observer, by manoeuvre; empty where they are left out
    """

    filters: tuple[tuple[SignalFilter, ...], ...]
    temperature: float = 1.0
    memories: tuple[Memory, ...] = ()

    def whitened(self, m: int, values: FloatArray) -> FloatArray:
        """Values (n, c, …) of manoeuvre ``m`` behind its filters (N_m, …), its signals one after the other."""
        filters = self.filters[m]
        if not filters:
            return np.zeros((0, *values.shape[2:]))
        shape = values.shape[2:]
        wide = np.ascontiguousarray(values).reshape(*values.shape[:2], int(np.prod(shape)))
        sums = self.memories[m].of(wide, filters) if self.memories else NO_SUMS
        ends = np.cumsum([0, *(len(one.rows) for one in filters)])
        white = np.empty((ends[-1], wide.shape[2]))
        for one, begin, end in zip(filters, ends[:-1], ends[1:], strict=True):
            one.apply_to(wide, one.column, sums, white[begin:end])
        return white.reshape(ends[-1], *shape)

    def residuals(self, residuals: Sequence[FloatArray]) -> list[FloatArray]:
        """Whitened residual (N_m,) of each manoeuvre, its signals one after the other."""
        return side_by_side(lambda m: self.whitened(m, residuals[m]), len(residuals))

    def sensitivities(self, sensitivities: Sequence[FloatArray]) -> list[FloatArray]:
        """Whitened sensitivities (N_m, p) of each manoeuvre."""
        return side_by_side(lambda m: self.whitened(m, sensitivities[m]), len(sensitivities))

    def blocks(self, samples: int = TEMPERATURE_BLOCK_SAMPLES) -> list[IntArray]:
        """Number of the block of so many samples (0.5 s) that each whitened row of a manoeuvre belongs to."""
        return [
            np.concatenate([one.samples[one.rows] // samples for one in filters])
            if filters
            else np.zeros(0, dtype=np.int64)
            for filters in self.filters
        ]

    def log_sigma(self) -> float:
        """Sum over rows of log sigma: how well the residual behind this filter is predicted."""
        return float(sum(len(one.rows) * np.log(one.sigma) for filters in self.filters for one in filters))


def sensor_whitener(replay: ReplayModel) -> Whitener:
    """Filter before anything is known: no colour, every signal in units of its sensor's own noise."""
    filters = []
    for index, weights in enumerate(replay.weights()):
        filters.append(
            tuple(
                SignalFilter(signal, column, samples, np.zeros(ORDER), replay.sensor_std(signal), 1.0)
                for column, signal in enumerate(replay.signals(index))
                if len(rows_of(samples := np.flatnonzero(weights[:, column] > 0.0))) > 3 * ORDER
            )
        )
    return Whitener(tuple(filters))


def fit_whitener(replay: ReplayModel, residuals: Sequence[FloatArray]) -> Whitener:
    """Filters from the residual that no effect can explain (that of the saturated fit); temperature still 1.

    How long the observer's corrections stay in the predictions differs with what corrects them beside it: of the
    ``LEAKS`` the one that predicts the residuals best is taken.
    """
    known = sensor_whitener(replay).filters
    without = [
        {
            one.column: fit_signal(one.signal, one.column, one.samples, values[one.samples, one.column], one.sigma)
            for one in filters
            if one.signal not in OF_SPEED
        }
        for filters, values in zip(known, residuals, strict=True)
    ]
    made = [_whitener_with_leak(replay, residuals, leak, known, without) for leak in LEAKS]
    return min(made, key=lambda whitener: whitener.log_sigma())


def _whitener_with_leak(
    replay: ReplayModel,
    residuals: Sequence[FloatArray],
    leak: float,
    sensors: Sequence[Sequence[SignalFilter]],
    without: Sequence[Mapping[int, SignalFilter]],
) -> Whitener:
    """Whitener with one leak; ``without`` are the filters, by column, of signals that have no memory."""
    filters, memories = [], []
    for m, (known, values) in enumerate(zip(sensors, residuals, strict=True)):
        begins = tuple(ends_of_gaps(replay.manoeuvres[m]).tolist())
        memory = Memory(replay.corrections(m), leak, begins)
        sums, lacking = memory.of(values, known), np.zeros(values.shape[1])
        for one in known:
            lacking[one.column] = _lacking_variance(values[one.samples, one.column], one.sigma)
        of_memory = memory.variance(lacking)
        filters.append(
            tuple(
                without[m].get(one.column)
                or fit_signal(
                    one.signal,
                    one.column,
                    one.samples,
                    values[one.samples, one.column],
                    one.sigma,
                    sums[one.samples],
                    of_memory,
                )
                for one in known
            )
        )
        memories.append(memory)
    return Whitener(tuple(filters), memories=tuple(memories))


def _lacking_variance(residual: FloatArray, own_std: float) -> float:
    """What a residual (k,) lacks of half its sensor's noise, as a variance."""
    return max((0.5 * own_std) ** 2 - noise_of(residual) ** 2, 0.0)


def fit_signal(
    signal: str,
    column: int,
    samples: IntArray,
    residual: FloatArray,
    own_std: float,
    memory: FloatArray | None = None,
    lacking_of_memory: FloatArray | None = None,
) -> SignalFilter:
    """Filter of one signal from its residual (k,) at the valid samples, its sensor's noise ``own_std`` in its unit.

    ``memory`` (k, s) are the observer's sums at these samples, ``lacking_of_memory`` (s,) the variances that they lack.
    """
    rows = rows_of(samples)
    sums = np.zeros((len(residual), 0)) if memory is None else memory
    known = np.stack([residual[rows - lag] for lag in range(1, ORDER + 1)] + list(sums[rows].T), axis=1)
    gram = known.T @ known
    own, states = np.arange(ORDER), np.arange(ORDER, known.shape[1])
    gram[own, own] += RIDGE * max(float(np.trace(gram[:ORDER, :ORDER])) / ORDER, 1e-300)
    # a log without its sensors' noise would be predicted from itself so well that nothing slow is left to explain
    gram[own, own] += len(rows) * _lacking_variance(residual, own_std)
    gram[states, states] += np.maximum(RIDGE * gram[states, states], 1e-300)
    if memory is not None and lacking_of_memory is not None:
        gram[states, states] += len(rows) * lacking_of_memory
    solved = np.asarray(np.linalg.solve(gram, known.T @ residual[rows]), dtype=np.float64)
    innovations = residual[rows] - known @ solved
    coefficients, of_memory = solved[:ORDER], solved[ORDER:]
    # what the sensor's own noise becomes behind the same filter is the least that can be left
    floor = 0.5 * own_std * float(np.sqrt(1.0 + coefficients @ coefficients))
    sigma = max(float(np.sqrt(np.mean(innovations**2))), floor)
    inflation = form_inflation(innovations / sigma)
    return SignalFilter(signal, column, samples, coefficients, sigma * float(np.sqrt(inflation)), inflation, of_memory)


def form_inflation(innovations: FloatArray) -> float:
    """Variance factor for a wrong form: slow drifts and bursts that white innovations of unit variance do not have."""
    slow = 1.0
    for length in INFLATION_BLOCKS_SAMPLES:
        blocks = innovations[: len(innovations) // length * length].reshape(-1, length)
        if len(blocks):
            slow = max(slow, float(np.mean(blocks.sum(axis=1) ** 2)) / length)
    local = [float(np.mean(part**2)) for part in np.array_split(innovations, LOCAL_VARIANCES) if len(part)]
    burst = max(1.0, float(np.sqrt(max(local, default=1.0))) / LOCAL_VARIANCE_ALLOWANCE)
    return slow * burst


def scatter(
    residuals: Sequence[FloatArray], sensitivities: Sequence[FloatArray], blocks: Sequence[IntArray]
) -> tuple[FloatArray, FloatArray]:
    """Squared scores of each column (p,), summed over blocks, and what white innovations would make of them."""
    columns = sensitivities[0].shape[1]
    observed, expected = np.zeros(columns), np.zeros(columns)
    for residual, matrix, block in zip(residuals, sensitivities, blocks, strict=True):
        if not len(residual):
            continue
        weights = huber_weights(residual)
        member = csr_array((weights * residual, (block, np.arange(len(block)))))
        score = member @ matrix
        observed += np.sum(score**2, axis=0)
        expected += np.einsum("ij,ij,i->j", matrix, matrix, weights)
    return observed, expected


def temperature(
    residuals: Sequence[FloatArray], sensitivities: Sequence[FloatArray], blocks: Sequence[IntArray]
) -> float:
    """Factor by which sums over 0.5 s blocks scatter more than white innovations would let them (at least 1)."""
    observed, expected = scatter(residuals, sensitivities, blocks)
    excited = expected > 1e-9 * max(float(expected.max(initial=0.0)), 1e-300)
    if not excited.any():
        return 1.0
    return max(1.0, float(np.median(observed[excited] / expected[excited])))
