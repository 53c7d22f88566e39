"""Scenarios S1 to S4 of the force document on the car that it defines (15c), and its observers on them."""

from collections.abc import Mapping
from dataclasses import dataclass
from functools import cache
from typing import Any

import numpy as np
from numpy.typing import NDArray

from estimators import create
from estimators.neural_force_model import force_car, observer_gains
from estimators.neural_force_settings import NeuralForceSettings
from signals.catalogue import block_slice, index_of
from vehicle_model.reference.steered_track import SteeredTrack
from vehicle_model.vehicle_file import load_vehicle

FloatArray = NDArray[np.float64]
SECONDS = 20
WHEELS = ("fl", "fr", "rl", "rr")
RATIO = 16.0
BUS, AGES = block_slice("bus"), block_slice("bus_age")
QUIET = {"learning_front": 1e8, "learning_rear": 4e6}
"""Gains of the noise-free runs (3.4)."""


@dataclass(frozen=True)
class Drive:
    """Noise-free signals and truth at 1 kHz."""

    time: FloatArray
    signals: dict[str, FloatArray]
    truth: dict[str, FloatArray]


def _forces(name: str, time: FloatArray) -> tuple[FloatArray, FloatArray]:
    if name == "S3":
        return np.where(time < 6.0, 0.0, -400.0), np.where(time < 8.0, 500.0, 2000.0)
    front = -200.0 + 120.0 * np.sin(2.0 * np.pi * 0.15 * time) - 150.0 * np.sin(2.0 * np.pi * 0.05 * time)
    return front, 3500.0 * np.exp(-time / 1.5) + 300.0 + 500.0 * np.sin(2.0 * np.pi * 0.1 * time)


def _command(name: str, time: FloatArray, amplitude: float) -> FloatArray:
    if name == "S2":
        return 1.0 * np.sin(2.0 * np.pi * 0.1 * time)
    if name == "S3":
        return np.full_like(time, 0.5)
    steered = amplitude * np.sin(2.0 * np.pi * 0.2 * time)
    return np.where(time < 10.0, steered, 0.0) if name == "S4 stopped" else steered


SPEEDS = {"S1": 6.0, "S2": 3.0, "S3": 8.0, "S4 stopped": 6.0}


@cache
def drive(
    name: str, *, amplitude: float = 0.7, speed: float = 0.0, changes: tuple[tuple[str, float], ...] = ()
) -> Drive:
    """Drive a scenario; ``changes`` are parameters of the plant that differ from the vehicle file."""
    car = SteeredTrack(load_vehicle("neural_700kg"))
    for path, value in changes:
        car.set(path, value)
    car.reset(speed_m_s=speed or SPEEDS[name])
    time = np.arange(1000 * SECONDS) * 1e-3
    front, rear = _forces(name, time)
    command = _command(name, time, amplitude)
    state = np.zeros((len(time), 4))
    radius, brake, drive_torque = car.get("wheels.fl.radius"), np.zeros(4), np.zeros(4)
    for k, at in enumerate(time):
        s = car._state[0]
        state[k] = s["speed"], s["lateral_speed"], s["yaw_rate"], s["angle"]
        drive_torque[:2], drive_torque[2:] = 0.5 * front[k] * radius, 0.5 * rear[k] * radius
        car.tick(brake, drive_torque, command[k] * RATIO, at)
    signals = {
        "yaw_rate": state[:, 2],
        "road_wheel_angle": state[:, 3],
        "steering_command": command,
        "speed": state[:, 0],
    }
    truth = {name: state[:, k] for k, name in enumerate(("speed", "lateral_speed", "yaw_rate", "road_wheel_angle"))}
    return Drive(time, signals, {**truth, "force_front": front, "force_rear": rear, "force_total": front + rear})


def measured(source: Drive, seed: int | None = None) -> dict[str, FloatArray]:
    """The drive as the observers see it: rolling wheels give v_x; with the document's noise if a seed is given."""
    signals = dict(source.signals)
    if seed is not None:
        random = np.random.default_rng(seed)
        for name, deviation in (("speed", 0.02), ("yaw_rate", 0.001), ("road_wheel_angle", 0.001)):
            signals[name] = signals[name] + random.normal(0.0, deviation, len(source.time))
    radius = numbers()["wheels.fl.radius"]
    rim = signals.pop("speed") / radius
    return {**signals, **{f"wheel_speed_{wheel}": rim for wheel in WHEELS}}


def observe(
    signals: Mapping[str, FloatArray],
    settings: Mapping[str, Any] | None = None,
    estimator: str = "neural_force_observer",
    car: Mapping[str, float] | None = None,
) -> dict[str, FloatArray]:
    """Outputs of an observer by name; ``car`` is what it believes, the document's if nothing is told."""
    built = create(estimator, car or numbers(), dict(settings or {}))
    results = built.replay(signals)
    return {signal.name.partition(".")[2]: results[:, k] for k, signal in enumerate(built.outputs)}


@cache
def numbers() -> dict[str, float]:
    """Numbers of the document's car."""
    return load_vehicle("neural_700kg").numbers()


def rmse(
    found: Mapping[str, FloatArray], source: Drive, output: str, start_s: float = 5.0, end_s: float = 20.0
) -> float:
    """Root mean square error of an output, over 5 to 20 s as in the document if not told otherwise."""
    part = (source.time >= start_s) & (source.time < end_s)
    return float(np.sqrt(np.mean(np.square(found[output][part] - source.truth[output][part]))))


def document_car(**settings: Any) -> np.void:
    """The document's car as the observers read it."""
    return force_car(numbers(), NeuralForceSettings(**settings))[0]


def gains(**settings: Any) -> tuple[float, float, float, float]:
    """L_11, L_12, L_21, L_22."""
    return observer_gains(NeuralForceSettings(**settings), 0.1)


def input_columns() -> tuple[np.ndarray, np.ndarray]:
    """Values and ages of the bus as an observer reads them."""
    return np.zeros(BUS.stop - BUS.start), np.zeros(AGES.stop - AGES.start)


def put_inputs(values: np.ndarray, yaw_rate: float, angle: float, speed: float) -> None:
    """Yaw rate [rad/s], steering angle [rad], and wheels that roll at the speed [m/s]."""
    radius = numbers()["wheels.fl.radius"]
    values[index_of("yaw_rate") - BUS.start], values[index_of("road_wheel_angle") - BUS.start] = yaw_rate, angle
    values[index_of("steering_command") - BUS.start] = angle
    for wheel in WHEELS:
        values[index_of(f"wheel_speed_{wheel}") - BUS.start] = speed / radius
