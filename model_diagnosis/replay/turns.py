"""Pressures that turn only where more than their noise turns them; compiled.

A brake with hysteresis follows a falling pressure only beyond its width. Each peak of noise on a flank turns it back,
and it holds the torque of that peak: the noise would pass for a wider hysteresis. Between turns that noise does not
make, the course is the monotone one that is nearest to the samples (pool adjacent violators: Ayer, Brunk, Ewing, Reid
and Silverman 1955), and a turn lies at the mean of the samples about it that noise does not tell apart.
"""

import numpy as np
from numba import njit
from numpy.typing import NDArray

FloatArray = NDArray[np.float64]
IntArray = NDArray[np.int64]

TURN_STDS = 3.0
"""Standard deviations of the noise from which a way back is a turn: samples of a flank keep all of it, and 3 of 100
pairs differ by more."""


def without_small_turns(values: FloatArray, noise: float) -> FloatArray:
    """Samples (n,) that rise or fall between turns of more than ``TURN_STDS`` of the noise."""
    course: FloatArray = np.array(values, dtype=np.float64)
    if noise > 0.0 and len(values) > 1:
        turns = turning_points(course, TURN_STDS * noise)
        _level_turns(course, turns, noise)
        _pool_between(course, turns)
    return course


@njit(cache=True, nogil=True)
def turning_points(values: FloatArray, least: float) -> IntArray:
    """Places of the first sample, of each extreme from which the values (n,) go back by more than ``least``, and of the
    last sample."""
    found = np.zeros(len(values) + 1, dtype=np.int64)
    count = 1
    low = high = 0
    direction = 0
    for i in range(1, len(values)):
        if values[i] > values[high]:
            high = i
        if values[i] < values[low]:
            low = i
        if direction >= 0 and values[high] - values[i] > least:
            if high > found[count - 1]:
                found[count] = high
                count += 1
            direction, low = -1, i
        elif direction <= 0 and values[i] - values[low] > least:
            if low > found[count - 1]:
                found[count] = low
                count += 1
            direction, high = 1, i
    if found[count - 1] < len(values) - 1:
        found[count] = len(values) - 1
        count += 1
    return found[:count]


@njit(cache=True, nogil=True)
def _level_turns(values: FloatArray, turns: IntArray, within: float) -> None:
    """Give the samples about each turn that are as near to it as ``within`` their mean: a hold ends at no peak of its
    noise."""
    last = turns[0]
    for part in range(1, len(turns) - 1):
        turn, begin, end = turns[part], turns[part], turns[part] + 1
        while begin > last + 1 and abs(values[begin - 1] - values[turn]) < within:
            begin -= 1
        while end < turns[part + 1] and abs(values[end] - values[turn]) < within:
            end += 1
        values[begin:end] = np.mean(values[begin:end])
        last = end - 1


@njit(cache=True, nogil=True)
def _pool_between(values: FloatArray, turns: IntArray) -> None:
    """Make the values (n,) monotone from each turn to the next one."""
    means, counts = np.zeros(len(values)), np.zeros(len(values), dtype=np.int64)
    for part in range(len(turns) - 1):
        begin, end = turns[part], turns[part + 1]
        sign = 1.0 if values[end] >= values[begin] else -1.0
        blocks = 0
        for i in range(begin, end + 1):
            means[blocks], counts[blocks] = sign * values[i], 1
            blocks += 1
            while blocks > 1 and means[blocks - 2] > means[blocks - 1]:
                both = counts[blocks - 2] + counts[blocks - 1]
                total = means[blocks - 2] * counts[blocks - 2] + means[blocks - 1] * counts[blocks - 1]
                means[blocks - 2], counts[blocks - 2] = total / both, both
                blocks -= 1
        at = begin
        for block in range(blocks):
            values[at : at + counts[block]] = sign * means[block]
            at += counts[block]
