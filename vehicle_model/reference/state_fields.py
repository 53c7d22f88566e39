"""Fields that the state records of several reference plants share: what their outputs are written from."""

Field = tuple[str, str] | tuple[str, str, tuple[int, ...]]

ENERGIES: list[Field] = [
    ("gravity_energy", "f8"),
    ("brake_energy", "f8"),
    ("tyre_energy", "f8"),
    ("air_energy", "f8"),
    ("rolling_energy", "f8"),
    ("drive_energy", "f8"),
]
"""Since the reset [J]."""

WRITTEN_OUT: list[Field] = [
    ("speed", "f8"),
    ("lateral_speed", "f8"),
    ("yaw_rate", "f8"),
    ("x", "f8"),
    ("y", "f8"),
    ("yaw", "f8"),
    ("distance", "f8"),
    ("roll", "f8"),
    ("roll_rate", "f8"),
    ("nose_up", "f8"),
    ("nose_up_rate", "f8"),
    ("omega", "f8", (4,)),
    ("steer", "f8", (4,)),
    ("slip_angle", "f8", (4,)),
    ("friction_limit", "f8", (4,)),
    # means over the tick, forces in the axes of each wheel
    ("mean_x", "f8"),
    ("mean_y", "f8"),
    ("mean_load", "f8", (4,)),
    ("mean_force_x", "f8", (4,)),
    ("mean_force_y", "f8", (4,)),
    ("mean_brake", "f8", (4,)),
    *ENERGIES,
]
"""What ``planar_outputs.write_outputs`` reads of a car that moves in the plane."""
