"""Memory of the compiled two-track car."""

import numpy as np

from vehicle_model.reference.state_fields import WRITTEN_OUT

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
        *WRITTEN_OUT,
        # of the step before, which the loads follow
        ("acceleration_x", "f8"),
        ("axle_side_force", "f8", (2,)),
    ]
)
