"""Memory of the compiled single-track car."""

import numpy as np

from vehicle_model.reference.state_fields import ENERGIES

FRONT, REAR = 0, 1

PARAMETER_RECORD = np.dtype(
    [
        ("substeps", "i8"),
        ("mass", "f8"),
        ("wheelbase", "f8"),
        ("to_front", "f8"),
        ("height", "f8"),
        ("drag", "f8"),  # D_a of eq. 28
        ("drag_height", "f8"),
        ("rolling", "f8"),  # C_roll
        ("half_track", "f8", (2,)),
        ("radius", "f8", (2,)),
        ("inertia", "f8", (2,)),  # of the axle
        ("friction_factor", "f8", (4,)),
        ("contact_stiffness", "f8", (2,)),  # of the axle
        ("contact_damping", "f8", (2,)),
        ("full_below", "f8", (2,)),
        ("none_above", "f8", (2,)),
    ]
)

STATE_RECORD = np.dtype(
    [
        ("speed", "f8"),
        ("x", "f8"),
        ("y", "f8"),
        ("yaw", "f8"),
        ("distance", "f8"),
        ("omega", "f8", (2,)),
        ("bristle", "f8", (2,)),
        ("load", "f8", (2,)),
        # friction coefficient and its slope by the wheel's speed, at this instant
        ("friction", "f8", (2,)),
        ("slope", "f8", (2,)),
        ("bristle_friction", "f8", (2,)),
        ("bristle_slope", "f8", (2,)),
        ("wheel_friction", "f8", (4,)),
        ("friction_limit", "f8", (4,)),
        ("prepared_load", "f8", (2,)),
        ("rolling_force", "f8"),  # against forward motion
        ("air_force", "f8"),  # against forward motion
        # means over the tick
        ("mean_acceleration", "f8"),
        ("mean_force", "f8", (2,)),
        ("mean_load", "f8", (2,)),
        ("mean_brake", "f8", (2,)),
        *ENERGIES,
    ]
)
