"""One car, four or eight through a manoeuvre, compiled and without Python's lock, so that threads share the work."""

from collections.abc import Callable, Mapping

import numpy as np
from numba import njit
from numpy.typing import NDArray

from model_diagnosis.replay import lane_math  # noqa: F401  teaches the compiler logarithms and angles of lanes
from model_diagnosis.replay.lane_memory import LANE_AXES, lanes_of, numbers_of_lanes
from model_diagnosis.replay.record import OUTPUTS
from model_diagnosis.replay.run import run_through
from model_diagnosis.replay.state import STATE_RECORD

_OUTPUTS = len(OUTPUTS)
_STATE_NUMBERS = STATE_RECORD.itemsize // 8


@njit(cache=True, nogil=True, error_model="numpy")
def replay_car(
    cars: NDArray[np.void],
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
    place: int,
    disturbance: NDArray[np.float64],
    out: NDArray[np.float64],
) -> None:
    """The first of the cars, of ``REPLAY_RECORD``; other arguments as in ``run_through``."""
    memory = np.zeros(1, STATE_RECORD)
    work = np.zeros(_OUTPUTS), np.zeros(_OUTPUTS), np.zeros(6), np.zeros(6), np.zeros(6), np.zeros(6)
    fixed = tables, inputs, between, measured, valid, start, gains, least, horizon, sample_time, chosen
    phases = input_phases, corrected_phases, output_phases
    run_through(cars[0], memory[0], *fixed, *phases, place, disturbance, work, out)


def _replay_of(count: int) -> Callable[..., None]:
    @njit(cache=True, nogil=True, error_model="numpy")
    def run(
        cars: NDArray[np.float64],
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
        place: int,
        disturbance: NDArray[np.float64],
        out: NDArray[np.float64],
    ) -> None:
        """Cars whose numbers are the rows of ``cars`` (k, count); other arguments as in ``run_through``."""
        memory = np.zeros((_STATE_NUMBERS, count))
        full, before, six = np.zeros((_OUTPUTS, count)), np.zeros((_OUTPUTS, count)), np.zeros((4, 6, count))
        work = (
            numbers_of_lanes(full, count),
            numbers_of_lanes(before, count),
            numbers_of_lanes(six[0], count),
            numbers_of_lanes(six[1], count),
            numbers_of_lanes(six[2], count),
            numbers_of_lanes(six[3], count),
        )
        fixed = tables, inputs, between, measured, valid, start, gains, least, horizon, sample_time, chosen
        phases = input_phases, corrected_phases, output_phases
        car, state = lanes_of("car", cars, count), lanes_of("state", memory, count)
        run_through(car, state, *fixed, *phases, place, disturbance, work, out)

    compiled: Callable[..., None] = run
    return compiled


replay_several: Mapping[int, Callable[..., None]] = {count: _replay_of(count) for count in LANE_AXES}
"""Replay of so many cars side by side."""
