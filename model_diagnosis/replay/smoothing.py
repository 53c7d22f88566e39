"""Inputs of the replay without their sensors' noise.

What drives the replay goes through valves that let fluid one way and pads that only press: both make a mean pressure
out of noise, so that a noisy input drives another car than the one that was measured. A course of straight lines with
corners and jumps is taken for what it is. One that bends from sample to sample, as in an ABS stop, is no such course:
there each sample is the middle of the straight line through the widest window about it that the noise alone explains
(Lepski's rule for the width), and flanks keep every sample.
"""

from functools import lru_cache

import numpy as np
from numpy.typing import NDArray
from scipy.ndimage import median_filter
from scipy.stats import chi2

from model_diagnosis.replay.broken_lines import LEAST_SAMPLES, broken_lines
from model_diagnosis.replay.record import COASTING_NM
from model_diagnosis.replay.turns import without_small_turns

FloatArray = NDArray[np.float64]

HALF_WIDTHS = (2, 4, 8, 16)
"""Half widths of the windows in samples."""

_ALLOWED_SPREADS = 3.0
"""Standard deviations of a chi-square over its freedoms, up to which noise explains the residual variance."""

_LEFT_OF_NOISE = 1.05
"""Share of the noise beyond which straight lines leave more than noise: in stops of the challenge's generator they
leave 0.87 to 1.0 of it, in its ABS stops, which bend from sample to sample, 1.1 to 1.2 (tuning seeds)."""

_LEAST_PRESSURE = 0.5
"""Share of the noise below which a pressure is none: three deviations of the mean over the widest window."""

_LARGEST_MEDIAN = 1.0
"""Share of the noise that its median over the widest window stays below: 4.6 deviations of it, 2.9 at ends."""

_LARGEST_PEAK = 4.5
"""Standard deviations that white noise stays below in a drive."""

_TORQUE_SAMPLES = 11
_TORQUE_STDS = 2.0
"""Of a torque's noise, five standard deviations of the median over 0.11 s."""
_LARGEST_RESTING_NM = 20.0
"""More drives the car, whatever the noise: a rolling resistance of 1 % takes 44 N m of 1.5 t on wheels of 0.3 m."""

_QUIET_SAMPLES = 15
_QUIET_SHARE = 0.1
"""Share of the windows of so many samples in which nothing but noise is taken to move a signal; an ABS moves pressures
in nearly all others."""

_KEPT = 256
"""Pressures whose course is kept: what is late is asked for by replays that differ in one channel of many."""

_CORRELATED = 1.0 + 2.0 * (4.0 / 6.0) ** 2 + 2.0 * (1.0 / 6.0) ** 2
"""Second differences of white noise that tell as much of its variance as one of independent numbers."""


def noise_of(values: FloatArray) -> float:
    """Standard deviation of the white noise in (n,) samples; 0 below five samples.

    From the second differences in short windows: a low quantile of their variances, over what that quantile is of
    chi-square for noise alone. Their median would be that of the motion in a stop whose pressures never rest.
    """
    if len(values) < 5:
        return 0.0
    squares = np.diff(values, 2) ** 2
    count = min(_QUIET_SAMPLES, len(squares))
    means = np.lib.stride_tricks.sliding_window_view(squares, count).mean(axis=1)
    moving = means[means > 0.0]
    if not len(moving):
        return 0.0
    freedoms = count / _CORRELATED
    of_noise = float(chi2.ppf(_QUIET_SHARE, freedoms)) / freedoms
    return float(np.sqrt(np.quantile(moving, _QUIET_SHARE) / (6.0 * of_noise)))


def without_noise(values: FloatArray) -> FloatArray:
    """Samples (n,) without noise, corners and jumps as they are."""
    noise = noise_of(values)
    course: FloatArray = np.array(values, dtype=np.float64)
    if (
        noise > 0.0
        and len(values) >= LEAST_SAMPLES
        and broken_lines(course.copy(), noise, course) > _LEFT_OF_NOISE * noise
    ):
        return _by_windows(values, noise)
    return course


def _by_windows(values: FloatArray, noise: float) -> FloatArray:
    """Samples (n,) without noise; those of a flank, where a straight line does not fit, stay as they are."""
    kept: FloatArray = values.copy()
    growing = np.ones(len(values), dtype=np.bool_)
    for half in HALF_WIDTHS:
        if len(values) <= 2 * half:
            break
        line, spread = _local_lines(values, half)
        allowed = 1.0 + _ALLOWED_SPREADS * np.sqrt(2.0 / (2 * half - 1))
        growing &= spread <= allowed * noise**2
        kept[growing] = line[growing]
    return kept


def pressure_without_noise(values: FloatArray) -> FloatArray:
    """Pressure (n,) without noise, and none at all where no more is left than the noise of a window's mean.

    Single peaks of the noise make a window's variance too large for its line; about them the median tells the rest.
    """
    return _quiet_pressure(np.asarray(values, dtype=np.float64).tobytes()).copy()


@lru_cache(maxsize=_KEPT)
def _quiet_pressure(samples: bytes) -> FloatArray:
    values = np.frombuffer(samples)
    return as_pressure(values, without_noise(values), noise_of(values))


def as_pressure(measured: FloatArray, course: FloatArray, noise: float) -> FloatArray:
    """Course (n,) that turns only beyond the noise of a measured pressure, and is exactly 0 where that one is not told
    from its noise."""
    pressure = without_small_turns(course, noise)
    resting = median_filter(measured, 2 * HALF_WIDTHS[-1] + 1, mode="reflect") < _LARGEST_MEDIAN * noise
    traces = (pressure < _LEAST_PRESSURE * noise) | (resting & (measured < _LARGEST_PEAK * noise))
    return np.where(traces, 0.0, pressure)


def torque_without_noise_at_rest(values: FloatArray) -> FloatArray:
    """Drive torque (n,) that is exactly 0 where only its sensor's noise is left, and as measured elsewhere.

    What acts while no torque drives, the engine's drag, would be switched on and off by that noise.
    """
    resting = min(max(COASTING_NM, _TORQUE_STDS * noise_of(values)), _LARGEST_RESTING_NM)
    return np.where(np.abs(median_filter(values, _TORQUE_SAMPLES, mode="reflect")) <= resting, 0.0, values)


def _local_lines(values: FloatArray, half: int) -> tuple[FloatArray, FloatArray]:
    """Straight line at the middle of each window (n,), and the residual variance in the window; inf at the ends."""
    count = 2 * half + 1
    offsets = np.arange(-half, half + 1)
    windows = np.lib.stride_tricks.sliding_window_view(values, count)
    mean = windows.mean(axis=1)
    slope = windows @ offsets / float(offsets @ offsets)
    left = windows - mean[:, None] - slope[:, None] * offsets
    line, spread = values.copy(), np.full(len(values), np.inf)
    line[half:-half] = mean
    spread[half:-half] = np.sum(left**2, axis=1) / (count - 2)
    return line, spread
