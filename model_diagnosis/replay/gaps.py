"""Gaps of the inputs: what drove the car in them is unknown, and the observer begins anew behind each.

Inputs are laid straight across a gap, so that the replayed car comes out of it at another speed than the measured one.
Drawn back by its usual gains it would err for a fifth of a second, by all wheels alike, and an effect that is not there
would explain it. Behind a gap the k-th measured sample has the gain 1/k at least (a filter with growing memory, which
begins with the measured value and ends where the usual gain is larger). Until then nothing counts as evidence: what is
not measured (slips, brake torques, pitch) has to find its way back too.
"""

from collections.abc import Callable
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

FAR_OFF = 20.0
"""Standard deviations of a pressure's own noise that no usual error of the hydraulic unit reaches within a sample: in
an ABS stop of the challenge's generator it errs by up to 6, and by 20 to 90 where a command was lost."""

LOST_COMMANDS = 8
"""Rounds in which the pressures' observer is begun anew; each finds at least the first lost command that is left."""

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


def begun_anew(off: Callable[[FloatArray], FloatArray], least: FloatArray, noise: float) -> FloatArray:
    """Least gains (n, c) with 1 where a command was lost, of those that the gaps ask for.

    What a unit errs by far in one sample comes from a valve that moved when the log says it rested, or rested when it
    moved. By its usual gain the observer would carry that on for a fifth of a second.

    Parameters
    ----------
    off : errors (n, c) of the vehicle's own unit with such least gains, 0 where nothing was measured
    noise : standard deviation of the sensors' own noise
    """
    for _ in range(LOST_COMMANDS):
        far = off(least) > FAR_OFF * noise
        begins = far & (least < 1.0)
        begins[1:] &= ~far[:-1] | (least[:-1] == 1.0)  # what follows one that is begun anew stands on its own
        if not begins.any():
            break
        least = np.where(begins, 1.0, least)
    return least
