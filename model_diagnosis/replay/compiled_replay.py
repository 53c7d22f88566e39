"""One car, four or eight through a manoeuvre, compiled and without Python's lock, so that threads share the work.

All take their cars and then the arguments of ``run_through`` from ``tables`` on.
"""

from collections.abc import Callable, Mapping
from typing import Any

import numpy as np
from numba import njit
from numpy.typing import NDArray

from model_diagnosis.replay import lane_math  # noqa: F401  teaches the compiler logarithms and angles of lanes
from model_diagnosis.replay.lane_memory import LANE_AXES, lanes_of, numbers_of_lanes
from model_diagnosis.replay.record import CORRECTED, OUTPUTS
from model_diagnosis.replay.run import run_through
from model_diagnosis.replay.state import STATE_RECORD

_OUTPUTS, _CORRECTED = len(OUTPUTS), len(CORRECTED)
_STATE_NUMBERS = STATE_RECORD.itemsize // 8


@njit(cache=True, nogil=True, error_model="numpy")
def replay_car(cars: NDArray[np.void], *manoeuvre: Any) -> None:
    """The first of the cars, of ``REPLAY_RECORD``."""
    memory, seen = np.zeros(1, STATE_RECORD), np.zeros((4, _CORRECTED))
    work = np.zeros(_OUTPUTS), np.zeros(_OUTPUTS), seen[0], seen[1], seen[2], seen[3]
    run_through(cars[0], memory[0], work, *manoeuvre)


def _replay_of(count: int) -> Callable[..., None]:
    @njit(cache=True, nogil=True, error_model="numpy")
    def run(cars: NDArray[np.float64], *manoeuvre: Any) -> None:
        """Cars whose numbers are the rows of ``cars`` (k, count)."""
        memory, seen = np.zeros((_STATE_NUMBERS, count)), np.zeros((4, _CORRECTED, count))
        full, before = np.zeros((_OUTPUTS, count)), np.zeros((_OUTPUTS, count))
        work = (
            numbers_of_lanes(full, count),
            numbers_of_lanes(before, count),
            numbers_of_lanes(seen[0], count),
            numbers_of_lanes(seen[1], count),
            numbers_of_lanes(seen[2], count),
            numbers_of_lanes(seen[3], count),
        )
        run_through(lanes_of("car", cars, count), lanes_of("state", memory, count), work, *manoeuvre)

    compiled: Callable[..., None] = run
    return compiled


replay_several: Mapping[int, Callable[..., None]] = {count: _replay_of(count) for count in LANE_AXES}
"""Replay of so many cars side by side."""
