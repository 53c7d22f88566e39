"""Memory of the hydraulic unit between two steps."""

import numpy as np

from hydraulics.record import LONGEST_DELAY_STEPS

STATE_RECORD = np.dtype(
    [
        ("pressure", "f8", (4,)),
        ("target", "f8", (4,)),
        ("difference", "f8", (4,)),
        ("segment_time", "f8", (4,)),
        ("supply_start", "f8", (4,)),
        ("previous_state", "i8", (4,)),
        ("rearm", "i8"),
        ("accumulator", "f8", (2,)),
        ("pumped", "f8", (2,)),
        ("invalid_steps", "i8", (4,)),
        ("delayed_supply", "f8"),
        ("position", "i8"),
        # wheel brakes
        ("clamping", "f8", (4,)),  # pressure at the pads
        ("disc_temperature", "f8", (4,)),
        ("disc_angle", "f8", (4,)),
        ("lagged_torque", "f8", (4,)),
        ("master_history", "f8", (LONGEST_DELAY_STEPS,)),
        ("inlet_history", "f8", (LONGEST_DELAY_STEPS, 4)),
        ("outlet_history", "f8", (LONGEST_DELAY_STEPS, 4)),
    ]
)
