"""Single CAN frames that were lost and that a log on one raster fills with the values before.

That one value repeats says nothing where the resolution is coarse. That all signals of a frame repeat exactly at once
while one of them moves does. So few are no fault of the data, but each is off by what its signals moved meanwhile.
"""

from collections.abc import Mapping, Sequence

import numpy as np
from numpy.typing import NDArray

from model_diagnosis.data.sample_values import noise_of, resolution
from model_diagnosis.data.samples import Samples
from signals.wheels import WHEELS

FloatArray = NDArray[np.float64]

FRAMES = (
    tuple(f"brake_pressure_{wheel}" for wheel in WHEELS),
    tuple(f"wheel_speed_{wheel}" for wheel in WHEELS),
)
"""Signals of one sensor unit's frame, by the catalogue's names."""

MOVED = 6.0
"""Standard deviations of its noise, or steps of its resolution, by which a signal has moved from before to after.
That is 4.2 deviations of the difference of two samples, which noise alone exceeds once in 37000."""


def mask_lost_frames(channels: Mapping[str, Samples]) -> dict[str, Samples]:
    """The channels with the samples of lost frames marked as no measurement."""
    masked = dict(channels)
    for names in FRAMES:
        if all(name in channels for name in names):
            frame = [channels[name] for name in names]
            if all(np.array_equal(one.time, frame[0].time) for one in frame):
                lost = _lost(frame)
                masked |= {name: one.masked(lost) for name, one in zip(names, frame, strict=True)}
    return masked


def _lost(frame: Sequence[Samples]) -> NDArray[np.bool_]:
    """True (n,) where all signals repeat the sample before and one moves."""
    count = len(frame[0].time)
    lost = np.zeros(count, dtype=np.bool_)
    if count < 3:
        return lost
    repeats, moves = np.ones(count - 2, dtype=np.bool_), np.zeros(count - 2, dtype=np.bool_)
    for one in frame:
        values = one.values
        known = values[np.isfinite(values)]
        least = MOVED * max(noise_of(known), resolution(known))
        repeats &= values[1:-1] == values[:-2]
        moves |= np.abs(values[2:] - values[:-2]) > least
    for k in np.flatnonzero(repeats)[::-1]:  # of several in a row the last one tells that the signals moved on
        lost[k + 1] = moves[k] or lost[k + 2]
    return lost
