"""Memory of the compiled two-track car."""

import numpy as np

PARAMETER_RECORD = np.dtype(
    [
        ("mass", "f8"),
        ("sprung_mass", "f8"),
        ("yaw_inertia", "f8"),
        ("roll_inertia", "f8"),  # about the roll axis
        ("to_front", "f8"),
        ("to_rear", "f8"),
        ("track", "f8"),
        ("height", "f8"),
        ("roll_centre", "f8"),
        ("roll_arm", "f8"),  # centre of gravity above the roll axis
        ("roll_stiffness", "f8"),
        ("roll_damping", "f8"),
        ("roll_share", "f8", (2,)),
        ("road_roll_moment", "f8"),
        ("cornering_stiffness", "f8", (2,)),
        ("steering_ratio", "f8"),
        ("steering_offset", "f8"),
        ("wheel_x", "f8", (4,)),
        ("wheel_y", "f8", (4,)),
        ("radius", "f8", (4,)),
        ("inertia", "f8", (4,)),  # 0: the document's wheels have no mass
        ("friction_factor", "f8", (4,)),
    ]
)

STATE_RECORD = np.dtype(
    [
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
        # of the step before, which the loads follow
        ("acceleration_x", "f8"),
        ("axle_side_force", "f8", (2,)),
        # of this step
        ("mean_x", "f8"),
        ("mean_y", "f8"),
        ("mean_load", "f8", (4,)),
        ("mean_force_x", "f8", (4,)),
        ("mean_force_y", "f8", (4,)),
        ("mean_brake", "f8", (4,)),
        # energies since the reset
        ("gravity_energy", "f8"),
        ("brake_energy", "f8"),
        ("tyre_energy", "f8"),
        ("air_energy", "f8"),
        ("rolling_energy", "f8"),
        ("drive_energy", "f8"),
    ]
)
