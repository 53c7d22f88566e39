"""Kinds of kinematic twins: what each compares, which group's factor or delay shows in it, and how closely it holds."""

from collections.abc import Mapping
from dataclasses import dataclass

_LEAST_M_S2, _LEAST_RAD_S, _LEAST_M_S = 0.2, 0.01, 0.3
LEAST_OF = {
    "longitudinal_acceleration": _LEAST_M_S2,
    "lateral_acceleration": _LEAST_M_S2,
    "yaw_rate": _LEAST_RAD_S,
    "speed": _LEAST_M_S,
}
"""Spreads below which a car moves by itself: a straight stop with ABS sways by 0.13 m/s² and 0.007 rad/s, and steering
takes 0.13 m/s of a car that coasts. Two of some thirty such stops swayed by more than 0.2 m/s²: wheels that slip tell
no delay between lateral acceleration and yaw rate."""


@dataclass(frozen=True)
class TwinKind:
    """How two sides compare.

    Attributes
    ----------
    exponents : group -> power with which its factor enters left over right side
    late, early : group whose delay makes the left side late, and the one that makes it early
    log_tolerance : spread of log(left/right) over ordinary cars
    lag_tolerance_s : spread of the lag over ordinary cars, the car's own answer included
    usual_lag_s : lag of the left side in an ordinary car
    level : True where the levels are compared, False where only their changes are
    driven : True where only stretches count in which the right side is at work (pedal or throttle)
    unbraked : True where those in which the brakes are at work do not count
    gentle : True where those do not in which brakes or drive ask for so much that wheels slip
    least : spread of a side below which no driver asked for the motion: of it the twin need not hold
    """

    name: str
    exponents: Mapping[str, float]
    late: str
    early: str
    log_tolerance: float
    lag_tolerance_s: float
    usual_lag_s: float = 0.0
    level: bool = False
    driven: bool = False
    unbraked: bool = False
    gentle: bool = False
    least: float = 0.0


SPEED_WHEELS = TwinKind(
    "speed and wheels",
    {"speed": 1, "wheel_speed": -1},
    "speed",
    "wheel_speed",
    0.04,
    0.12,
    usual_lag_s=0.06,
    level=True,
    least=_LEAST_M_S,
)
AX_SPEED = TwinKind(
    "longitudinal acceleration and speed",
    {"longitudinal_acceleration": 1, "speed": -1},
    "longitudinal_acceleration",
    "speed",
    0.13,
    0.02,
    least=_LEAST_M_S2,
)
AX_WHEELS = TwinKind(
    "longitudinal acceleration and wheels",
    {"longitudinal_acceleration": 1, "wheel_speed": -1},
    "longitudinal_acceleration",
    "wheel_speed",
    0.15,
    0.06,
    usual_lag_s=0.05,
    least=_LEAST_M_S2,
)
AY_YAW = TwinKind(
    "lateral acceleration and yaw rate",
    {"lateral_acceleration": 1, "yaw_rate": -1, "speed": -1},
    "lateral_acceleration",
    "yaw_rate",
    0.15,
    0.03,
    usual_lag_s=-0.01,
    gentle=True,
    least=_LEAST_M_S2,
)
YAW_WHEELS = TwinKind(
    "yaw rate and wheels",
    {"yaw_rate": 1, "wheel_speed": -1},
    "yaw_rate",
    "wheel_speed",
    0.15,
    0.02,
    gentle=True,
    least=_LEAST_RAD_S,
)
YAW_STEER = TwinKind(
    "yaw rate and steering",
    {"yaw_rate": 1, "steering": -1, "speed": -1},
    "yaw_rate",
    "steering",
    0.3,
    0.1,
    usual_lag_s=0.07,
    least=_LEAST_RAD_S,
)
AX_PRESSURE = TwinKind(
    "longitudinal acceleration and brake pressure",
    {"longitudinal_acceleration": 1, "brake_pressure": -1},
    "longitudinal_acceleration",
    "brake_pressure",
    0.45,
    0.04,
    usual_lag_s=0.03,
    driven=True,
    least=_LEAST_M_S2,
)
WHEELS_PRESSURE = TwinKind(
    "wheels and brake pressure",
    {"wheel_speed": 1, "brake_pressure": -1},
    "wheel_speed",
    "brake_pressure",
    0.45,
    0.07,
    usual_lag_s=-0.03,
    driven=True,
    least=_LEAST_M_S2,
)
AX_DRIVE = TwinKind(
    "longitudinal acceleration and drive torque",
    {"longitudinal_acceleration": 1, "drive_torque": -1},
    "longitudinal_acceleration",
    "drive_torque",
    0.45,
    0.1,
    usual_lag_s=0.03,
    driven=True,
    unbraked=True,
    least=_LEAST_M_S2,
)
YAW_HEADING = TwinKind(
    "yaw rate and heading", {"yaw_rate": 1, "yaw_angle": -1}, "yaw_rate", "yaw_angle", 0.1, 0.05, least=_LEAST_RAD_S
)
SIDE_SLIP = TwinKind(
    "side slip and lateral speed",
    {"side_slip_angle": 1, "lateral_speed": -1, "speed": 1},
    "side_slip_angle",
    "lateral_speed",
    0.1,
    0.05,
)
