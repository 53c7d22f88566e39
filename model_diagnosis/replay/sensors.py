"""Own noise of the sensors: what a residual cannot fall below."""

import math

from vehicle_model.vehicle_file import VehicleFile

_LEAST = {
    "wheel_speed": 0.04,
    "longitudinal_acceleration": 0.03,
    "lateral_acceleration": 0.03,
    "vertical_acceleration": 0.03,
    "yaw_rate": 0.001,
    "roll_rate": 0.002,
    "pitch_rate": 0.002,
    "roll_angle": 0.001,
    "pitch_angle": 0.001,
    "side_slip_angle": 0.002,
    "speed": 0.03,
    "lateral_speed": 0.03,
    "brake_pressure": 1e4,
    "master_pressure": 1e4,
    "vertical_load": 50.0,
    "longitudinal_force": 50.0,
    "lateral_force": 50.0,
    "suspension_travel": 5e-4,
}
"""Noise of a good series sensor in the catalogue's unit, the least that is believed."""


def own_noise(vehicle: VehicleFile, signal: str) -> float:
    """Standard deviation of a signal's sensor: the vehicle file's noise and resolution, at least a good sensor's.

    Raises
    ------
    KeyError
        If the replay does not compare such a signal.
    """
    kind = signal.rpartition("_")[0] if signal[-3:] in ("_fl", "_fr", "_rl", "_rr") else signal
    least = _LEAST[kind]
    sensor = getattr(vehicle.sensors, kind, None)
    if sensor is None or not hasattr(sensor, "noise"):
        return least
    return max(math.hypot(sensor.noise, sensor.resolution / math.sqrt(12.0)), least)
