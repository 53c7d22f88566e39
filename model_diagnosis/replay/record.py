"""Numbers of the replay's car as the compiled step reads them; arrays of four are in wheel order.

The body frame has its origin at the car's centre of gravity, axes of ISO 8855. A row of ``REPLAY_RECORD`` is one car:
sweeps over deviations run one row per column.
"""

from typing import Any, TypeAlias

import numpy as np

from signals.wheels import WHEELS

Record: TypeAlias = Any
"""An element of an array of ``REPLAY_RECORD``, its fields as attributes in compiled code."""

_NUMBERS = (
    # body
    "mass",
    "yaw_inertia",
    "roll_inertia",  # of the sprung body
    "pitch_inertia",
    "height",
    "front_arm",  # centre of gravity behind the front axle
    "wheelbase",
    "track_front",
    "track_rear",
    # tyre, all wheels
    "more_load_loss",  # what a car's tyres lose by load beyond their file
    "peak_shift",  # relative shift of the slip at the peak at the same stiffness
    "heat_fade",  # 1/K^2
    "velocity_fade",  # s/m
    "camber_angle",  # inclination of all wheels against the road, top to the right positive
    "camber_stiffness",  # side force per load and inclination
    "conicity",  # N, to the left
    "rolling_speed",  # rise of the rolling resistance by speed, s/m
    "radius_load",  # loss of radius per load, m/N
    "radius_speed",  # growth of radius by speed squared, s^2/m
    # brakes, all wheels
    "in_stop_rise",
    "stop_energy",  # J, to which the rise refers
    "hysteresis",  # Pa
    "caliper_lag",  # s
    "ambient_temperature",
    # air: half density times area, and that times a coefficient
    "air",
    "drag",
    "drag_height",
    "lift_front",
    "lift_rear",
    "side_force",
    "side_force_position",
    "wind_along",  # m/s, against the car positive
    "wind_across",  # m/s, from the left positive
    "inferred_front",  # more share of the front axle in braking that no channel tells
    # road
    "grade",
    "bank",
    "friction_step",  # relative change of friction behind a place
    "friction_step_place",  # m from the start
    "friction_split",  # relative, more on the left and less on the right
    # driveline
    "engine_drag",  # N m on the driven axles together
    "driveline_drag",  # N m
    "driveline_viscous",  # N m s/rad
    "locking_preload",  # N m
    "locking_viscous",  # N m s/rad
    # steering
    "steering_scale",
    "steering_offset",
    "steering_stiffness",
    "steering_damping",
    "ackermann",
    # sensors
    "accelerometer_leaning",  # share of the body's lean, by which gravity shows, that the reported accelerations keep
    "accelerometer_lag",
    "accelerometer_damping",  # damping ratio of the sensor's second-order low-pass
    "gyro_lag",
    "speed_lag",
    "wheel_speed_lag",
    "roll_scrub",  # share of the body's roll rate and pitch rate that moves the contact patches
    "pitch_scrub",
    "link_scrub",  # share of what inclined links move them by as the wheels travel
    "pitch_pole",  # share of the way from the centre of gravity to the springs' centre about which the body pitches
    "guide_lean",  # share of the body's lean that turns the wheels' guides
    "support_apart",  # share of the difference of an axle's braking by which links push up one side more
    "link_lift_held",  # share of what links lift the body by in all that its weight takes back at once
    "lag_on_force",  # share of the relaxation lengths along which the force follows, not the slip
    "steering_link",  # share of the way from each front wheel's own aligning moment to their mean, to which it yields
    "trail_bulge",  # how much longer the trail stays than along a straight line to the peak
    "trail_across",  # share by which the slip across alone shortens the trail, and not the whole slip
    "roll_weight_arm",  # m, beyond the height over the wheels' axes
    "pitch_weight_arm",
    "place_x",
    "place_y",
)
_WHEELS = (
    "unsprung_mass",
    "spin_inertia",
    "radius",
    "rolling_resistance",
    "rolling_reference",  # of the vehicle file, to which its rise by speed refers
    "toe",
    "friction",
    "longitudinal_stiffness",
    "cornering_stiffness",
    "peak_x",
    "peak_y",
    "load_loss_x",  # relative loss of friction per relative rise of the load
    "load_loss_y",
    "stiffness_loss_x",
    "stiffness_loss_y",
    "peak_slip_x",
    "peak_slip_y",
    "reference_load",
    "nominal_load",  # to which the file's loss of friction by load refers
    "file_load_loss",
    "friction_stiffens",  # 1 where more friction is more stiffness too, 0 where the stiffness stays
    "relaxation_x",
    "relaxation_y",
    "trail",
    "torque_per_pressure",
    "threshold_pressure",
    "brake_factor",
    "drag_torque",
    "pad_speed_exponent",
    "pad_pressure_exponent",
    "fade",
    "fade_temperature",
    "fade_floor",
    "heat_capacity",
    "heat_share",
    "cooling",
    "cooling_per_speed",
    "start_temperature",
    "thickness_variation_sine",
    "thickness_variation_cosine",
    "effective_radius",
    "vertical_stiffness",
    "spring_rate",
    "compression_damping",
    "rebound_damping",
    "anti_roll_rate",
    "bump_clearance",
    "bump_rate",
    "bump_progression",
    "roll_centre_height",
    "brake_support",  # tangent of the support angle
    "drive_support",
    "drive_share",  # 1 on driven wheels
)

