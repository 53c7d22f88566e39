"""Memory of the compiled sensors."""

import numpy as np

from vehicle_model.tone_ring import RING_FIELDS, RING_STATE_FIELDS

# analogue channels
ACCELERATION_X, ACCELERATION_Y, ACCELERATION_Z, RATE_Z, RATE_X, RATE_Y = range(6)
INERTIAL_CHANNELS = 6
MASTER_PRESSURE, BRAKE_PRESSURE, PEDAL_FORCE, STEERING = 6, 7, 11, 12
CHANNELS = 13
LONGEST_DELAY_TICKS = 128  # a power of two
# what longitudinal_acceleration is made of
SENSOR, NOISE_FREE, IDEAL = range(3)

# signals of the vector that the sensors look at, and of block "bus" that they write; of four wheels the first
INPUT_SIGNALS = (
    "driver_pedal_force",
    "driver_gear",
    "driver_steering_wheel_angle",
    "true_master_pressure",
    "true_brake_pressure_fl",
    "true_engine_speed",
    "true_engine_torque",
    "drive_torque_demand_fl",
    "yaw_angle",
    "roll_angle",
    "pitch_angle",
    "true_yaw_rate",
    "true_roll_rate",
    "true_pitch_rate",
    "true_longitudinal_acceleration",
    "true_lateral_acceleration",
    "true_vertical_acceleration",
    "true_wheel_speed_fl",
    "true_road_wheel_angle_fl",
    "road_grade",
    "road_bank",
)
CHANNEL_SIGNALS = (
    "longitudinal_acceleration",
    "lateral_acceleration",
    "vertical_acceleration",
    "yaw_rate",
    "roll_rate",
    "pitch_rate",
    "master_pressure",
    "brake_pressure_fl",
    "brake_pressure_fr",
    "brake_pressure_rl",
    "brake_pressure_rr",
    "pedal_force",
    "steering_wheel_angle",
)
OUTPUT_SIGNALS = (
    "wheel_speed_fl",
    "wheel_edge_count_fl",
    "wheel_edge_time_fl",
    "brake_switch",
    "engine_torque",
    "engine_speed",
    "gearbox_speed",
    "gear",
    "drive_torque_f",
    "drive_torque_r",
    "steering_command",
    "road_wheel_angle",
    "ignition",
)

PARAMETER_RECORD = np.dtype(
    [
        *[(name, "i8") for name in INPUT_SIGNALS],
        *[(f"to_{name}", "i8") for name in OUTPUT_SIGNALS],
        ("to_channel", "i8", (CHANNELS,)),
        *RING_FIELDS,
        # inertial unit
        ("transition", "f8", (2, 2)),  # of the low-pass over a tick
        ("entry", "f8", (2,)),
        ("place", "f8", (3,)),
        ("acceleration_source", "i8"),
        ("scale", "f8", (CHANNELS,)),
        ("offset", "f8", (CHANNELS,)),
        ("noise", "f8", (CHANNELS,)),
        ("resolution", "f8", (CHANNELS,)),
        ("delay_ticks", "f8", (CHANNELS,)),
        ("drift", "f8", (CHANNELS,)),
        ("stuck", "f8", (CHANNELS + 4,)),  # analogue channels, then wheel-speed sensors
        ("dropout_rate", "f8", (CHANNELS + 4,)),
        ("dropout_duration", "f8", (CHANNELS + 4,)),
        ("mounting", "f8", (3,)),  # roll, pitch, yaw of the inertial unit
        ("connected", "i8", (4,)),
        ("ring_scale", "f8", (4,)),
        ("brake_switch_force", "f8"),
        ("final_drive", "f8"),
        ("wheel_share", "f8", (4,)),
        ("steering_ratio", "f8"),
    ]
)
STATE_RECORD = np.dtype(
    [
        *RING_STATE_FIELDS,
        ("started", "i8"),
        ("row", "i8"),  # of the noise that is drawn in advance
        ("contact_row", "i8"),  # the same for the contacts
        ("open_ticks", "f8", (CHANNELS + 4,)),  # that a contact stays open
        ("drifted", "f8", (CHANNELS,)),
        ("held", "f8", (CHANNELS,)),
        ("wheel_reports", "f8", (4, 3)),  # speed, count and time that each wheel-speed sensor reports
        ("rates", "f8", (3,)),
        ("low_pass", "f8", (INERTIAL_CHANNELS, 2)),
        ("position", "i8"),
        ("history", "f8", (CHANNELS, LONGEST_DELAY_TICKS)),
        ("measured", "f8", (CHANNELS,)),
    ]
)
