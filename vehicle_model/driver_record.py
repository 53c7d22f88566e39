"""What the compiled driver is told (`COMMAND_RECORD`) and what it remembers (`STATE_RECORD`)."""

import numpy as np

MOST_GEARS = 12
LONGEST_REACTION_TICKS = 1024

# what the feet do
RELEASE, ACCELERATE, HOLD_SPEED, COAST, BRAKE = range(5)
# what the hands do
ANGLE, TABLE, SINE, SINE_WITH_DWELL, STRAIGHT, CIRCLE, PATH = range(7)

INPUT_SIGNALS = (
    "speed",
    "lateral_speed",
    "position_x",
    "position_y",
    "yaw_angle",
    "true_yaw_rate",
    "true_engine_speed",
)

COMMAND_RECORD = np.dtype(
    [
        # places in the signal vector
        *[(name, "i8") for name in INPUT_SIGNALS],
        ("phase", "i8"),
        ("outputs", "i8"),  # first signal of block "driver"
        # the car
        ("wheelbase", "f8"),
        ("understeer", "f8"),  # additional road-wheel angle per lateral acceleration, s^2 rad/m
        ("steering_ratio", "f8"),
        ("radius", "f8"),  # of the driven wheels
        ("idle_speed", "f8"),
        ("gears", "i8"),
        ("ratio", "f8", (MOST_GEARS + 1,)),
        ("booster_gain", "f8"),
        ("booster_knee_pressure", "f8"),
        ("booster_slope_loss", "f8"),
        ("initial_gear", "i8"),  # -1 is what suits the speed
        # the step
        ("phase_number", "f8"),
        ("serial", "i8"),  # changes with every step
        ("feet", "i8"),
        ("feet_serial", "i8"),  # changes with every step that tells the feet something
        ("accelerator", "f8", (MOST_GEARS + 1,)),  # in each gear
        ("accelerator_rate", "f8"),
        ("gear", "i8"),  # -1 is auto
        ("highest_gear", "i8"),
        ("shift_engine_speed", "f8"),
        ("shift_speed", "f8", (MOST_GEARS + 1,)),  # speed of the car at which each gear is left; 0: by engine speed
        ("launch_engine_speed", "f8"),
        ("shift_duration", "f8"),
        ("clutch_duration", "f8"),
        ("speed_target", "f8"),
        ("proportional_gain", "f8"),
        ("integral_gain", "f8"),
        ("feedforward", "f8"),  # accelerator that holds the target speed on a level road
        ("brake_by_pressure", "i8"),
        ("brake_target", "f8"),  # N or Pa
        ("brake_ramp", "f8"),  # N/s or Pa/s
        ("brake_human", "i8"),
        ("brake_declutch", "i8"),
        ("hands", "i8"),
        ("hands_serial", "i8"),
        ("angle", "f8"),
        ("rate", "f8"),
        ("amplitude", "f8"),
        ("frequency", "f8"),
        ("periods", "f8"),
        ("dwell", "f8"),
        ("path_radius", "f8"),
        ("path_y", "f8"),
        ("preview", "f8"),
        ("reaction_ticks", "i8"),
        ("countersteer_gain", "f8"),
        ("maximum_angle", "f8"),
    ]
)

STATE_RECORD = np.dtype(
    [
        ("started", "i8"),
        ("feet_serial", "i8"),
        ("hands_serial", "i8"),
        ("feet_began", "f8"),
        ("hands_began", "f8"),
        ("accelerator", "f8"),
        ("clutch", "f8"),
        ("gear", "i8"),
        ("next_gear", "i8"),
        ("shift_left", "f8"),  # time until the clutch closes again
        ("integral", "f8"),
        ("brake_start", "f8"),
        ("pedal_force", "f8"),
        ("master_pressure", "f8"),
        ("steering", "f8"),
        ("steering_start", "f8"),
        ("follows", "i8"),
        ("trim", "f8"),
        ("centre_x", "f8"),
        ("centre_y", "f8"),
        ("table_row", "i8"),
        ("position", "i8"),
        ("history", "f8", (LONGEST_REACTION_TICKS,)),
    ]
)
