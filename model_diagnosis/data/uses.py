"""What cannot be diagnosed without a channel, in words."""

_LOST = {
    "wheel_speed_": "Without it that wheel's slip is unknown: tyre and brake of this wheel cannot be judged.",
    "brake_pressure_": "Without it the brakes are driven by the master pressure, if there is one.",
    "master_pressure": "Without it booster and hydraulics cannot be judged.",
    "longitudinal_acceleration": "Without it grade cannot be told from mass and drag.",
    "lateral_acceleration": "Without it cornering is judged by the yaw rate alone; bank and tilt are not seen.",
    "yaw_rate": "Without it steering, cornering stiffness and yaw inertia are judged by lateral acceleration alone.",
    "speed": "Without it the wheel radius and a common slip of all wheels are not seen.",
    "steering_wheel_angle": "Without it (and without road_wheel_angle) lateral dynamics cannot be replayed.",
    "road_wheel_angle": "Without it (and without steering_wheel_angle) lateral dynamics cannot be replayed.",
    "drive_torque_": "Without it stretches under drive torque say nothing on mass, drag and driveline.",
    "engine_torque": "Without it stretches under drive torque say nothing on mass, drag and driveline.",
    "valve_": "Without it the hydraulic unit's conductances and delays cannot be judged.",
    "pedal_force": "Without it the booster cannot be judged.",
}


def what_is_lost(name: str) -> str:
    """One sentence on what a missing channel takes from the diagnosis; "" where nothing depends on it."""
    return next((text for start, text in _LOST.items() if name.startswith(start)), "")
