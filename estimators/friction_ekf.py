"""Extended Kalman filter for the friction between tyre and road (Enisz 2015, chapter on stage 2).

Nine states, eight measurement rows; friction document, section 3.6. The model is in :mod:`estimators.friction_model`,
its Jacobians in :mod:`estimators.friction_jacobians`, start and reset in :mod:`estimators.friction_step`, outputs in
:mod:`estimators.friction_results`.
"""

from collections.abc import Mapping
from functools import partial

import numpy as np
from numba import njit

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
from estimators.friction_model import AXLES, SPEED, STATES, STOPPED_F, STOPPED_R, WHEEL_F, WHEEL_R
from estimators.friction_results import write_outputs
from estimators.friction_settings import FrictionEkfSettings, friction_inputs
from estimators.friction_setup import friction_tuning, post_filter_delay, post_filter_memory
from estimators.friction_step import (
    GATE,
    INNOVATION,
    KINEMATIC_WHEELS,
    LOCKED_RATE_DECAY,
    PROCESS_VARIANCE,
    SAMPLE_TIME,
    STATUS_SIZE,
    SUBSTEPS,
    begin_tick,
    bring_forward,
    build_measurement,
    forget_everything,
    guard_limits,
    read_torques,
    stop,
)
from estimators.inputs import input_guard
from estimators.interface import Estimator
from estimators.kalman.correction import ROW_STALE, correct_rows
from estimators.kalman.covariance import FloatArray, IntArray, all_finite, propagate_sparse
from estimators.longitudinal_start import RUN
from estimators.wheel_speed_sensor import HISTORY_SIZE, forget_changes

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
    bring_forward(history, tuning, state[WHEEL_F] - before_f, state[WHEEL_R] - before_r, measured, noise)
    expected = memory[_EXPECTED, :MEASUREMENTS]
    measure(state, tuning, forces, expected, design)
    for r in range(MEASUREMENTS):
        expected[r] = measured[r] - expected[r]
    return correct_rows(
        state,
        covariance,
        expected,
        design,
        noise,
        rows,
        tuning[GATE],
        DESIGN_COLUMNS,
        scratch[:4],
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
    state = memory[_STATE]
    covariance = memory[_COVARIANCE:_TRANSITION]
    if begin_tick(state, covariance, status, tuning, guard, positions, inputs, ages) == RUN:
        torques, measured = memory[_TORQUES], memory[_MEASURED]
        read_torques(guard, tuning, torques)
        build_measurement(guard, tuning, status, state[SPEED], measured, rows)
        status[INNOVATION] = filter_step(memory, history, tuning, torques, measured, rows)
        guard_limits(state, tuning)
        if not all_finite(state):
            stop(state, covariance, status, tuning)
    else:
        forget_changes(history)
    forces = memory[_FORCES:_MEMORY_ROWS].ravel()[:24].reshape(4, 6)
    write_outputs(state, covariance, status, tuning, forces, filters, out)


class FrictionEkf(Estimator):
    """Friction EKF; build it with :func:`estimators.create`.

    Attributes
    ----------
    state : array, shape (9,)
        Speed [m/s], wheel speeds front, rear [rad/s], slips front, rear, friction limit front, its rate [1/s], friction
        limit rear, its rate; a view, valid while ``active``.
    covariance : array, shape (9, 9)
        View of the covariance of the state.
    post_filter_delay_s : float
        Delay of the ``..._filtered`` outputs for slow changes [s].
    """

    def __init__(
        self, vehicle: Mapping[str, float], settings: FrictionEkfSettings, sample_time_s: float = 0.001
    ) -> None:
        self.settings = settings
        self._tuning = friction_tuning(vehicle, settings, sample_time_s)
        self._tuning[GATE] = settings.gate**2
        self._tuning[SUBSTEPS] = settings.prediction_substeps
        self._tuning[PROCESS_VARIANCE : PROCESS_VARIANCE + STATES] /= settings.prediction_substeps
        self._memory = np.zeros((_MEMORY_ROWS, STATES))
        self._history = np.zeros((2, HISTORY_SIZE))
        self._status = np.zeros(STATUS_SIZE)
        self._filters = post_filter_memory(settings)
        self.post_filter_delay_s = post_filter_delay(settings, sample_time_s)
        self._rows = np.zeros(MEASUREMENTS, dtype=np.int64)
        inputs = friction_inputs(settings)
        self._guard, self._positions = input_guard(inputs, settings.input_timeout)
        self.state = self._memory[_STATE]
        self.covariance = self._memory[_COVARIANCE:_TRANSITION]
        super().__init__("friction_ekf", inputs, sample_time_s)
        self.tick = partial(
            _tick,
            self._memory,
            self._history,
            self._status,
            self._filters,
            self._rows,
            self._tuning,
            self._guard,
            self._positions,
        )
        self.reset()

    def reset(self) -> None:
        """Return to the state of a new filter."""
        forget_everything(self.state, self.covariance, self._status, self._history, self._tuning, self._guard)
