"""Mean course of a noisy signal that is made of straight lines, over all places where one may end; compiled.

Each line has its own level and slope, so that corners and jumps stay where they are. A line of k samples is as likely
as its residuals under white noise, over the ranges that level and slope may take; the sum over all ways to cut the
signal is exact by recursions from both ends (P. Fearnhead, Exact and efficient Bayesian inference for multiple
changepoint problems, Statistics and Computing 16, 2006, section 2).
"""

import math
from typing import TypeAlias

import numpy as np
from numba import njit
from numpy.typing import NDArray

FloatArray = NDArray[np.float64]
Sums: TypeAlias = tuple[float, float, float]

LEAST_SAMPLES = 8
"""Fewer are no signal to cut."""
_LONGEST = 128
"""Samples of one line, at 10 ms 1.3 s: longer ones average no noise that matters."""
_END_CHANCE = 0.05
"""Of a line, at each of its samples: one in 0.2 s, as corners of a pedal's stroke lie. Between 0.04 and 0.1 the errors
left in stops of the challenge's generator differ by less than a tenth (tuning seeds)."""
_SLOPE_SAMPLES = 4
_STEEPER = 2.0
"""Lines may be twice as steep as the steepest change over 0.04 s, in which noise does not count: the range of slopes
only prices a line, by 0.7 in the logarithm for a factor of 2."""
_NEGLIGIBLE = -20.0
"""Logarithm of a line's probability, 2e-9, below which it changes no digit that matters."""
_SHORTEST = 2
"""Samples of the shortest line: as many as it has numbers, for which its residuals have no freedom."""


@njit(cache=True, nogil=True, error_model="numpy")
def broken_lines(values: FloatArray, noise: float, course: FloatArray) -> float:
    """Write the mean course (n,) of values (n,) with white noise; returns the noise that the lines leave.

    Parameters
    ----------
    values : (n,), at least ``LEAST_SAMPLES``
    noise : standard deviation of the values' noise, above 0
    """
    n = len(values)
    evidence = np.full((n, min(_LONGEST, n) + 1), -np.inf)
    _weigh_lines(values, noise, evidence)
    before, behind = np.full(n + 1, -np.inf), np.full(n + 1, -np.inf)
    _sum_before(evidence, before)
    _sum_behind(evidence, behind)
    # each line's offset and slope come in where it begins and go where it ends
    offsets, slopes = np.zeros(n + 1), np.zeros(n + 1)
    left, freedoms = 0.0, 0.0
    for begin in range(n):
        sums = 0.0, 0.0, 0.0
        for k in range(1, min(_LONGEST, n - begin) + 1):
            sums = _longer(sums, k, values[begin + k - 1] - values[begin])
            log_share = before[begin] + evidence[begin, k] + behind[begin + k] - before[n]
            if log_share < _NEGLIGIBLE:
                continue
            share = math.exp(log_share)
            level, slope, misfit = _line(sums, k)
            offset = share * (values[begin] + level - slope * begin)
            offsets[begin] += offset
            offsets[begin + k] -= offset
            slopes[begin] += share * slope
            slopes[begin + k] -= share * slope
            left += share * misfit
            freedoms += share * (k - _SHORTEST)
    offset, slope = 0.0, 0.0
    for i in range(n):
        offset += offsets[i]
        slope += slopes[i]
        course[i] = offset + slope * i
    return math.sqrt(left / max(freedoms, 1.0))


@njit(cache=True, nogil=True, forceinline=True, error_model="numpy")
def _longer(sums: Sums, k: int, beyond: float) -> Sums:
    """Sum, moment and sum of squares of a line's first k samples, of which the last lies so far beyond the first."""
    return sums[0] + beyond, sums[1] + (k - 1) * beyond, sums[2] + beyond * beyond


@njit(cache=True, nogil=True, forceinline=True, error_model="numpy")
def _line(sums: Sums, k: int) -> Sums:
    """Level beyond the first sample, slope and sum of squared residuals of the line through k samples."""
    middle = 0.5 * (k - 1)
    along = sums[1] - middle * sums[0]
    slope = along * 12.0 / (k * (k * k - 1))
    misfit = max(sums[2] - sums[0] * sums[0] / k - slope * along, 0.0)
    return sums[0] / k - slope * middle, slope, misfit


@njit(cache=True, nogil=True, error_model="numpy")
def _weigh_lines(values: FloatArray, noise: float, evidence: FloatArray) -> None:
    """Write the log evidence (n, longest + 1) of each line, by its first sample and its length."""
    n, longest = len(values), evidence.shape[1] - 1
    variance = noise * noise
    ranges = math.log(_range_of_levels(values, noise)) + math.log(_range_of_slopes(values, noise))
    of_noise, goes_on, ends = math.log(2.0 * math.pi * variance), math.log(1.0 - _END_CHANCE), math.log(_END_CHANCE)
    for begin in range(n):
        sums = 0.0, 0.0, 0.0
        for k in range(1, min(longest, n - begin) + 1):
            sums = _longer(sums, k, values[begin + k - 1] - values[begin])
            if k >= _SHORTEST:
                likely = -0.5 * (_line(sums, k)[2] / variance + (k - _SHORTEST) * of_noise)
                determined = 0.5 * math.log(k * k * (k * k - 1) / 12.0)
                evidence[begin, k] = likely - determined - ranges + (k - 1) * goes_on + ends


@njit(cache=True, nogil=True, error_model="numpy")
def _range_of_levels(values: FloatArray, noise: float) -> float:
    return max(values.max() - values.min(), noise)


@njit(cache=True, nogil=True, error_model="numpy")
def _range_of_slopes(values: FloatArray, noise: float) -> float:
    steepest = noise
    for i in range(len(values) - _SLOPE_SAMPLES):
        steepest = max(steepest, _STEEPER * abs(values[i + _SLOPE_SAMPLES] - values[i]) / _SLOPE_SAMPLES)
    return steepest


@njit(cache=True, nogil=True, error_model="numpy")
def _sum_before(evidence: FloatArray, before: FloatArray) -> None:
    """Write the log evidence (n + 1,) of the first samples, over all ways to cut them."""
    n, longest = len(evidence), evidence.shape[1] - 1
    before[0] = 0.0
    for end in range(1, n + 1):
        count = min(longest, end)
        best = -np.inf
        for k in range(_SHORTEST, count + 1):
            best = max(best, before[end - k] + evidence[end - k, k])
        if best == -np.inf:
            continue
        total = 0.0
        for k in range(_SHORTEST, count + 1):
            total += math.exp(before[end - k] + evidence[end - k, k] - best)
        before[end] = best + math.log(total)


@njit(cache=True, nogil=True, error_model="numpy")
def _sum_behind(evidence: FloatArray, behind: FloatArray) -> None:
    """Write the log evidence (n + 1,) of the samples from each one on."""
    n, longest = len(evidence), evidence.shape[1] - 1
    behind[n] = 0.0
    for begin in range(n - 1, -1, -1):
        count = min(longest, n - begin)
        best = -np.inf
        for k in range(_SHORTEST, count + 1):
            best = max(best, behind[begin + k] + evidence[begin, k])
        if best == -np.inf:
            continue
        total = 0.0
        for k in range(_SHORTEST, count + 1):
            total += math.exp(behind[begin + k] + evidence[begin, k] - best)
        behind[begin] = best + math.log(total)
