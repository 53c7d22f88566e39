"""Whitening of residuals and sensitivities: AR(4) per signal, inflation where the form is wrong, temperature.

Source: model discrepancy anchor, section 3.4. The filter runs over the valid samples of a signal one after the other,
so that a signal held for ten samples out of eleven is whitened at its own rate.
"""

from collections.abc import Sequence
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import csr_array

from model_diagnosis.evidence.replay_model import ReplayModel
from model_diagnosis.replay.smoothing import noise_of

FloatArray = NDArray[np.float64]
IntArray = NDArray[np.int64]

ORDER = 4
RIDGE = 1e-5
HUBER_LIMIT = 3.0
TEMPERATURE_BLOCK_SAMPLES = 50
INFLATION_BLOCKS_SAMPLES = (20, 50)
LOCAL_VARIANCES = 10
LOCAL_VARIANCE_ALLOWANCE = 1.5


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
    """

    signal: str
    column: int
    samples: IntArray
    coefficients: FloatArray
    sigma: float
    inflation: float

    def apply(self, values: FloatArray) -> FloatArray:
        """Whiten (n, …) samples of this signal: (k - 4, …) innovations in units of sigma."""
        valid = values[self.samples]
        white = valid[ORDER:].copy()
        for lag, coefficient in enumerate(self.coefficients, start=1):
            white -= coefficient * valid[ORDER - lag : -lag]
        white /= self.sigma
        return white


@dataclass(frozen=True)
class Whitener:
    """All filters, by manoeuvre, and the temperature that divides every quadratic form."""

    filters: tuple[tuple[SignalFilter, ...], ...]
    temperature: float = 1.0
    rows: tuple[int, ...] = field(default=())

    def residuals(self, residuals: Sequence[FloatArray]) -> list[FloatArray]:
        """Whitened residual (N_m,) of each manoeuvre, its signals one after the other."""
        return [
            _stack([one.apply(values[:, one.column]) for one in filters], ())
            for filters, values in zip(self.filters, residuals, strict=True)
        ]

    def sensitivities(self, sensitivities: Sequence[FloatArray]) -> list[FloatArray]:
        """Whitened sensitivities (N_m, p) of each manoeuvre."""
        return [
            _stack([one.apply(values[:, one.column]) for one in filters], values.shape[2:])
            for filters, values in zip(self.filters, sensitivities, strict=True)
        ]

    def blocks(self) -> list[IntArray]:
        """Number of the 0.5 s block that each whitened row of a manoeuvre belongs to."""
        return [
            np.concatenate([one.samples[ORDER:] // TEMPERATURE_BLOCK_SAMPLES for one in filters])
            if filters
            else np.zeros(0, dtype=np.int64)
            for filters in self.filters
        ]

    def log_sigma(self) -> float:
        """Sum over rows of log sigma: how well the residual behind this filter is predicted."""
        return float(sum((len(one.samples) - ORDER) * np.log(one.sigma) for filters in self.filters for one in filters))


def _stack(parts: list[FloatArray], shape: tuple[int, ...]) -> FloatArray:
    return np.concatenate(parts) if parts else np.zeros((0, *shape))


def sensor_whitener(replay: ReplayModel) -> Whitener:
    """Filter before anything is known: no colour, every signal in units of its sensor's own noise."""
    filters = []
    for index, weights in enumerate(replay.weights()):
        filters.append(
            tuple(
                SignalFilter(signal, column, samples, np.zeros(ORDER), replay.sensor_std(signal), 1.0)
                for column, signal in enumerate(replay.signals(index))
                if len(samples := np.flatnonzero(weights[:, column] > 0.0)) > 4 * ORDER
            )
        )
    return Whitener(tuple(filters))


def fit_whitener(replay: ReplayModel, residuals: Sequence[FloatArray]) -> Whitener:
    """Filters from the residual that no effect can explain (that of the saturated fit); temperature still 1."""
    filters = []
    for known, values in zip(sensor_whitener(replay).filters, residuals, strict=True):
        filters.append(
            tuple(
                fit_signal(one.signal, one.column, one.samples, values[one.samples, one.column], one.sigma)
                for one in known
            )
        )
    return Whitener(tuple(filters))


def fit_signal(signal: str, column: int, samples: IntArray, residual: FloatArray, own_std: float) -> SignalFilter:
    """Filter of one signal from its residual (k,) at the valid samples, its sensor's noise ``own_std`` in its unit."""
    lags = np.stack([residual[ORDER - lag : -lag] for lag in range(1, ORDER + 1)], axis=1)
    gram = lags.T @ lags
    gram[np.diag_indices(ORDER)] += RIDGE * max(float(np.trace(gram)) / ORDER, 1e-300)
    # a log without its sensors' noise would be predicted from itself so well that nothing slow is left to explain
    lacking = max((0.5 * own_std) ** 2 - noise_of(residual) ** 2, 0.0)
    gram[np.diag_indices(ORDER)] += len(lags) * lacking
    coefficients = np.asarray(np.linalg.solve(gram, lags.T @ residual[ORDER:]), dtype=np.float64)
    innovations = residual[ORDER:] - lags @ coefficients
    # what the sensor's own noise becomes behind the same filter is the least that can be left
    floor = 0.5 * own_std * float(np.sqrt(1.0 + coefficients @ coefficients))
    sigma = max(float(np.sqrt(np.mean(innovations**2))), floor)
    inflation = form_inflation(innovations / sigma)
    return SignalFilter(signal, column, samples, coefficients, sigma * float(np.sqrt(inflation)), inflation)


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


def huber_weights(whitened: FloatArray) -> FloatArray:
    """Weights of iteratively reweighted least squares with Huber's loss, limit 3 standard deviations."""
    return np.minimum(1.0, HUBER_LIMIT / np.maximum(np.abs(whitened), 1e-12))


def huber_loss(whitened: FloatArray) -> float:
    """Sum of Huber's loss, scaled so that it is the sum of squares within the limit."""
    size = np.abs(whitened)
    return float(np.sum(np.where(size <= HUBER_LIMIT, size**2, HUBER_LIMIT * (2.0 * size - HUBER_LIMIT))))


def temperature(
    residuals: Sequence[FloatArray], sensitivities: Sequence[FloatArray], blocks: Sequence[IntArray]
) -> float:
    """Factor by which sums over 0.5 s blocks scatter more than white innovations would let them (at least 1)."""
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
    excited = expected > 1e-9 * max(float(expected.max(initial=0.0)), 1e-300)
    if not excited.any():
        return 1.0
    return max(1.0, float(np.median(observed[excited] / expected[excited])))
