"""Observers of the vertical wheel loads (vertical-load document, section 3).

``VerticalLoadUkf`` is the proposed unscented filter, ``VerticalLoadKalman`` the fixed-gain filters with two and three
sensors it is compared with, ``VerticalLoadStatic`` the zero baseline. The model is linear: the unscented filter with
points of the full covariance, drawn anew, is the ordinary Kalman filter (finding F1).
"""

import math
from collections.abc import Mapping
from functools import partial
from typing import Any

import numpy as np
from numba import njit

from estimators.inputs import INPUTS_LOST, accept_inputs, forget_inputs, input_guard
from estimators.interface import Estimator
from estimators.kalman.covariance import FloatArray, IntArray
from estimators.vertical_load_car import load_car
from estimators.vertical_load_model import MEASURED, STATES, continuous, discretise
from estimators.vertical_load_settings import (
    VerticalLoadKalmanSettings,
    VerticalLoadSettings,
    VerticalLoadUkfSettings,
    static_inputs,
    two_sensor_inputs,
    vertical_load_inputs,
)
from estimators.vertical_load_step import (
    DAMPED,
    DIAGONAL,
    ENLARGED,
    MINIMUM_SPEED,
    OUT_LOAD,
    PERIOD,
    PERIOD_TICKS,
    REDRAW,
    SAMPLE_TIME,
    SENSORS,
    SPREAD,
    STALE_AGE,
    STEP_RECORD,
    TUNING_SIZE,
    forget_motion,
    vertical_load_tick,
)


def _tuning(settings: Any, sample_time_s: float, sensors: int) -> FloatArray:
    values = np.zeros(TUNING_SIZE)
    ticks = max(1, round(settings.period / sample_time_s))
    values[SAMPLE_TIME], values[PERIOD_TICKS] = sample_time_s, ticks
    values[PERIOD] = ticks * sample_time_s
    values[STALE_AGE] = max(2.0 * values[PERIOD], 0.02)
    values[MINIMUM_SPEED], values[DAMPED] = settings.minimum_speed, settings.transfer == "full"
    values[SENSORS] = sensors
    return values


SLOWEST_OVER_DESIGN = 0.5
"""Share of the design speed below which the model of a fixed-gain filter no longer follows the speed."""


class VerticalLoadObserver(Estimator):
    """Base of the observers with a state.

    Attributes
    ----------
    state : array, shape (4,)
        Lateral speed [m/s], yaw rate [rad/s], roll angle [rad], roll rate [rad/s]; a view.
    covariance, gain : arrays, shapes (4, 4) and (4, 3)
        Views; those of a fixed-gain filter are as designed.
    phi, gamma : arrays, shapes (4, 4) and (4,)
        Discrete model of the last step; views.
    """

    def __init__(
        self,
        name: str,
        vehicle: Mapping[str, float],
        settings: VerticalLoadUkfSettings | VerticalLoadKalmanSettings,
        sample_time_s: float,
        sensors: int,
    ) -> None:
        self.settings = settings
        self._car = load_car(vehicle, settings)
        self._memory: Any = np.zeros(1, STEP_RECORD)
        self._tuning = _tuning(settings, sample_time_s, sensors)
        names = vertical_load_inputs(settings) if sensors == MEASURED else two_sensor_inputs(settings)
        self._guard, positions = input_guard(names, settings.input_timeout)
        memory = self._memory[0]
        self.state, self.covariance, self.gain = memory["state"], memory["covariance"], memory["gain"]
        self.phi, self.gamma = memory["phi"], memory["gamma"]
        memory["process"] = np.diag(settings.variances())
        deviations = settings.measurement_acceleration, settings.measurement_yaw_rate, settings.measurement_roll_rate
        memory["noise"] = np.diag(np.square(deviations))
        super().__init__(name, names, sample_time_s)
        self._unscented = isinstance(settings, VerticalLoadUkfSettings)
        self.tick = partial(
            vertical_load_tick, self._memory, self._car, self._tuning, self._guard, positions, self._unscented
        )

    def reset(self) -> None:
        """Return to the state of a new observer."""
        forget_motion(self._memory[0], self._unscented)
        self._memory[0]["status"] = 0.0
        forget_inputs(self._guard)


