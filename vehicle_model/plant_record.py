"""Memory of the compiled plant: one record of parameters, one of states.

Arrays of four are in wheel order. The body frame has its origin at the car's centre of gravity at rest.
"""

from typing import Any, TypeAlias

import numpy as np

from vehicle_model.extension_terms_file import TARGETS
from vehicle_model.suspension_file import MOST_DAMPER_POINTS

Record: TypeAlias = Any
"""An element of an array with one of the dtypes below (or a road's), its fields as attributes in compiled code."""

PARAMETER_RECORD = np.dtype(
    [
        ("steps", "i8"),  # integration steps per tick
        ("substeps", "i8"),  # steps of the wheels' spin per integration step
        # geometry and masses
        ("height", "f8"),
        ("wheel_x", "f8", (4,)),
        ("wheel_y", "f8", (4,)),
        ("wheel_z", "f8", (4,)),
        ("sprung_mass", "f8"),
        ("sprung_centre", "f8", (3,)),
        ("sprung_inertia", "f8", (3, 3)),
        ("unsprung_mass", "f8", (4,)),
        ("spin_inertia", "f8", (4,)),
        ("transverse_inertia", "f8", (4,)),
        # suspension
        ("spring_rate", "f8", (4,)),
        ("spring_preload", "f8", (4,)),
        ("compression_damping", "f8", (4,)),
        ("rebound_damping", "f8", (4,)),
        ("anti_roll_rate", "f8", (4,)),
        ("damping_scale", "f8", (4,)),
        ("damper_points", "i8", (4,)),  # of the curve; 0: two rates
        ("damper_speeds", "f8", (4, MOST_DAMPER_POINTS)),
        ("damper_forces", "f8", (4, MOST_DAMPER_POINTS)),
        ("stops", "i8", (4,)),  # 1 where there is a stop
        ("bump_clearance", "f8", (4,)),
        ("bump_rate", "f8", (4,)),
        ("bump_progression", "f8", (4,)),
        ("rebound_clearance", "f8", (4,)),
        ("rebound_rate", "f8", (4,)),
        ("adaptive", "i8"),
        ("skyhook_damping", "f8"),
        ("soft_scale", "f8"),
        ("firm_scale", "f8"),
        ("valve_time_constant", "f8"),
        # guidance of the wheels: what a wheel does while it travels by 1 m along the body's z axis
        ("guided", "i8", (4,)),  # 1 where the wheel moves along another line than that axis
        ("slide_x", "f8", (4,)),
        ("slide_y", "f8", (4,)),
        ("carrier_pitch", "f8", (4,)),  # rad/m
        ("camber", "f8", (4,)),  # inclination of the wheel against the body at rest, top to the right positive
        ("camber_gain", "f8", (4,)),  # rad/m
        # steering
        ("steering_ratio", "f8"),
        ("steering_offset", "f8"),
        ("ackermann", "f8"),
        ("half_track_over_wheelbase", "f8"),
        ("steering_stiffness", "f8"),
        ("steering_damping", "f8"),
        # tyres
        ("radius", "f8", (4,)),
        ("static_load", "f8", (4,)),
        ("vertical_stiffness", "f8", (4,)),
        ("vertical_damping", "f8", (4,)),
        ("rolling_resistance", "f8", (4,)),
        ("friction_factor", "f8", (4,)),
        ("toe", "f8", (4,)),
        ("relaxation_x", "f8", (4,)),
        ("relaxation_y", "f8", (4,)),
        ("contact_stiffness_x", "f8", (4,)),
        ("contact_stiffness_y", "f8", (4,)),
        ("contact_damping", "f8", (4,)),
        ("contact_full_below", "f8", (4,)),
        ("contact_none_above", "f8", (4,)),
        # air: dynamic pressure over speed squared, times area and coefficient
        ("drag", "f8"),
        ("side_force", "f8"),
        ("side_force_position", "f8"),
        ("lift_front", "f8"),
        ("lift_rear", "f8"),
        ("drag_height", "f8"),
        # added terms, and what their variables need of tyres and brakes
        ("terms", "i8"),
        ("radius_changed", "i8"),  # 1 where a term acts on a radius
        ("nominal_radius", "f8", (4,)),
        ("tyre_heat_capacity", "f8"),
        ("tyre_cooling_rate", "f8"),
        ("ambient_temperature", "f8"),
        ("torque_per_pressure", "f8", (4,)),
        ("disc_heat_capacity", "f8", (4,)),
        ("disc_heat_share", "f8", (4,)),
        ("disc_cooling", "f8", (4,)),
        ("disc_cooling_per_speed", "f8", (4,)),
        ("disc_start_temperature", "f8", (4,)),
    ],
    align=True,
)

