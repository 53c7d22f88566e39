"""Signals that are taken between the instants of the samples, each at its own phase (``phases``); compiled."""

import numpy as np
from numba import njit
from numpy.typing import NDArray

from model_diagnosis.replay.lane_memory import at, put
from model_diagnosis.replay.lanes import some
from model_diagnosis.replay.record import CORRECTED, OUTPUTS
from model_diagnosis.replay.state import SUBSTEPS

Taken = tuple[NDArray[np.int64], NDArray[np.int64], NDArray[np.float64]]

CORRECTED_OUTPUTS = tuple(OUTPUTS.index(name) for name in CORRECTED)
"""Places of the signals that the observer corrects on among the outputs."""


@njit(cache=True, nogil=True, error_model="numpy")
def when_taken(phases: NDArray[np.float64]) -> Taken:
    """When in the steps to a sample k signals are taken: which sample that is (k or k - 1, as 0 or -1), in which step,
    and after which share of it; (c,) each."""
    rows, steps = np.zeros(len(phases), np.int64), np.zeros(len(phases), np.int64)
    shares = np.zeros(len(phases))
    for c in range(len(phases)):
        place = (phases[c] if phases[c] > 0.0 else 1.0 + phases[c]) * SUBSTEPS
        steps[c] = min(max(int(np.ceil(place - 1e-9)) - 1, 0), SUBSTEPS - 1)
        rows[c], shares[c] = (-1 if phases[c] > 0.0 else 0), place - steps[c]
    return rows, steps, shares


@njit(cache=True, nogil=True, error_model="numpy")
def write_taken(
    k: int,
    j: int,
    before: NDArray[np.float64],
    full: NDArray[np.float64],
    chosen: NDArray[np.int64],
    taken: Taken,
    out: NDArray[np.float64],
) -> None:
    """Outputs that are taken in step ``j`` to sample ``k``, on the straight line over the step."""
    rows, steps, shares = taken
    for c in range(chosen.shape[0]):
        if steps[c] == j:
            number = before[chosen[c]] + shares[c] * (full[chosen[c]] - before[chosen[c]])
            put(out, k + rows[c], c, number)


@njit(cache=True, nogil=True, error_model="numpy")
def write_last(
    full: NDArray[np.float64], chosen: NDArray[np.int64], phases: NDArray[np.float64], out: NDArray[np.float64]
) -> None:
    """What is taken behind the last sample's instant is not reached; it gets the last outputs, and has no weight."""
    for c in range(chosen.shape[0]):
        if phases[c] > 0.0:
            put(out, out.shape[0] - 1, c, full[chosen[c]])


@njit(cache=True, nogil=True, error_model="numpy")
def take_corrected(
    k: int,
    j: int,
    before: NDArray[np.float64],
    full: NDArray[np.float64],
    measured: NDArray[np.float64],
    valid: NDArray[np.float64],
    least: NDArray[np.float64],
    corrected: Taken,
    seen: NDArray[np.float64],
    known: NDArray[np.float64],
    counts: NDArray[np.float64],
    anew: NDArray[np.float64],
) -> bool:
    """What the observer corrects on of the signals that are taken in step ``j`` to sample ``k``; False if nothing.

    Into ``seen``, ``known``, ``counts``, ``anew`` (6,) go prediction, measurement, 1 where it holds, and least gain.
    """
    rows, steps, shares = corrected
    found = False
    for q in range(6):
        counts[q] = 0.0
        if steps[q] == j:
            column = CORRECTED_OUTPUTS[q]
            seen[q] = before[column] + shares[q] * (full[column] - before[column])
            row = k + rows[q]
            known[q], counts[q], anew[q] = at(measured, row, q), at(valid, row, q), at(least, row, q)
            found = found or some(counts[q] != 0.0)
        else:
            known[q] = anew[q] = 0.0
    return found
