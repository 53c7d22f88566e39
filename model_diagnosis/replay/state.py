"""Memory of the replay's car while it runs: states, the inputs of this step and the tables of its tyres.

Records, not arrays: compiled functions hand them on without counting references, which costs more than the physics.
"""

import numpy as np

from model_diagnosis.replay.record import CELLS

SUBSTEPS = 5
"""Steps of 2 ms within a sample of 10 ms."""

PAST_STEPS = SUBSTEPS + 1
"""Wheel speeds kept for a sensor's lag: those at the ends of a sample's steps and at its begin."""

_BODY = (
    "speed",
    "speed_rate",
    "lateral_speed",
    "lateral_rate",
    "yaw_rate",
    "yaw_acceleration",
    "heave",
    "heave_rate",
    "heave_acceleration",
    "pitch",  # nose down positive
    "pitch_rate",
    "pitch_acceleration",
    "roll",  # left side up positive
    "roll_rate",
    "roll_acceleration",
    # in the middle of this step
    "mid_speed",
    "mid_lateral_speed",
    "mid_yaw_rate",
    "mid_pitch",
    "mid_pitch_rate",
    "mid_roll",
    "mid_roll_rate",
    # force and moments of springs, dampers and links on the body in this step
    "spring_up",
    "spring_nose_down",
    "spring_left_up",
    "distance",
    "stop_energy",
    "acceleration_x",  # specific force as the accelerometer reports it
    "acceleration_y",
    "felt_rate_x",  # and its rate within the sensor
    "felt_rate_y",
    # what a step leaves of the sensor's distance from the truth and of its rate
    "felt_kept",
    "felt_of_rate",
    "felt_rate_of",
    "felt_rate_kept",
    "ground_x",  # forces of the tyres and of the air, body axes
    "ground_y",
    "air_x",
    "air_y",
    "spin_momentum",  # of all wheels about their axes
    # inputs of this step
    "drive_front",
    "drive_rear",
    "steer",
    "grade",
    "bank",
    "term_force_x",  # of terms that no effect of the catalogue is
    "term_force_y",
    "term_yaw_moment",
)
_WHEELS = (
    "spin",
    "spin_rate",
    "lagged_x",  # slip that the tyre follows
    "lagged_y",
    "slip_x",
    "slip_y",
    "tyre_x",  # forces along and across the wheel
    "tyre_y",
    "ground_force_x",  # the same along and across the body
    "ground_force_y",
    "link_push",  # by which links push the body up
    "aligning",
    "load",
    "travel",
    "travel_rate",
    "angle",  # of the road wheel
    "sine",
    "cosine",
    "clamping",  # pressure behind the hysteresis
    "lagged_torque",
    "lagged_force_x",
    "lagged_force_y",
    "brake_torque",
    "drive_torque",
    "rolling_torque",
    "disc_temperature",
    "disc_sine",  # of the angle it has turned by
    "disc_cosine",
    "tyre_heat",  # rise of the tread's temperature
    "pressure",  # inputs of this step
    "brake_share",
    "grip_share",
)

STATE_RECORD = np.dtype(
    [
        *[(name, "f8") for name in _BODY],
        *[(name, "f8", (4,)) for name in _WHEELS],
        ("past_spin", "f8", (PAST_STEPS, 4)),  # at the ends of the last steps, the last one first
        ("table", "f8", (2, 2, CELLS + 1, 2)),  # axle, direction
    ],
    align=True,
)
