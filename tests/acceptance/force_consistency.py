"""NEES and NIS of the random-walk force filter on the car of the force document (15c)."""

from dataclasses import dataclass

import numpy as np
from force_scenarios import RATIO, WHEELS, FloatArray, drive, measured, numbers

from estimators import create
from estimators.kalman.consistency import Consistency, chi_square_band, normalised_estimation_error
from estimators.neural_force_settings import RandomWalkForceSettings
from estimators.random_walk_force import RandomWalkForce
from vehicle_model.reference.steered_track import SteeredTrack
from vehicle_model.vehicle_file import load_vehicle

RUNS = 60
STATES = ("speed", "lateral_speed", "yaw_rate", "force_front", "force_rear")
FIRST_S, LAST_S = 5.0, 20.0
"""Part of S1 that the document judges; each run ends at another time in it, so that all phases of its forces count."""
DRAWN_SAMPLES, DRAWN_SPEED_M_S, DRAWN_ANGLE_RAD = 3000, 10.0, 0.5
STEP_S = 1e-3


@dataclass(frozen=True)
class Statistics:
    """Both statistics over the runs; errors and told deviations of the states, shape (60, 5)."""

    nees: Consistency
    nis: Consistency
    errors: FloatArray
    deviations: FloatArray


def _judged(runs: list[tuple[dict[str, FloatArray], FloatArray]]) -> Statistics:
    """Statistics at the last sample of signals, whose true states are given."""
    errors, deviations, nees, nis = [], [], [], []
    for signals, truth in runs:
        filter_ = create("random_walk_force_ekf", numbers(), {})
        assert isinstance(filter_, RandomWalkForce)
        out = filter_.replay(signals)[-1]
        error = truth - filter_.state
        errors.append(error)
        deviations.append(np.sqrt(np.diag(filter_.covariance)))
        nees.append(normalised_estimation_error(error, filter_.covariance))
        nis.append(out[[signal.name for signal in filter_.outputs].index("random_walk_force_ekf.innovation")])
    return Statistics(
        chi_square_band(nees, len(STATES)), chi_square_band(nis, 2), np.array(errors), np.array(deviations)
    )


def on_the_documents_drive() -> Statistics:
    """S1 with the document's noise."""
    source, runs = drive("S1"), []
    for seed, end in enumerate(np.linspace(FIRST_S, LAST_S, RUNS)):
        n = round(end / STEP_S)
        signals = {name: values[:n] for name, values in measured(source, seed).items()}
        runs.append((signals, np.array([source.truth[name][n - 1] for name in STATES])))
    return _judged(runs)


def where_its_noise_is_true() -> Statistics:
    """Forces that walk at random as the filter believes, the speeds shaken as it believes, an exact steering angle."""
    return _judged([_drawn(seed) for seed in range(RUNS)])


def _drawn(seed: int) -> tuple[dict[str, FloatArray], FloatArray]:
    random, believed = np.random.default_rng([13, seed]), RandomWalkForceSettings()
    car = SteeredTrack(load_vehicle("neural_700kg"))
    car.reset(speed_m_s=DRAWN_SPEED_M_S)
    steps = random.standard_normal((DRAWN_SAMPLES, len(STATES))) * np.sqrt(STEP_S)
    steps *= [
        believed.process_speed,
        believed.process_speed,
        believed.process_yaw_rate,
        believed.process_force_front,
        believed.process_force_rear,
    ]
    # the front force starts within the filter's P_0; the rear one, whose P_0 would stop the car, at what it knows
    steps[0, 3] = 300.0 * random.standard_normal()
    forces = np.cumsum(steps[:, 3:], axis=0)
    truth, angle = np.zeros((DRAWN_SAMPLES, len(STATES))), np.zeros(DRAWN_SAMPLES)
    radius, brake, drive_torque, state = car.get("wheels.fl.radius"), np.zeros(4), np.zeros(4), car._state[0]
    for k in range(DRAWN_SAMPLES):
        truth[k] = state["speed"], state["lateral_speed"], state["yaw_rate"], *forces[k]
        angle[k] = state["angle"]
        drive_torque[:2], drive_torque[2:] = 0.5 * radius * forces[k, :1], 0.5 * radius * forces[k, 1:]
        car.tick(brake, drive_torque, DRAWN_ANGLE_RAD * RATIO, k * STEP_S)
        for place, name in enumerate(STATES[:3]):
            state[name] += steps[k, place]
    noise = random.standard_normal((DRAWN_SAMPLES, 2)) * [believed.measurement_speed, believed.measurement_yaw_rate]
    rim = (truth[:, 0] + noise[:, 0]) / numbers()["wheels.fl.radius"]
    signals = {"yaw_rate": truth[:, 2] + noise[:, 1], "road_wheel_angle": angle}
    return signals | {f"wheel_speed_{wheel}": rim for wheel in WHEELS}, truth[-1]