# what follows from the numbers above and spares divisions in every step (``derived.derive``)
_DERIVED_NUMBERS = ("inverse_mass", "inverse_sprung", "inverse_roll", "inverse_pitch", "inverse_yaw", "steering_lag")
_DERIVED_WHEELS = (
    "wheel_x",  # place ahead of the centre of gravity
    "wheel_y",  # and left of it
    "pitch_arm",  # place ahead of what the body pitches about
    "static_load",
    "inverse_load",  # 1/reference_load
    "inverse_nominal_load",
    "inverse_peak_x",  # 1/slip at the peak, with the factors of the stiffness
    "inverse_peak_y",
    "mean_share",  # of an axle's mean compression that springs take, not tyres
    "half_share",  # of half its difference
    "mean_rate",  # force per mean compression
    "half_rate",
    "guide_brake",  # load per longitudinal force past the spring
    "guide_drive",
    "guide_side",
    "inverse_capacity",  # of the disc's heat
)
CELLS = 256
"""Cells of a tyre's table; its variable is rho/(1 + rho), from 0 at no slip to 1 at an infinite one."""

REPLAY_RECORD = np.dtype(
    [
        *[(name, "f8") for name in (*_NUMBERS, *_DERIVED_NUMBERS)],
        *[(name, "f8", (4,)) for name in (*_WHEELS, *_DERIVED_WHEELS)],
    ],
    align=True,
)

# columns of the inputs of a manoeuvre
INPUT_PRESSURE, INPUT_DRIVE_FRONT, INPUT_DRIVE_REAR, INPUT_STEER, INPUT_GRADE, INPUT_BANK = 0, 4, 5, 6, 7, 8
INPUTS = 9
"""Wheel pressures [Pa], drive torque of the axles [N m], road-wheel angle [rad], grade and bank of the road."""
COASTING_NM = 1.0
"""Drive torque of both axles up to which the engine drags."""

# and of terms that no effect is, where there are any
INPUT_BRAKE_SHARE, INPUT_GRIP_SHARE, INPUT_FORCE_X, INPUT_FORCE_Y, INPUT_YAW_MOMENT = 9, 13, 17, 18, 19
INPUTS_WITH_TERMS = 20
"""Factors on brake torque and friction of the wheels, forces [N] and yaw moment [N m] on the body."""

CORRECTED = ("wheel_speed_fl", "wheel_speed_fr", "wheel_speed_rl", "wheel_speed_rr", "speed", "yaw_rate")
"""Signals on which the observer corrects."""

_OUTPUT_WHEELS = (
    "wheel_speed",
    "vertical_load",
    "longitudinal_force",
    "lateral_force",
    "suspension_travel",
    "slip_ratio",
    "slip_angle",
    "brake_disc_temperature",
    "brake_torque",
    "drive_torque",
    "road_wheel_angle",
)
OUTPUTS = (
    *(f"{name}_{wheel}" for name in _OUTPUT_WHEELS for wheel in WHEELS),
    "speed",
    "lateral_speed",
    "yaw_rate",
    "longitudinal_acceleration",
    "lateral_acceleration",
    "roll_rate",
    "pitch_rate",
    "roll_angle",
    "pitch_angle",
    "side_slip_angle",
    "distance",
    "yaw_acceleration",
)
"""What the compiled run writes at each sample, catalogue units."""

_NOT_SHOWN = ("wheel_speed", "suspension_travel")
SHOWN_STATES = (
    "speed",
    "lateral_speed",
    "pitch_angle",
    "roll_angle",
    "yaw_acceleration",
    *(f"{name}_{wheel}" for name in _OUTPUT_WHEELS if name not in _NOT_SHOWN for wheel in WHEELS),
)
"""States of the observer replay over which residuals are looked at."""
