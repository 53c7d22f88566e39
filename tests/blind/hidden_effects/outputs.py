"""Columns of a simulated manoeuvre."""

from hidden_effects.car import WHEELS


def _wheels(name: str) -> list[str]:
    return [f"{name}_{wheel}" for wheel in WHEELS]


OUTPUTS: tuple[str, ...] = (
    "speed",
    "lateral_speed",
    "yaw_rate",
    "specific_force_x",
    "specific_force_y",
    "pitch_angle",
    "pitch_rate",
    "roll_angle",
    "roll_rate",
    "distance",
    "master_pressure",
    "pump",
    *_wheels("wheel_speed"),
    *_wheels("pressure"),
    *_wheels("valve_inlet"),
    *_wheels("valve_outlet"),
    *_wheels("load"),
    *_wheels("force_x"),
    *_wheels("force_y"),
    *_wheels("brake_torque"),
    *_wheels("disc"),
    "kinetic_energy",
    "work",
)
"""``work`` is that of all forces and torques on car and wheels since the start [J]; the rest is in SI units."""

INDEX = {name: column for column, name in enumerate(OUTPUTS)}
