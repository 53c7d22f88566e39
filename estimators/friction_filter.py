"""What the extended and the unscented friction filter share around their own filter step: memory and tick.

Friction document, sections 3.6.2 and 3.6.7.
"""

from collections.abc import Mapping

import numpy as np
from numba import njit

from estimators.friction_jacobians import MEASUREMENTS
from estimators.friction_model import SPEED, STATES
from estimators.friction_results import write_outputs
from estimators.friction_settings import FrictionSettings, friction_inputs
from estimators.friction_setup import friction_tuning, post_filter_delay, post_filter_memory
from estimators.friction_step import (
    INNOVATION,
    STATUS_SIZE,
    begin_tick,
    build_measurement,
    forget_everything,
    guard_limits,
    read_torques,
    stop,
)
from estimators.inputs import input_guard
from estimators.interface import Estimator
from estimators.kalman.covariance import FloatArray, IntArray, all_finite
from estimators.longitudinal_start import RUN
from estimators.wheel_speed_sensor import HISTORY_SIZE, forget_changes


@njit(cache=True)
def prepare_step(
    state: FloatArray,
    covariance: FloatArray,
    status: FloatArray,
    history: FloatArray,
    tuning: FloatArray,
    guard: FloatArray,
    positions: IntArray,
    inputs: FloatArray,
    ages: FloatArray,
    torques: FloatArray,
    measured: FloatArray,
    rows: IntArray,
) -> bool:
    """Take over the inputs, start or reset; True with torques and measurements where a filter step is to be made."""
    if begin_tick(state, covariance, status, tuning, guard, positions, inputs, ages) != RUN:
        forget_changes(history)
        return False
    read_torques(guard, tuning, torques)
    build_measurement(guard, tuning, status, state[SPEED], measured, rows)
    return True


@njit(cache=True)
def finish_tick(
    stepped: bool,
    state: FloatArray,
    covariance: FloatArray,
    status: FloatArray,
    tuning: FloatArray,
    forces: FloatArray,
    filters: FloatArray,
    out: FloatArray,
) -> None:
    """Guard the state after a filter step, reset where it is not finite, write the outputs."""
    if stepped:
        guard_limits(state, tuning)
        if not (all_finite(state) and np.isfinite(status[INNOVATION])):
            stop(state, covariance, status, tuning)
    write_outputs(state, covariance, status, tuning, forces, filters, out)


class FrictionFilter(Estimator):
    """Base of the friction filters.

    Parameters
    ----------
    memory_rows, covariance_row : int
        Rows of nine columns that the filter works in; the state is the first, the covariance begins at this one.

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
        self,
        name: str,
        vehicle: Mapping[str, float],
        settings: FrictionSettings,
        sample_time_s: float,
        memory_rows: int,
        covariance_row: int,
    ) -> None:
        inputs = friction_inputs(settings)
        super().__init__(name, inputs, sample_time_s)
        self.settings = settings
        self.post_filter_delay_s = post_filter_delay(settings, sample_time_s)
        self._tuning = friction_tuning(vehicle, settings, sample_time_s)
        self._memory = np.zeros((memory_rows, STATES))
        self.state = self._memory[0]
        self.covariance = self._memory[covariance_row : covariance_row + STATES]
        self._history = np.zeros((2, HISTORY_SIZE))
        self._status = np.zeros(STATUS_SIZE)
        self._filters = post_filter_memory(settings)
        self._rows = np.zeros(MEASUREMENTS, dtype=np.int64)
        self._guard, self._positions = input_guard(inputs, settings.input_timeout)
        self.reset()

    def reset(self) -> None:
        """Return to the state of a new filter."""
        forget_everything(self.state, self.covariance, self._status, self._history, self._tuning, self._guard)
