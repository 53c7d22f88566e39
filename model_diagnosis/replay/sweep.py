"""Many cars through one manoeuvre, compiled and without Python's lock, so that threads share the work."""

import numpy as np
from numba import njit
from numpy.typing import NDArray

from model_diagnosis.replay.run import replay_run


@njit(cache=True, nogil=True)
def replay_cars(
    cars: NDArray[np.void],
    first: int,
    last: int,
    tables: NDArray[np.float64],
    inputs: NDArray[np.float64],
    measured: NDArray[np.float64],
    valid: NDArray[np.float64],
    start: NDArray[np.float64],
    gains: NDArray[np.float64],
    horizon: int,
    sample_time: float,
    chosen: NDArray[np.int64],
    out: NDArray[np.float64],
) -> None:
    """Cars ``first`` to ``last`` (exclusive) into ``out`` (cars, n, c); other arguments as in ``replay_run``."""
    for car in range(first, last):
        replay_run(cars, car, tables, inputs, measured, valid, start, gains, horizon, sample_time, chosen, out[car])
