"""Logs of one wheel on a rig: slip ratio and slip angle are set there, and the forces follow."""

from collections.abc import Collection, Sequence

from model_diagnosis.manoeuvre import Manoeuvre
from signals.wheels import WHEELS

SET_SLIPS = ("slip_ratio", "slip_angle")
LOAD = "vertical_load"
FORCES = ("longitudinal_force", "lateral_force")

_OF_A_CAR = (
    "wheel_speed_",
    "steering_",
    "road_wheel_angle",
    "brake_pressure_",
    "master_pressure",
    "pedal_force",
    "valve_",
    "drive_torque_",
    "engine_torque",
    "longitudinal_acceleration",
    "lateral_acceleration",
    "yaw_rate",
    "lateral_speed",
    "side_slip_angle",
    "roll_",
    "pitch_",
    "suspension_travel_",
)
"""Begins of channels that a car has and a rig has not: what drives it, and the motion of its body."""


def rig_wheel(channels: Collection[str]) -> str | None:
    """The wheel that a rig's channels are of; None where they are of a car, or of several wheels."""
    if any(name.startswith(_OF_A_CAR) for name in channels):
        return None
    kinds = (*SET_SLIPS, LOAD, *FORCES)
    measured = [wheel for wheel in WHEELS if any(f"{kind}_{wheel}" in channels for kind in kinds)]
    if len(measured) != 1:
        return None
    wheel = measured[0]
    is_set = any(f"{kind}_{wheel}" in channels for kind in SET_SLIPS)
    is_felt = any(f"{kind}_{wheel}" in channels for kind in FORCES)
    return wheel if is_set and is_felt else None


def is_on_rig(manoeuvres: Sequence[Manoeuvre]) -> bool:
    """True where every manoeuvre is of one wheel on a rig."""
    return bool(manoeuvres) and all(rig_wheel(one.channels) is not None for one in manoeuvres)
