"""Gaps of the inputs: what drove the car in them is unknown, and the observer begins anew behind each.

Inputs are laid straight across a gap, so that the replayed car comes out of it at another speed than the measured one.
Drawn back by its usual gains it would err for a fifth of a second, by all wheels alike, and an effect that is not there
would explain it. Behind a gap the k-th measured sample has the gain 1/k at least (a filter with growing memory, which
begins with the measured value and ends where the usual gain is larger). Until then nothing counts as evidence: what is
not measured (slips, brake torques, pitch) has to find its way back too.
"""

from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from model_diagnosis.manoeuvre import Manoeuvre
from signals.wheels import WHEELS

FloatArray = NDArray[np.float64]
IntArray = NDArray[np.int64]

GAP_STEPS = 4
"""A gap is longer than so many of a channel's usual steps: as many as the whitening filter is long."""

BEGINNING = 20
"""Samples for which the observer is beginning: from the 20th on its gain for the speed, 0.05, is the larger one."""

_DRIVING = (
    *(f"brake_pressure_{wheel}" for wheel in WHEELS),
    "master_pressure",
    "drive_torque_f",
    "drive_torque_r",
    "engine_torque",
    "road_wheel_angle",
    "steering_wheel_angle",
)


def pieces_of(samples: IntArray) -> IntArray:
    """Number (k,) of the piece without a gap that each valid sample (k,) of a channel belongs to, from 0 on."""
    if len(samples) < 2:
        return np.zeros(len(samples), dtype=np.int64)
    steps = np.diff(samples)
    return np.asarray(np.concatenate(([0], np.cumsum(steps > GAP_STEPS * np.median(steps)))), dtype=np.int64)


def ends_of_gaps(manoeuvre: Manoeuvre) -> IntArray:
    """Samples (g,) with which a channel that drives the replay begins again behind a gap."""
    found = [np.zeros(0, dtype=np.int64)]
    for name in _DRIVING:
        if name in manoeuvre.channels:
            samples = np.flatnonzero(manoeuvre.weight(name) > 0.0)
            found.append(samples[1:][np.diff(pieces_of(samples)) > 0])
    return np.unique(np.concatenate(found))


def is_beginning(samples: int, begins: IntArray) -> NDArray[np.bool_]:
    """True (samples,) where the observer is beginning behind a gap."""
    beginning = np.zeros(samples, dtype=np.bool_)
    for begin in begins:
        beginning[begin : begin + BEGINNING] = True
    return beginning


def least_gains(valid: FloatArray, begins: IntArray) -> FloatArray:
    """Least gains (n, c) where the k-th valid sample (n, c) since one of ``begins`` has 1/k; 0 before the first."""
    least = np.zeros_like(valid)
    for begin, end in pairwise([*begins.tolist(), len(valid)]):
        count = np.cumsum(valid[begin:end] > 0.0, axis=0)
        least[begin:end] = (valid[begin:end] > 0.0) / np.maximum(count, 1)
    return least
