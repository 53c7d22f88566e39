"""Memory of the compiled planar car."""

import numpy as np

from vehicle_model.reference.state_fields import WRITTEN_OUT

PARAMETER_RECORD = np.dtype(
    [
        ("substeps", "i8"),
        ("roll_dynamics", "i8"),
        ("mass", "f8"),
        ("yaw_inertia", "f8"),
        ("pitch_inertia", "f8"),
        ("roll_inertia", "f8"),
        ("to_front", "f8"),
        ("to_rear", "f8"),
        ("height", "f8"),
        ("drag", "f8"),  # half of density times coefficient times area
        ("drag_height", "f8"),
        ("pitch_stiffness", "f8"),
        ("pitch_damping", "f8"),
        ("roll_stiffness", "f8"),
        ("roll_damping", "f8"),
        ("rolling_speed_factor", "f8"),
        ("wheel_x", "f8", (4,)),
        ("wheel_y", "f8", (4,)),
        ("radius", "f8", (4,)),
        ("inertia", "f8", (4,)),
        ("rolling", "f8", (4,)),
        ("friction_factor", "f8", (4,)),
        ("slowest", "f8"),  # smallest speed in the divisors of slip and slip angle
        ("map_points", "i8"),
    ]
)

STATE_RECORD = np.dtype(
    [
        *WRITTEN_OUT,
        ("load", "f8", (4,)),
        ("prepared_load", "f8", (4,)),
        # of this sub-step, in the axes of each wheel
        ("force_x", "f8", (4,)),
        ("force_y", "f8", (4,)),
        ("slip", "f8", (4,)),
        ("acceleration_x", "f8"),
        ("acceleration_y", "f8"),
        ("rolling_moment", "f8"),
    ]
)
