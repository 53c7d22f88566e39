"""A planar bicycle car at constant speed for the tests of the cornering-stiffness method (friction document 2.7)."""

import math

import numpy as np
from friction_twin import GRAVITY, TABLE_8

MASS, WHEELBASE, FRONT, YAW_INERTIA, STEERING_RATIO = 1544.0, 3.105, 1.45, 2980.0, 16.0
SHAPE, STIFFNESS, LIMIT = 1.4, 13.0, 1.0
SPEED = 33 / 3.6

CAR = TABLE_8 | {
    "body.mass": MASS,
    "body.wheelbase": WHEELBASE,
    "body.centre_of_gravity_to_front_axle": FRONT,
    "body.yaw_inertia": YAW_INERTIA,
    "steering.ratio": STEERING_RATIO,
}


def side_friction(angle: float) -> float:
    """Side force over load of a tyre at a slip angle [rad]."""
    return LIMIT * math.sin(SHAPE * math.atan(STIFFNESS * angle))


def double_lane_change(amplitude: float = 0.16, seed: int = 0) -> tuple[dict[str, np.ndarray], dict[str, np.ndarray]]:
    """Signals and truth of a double lane change at 33 km/h; ``amplitude`` is the road wheel's angle [rad]."""
    random = np.random.default_rng(seed)
    rear = WHEELBASE - FRONT
    load_f, load_r = MASS * GRAVITY * rear / WHEELBASE, MASS * GRAVITY * FRONT / WHEELBASE
    side, yaw_rate = 0.0, 0.0
    rows = []
    for k in range(7000):
        t = k * 0.001
        steer = 0.0
        for start, sign in ((1.0, 1.0), (3.5, -1.0)):
            if start <= t < start + 2.0:
                steer = sign * amplitude * math.sin(2 * math.pi * (t - start) / 2.0)
        front_angle = steer - math.atan((side + FRONT * yaw_rate) / SPEED)
        rear_angle = -math.atan((side - rear * yaw_rate) / SPEED)
        force_f, force_r = load_f * side_friction(front_angle), load_r * side_friction(rear_angle)
        lateral = (force_f + force_r) / MASS
        rows.append((steer, lateral, yaw_rate, front_angle, rear_angle, force_f / load_f, force_r / load_r))
        side += 0.001 * (lateral - SPEED * yaw_rate)
        yaw_rate += 0.001 * (FRONT * force_f - rear * force_r) / YAW_INERTIA
    table = np.array(rows).T
    length = table.shape[1]
    signals = {
        "steering_wheel_angle": STEERING_RATIO * table[0] + 0.01 * random.standard_normal(length),
        "lateral_acceleration": table[1] + 0.05 * random.standard_normal(length),
        "yaw_rate": table[2] + 0.002 * random.standard_normal(length),
        "longitudinal_acceleration": 0.05 * random.standard_normal(length),
    }
    for wheel in ("fl", "fr", "rl", "rr"):
        radius = TABLE_8[f"wheels.{wheel}.radius"]
        signals[f"wheel_speed_{wheel}"] = SPEED / radius + 0.05 * random.standard_normal(length)
    truth = dict(zip(("angle_front", "angle_rear", "used_front", "used_rear"), table[3:], strict=True))
    return signals, truth
