"""Twin of the cluster's microcontroller: SPI master, low-pass filter and plausibility check in front of the CAN.

The document names these stages and no numbers (1.3, 1.7); the numbers are settings with the defaults below.
"""

import math
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from numba import njit

from bench.sensor_cluster.sensor_block import CHANNELS, FIRST_ADDRESS, RESOLUTIONS, FloatArray
from bench.sensor_cluster.words import NORMAL, IntArray, address_of, is_intact, read_request, status_of, value_of

REQUESTS = np.array([read_request(FIRST_ADDRESS + k) for k in (*range(len(CHANNELS)), 0)], np.int64)
"""Transfers of a cycle: the last one fetches the answer to the last channel."""

# columns of the channels
VALUE, RAW, BAD, GOOD, VALID, UNCHANGED = range(6)
# positions in the settings
KEPT, RANGE, STEP, BAD_LIMIT, GOOD_LIMIT, FROZEN_LIMIT = range(6)
# positions in the counts
LINE, STATUS, OUT_OF_RANGE, JUMP, FROZEN = range(5)
COUNTS = ("line_errors", "status_errors", "out_of_range", "jumps", "frozen")


@dataclass(frozen=True)
class Plausibility:
    """Numbers of filter and plausibility check.

    Attributes
    ----------
    cutoff_hz : corner of the first-order low-pass
    range_share : share of the measuring range beyond which a value counts as out of range
    step_share : share of the measuring range by which a value may change in 1 ms
    bad_samples, good_samples : in a row until a channel is invalid, and valid again
    frozen_samples : without any change, while another channel changes, until a channel counts as frozen
    """

    cutoff_hz: float = 100.0
    range_share: float = 0.95
    step_share: float = 0.25
    bad_samples: int = 5
    good_samples: int = 20
    frozen_samples: int = 500

    def settings(self, cycle_s: float = 1e-3) -> FloatArray:
        """As the compiled check reads them."""
        kept = math.exp(-2.0 * math.pi * self.cutoff_hz * cycle_s)
        span = 32768.0
        limits = (self.range_share * span, self.step_share * span)
        return np.array([kept, *limits, self.bad_samples, self.good_samples, self.frozen_samples], np.float64)


class MicrocontrollerMemory(NamedTuple):
    """State of the twin for the compiled calls, which work in place.

    Attributes
    ----------
    channels : float64 array, shape (6, 6)
        A row per channel with the columns VALUE … UNCHANGED.
    settings : float64 array, shape (6,)
        From :meth:`Plausibility.settings`.
    counts : int64 array, shape (5,)
        What the checks found, in the order of ``COUNTS``.
    """

    channels: FloatArray
    settings: FloatArray
    counts: IntArray


@njit(cache=True)
def take_answers(memory: MicrocontrollerMemory, answers: IntArray) -> bool:
    """Check and filter the answers of a cycle; True while every channel is valid.

    A bad sample leaves the channel's value as it is; ``BAD_LIMIT`` of them in a row make the channel invalid.
    """
    channels, settings, counts = memory.channels, memory.settings, memory.counts
    changed = 0
    for k in range(channels.shape[0]):
        changed += is_intact(answers[k + 1]) and value_of(answers[k + 1]) != channels[k, RAW]
    all_valid = True
    for k in range(channels.shape[0]):
        word = answers[k + 1]
        good = False
        if not is_intact(word) or address_of(word) != FIRST_ADDRESS + k:
            counts[LINE] += 1
        elif status_of(word) != NORMAL:
            counts[STATUS] += 1
        else:
            good = _plausible(channels[k], settings, counts, float(value_of(word)), changed)
        _judge(channels[k], settings, good, RESOLUTIONS[k])
        all_valid = all_valid and channels[k, VALID] > 0.0
    return all_valid


@njit(cache=True)
def _plausible(channel: FloatArray, settings: FloatArray, counts: IntArray, raw: float, changed: int) -> bool:
    good = True
    if abs(raw) > settings[RANGE]:
        counts[OUT_OF_RANGE] += 1
        good = False
    elif channel[VALID] > 0.0 and abs(raw - channel[RAW]) > settings[STEP]:
        counts[JUMP] += 1
        good = False
    if raw != channel[RAW]:
        channel[UNCHANGED] = 0.0
    elif changed > 0:
        channel[UNCHANGED] += 1.0
    if channel[UNCHANGED] >= settings[FROZEN_LIMIT]:
        counts[FROZEN] += 1
        good = False
    channel[RAW] = raw
    return good


@njit(cache=True)
def _judge(channel: FloatArray, settings: FloatArray, good: bool, resolution: float) -> None:
    if not good:
        channel[GOOD] = 0.0
        channel[BAD] += 1.0
        if channel[BAD] >= settings[BAD_LIMIT]:
            channel[VALID] = 0.0
        return
    channel[BAD] = 0.0
    channel[GOOD] += 1.0
    value = channel[RAW] * resolution
    if channel[VALID] > 0.0:
        channel[VALUE] = settings[KEPT] * channel[VALUE] + (1.0 - settings[KEPT]) * value
        return
    channel[VALUE] = value
    if channel[GOOD] >= settings[GOOD_LIMIT]:
        channel[VALID] = 1.0


class Microcontroller:
    """The twin: hands out the requests of a cycle, takes the answers.

    Attributes
    ----------
    memory : MicrocontrollerMemory
        For compiled callers.
    values : array, shape (6,)
        Filtered channels in SI units, in the order of ``CHANNELS``; a view.
    """

    def __init__(self, plausibility: Plausibility) -> None:
        channels = np.zeros((len(CHANNELS), 6))
        self.memory = MicrocontrollerMemory(channels, plausibility.settings(), np.zeros(len(COUNTS), np.int64))
        self.values = channels[:, VALUE]

    def take(self, answers: IntArray) -> bool:
        """Take the seven answers of a cycle; True while all channels are valid."""
        return bool(take_answers(self.memory, answers))

    def counts(self) -> dict[str, int]:
        """What the checks found since the start."""
        return {name: int(count) for name, count in zip(COUNTS, self.memory.counts, strict=True)}
