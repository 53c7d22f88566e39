"""Many cars through one manoeuvre, compiled and without Python's lock, so that threads share the work."""

import numpy as np
from numba import njit
from numpy.typing import NDArray

from model_diagnosis.replay.disturb_step import NOWHERE
from model_diagnosis.replay.run import replay_run
from model_diagnosis.replay.state import STATE_RECORD


@njit(cache=True, nogil=True, error_model="numpy")
def replay_cars(
    cars: NDArray[np.void],
    first: int,
    last: int,
    tables: NDArray[np.float64],
    inputs: NDArray[np.float64],
    between: NDArray[np.float64],
    measured: NDArray[np.float64],
    valid: NDArray[np.float64],
    start: NDArray[np.float64],
    gains: NDArray[np.float64],
    least: NDArray[np.float64],
    horizon: int,
    sample_time: float,
    chosen: NDArray[np.int64],
    input_phases: NDArray[np.float64],
    corrected_phases: NDArray[np.float64],
    output_phases: NDArray[np.float64],
    out: NDArray[np.float64],
) -> None:
    """Cars ``first`` to ``last`` (exclusive) into ``out`` (cars, n, c); other arguments as in ``replay_run``."""
    quiet = np.zeros(0)
    for car in range(first, last):
        memory = np.zeros(1, STATE_RECORD)
        fixed = tables, inputs, between, measured, valid, start, gains, least, horizon, sample_time, chosen
        phases = input_phases, corrected_phases, output_phases
        replay_run(cars, car, memory, *fixed, *phases, NOWHERE, quiet, out[car])