STATE_RECORD = np.dtype(
    [
        # contact
        ("bristle_x", "f8", (4,)),
        ("bristle_y", "f8", (4,)),
        ("lagged_slip_x", "f8", (4,)),
        ("lagged_slip_y", "f8", (4,)),
        # kinematics of this instant, road axes
        ("rotation", "f8", (3, 3)),
        ("angular_velocity", "f8", (3,)),
        ("yaw", "f8"),
        ("hub", "f8", (4, 3)),  # wheel centre from the body's origin
        ("hub_velocity", "f8", (4, 3)),
        ("slide", "f8", (4, 3)),  # movement of the wheel centre per travel
        ("carrier_spin", "f8", (4,)),  # turning of the carrier against the body about the spin axis, by its travel
        ("carrier_cosine", "f8", (4,)),  # of the angle between the spin axis and the body's y axis
        ("forward", "f8", (4, 2)),  # wheel heading in the road's plane
        ("axis_z", "f8", (4,)),  # vertical component of the spin axis: sine of the camber
        ("carrier_rate", "f8", (4,)),  # turning of the wheel carrier about the spin axis
        ("contact_velocity", "f8", (4, 3)),  # of the carrier's point at the contact
        # values at the start of the integration step
        ("velocity_before", "f8", (3,)),
        ("contact_velocity_before", "f8", (4, 2)),
        ("travel_rate_before", "f8", (4,)),
        ("hub_rate_before", "f8", (4,)),
        ("steer_rate_before", "f8", (2,)),
        ("carrier_rate_before", "f8", (4,)),
        ("carrier_spin_before", "f8", (4,)),
        ("moment_before", "f8", (3,)),
        # first moment of mass about the body's origin, road axes
        ("moment", "f8", (3,)),
        # mean values of the last integration step
        ("carrier_acceleration", "f8", (4,)),
        ("load", "f8", (4,)),
        ("load_damping", "f8", (4,)),  # part of the load that the tyre's vertical damper makes
        ("new_spin", "f8", (4,)),
        ("ground_force", "f8", (4, 2)),  # tyre force in road axes
        ("damper_force", "f8", (4,)),
        ("valve", "f8", (4,)),  # factor of an adaptive damper; 0 before its first step
        ("steer_torque", "f8", (2,)),
        ("air_power", "f8"),
        ("force_x", "f8", (4,)),
        ("force_y", "f8", (4,)),
        ("moment_z", "f8", (4,)),
        ("brake_torque", "f8", (4,)),
        ("drive_torque", "f8", (4,)),
        ("rolling_torque", "f8", (4,)),
        ("peak_friction", "f8", (4,)),
        ("acceleration", "f8", (3,)),
        ("grade", "f8"),
        ("bank", "f8"),
        ("road_height", "f8", (4,)),  # unevenness under the wheels, and its slope along the road
        ("road_slope", "f8", (4,)),
        # energy
        ("gravity_energy", "f8"),
        ("brake_energy", "f8"),
        ("tyre_energy", "f8"),
        ("rolling_energy", "f8"),
        ("damper_energy", "f8"),
        ("air_energy", "f8"),
        ("drive_energy", "f8"),
        ("distance", "f8"),
        # sums of the added terms by target and wheel; rises of temperature
        ("added", "f8", (len(TARGETS), 4)),
        ("stop_energy", "f8"),
        ("disc_heating", "f8", (4,)),
        ("tyre_heating", "f8", (4,)),
        ("brake_before", "f8", (4,)),
        ("brake_rate", "f8", (4,)),
    ],
    align=True,
)

# places of the joints in MuJoCo's vectors: free joint, then per wheel travel, (front only) steer, spin
POSITION_TRAVEL = (7, 10, 13, 15)
POSITION_STEER = (8, 11)
POSITION_SPIN = (9, 12, 14, 16)
VELOCITY_TRAVEL = (6, 9, 12, 14)
VELOCITY_STEER = (7, 10)
VELOCITY_SPIN = (8, 11, 13, 15)
POSITIONS, VELOCITIES = 17, 16