class VerticalLoadUkf(VerticalLoadObserver):
    """Unscented Kalman filter (21)-(34); build it with :func:`estimators.create`."""

    def __init__(
        self, vehicle: Mapping[str, float], settings: VerticalLoadUkfSettings, sample_time_s: float = 0.001
    ) -> None:
        super().__init__("vertical_load_ukf", vehicle, settings, sample_time_s, MEASURED)
        tuning, memory = self._tuning, self._memory[0]
        tuning[REDRAW], tuning[DIAGONAL] = settings.redraw, settings.points == "diagonal"
        tuning[ENLARGED] = settings.enlargement
        tuning[SPREAD] = math.sqrt((STATES + settings.kappa) * (1.0 + settings.enlargement**2))
        memory["weights"] = sigma_weights(settings.kappa)
        memory["initial"] = settings.initial_covariance
        self.reset()


def sigma_weights(kappa: float) -> FloatArray:
    """Weights of (23), the centre first, shape (9,); the printed numerator kappa holds for kappa = 1 only."""
    weights = np.full(2 * STATES + 1, 0.5 / (STATES + kappa))
    weights[0] = kappa / (STATES + kappa)
    return weights


class VerticalLoadKalman(VerticalLoadObserver):
    """Kalman filter with the gain of the steady state (17)-(20); build it with :func:`estimators.create`."""

    def __init__(
        self,
        name: str,
        sensors: int,
        vehicle: Mapping[str, float],
        settings: VerticalLoadKalmanSettings,
        sample_time_s: float = 0.001,
    ) -> None:
        super().__init__(name, vehicle, settings, sample_time_s, sensors)
        # far below its design speed the gain no longer fits the model, and the filter would diverge
        lowest = SLOWEST_OVER_DESIGN * settings.design_speed
        self._tuning[MINIMUM_SPEED] = max(self._tuning[MINIMUM_SPEED], lowest)
        self._design(settings.design_speed, sensors)
        self.reset()

    def _design(self, speed_m_s: float, sensors: int) -> None:
        """Gain, covariance and inverse innovation covariance at the design speed, by the Riccati equation (18)."""
        from scipy.linalg import solve_discrete_are

        memory = self._memory[0]
        continuous(self._car[0], speed_m_s, *(memory[name] for name in ("a", "b", "c", "d")))
        discretise(memory["a"], memory["b"], self._tuning[PERIOD], self.phi, self.gamma, memory["work"])
        design, noise = memory["c"][:sensors], memory["noise"][:sensors, :sensors]
        predicted = solve_discrete_are(self.phi.T, design.T, memory["process"], noise)
        inverse = np.linalg.inv(design @ predicted @ design.T + noise)
        self.gain[:, :sensors] = predicted @ design.T @ inverse
        self.covariance[:] = predicted - self.gain[:, :sensors] @ design @ predicted
        memory["innovation"][0, :sensors, :sensors] = inverse


def two_sensors(
    vehicle: Mapping[str, float], settings: VerticalLoadKalmanSettings, sample_time_s: float = 0.001
) -> VerticalLoadKalman:
    """The prior method: lateral acceleration and yaw rate."""
    return VerticalLoadKalman("vertical_load_kf2", 2, vehicle, settings, sample_time_s)


def three_sensors(
    vehicle: Mapping[str, float], settings: VerticalLoadKalmanSettings, sample_time_s: float = 0.001
) -> VerticalLoadKalman:
    """The same with the roll rate, which shows what the sensor gains and what the filter."""
    return VerticalLoadKalman("vertical_load_kf3", MEASURED, vehicle, settings, sample_time_s)


@njit(cache=True)
def _static_tick(
    loads: FloatArray,
    guard: FloatArray,
    positions: IntArray,
    sample_time: float,
    inputs: FloatArray,
    ages: FloatArray,
    out: FloatArray,
) -> None:
    verdict = accept_inputs(guard, positions, inputs, ages, sample_time)
    out[:] = 0.0
    out[0], out[2] = 0.0 if verdict == INPUTS_LOST else 1.0, verdict
    for i in range(4):
        out[OUT_LOAD + 2 * i] = loads[i]


class VerticalLoadStatic(Estimator):
    """The loads at rest: what every observer has to beat."""

    def __init__(
        self, vehicle: Mapping[str, float], settings: VerticalLoadSettings, sample_time_s: float = 0.001
    ) -> None:
        self.settings = settings
        names = static_inputs(settings)
        loads = np.repeat(0.5 * load_car(vehicle, settings)[0]["static_load"], 2)
        self._guard, positions = input_guard(names, settings.input_timeout)
        super().__init__("vertical_load_static", names, sample_time_s)
        self.tick = partial(_static_tick, loads, self._guard, positions, sample_time_s)

    def reset(self) -> None:
        """Return to the state of a new observer."""
        forget_inputs(self._guard)
