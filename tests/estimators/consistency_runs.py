"""NEES and NIS of filters over independent runs: where the noise model is true, and where it cannot be.

The truth is drawn from the filter's own model: process noise Q and measurement noise R as the filter believes them, the
initial error from its initial covariance.
"""

from dataclasses import dataclass

import friction_twin as twin
import numpy as np
from friction_figures import stop
from numpy.typing import NDArray

import estimators
from estimators import force_model
from estimators.force_ekf import model_parameters
from estimators.force_settings import ForceEkfSettings
from estimators.kalman.consistency import Consistency, chi_square_band, normalised_estimation_error
from estimators.kalman.filters import GaussianFilter, cubature_weights, unscented_weights
from estimators.vehicle_numbers import longitudinal_car

SEEDS = 60
STEPS = 150
QUIET = {
    "process_speed": 1e-4,
    "process_wheel_speed": 0.01,
    "process_force": 4.0,
    "process_force_rate": 40.0,
    "initial_force": 300.0,
    "initial_force_rate": 200.0,
    "brake_torque": "actual",
    "minimum_speed": 1.0,
}


@dataclass(frozen=True)
class Statistics:
    """Both statistics of a filter over the seeds, with their bands of 95 %."""

    nees: Consistency
    nis: Consistency


def pendulum(x: NDArray[np.float64]) -> NDArray[np.float64]:
    """A pendulum of unknown stiffness, a step of 0.05 s."""
    return np.array([x[0] + 0.05 * x[1], x[1] - 0.05 * x[2] * np.sin(x[0]), x[2]])


def watched(x: NDArray[np.float64]) -> NDArray[np.float64]:
    """What is measured of it."""
    return np.array([np.sin(x[0]), x[1]])


def core(kind: str) -> Statistics:
    """The Kalman core as EKF, UKF or CKF on the pendulum, 60 runs of 40 steps."""
    q, r = np.diag([1e-6, 1e-4, 1e-6]), np.diag([1e-3, 1e-3])
    start, spread = np.array([0.4, 0.0, 4.0]), np.diag([1e-2, 1e-2, 4e-2])
    nees, nis = [], []
    for seed in range(SEEDS):
        random = np.random.default_rng([11, seed])
        weights = {"ekf": (), "ukf": (unscented_weights(3, 1.0, 2.0, 0.0),), "ckf": (cubature_weights(3),)}[kind]
        own = GaussianFilter(start.copy(), spread.copy(), *weights)
        truth = start + np.linalg.cholesky(spread) @ random.standard_normal(3)
        for _ in range(40):
            truth = pendulum(truth) + np.sqrt(np.diag(q)) * random.standard_normal(3)
            measured = watched(truth) + np.sqrt(np.diag(r)) * random.standard_normal(2)
            if kind == "ekf":
                x = own.state
                f = np.array(
                    [[1.0, 0.05, 0.0], [-0.05 * x[2] * np.cos(x[0]), 1.0, -0.05 * np.sin(x[0])], [0.0, 0.0, 1.0]]
                )
                own.predict(f, q, pendulum(x))
                h = np.array([[np.cos(own.state[0]), 0.0, 0.0], [0.0, 1.0, 0.0]])
                own.correct(measured, h, r, watched(own.state))
            else:
                own.predict_through(pendulum, q)
                own.correct_through(measured, watched, r, redraw=True)
        nees.append(normalised_estimation_error(truth - own.state, own.covariance))
        nis.append(own.innovation)
    return Statistics(chi_square_band(nees, 3), chi_square_band(nis, 2))


def force_ekf() -> Statistics:
    """The force EKF as shipped, ticked on measurements of a car drawn from its own model, 60 runs of 150 steps."""
    settings = ForceEkfSettings.model_validate(QUIET)
    car = model_parameters(longitudinal_car(twin.TABLE_8), settings)
    wheel, force, rate = settings.process_wheel_speed, settings.process_force, settings.process_force_rate
    process = np.array([settings.process_speed, wheel, wheel, force, rate, force, rate, 0.0, 0.0])
    sensor = np.array([settings.measurement_acceleration, *[settings.measurement_wheel_speed] * 2])
    torques = np.array([250.0, -150.0, 0.0, 0.0])
    nees, nis = [], []
    for seed in range(SEEDS):
        random = np.random.default_rng([12, seed])
        estimator = estimators.create("force_ekf", twin.TABLE_8, QUIET)

        def tick(measured: NDArray[np.float64], estimator=estimator) -> NDArray[np.float64]:
            columns = {name: np.zeros(1) for name in estimator.inputs}
            columns["longitudinal_acceleration"][0] = measured[0]
            for place, name in ((1, "fl"), (1, "fr"), (2, "rl"), (2, "rr")):
                columns[f"wheel_speed_{name}"][0] = measured[place]
            columns["drive_torque_f"][0], columns["drive_torque_r"][0] = torques[:2]
            return estimator.replay(columns)[0]

        tick(np.array([0.0, 90.0, 90.0]))
        deviation = np.sqrt(np.diag(estimator.covariance))
        truth = estimator.state + deviation * random.standard_normal(9)
        for _ in range(STEPS):
            predicted = np.zeros(9)
            force_model.predict(truth, torques, 1e-3, car, predicted, np.zeros((9, 9)))
            truth = predicted + process * random.standard_normal(9)
            expected = np.zeros(3)
            force_model.measure(truth, car, expected, np.zeros((3, 9)))
            out = tick(expected + sensor * random.standard_normal(3))
        known = slice(0, 7)  # the unmodelled force is not estimated
        nees.append(normalised_estimation_error((truth - estimator.state)[known], estimator.covariance[known, known]))
        nis.append(out[[s.name for s in estimator.outputs].index("force_ekf.innovation")])
    return Statistics(chi_square_band(nees, 7), chi_square_band(nis, 3))


def friction(name: str, settings: dict[str, object] | None = None) -> Statistics:
    """A friction filter 1 s into a stop of the twin with ABS, 60 seeds of sensor noise; speed and limits count."""
    truth = stop("E8")
    at = truth.brake_onset() + 1000
    nees, nis = [], []
    for seed in range(SEEDS):
        columns = {key: values[: at + 1] for key, values in twin.measured(truth, seed=seed).items()}
        estimator = estimators.create(name, twin.TABLE_8, settings or {})
        out = estimator.replay(columns)[-1]
        chosen = [0, 5, 7]
        error = np.array([truth.speed[at], truth.limit_front[at], truth.limit_rear[at]]) - estimator.state[chosen]
        nees.append(normalised_estimation_error(error, estimator.covariance[np.ix_(chosen, chosen)]))
        nis.append(out[[s.name for s in estimator.outputs].index(f"{name}.innovation")])
    return Statistics(chi_square_band(nees, 3), chi_square_band(nis, 8))
