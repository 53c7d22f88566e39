"""A small car of its own for tests of the discovery: single track, brakes, drag, and one hidden force.

It shares no code with the product. Every nominal number is off by a few per cent, sensors are noisy, sampling is 10 ms;
the truth integrates with 1 ms steps.
"""

import math
from collections.abc import Callable
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

FloatArray = NDArray[np.float64]

MASS, YAW_INERTIA, FRONT, REAR = 1400.0, 2100.0, 1.2, 1.5
STIFFNESS_FRONT, STIFFNESS_REAR = 9.0e4, 1.0e5
DRAG, ROLLING, RADIUS = 0.42, 0.013, 0.3
BRAKE_N_PER_PA = 1.1e-3
GRAVITY = 9.81
STEP_S, SAMPLE_S = 1e-3, 1e-2


@dataclass
class State:
    """What a hidden force may look at."""

    speed: float
    lateral_speed: float = 0.0
    yaw_rate: float = 0.0
    lateral_acceleration: float = 0.0
    pressure: float = 0.0
    steer: float = 0.0
    brake_force: float = 0.0
    wheel_angle: float = 0.0
    distance: float = 0.0
    time: float = 0.0
    memory: float = 0.0


Hidden = Callable[[State], float]
"""Hidden longitudinal force [N] in a state."""


@dataclass
class Log:
    """Measured channels of one drive, 10 ms."""

    channels: dict[str, FloatArray] = field(default_factory=dict)


def _inputs(kind: int, random: np.random.Generator) -> Callable[[float, float], tuple[float, float, float]]:
    """Brake pressure [Pa], drive force [N] and road-wheel angle [rad] over time and speed."""
    level, phase, rate = random.uniform(0.8, 1.2), random.uniform(0.0, 6.0), random.uniform(0.8, 1.2)

    def coast(time: float, speed: float) -> tuple[float, float, float]:
        return 0.0, 0.0, 0.0

    def stops(time: float, speed: float) -> tuple[float, float, float]:
        pressure = 4.5e6 * level * max(math.sin(0.9 * rate * time + phase), 0.0)
        return pressure, 2500.0 if speed < 12.0 else 0.0, 0.0

    def sine(time: float, speed: float) -> tuple[float, float, float]:
        return 0.0, 900.0, 0.04 * level * math.sin(2.2 * rate * time + phase)

    def turn(time: float, speed: float) -> tuple[float, float, float]:
        pressure = 3e6 * level * max(math.sin(0.7 * rate * time + phase), 0.0)
        return pressure, 2000.0 if speed < 14.0 else 300.0, 0.03 * math.sin(1.1 * time + 2.0 * phase)

    def ramp(time: float, speed: float) -> tuple[float, float, float]:
        return 6e6 * level * min(max(time - 1.0, 0.0) / 6.0, 1.0), 0.0, 0.0

    def drive(time: float, speed: float) -> tuple[float, float, float]:
        return 0.0, 4000.0 * level if time < 5.0 else 0.0, 0.01 * math.sin(0.5 * time)

    return (coast, stops, sine, turn, ramp, drive)[kind]


def off_nominal(random: np.random.Generator, scatter: float = 0.02) -> FloatArray:
    """Mass, drag, rolling, brake, tyre stiffness front and rear of one car, off their nominals."""
    nominal = np.array([MASS, DRAG, ROLLING, BRAKE_N_PER_PA, STIFFNESS_FRONT, STIFFNESS_REAR])
    return nominal * (1.0 + scatter * random.normal(size=6))


def drive(kind: int, car: FloatArray, hidden: Hidden, random: np.random.Generator) -> Log:
    """One drive of 9 s."""
    mass, drag, rolling, brake, front, rear = (float(value) for value in car)
    inputs = _inputs(kind, random)
    state = State(speed=(32.0, 30.0, 24.0, 26.0, 33.0, 14.0)[kind] * random.uniform(0.95, 1.05))
    state.wheel_angle, state.distance = random.uniform(0.0, 6.0), random.uniform(0.0, 50.0)
    rows: list[list[float]] = []
    for tick in range(9000):
        state.time = tick * STEP_S
        if state.speed < 4.0:
            break
        pressure, force, steer = inputs(state.time, state.speed)
        state.pressure, state.steer = pressure, steer
        state.brake_force = brake * pressure
        v, vy, r = state.speed, state.lateral_speed, state.yaw_rate
        side_front = -front * (math.atan2(vy + FRONT * r, v) - steer)
        side_rear = -rear * math.atan2(vy - REAR * r, v)
        f_x = force - state.brake_force - drag * v * v - rolling * mass * GRAVITY - side_front * math.sin(steer)
        f_x += hidden(state)
        f_y = side_front * math.cos(steer) + side_rear
        a_x, a_y = f_x / mass, f_y / mass
        state.lateral_acceleration = a_y
        if tick % 10 == 0:
            rows.append([state.time, v, a_x, a_y, r, vy, pressure, force, steer, state.distance])
        state.speed += STEP_S * (a_x + vy * r)
        state.lateral_speed += STEP_S * (a_y - v * r)
        state.yaw_rate += STEP_S * (FRONT * side_front - REAR * side_rear) / YAW_INERTIA
        state.wheel_angle += STEP_S * v / RADIUS
        state.distance += STEP_S * v
    return _measure(np.array(rows), random)


def _measure(truth: FloatArray, random: np.random.Generator) -> Log:
    noise = {"speed": 0.02, "longitudinal_acceleration": 0.05, "lateral_acceleration": 0.05, "yaw_rate": 2e-3}
    names = (
        "time",
        "speed",
        "longitudinal_acceleration",
        "lateral_acceleration",
        "yaw_rate",
        "lateral_speed",
        "brake_pressure",
        "drive_force",
        "road_wheel_angle",
        "distance",
    )
    channels = {name: truth[:, number].copy() for number, name in enumerate(names)}
    for name, std in noise.items():
        channels[name] += std * random.normal(size=len(truth))
    channels["brake_pressure"] = (
        np.round((channels["brake_pressure"] + 2e4 * random.normal(size=len(truth))) / 1e4) * 1e4
    )
    # the integral of a measured wheel speed, its start unknown
    channels["wheel_angle"] = np.cumsum(channels["speed"]) * SAMPLE_S / RADIUS
    channels["distance"] = np.cumsum(channels["speed"]) * SAMPLE_S
    return Log(channels)
