"""Extended Kalman filter for the friction between tyre and road (Enisz 2015, chapter on stage 2).

Nine states, eight measurement rows; friction document, section 3.6. The model is in :mod:`estimators.friction_model`,
its Jacobians in :mod:`estimators.friction_jacobians`, start and reset in :mod:`estimators.friction_step`, the tick
around the filter step in :mod:`estimators.friction_filter`, outputs in :mod:`estimators.friction_results`.
"""

from collections.abc import Callable, Mapping
from functools import partial
from typing import Any

from numba import njit

from estimators.friction_filter import FrictionFilter, finish_tick, prepare_step
from estimators.friction_jacobians import (
    DESIGN_COLUMNS,
    MEASUREMENTS,
    ROW_WHEEL_F,
    ROW_WHEEL_R,
    TRANSITION_COLUMNS,
    hold_limit_rates,
    measure,
    predict,
    share_limit_noise,
)
from estimators.friction_model import AXLES, STATES, STOPPED_F, STOPPED_R, WHEEL_F, WHEEL_R
from estimators.friction_settings import FrictionEkfSettings
from estimators.friction_step import (
    GATE,
    INNOVATION,
    KINEMATIC_WHEELS,
    LOCKED_RATE_DECAY,
    PROCESS_VARIANCE,
    SAMPLE_TIME,
    SUBSTEPS,
    compensate_sensors,
)
from estimators.kalman.correction import ROW_STALE, correct_rows_of
from estimators.kalman.covariance import FloatArray, IntArray, propagate_sparse
from signals.record_memory import addresses_at, matrix_in, row_in, table_of, whole_matrix_in, whole_row_in

# rows of the memory, nine columns each
_STATE, _PREDICTED, _EXPECTED, _MEASURED, _TORQUES, _NOISE = range(6)
_COVARIANCE = 6
_TRANSITION = _COVARIANCE + STATES
_DESIGN = _TRANSITION + STATES
_SCRATCH = _DESIGN + MEASUREMENTS
_FORCES = _SCRATCH + STATES
_MEMORY_ROWS = _FORCES + 3


@njit(cache=True)
def filter_step(
    memory: FloatArray,
    history: FloatArray,
    tuning: FloatArray,
    torques: FloatArray,
    measured: FloatArray,
    rows: IntArray,
) -> float:
    """One step of the filter: predict, correct (3.6.10); returns the normalised innovation squared."""
    state, predicted = memory[_STATE], memory[_PREDICTED]
    covariance = memory[_COVARIANCE:_TRANSITION]
    transition = memory[_TRANSITION:_DESIGN]
    design = memory[_DESIGN:_SCRATCH]
    scratch = memory[_SCRATCH:_FORCES]
    forces = memory[_FORCES:_MEMORY_ROWS].ravel()[:24].reshape(4, 6)
    variances = tuning[PROCESS_VARIANCE : PROCESS_VARIANCE + STATES]
    substeps = int(tuning[SUBSTEPS])
    before_f, before_r = state[WHEEL_F], state[WHEEL_R]
    noise = memory[_NOISE, :MEASUREMENTS]
    for _ in range(substeps):
        predict(
            state,
            torques,
            tuning[SAMPLE_TIME] / substeps,
            tuning,
            tuning[KINEMATIC_WHEELS] > 0.0,
            forces,
            predicted,
            transition,
        )
        blind_f = forces[AXLES, STOPPED_F] > 0.0 or rows[ROW_WHEEL_F] == ROW_STALE
        blind_r = forces[AXLES, STOPPED_R] > 0.0 or rows[ROW_WHEEL_R] == ROW_STALE
        if blind_f and blind_r:
            hold_limit_rates(predicted, transition, tuning[LOCKED_RATE_DECAY])
        propagate_sparse(covariance, transition, TRANSITION_COLUMNS, variances, scratch)
        if blind_f and blind_r:
            share_limit_noise(covariance, variances)
        state[:] = predicted
    compensate_sensors(history, tuning, state[WHEEL_F] - before_f, state[WHEEL_R] - before_r, measured, noise)
    expected = memory[_EXPECTED, :MEASUREMENTS]
    measure(state, tuning, forces, expected, design)
    for r in range(MEASUREMENTS):
        expected[r] = measured[r] - expected[r]
    return correct_rows_of(
        STATES,
        state,
        covariance,
        expected,
        design,
        noise,
        rows,
        tuning[GATE],
        DESIGN_COLUMNS,
        scratch[:3],
    )


@njit(cache=True)
def _tick(
    memory: FloatArray,
    history: FloatArray,
    status: FloatArray,
    filters: FloatArray,
    rows: IntArray,
    tuning: FloatArray,
    guard: FloatArray,
    positions: IntArray,
    inputs: FloatArray,
    ages: FloatArray,
    out: FloatArray,
) -> None:
    state, covariance = memory[_STATE], memory[_COVARIANCE:_TRANSITION]
    torques, measured = memory[_TORQUES], memory[_MEASURED]
    stepped = prepare_step(
        state, covariance, status, history, tuning, guard, positions, inputs, ages, torques, measured, rows
    )
    if stepped:
        status[INNOVATION] = filter_step(memory, history, tuning, torques, measured, rows)
    forces = memory[_FORCES:_MEMORY_ROWS].ravel()[:24].reshape(4, 6)
    finish_tick(stepped, state, covariance, status, tuning, forces, filters, out)


@njit(cache=True)
def _tick_at(memory: int) -> None:
    """`_tick` on the arrays of a table: unpacking eleven of them takes a fifth of the filter's time."""
    table: Any = addresses_at(memory)
    _tick(
        matrix_in(table, 0),
        matrix_in(table, 1),
        row_in(table, 2),
        matrix_in(table, 3),
        whole_row_in(table, 4),
        row_in(table, 5),
        matrix_in(table, 6),
        whole_matrix_in(table, 7),
        row_in(table, 8),
        row_in(table, 9),
        row_in(table, 10),
    )


class FrictionEkf(FrictionFilter):
    """Friction EKF; build it with :func:`estimators.create`."""

    settings: FrictionEkfSettings

    def __init__(
        self, vehicle: Mapping[str, float], settings: FrictionEkfSettings, sample_time_s: float = 0.001
    ) -> None:
        super().__init__("friction_ekf", vehicle, settings, sample_time_s, _MEMORY_ROWS, _COVARIANCE)
        self._tuning[GATE] = settings.gate**2
        self._tuning[SUBSTEPS] = settings.prediction_substeps
        self._tuning[PROCESS_VARIANCE : PROCESS_VARIANCE + STATES] /= settings.prediction_substeps
        self._arrays = (
            self._memory,
            self._history,
            self._status,
            self._filters,
            self._rows,
            self._tuning,
            self._guard,
            self._positions,
        )
        self.tick = partial(_tick, *self._arrays)
        self._bound: list[tuple[Any, ...]] = []

    def bind(self, inputs: FloatArray, ages: FloatArray, out: FloatArray) -> Callable[[], Any]:
        """A tick on these arrays, which are kept."""
        table = table_of(*self._arrays, inputs, ages, out)
        self._bound.append((table, inputs, ages, out))
        return partial(_tick_at, int(table.ctypes.data))
