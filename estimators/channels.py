"""Decoded signals that estimators read: the age that belongs to each and the range of its sensor."""

from dataclasses import dataclass

from signals.wheels import WHEELS


@dataclass(frozen=True)
class Channel:
    """Name of the age in block "bus_age" and plausible range in SI units."""

    age: str
    low: float
    high: float


def _table() -> dict[str, Channel]:
    table = {
        "longitudinal_acceleration": Channel("age_inertial", -40.0, 40.0),
        "lateral_acceleration": Channel("age_inertial", -40.0, 40.0),
        "vertical_acceleration": Channel("age_inertial", -60.0, 60.0),
        "yaw_rate": Channel("age_inertial", -6.0, 6.0),
        "roll_rate": Channel("age_inertial", -6.0, 6.0),
        "pitch_rate": Channel("age_inertial", -6.0, 6.0),
        "drive_torque_f": Channel("age_powertrain", -2e4, 2e4),
        "drive_torque_r": Channel("age_powertrain", -2e4, 2e4),
        "engine_torque": Channel("age_powertrain", -2e3, 2e3),
        "engine_speed": Channel("age_powertrain", 0.0, 2e3),
        "gear": Channel("age_powertrain", -1.0, 14.0),
        "steering_wheel_angle": Channel("age_vehicle_status", -20.0, 20.0),
        "steering_command": Channel("age_vehicle_status", -1.6, 1.6),
        "road_wheel_angle": Channel("age_vehicle_status", -1.6, 1.6),
        "ecu_reference_speed": Channel("age_abs_status", -5.0, 120.0),
        "abs_active": Channel("age_abs_status", 0.0, 1.0),
        "master_pressure": Channel("age_brake", -2e6, 4e7),
        "brake_switch": Channel("age_brake", 0.0, 1.0),
    }
    for wheel in WHEELS:
        table[f"wheel_speed_{wheel}"] = Channel("age_wheel_speed", -20.0, 500.0)
        table[f"brake_pressure_{wheel}"] = Channel("age_wheel_pressure", -2e6, 4e7)
    return table


CHANNELS: dict[str, Channel] = _table()

MOTION_INPUTS: tuple[str, ...] = ("longitudinal_acceleration", *(f"wheel_speed_{wheel}" for wheel in WHEELS))
TORQUE_INPUTS: tuple[str, ...] = (
    *(f"brake_pressure_{wheel}" for wheel in WHEELS),
    "drive_torque_f",
    "drive_torque_r",
)
