"""Rule for inputs that come late, wrong or not at all, the same for every estimator.

Inputs arrive at the rate of their frames (5 or 10 ms) while an estimator ticks every millisecond. A value is held
between frames; the age that comes with it tells when a new one has arrived. A sample that is not a number or lies
outside the range of its sensor counts as not received, and so does one that is already old when it arrives, as where
frames are held up on the bus: the last good value is held. An input without a good sample for
longer than its timeout is lost; the estimator then resets itself and stays inactive until all of its inputs are back.
"""

from collections.abc import Mapping, Sequence

import numpy as np
from numba import njit
from numpy.typing import NDArray

from estimators.channels import CHANNELS
from signals.catalogue import block_slice, index_of

FloatArray = NDArray[np.float64]
IntArray = NDArray[np.int64]

LOW, HIGH, TIMEOUT, VALUE, DATA_AGE, PREVIOUS_AGE, FRESH = range(7)
GUARD_COLUMNS = 7

OLDEST_ON_ARRIVAL_S = 0.008
"""Beyond the jitter of a bus, below the 10 ms that the slip of a wheel under slip control needs to change visibly."""

INPUTS_GOOD, INPUTS_HELD, INPUTS_LOST = 0, 1, 2


def input_guard(
    names: Sequence[str | None], timeout_s: float, ranges: Mapping[str, tuple[float, float]] | None = None
) -> tuple[FloatArray, IntArray]:
    """Memory and positions for :func:`accept_inputs`.

    Parameters
    ----------
    names : sequence of str or None
        Catalogue names of the decoded signals, in the order in which the estimator wants them; None for a row that no
        signal feeds: its value stays 0 and it is never lost.
    timeout_s : float
        Time without a good sample after which an input is lost.
    ranges : mapping, optional
        Plausible range in SI units of single signals, instead of the usual one.

    Returns
    -------
    guard : array, shape (n, 7)
        Range, timeout, held value, age of the held value, last reported age, 1 where the value is new in this tick.
    positions : array, shape (n, 2)
        Position in the views of block "bus" and of block "bus_age".
    """
    guard = np.zeros((len(names), GUARD_COLUMNS))
    positions = np.zeros((len(names), 2), dtype=np.int64)
    bus, ages = block_slice("bus").start, block_slice("bus_age").start
    for row, name in enumerate(names):
        if name is None:
            guard[row, TIMEOUT] = np.nan  # every comparison with it is false: nothing arrives, nothing is too old
            continue
        channel = CHANNELS[name]
        low, high = (ranges or {}).get(name, (channel.low, channel.high))
        guard[row, LOW], guard[row, HIGH], guard[row, TIMEOUT] = low, high, timeout_s
        positions[row] = index_of(name) - bus, index_of(channel.age) - ages
    forget_inputs(guard)
    return guard, positions


@njit(cache=True)
def forget_inputs(guard: FloatArray) -> None:
    """Forget all samples; every input is lost until its next good sample."""
    guard[:, VALUE] = 0.0
    guard[:, DATA_AGE] = np.inf
    guard[:, PREVIOUS_AGE] = np.inf
    guard[:, FRESH] = 0.0


@njit(cache=True)
def accept_inputs(
    guard: FloatArray, positions: IntArray, inputs: FloatArray, ages: FloatArray, sample_time: float
) -> int:
    """Take over the samples that are new and good, hold the others.

    A sample is new when its age has not grown by a whole tick since the last call.

    Returns
    -------
    int
        ``INPUTS_GOOD``, ``INPUTS_HELD`` (a wrong sample was replaced by the last good one) or ``INPUTS_LOST``.
    """
    verdict = INPUTS_GOOD
    for row in range(guard.shape[0]):
        value = inputs[positions[row, 0]]
        age = ages[positions[row, 1]]
        arrived = age < guard[row, PREVIOUS_AGE] + 0.5 * sample_time and 0.0 <= age <= guard[row, TIMEOUT]
        good = guard[row, LOW] <= value <= guard[row, HIGH] and age <= OLDEST_ON_ARRIVAL_S
        guard[row, PREVIOUS_AGE] = age if age >= 0.0 else np.inf
        if arrived and good:
            guard[row, VALUE] = value
            guard[row, DATA_AGE] = age
            guard[row, FRESH] = 1.0
            continue
        guard[row, DATA_AGE] += sample_time
        guard[row, FRESH] = 0.0
        if guard[row, DATA_AGE] > guard[row, TIMEOUT]:
            verdict = INPUTS_LOST
        elif arrived and verdict == INPUTS_GOOD:
            verdict = INPUTS_HELD
    return verdict
