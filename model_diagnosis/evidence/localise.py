"""Which equation is violated: a drifting disturbance in each balance, by maximum likelihood.

Source: model discrepancy anchor, section 3.8. Each equation error (force balances, wheel torques, …) and each
signal's innovation is read as a disturbance that walks at random, variance q per sample, beneath white noise;
LR = 2 (l(q̂) - l(0)).
"""

from collections.abc import Callable, Mapping, Sequence

import numpy as np
from numba import njit
from numpy.typing import NDArray

FloatArray = NDArray[np.float64]

BLOCK_SAMPLES = 7
"""Samples averaged to one: the span of the fits behind the derivatives (70 ms), so that noise is white again."""

GOLDEN_STEPS = 12
LOG_RATIO_LOW, LOG_RATIO_HIGH = -12.0, 3.0


@njit(cache=True)
def _log_likelihood(series: FloatArray, noise_variance: float, ratio: float) -> float:
    """Log likelihood of a random walk from 0, variance ratio * noise per step, under white noise."""
    state, variance, total = 0.0, 0.0, 0.0
    for value in series:
        variance += ratio * noise_variance
        innovation_variance = variance + noise_variance
        error = value - state
        total -= 0.5 * (np.log(innovation_variance) + error * error / innovation_variance)
        gain = variance / innovation_variance
        state += gain * error
        variance *= 1.0 - gain
    return total


def likelihood_ratio(series: Sequence[FloatArray]) -> float:
    """LR of a random walk in the equation errors of all manoeuvres, one q for all; series (n_m,), nan where unknown."""
    blocks = [_block_means(values) for values in series]
    blocks = [values for values in blocks if len(values) > 3]
    if not blocks:
        return 0.0
    noise = [_noise_variance(values) for values in blocks]

    def total(log_ratio: float) -> float:
        ratio = float(np.exp(log_ratio))
        return sum(_log_likelihood(values, level, ratio) for values, level in zip(blocks, noise, strict=True))

    best = _golden_maximum(total, LOG_RATIO_LOW, LOG_RATIO_HIGH)
    nothing = sum(_log_likelihood(values, level, 0.0) for values, level in zip(blocks, noise, strict=True))
    return max(0.0, 2.0 * (best - nothing))


def violated_equations(errors: Sequence[Mapping[str, FloatArray]], temperature: float) -> dict[str, float]:
    """LR / T of every equation, the most violated first; ``errors`` per manoeuvre: equation -> (n,)."""
    names = list(dict.fromkeys(name for one in errors for name in one))
    ratios = {name: likelihood_ratio([one[name] for one in errors if name in one]) / temperature for name in names}
    return dict(sorted(ratios.items(), key=lambda item: -item[1]))


def _block_means(values: FloatArray) -> FloatArray:
    known = values[np.isfinite(values)]
    return known[: len(known) // BLOCK_SAMPLES * BLOCK_SAMPLES].reshape(-1, BLOCK_SAMPLES).mean(axis=1)


def _noise_variance(values: FloatArray) -> float:
    """Half the mean squared second difference's share: what does not drift from block to block."""
    second = values[2:] - 2.0 * values[1:-1] + values[:-2]
    return max(float(np.median(second**2)) / 0.4549 / 6.0, 1e-12 * max(float(np.mean(values**2)), 1e-12))


def _golden_maximum(function: Callable[[float], float], low: float, high: float) -> float:
    """Largest value of a unimodal function on [low, high]."""
    share = (np.sqrt(5.0) - 1.0) / 2.0
    left, right = high - share * (high - low), low + share * (high - low)
    at_left, at_right = function(left), function(right)
    for _ in range(GOLDEN_STEPS):
        if at_left > at_right:
            high, right, at_right = right, left, at_left
            left = high - share * (high - low)
            at_left = function(left)
        else:
            low, left, at_left = left, right, at_right
            right = low + share * (high - low)
            at_right = function(right)
    return float(max(at_left, at_right))
