"""Terms outside any catalogue that can be hidden in the brake torque: five kinds of law, compiled.

Each multiplies or adds to a wheel's brake torque; the label states kind, formula and variables.
"""

import math
from dataclasses import dataclass

from numba import njit

PRODUCT, POWER, HYSTERESIS, THRESHOLD, PERIODIC = 1.0, 2.0, 3.0, 4.0, 5.0


@dataclass(frozen=True)
class UnknownKind:
    """One kind: its number in the record, formula, variables that a right answer names, range of its size."""

    number: float
    name: str
    formula: str
    variables: tuple[str, ...]
    low: float
    high: float


KINDS = (
    UnknownKind(PRODUCT, "product", "T_b (1 − a (v / 30 m/s)²)", ("speed", "brake_torque"), 0.15, 0.3),
    UnknownKind(POWER, "power", "T_b (1 − a |r / 0.3 rad/s|^1.5)", ("yaw_rate", "brake_torque"), 0.2, 0.4),
    UnknownKind(HYSTERESIS, "hysteresis", "T_b (1 + a sign(dp/dt))", ("pressure_rate", "brake_torque"), 0.08, 0.2),
    UnknownKind(THRESHOLD, "threshold", "T_b − a k max(p − 30 bar, 0)", ("brake_pressure", "brake_torque"), 0.2, 0.4),
    UnknownKind(PERIODIC, "periodic", "T_b (1 + a sin(2π v / 3 m/s))", ("speed", "brake_torque"), 0.1, 0.25),
)
"""Sizes a are dimensionless: the largest change relative to the torque in the shipped manoeuvres."""

_PRESSURE_RATE_FULL_PA_S = 5e6
_KNEE_PA = 3e6


@njit(cache=True)
def torque_factor(
    kind: float, size: float, speed: float, yaw_rate: float, pressure: float, pressure_rate: float
) -> float:
    """Factor on the brake torque by the hidden term; 1 without one."""
    if kind == PRODUCT:
        return 1.0 - size * (speed / 30.0) ** 2
    if kind == POWER:
        return max(1.0 - size * abs(yaw_rate / 0.3) ** 1.5, 0.0)
    if kind == HYSTERESIS:
        return 1.0 + size * max(-1.0, min(1.0, pressure_rate / _PRESSURE_RATE_FULL_PA_S))
    if kind == THRESHOLD:
        return 1.0 - size * max(pressure - _KNEE_PA, 0.0) / pressure if pressure > 0.0 else 1.0
    if kind == PERIODIC:
        return 1.0 + size * math.sin(2.0 * math.pi * speed / 3.0)
    return 1.0
