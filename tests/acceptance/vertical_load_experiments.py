"""Experiments E1 to E4 of the vertical-load document on the car that it defines (4.1), and its observers on them."""

from collections.abc import Mapping
from dataclasses import dataclass
from functools import cache
from typing import Any

import numpy as np
from numpy.typing import NDArray

from estimators import create
from estimators.vertical_load_car import load_car
from estimators.vertical_load_model import continuous
from estimators.vertical_load_settings import VerticalLoadSettings
from signals.catalogue import block_slice, index_of
from vehicle_model.reference.two_track import TwoTrack
from vehicle_model.road_file import RoadFile
from vehicle_model.vehicle_file import load_vehicle

FloatArray = NDArray[np.float64]

STEERING_RATIO = 17.0
SAMPLE_S = 0.01
KMH = 1.0 / 3.6
SECONDS = 9
WHEELS = ("fl", "fr", "rl", "rr")
NOISE = {
    "lateral_acceleration": 0.05,
    "yaw_rate": 0.002,
    "roll_rate": 0.005,
    "longitudinal_acceleration": 0.05,
}
"""One sigma, white, at 100 Hz (4.1)."""


@dataclass(frozen=True)
class Experiment:
    """Speed [m/s], friction, steering of 4.1."""

    speed: float
    friction: float
    amplitude: float
    double: bool


EXPERIMENTS = {
    "E1": Experiment(70.0 / 3.6, 1.0, 0.032, False),
    "E2": Experiment(70.0 / 3.6, 0.2, 0.032, False),
    "E3": Experiment(50.0 / 3.6, 1.0, 0.045, True),
    "E4": Experiment(50.0 / 3.6, 0.2, 0.045, True),
}


def road_wheel_angle(experiment: Experiment, time: float) -> float:
    """Lane change [rad]: one period of 2.5 s from 1 s on; the double one comes back after a pause of 1 s."""
    if 1.0 <= time < 3.5:
        return experiment.amplitude * float(np.sin(2.0 * np.pi * (time - 1.0) / 2.5))
    if experiment.double and 4.5 <= time < 7.0:
        return -experiment.amplitude * float(np.sin(2.0 * np.pi * (time - 4.5) / 2.5))
    return 0.0


@dataclass(frozen=True)
class Drive:
    """Noise-free signals of a drive, each of shape (900,) at 100 Hz; ``loads`` of shape (900, 4)."""

    experiment: Experiment
    signals: dict[str, FloatArray]
    truth: dict[str, FloatArray]
    loads: FloatArray


@cache
def drive(
    name: str, *, road_roll: float = 0.0, brake: float = 0.0, car_changes: tuple[tuple[str, float], ...] = ()
) -> Drive:
    """Drive an experiment.

    Parameters
    ----------
    road_roll : float
        Amplitude of M_road = a sin(2 pi 1.2 t) from 1 s on [N m] (finding F3).
    brake : float
        Longitudinal acceleration demanded for 2 s instead of the speed control, then minus two thirds of it: -3 and
        +2 m/s^2 if -3 is given (2.4; the times are those that the document's two figures for wrong forms imply).
    car_changes : tuple of (path, value)
        Parameters of the plant that differ from the vehicle file.
    """
    experiment = EXPERIMENTS[name]
    car = TwoTrack(load_vehicle("e_class_suv"), RoadFile(friction=experiment.friction))
    for path, value in car_changes:
        car.set(path, value)
    car.reset(speed_m_s=experiment.speed)
    state = car.state()
    mass, radius = car.get("body.mass"), car.get("wheels.fl.radius")
    most = 0.3 * experiment.friction * mass * 9.81
    rows: list[dict[str, float]] = []
    angles = []
    for tick in range(1000 * SECONDS):
        time = tick * 1e-3
        if road_roll:
            car.set("two_track.road_roll_moment", road_roll * np.sin(2.0 * np.pi * 1.2 * time) if time > 1.0 else 0.0)
        force = float(np.clip(5000.0 * (experiment.speed - car.outputs[SPEED]), -most, most))
        if brake:
            force = mass * (brake if time < 2.0 else -2.0 / 3.0 * brake if time < 4.0 else 0.0)
        angle = 0.0 if brake else road_wheel_angle(experiment, time)
        car.tick(np.zeros(4), np.full(4, 0.25 * force * radius), angle * STEERING_RATIO, time)
        if tick % 10 == 9:
            state = car.state()
            rows.append(state)
            angles.append(angle)
    truth = {key: np.array([row[key] for row in rows]) for key in rows[0]}
    signals = {
        "lateral_acceleration": truth["true_lateral_acceleration"],
        "longitudinal_acceleration": truth["true_longitudinal_acceleration"],
        "yaw_rate": truth["true_yaw_rate"],
        "roll_rate": truth["true_roll_rate"],
        "steering_wheel_angle": np.array(angles) * STEERING_RATIO,
        **{f"wheel_speed_{wheel}": truth["speed"] / radius for wheel in WHEELS},
    }
    return Drive(experiment, signals, truth, np.column_stack([truth[f"vertical_load_{wheel}"] for wheel in WHEELS]))


def noisy(source: Drive, seed: int) -> dict[str, FloatArray]:
    """The drive as its sensors measure it."""
    random = np.random.default_rng(seed)
    return {
        name: values + random.normal(0.0, NOISE[name], len(values)) if name in NOISE else values
        for name, values in source.signals.items()
    }


def observe(
    estimator: str, measured: Mapping[str, FloatArray], settings: Mapping[str, Any] | None = None
) -> dict[str, FloatArray]:
    """Outputs of an observer over a drive, by name."""
    built = create(estimator, vehicle_numbers(), {"accelerometer": "level", **(settings or {})}, SAMPLE_S)
    results = built.replay(measured)
    return {signal.name.partition(".")[2]: results[:, k] for k, signal in enumerate(built.outputs)}


@cache
def vehicle_numbers() -> dict[str, float]:
    """Numbers of the document's car."""
    return load_vehicle("e_class_suv").numbers()


def loads_of(estimates: Mapping[str, FloatArray]) -> FloatArray:
    """Estimated loads, shape (900, 4)."""
    return np.column_stack([estimates[f"vertical_load_{wheel}"] for wheel in WHEELS])


def rmse(estimated: FloatArray, true: FloatArray) -> tuple[float, float]:
    """Root mean square error of front and rear wheels [N]."""
    error = np.square(estimated - true)
    return float(np.sqrt(error[:, :2].mean())), float(np.sqrt(error[:, 2:].mean()))


SPEED = index_of("speed") - block_slice("plant").start


def document_record(**settings: Any) -> np.void:
    """The document's car as the observers read it."""
    return load_car(vehicle_numbers(), VerticalLoadSettings(accelerometer="level", **settings))[0]


def matrices(speed: float) -> tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray]:
    """A, B, C, D at a speed."""
    a, b, c, d = np.zeros((4, 4)), np.zeros(4), np.zeros((3, 4)), np.zeros(3)
    continuous(document_record(), speed, a, b, c, d)
    return a, b, c, d
