"""Hidden forces of five kinds for the small car, with the variables that a discovery has to name."""

import math
from dataclasses import dataclass

import numpy as np
from small_car import Hidden, State


@dataclass(frozen=True)
class Unknown:
    """A hidden force and what names it: any of these sets of variables (a force that is multiplied counts as one)."""

    kind: str
    force: Hidden
    variables: tuple[frozenset[str], ...]


def _sets(*names: str) -> tuple[frozenset[str], ...]:
    return tuple(frozenset(name.split()) for name in names)


def _direction(state: State, value: float, width: float) -> float:
    state.memory = min(max(state.memory, value - width), value + width)
    return (value - state.memory) / width


def _relay(state: State, value: float, low: float, high: float) -> float:
    if state.memory == 0.0:
        state.memory = -1.0
    if value > high:
        state.memory = 1.0
    elif value < low:
        state.memory = -1.0
    return state.memory


def product(random: np.random.Generator) -> Unknown:
    size = random.uniform(0.7, 1.3)
    choices = (
        # pads that lose torque with speed: 18 % at 30 m/s
        Unknown(
            "product", lambda s: 0.006 * size * s.brake_force * s.speed, _sets("brake speed", "brake_pressure speed")
        ),
        # 300 N at 25 m/s and 0.25 rad/s
        Unknown(
            "product",
            lambda s: -48.0 * size * s.speed * abs(s.yaw_rate),
            _sets("speed yaw_rate", "lateral_acceleration"),
        ),
        # brakes that gain in a turn: 25 % at 5 m/s²
        Unknown(
            "product",
            lambda s: -0.05 * size * s.brake_force * abs(s.lateral_acceleration),
            _sets("brake lateral_acceleration", "brake_pressure lateral_acceleration"),
        ),
    )
    return choices[random.integers(len(choices))]


def power(random: np.random.Generator) -> Unknown:
    size = random.uniform(0.7, 1.3)
    choices = (
        # 500 N at 30 m/s beside a drag whose coefficient is free
        Unknown("power", lambda s: -500.0 * size * (s.speed / 30.0) ** 4, _sets("speed")),
        Unknown(
            "power",
            lambda s: 0.2 * size * s.brake_force * (s.speed / 30.0) ** 2,
            _sets("brake speed", "brake_pressure speed"),
        ),
        Unknown(
            "power", lambda s: -350.0 * size * (abs(s.lateral_acceleration) / 5.0) ** 1.5, _sets("lateral_acceleration")
        ),
    )
    return choices[random.integers(len(choices))]


def threshold(random: np.random.Generator) -> Unknown:
    size, at = random.uniform(0.7, 1.3), random.uniform(0.9, 1.1)
    choices = (
        Unknown(
            "threshold",
            lambda s: -220.0 * size * max(abs(s.lateral_acceleration) - 2.5 * at, 0.0),
            _sets("lateral_acceleration"),
        ),
        Unknown("threshold", lambda s: 450.0 * size * (s.speed > 20.0 * at), _sets("speed")),
        Unknown(
            "threshold",
            lambda s: 3e-4 * size * max(s.pressure - 2.2e6 * at, 0.0),
            _sets("brake_pressure", "brake brake_pressure", "brake"),
        ),
    )
    return choices[random.integers(len(choices))]


def hysteresis(random: np.random.Generator) -> Unknown:
    size = random.uniform(0.7, 1.3)
    choices = (
        Unknown("hysteresis", lambda s: 330.0 * size * _direction(s, s.pressure, 1.5e5), _sets("brake_pressure")),
        Unknown("hysteresis", lambda s: 200.0 * size * _relay(s, s.speed, 17.0, 21.0), _sets("speed")),
    )
    return choices[random.integers(len(choices))]


def periodic(random: np.random.Generator) -> Unknown:
    size = random.uniform(0.7, 1.3)
    wave = random.uniform(0.15, 0.4)
    choices = (
        Unknown(
            "periodic",
            lambda s: 0.08 * size * s.brake_force * math.sin(s.wheel_angle),
            _sets("brake wheel_angle", "brake distance", "brake_pressure wheel_angle"),
        ),
        Unknown("periodic", lambda s: 150.0 * size * math.sin(2.0 * s.wheel_angle), _sets("wheel_angle", "distance")),
        Unknown("periodic", lambda s: 220.0 * size * math.sin(wave * s.distance), _sets("distance", "wheel_angle")),
    )
    return choices[random.integers(len(choices))]


KINDS = (product, power, threshold, hysteresis, periodic)
