"""A stop with a closed form, as arrays: constant speed for 1 s, then constant deceleration to standstill."""

import numpy as np

from bench.recording.arrays import RunArrays
from signals.catalogue import catalogue

DECELERATION = 8.0
SPEED = 25.0
BRAKE_AT = 1.0
STOP_AFTER = SPEED / DECELERATION
FRONT_SLIP, REAR_SLIP = 0.12, 0.06


def stop(**columns) -> RunArrays:
    """Run of a point that brakes at a constant rate; ``columns`` replace or add signals given as functions of time."""
    end = BRAKE_AT + STOP_AFTER + 0.5
    time = np.arange(round(end * 1000)) * 1e-3
    braking = np.maximum(time - BRAKE_AT, 0.0)
    v = np.maximum(SPEED - DECELERATION * braking, 0.0)
    moving = (time >= BRAKE_AT) & (v > 0)
    values = {
        "time": time,
        "manoeuvre_phase": (time >= BRAKE_AT).astype(float),
        "driver_pedal_force": np.where(time >= BRAKE_AT, 400.0, 0.0),
        "driver_master_pressure": np.where(time >= BRAKE_AT, 1e7, 0.0),
        "speed": v,
        "true_yaw_rate": 0.1 * np.sin(2 * np.pi * time),
        "yaw_angle": 0.02 * np.minimum(braking, STOP_AFTER),
        "position_x": np.zeros_like(time),
        "position_y": np.zeros_like(time),
    }
    for wheel in ("fl", "fr"):
        values[f"slip_ratio_{wheel}"] = np.where(moving, -FRONT_SLIP, 0.0)
        values[f"friction_limit_{wheel}"] = np.ones_like(time)
    for wheel in ("rl", "rr"):
        values[f"slip_ratio_{wheel}"] = np.where(moving, -REAR_SLIP, 0.0)
        values[f"friction_limit_{wheel}"] = np.ones_like(time)
    for wheel in ("fl", "fr", "rl", "rr"):
        values[f"ecu_phase_{wheel}"] = np.zeros_like(time)
        values[f"vertical_load_{wheel}"] = np.full_like(time, 4000.0)
    values |= {name: function(time) for name, function in columns.items()}
    units = {signal.name: signal.unit for signal in catalogue()}
    units |= {name: "1" for name in values if name not in units}
    return RunArrays(time, values, {name: units[name] for name in values}, phase_names=("hold", "stop"))
