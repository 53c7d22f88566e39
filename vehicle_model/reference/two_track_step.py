"""One tick of the two-track car that the vertical-load document puts in place of its simulator (its 4.1), compiled.

Speed, side speed, yaw rate, roll angle and roll rate; Fiala tyres with a constant cornering stiffness; loads from the
full form of the axle's roll balance (11c) and the quasi-static pitch (14c), with the forces of the step before. Steps
of 1 ms, semi-implicit Euler. Wheels roll freely: drive and brake torques act as forces at the contacts, no tyre slips
along its heading, and the side force does not know of the longitudinal one.
"""

import math
from typing import Any

from numba import njit

from vehicle_model.interface import TIME_STEP_S
from vehicle_model.reference.planar_outputs import write_outputs
from vehicle_model.road import friction_at, slopes_at

_SLOWEST = 0.3
"""Smallest speed [m/s] in the divisors of slip angles, which are not defined at standstill."""


@njit(cache=True)
def fiala_side_force(slip_angle: float, cornering_stiffness: float, capacity: float) -> float:
    """Side force [N] to the left at a slip angle positive where the wheel drifts to its left; capacity is mu F_z."""
    if capacity <= 0.0:
        return 0.0
    tangent = math.tan(slip_angle)
    share = cornering_stiffness * abs(tangent) / (3.0 * capacity)
    if share >= 1.0:
        return -math.copysign(capacity, slip_angle)
    return -cornering_stiffness * tangent * (1.0 - share + share * share / 3.0)


@njit(cache=True)
def load_wheels(p: Any, s: Any, weight: float) -> None:
    """Wheel loads (15c) with the full lateral form (11c), clipped at zero, into ``mean_load``; order fl fr rl rr."""
    wheelbase = p.to_front + p.to_rear
    along = p.mass * s.acceleration_x * p.height / wheelbase
    roll_moment = p.roll_stiffness * s.roll + p.roll_damping * s.roll_rate
    for axle in range(2):
        static = weight * (p.to_rear if axle == 0 else p.to_front) / wheelbase
        both = static - along if axle == 0 else static + along
        difference = 2.0 / p.track * (s.axle_side_force[axle] * p.roll_centre + p.roll_share[axle] * roll_moment)
        s.mean_load[2 * axle] = max(0.0, 0.5 * (both - difference))
        s.mean_load[2 * axle + 1] = max(0.0, 0.5 * (both + difference))


@njit(cache=True)
def _push_wheels(p: Any, s: Any, brake: Any, drive: Any) -> float:
    """Longitudinal forces of brakes and drive within the grip; returns their sum [N]."""
    total = 0.0
    for i in range(4):
        capacity = s.friction_limit[i] * s.mean_load[i]
        # a brake takes at most the motion that is left in this step
        still = p.mass * abs(s.speed) / (4.0 * TIME_STEP_S)
        braking = math.copysign(min(max(brake[i], 0.0) / p.radius[i], still), s.speed)
        force = min(max(drive[i] / p.radius[i] - braking, -capacity), capacity)
        s.mean_force_x[i] = force
        s.mean_brake[i] = braking * p.radius[i]
        s.brake_energy += TIME_STEP_S * braking * s.speed
        s.drive_energy += TIME_STEP_S * drive[i] / p.radius[i] * s.speed
        total += force
    return total


@njit(cache=True)
def _turn_wheels(p: Any, s: Any) -> tuple[float, float]:
    """Slip angles and side forces; returns the sums of both axles along the car's side [N], front times cos(d)."""
    for i in range(4):
        v_x = s.speed - s.yaw_rate * p.wheel_y[i]
        v_y = s.lateral_speed + s.yaw_rate * p.wheel_x[i]
        s.slip_angle[i] = math.atan2(v_y, max(abs(v_x), _SLOWEST)) - s.steer[i]
        stiffness = p.cornering_stiffness[0 if i < 2 else 1]
        s.mean_force_y[i] = fiala_side_force(s.slip_angle[i], stiffness, s.friction_limit[i] * s.mean_load[i])
        s.omega[i] = (v_x * math.cos(s.steer[i]) + v_y * math.sin(s.steer[i])) / p.radius[i]
    front = (s.mean_force_y[0] + s.mean_force_y[1]) * math.cos(s.steer[0])
    return front, s.mean_force_y[2] + s.mean_force_y[3]


@njit(cache=True)
def _look_at_road(p: Any, s: Any, road: Any, jumps: Any, patches: Any, time: float) -> None:
    cosine, sine = math.cos(s.yaw), math.sin(s.yaw)
    for i in range(4):
        x = s.x + p.wheel_x[i] * cosine - p.wheel_y[i] * sine
        y = s.y + p.wheel_x[i] * sine + p.wheel_y[i] * cosine
        friction, _ = friction_at(road, jumps, patches, x, y, time)
        s.friction_limit[i] = friction * p.friction_factor[i]


@njit(cache=True)
def _move(p: Any, s: Any, front: float, rear: float, along: float, gravity: float) -> None:
    """Motion over 1 ms; ``along`` is the sum of the forces along the car but the steered wheels' side forces [N]."""
    h = TIME_STEP_S
    s.acceleration_x = (along - (s.mean_force_y[0] + s.mean_force_y[1]) * math.sin(s.steer[0])) / p.mass
    acceleration_y = (front + rear) / p.mass
    s.mean_x, s.mean_y = s.acceleration_x, acceleration_y
    s.axle_side_force[0], s.axle_side_force[1] = front, rear
    before_x, before_y, turn = s.speed, s.lateral_speed, s.yaw_rate
    s.speed += h * (s.acceleration_x + before_y * turn)
    s.lateral_speed += h * (acceleration_y - before_x * turn)
    s.yaw_rate += h * (p.to_front * front - p.to_rear * rear) / p.yaw_inertia
    overturning = p.sprung_mass * p.roll_arm * (acceleration_y + gravity * s.roll)
    resisting = p.roll_stiffness * s.roll + p.roll_damping * s.roll_rate
    s.roll_rate += h * (overturning - resisting + p.road_roll_moment) / p.roll_inertia
    s.roll += h * s.roll_rate
    cosine, sine = math.cos(s.yaw), math.sin(s.yaw)
    s.x += h * (s.speed * cosine - s.lateral_speed * sine)
    s.y += h * (s.speed * sine + s.lateral_speed * cosine)
    s.yaw += h * s.yaw_rate
    s.distance += h * math.hypot(s.speed, s.lateral_speed)
    s.tyre_energy -= h * (front * (before_y + turn * p.to_front) + rear * (before_y - turn * p.to_rear))
    s.tyre_energy -= h * (s.acceleration_x * p.mass - along) * before_x


@njit(cache=True)
def two_track_tick(
    p_rows: Any,
    s_rows: Any,
    road_rows: Any,
    jumps: Any,
    patches: Any,
    points: Any,
    outputs: Any,
    brake: Any,
    drive: Any,
    wheel_angle: float,
    time: float,
) -> None:
    """Advance by 1 ms.

    Parameters
    ----------
    p_rows, s_rows : shape (1,), dtypes ``PARAMETER_RECORD`` and ``STATE_RECORD``
    road_rows, jumps, patches, points
        Tables of the road; its friction is the tyres', its grade pulls at the centre of gravity, a bank is not seen.
    outputs
        Block "plant" of the catalogue.
    brake, drive : shape (4,), N m
        Capacity of the brakes and drive torques per wheel.
    wheel_angle : rad
        Steering-wheel angle, positive to the left.
    time : s
    """
    p, s, road = p_rows[0], s_rows[0], road_rows[0]
    grade, bank = slopes_at(road, points, s.x)
    steer = wheel_angle / p.steering_ratio + p.steering_offset
    s.steer[0] = s.steer[1] = steer
    weight = p.mass * road.gravity / math.sqrt(1.0 + grade * grade + bank * bank)
    load_wheels(p, s, weight)
    _look_at_road(p, s, road, jumps, patches, time)
    along = _push_wheels(p, s, brake, drive) - weight * grade
    front, rear = _turn_wheels(p, s)
    s.gravity_energy += TIME_STEP_S * weight * grade * s.speed
    _move(p, s, front, rear, along, road.gravity)
    write_outputs(p, s, drive, grade, bank, outputs)


@njit(cache=True)
def refresh(p_rows: Any, s_rows: Any, road_rows: Any, jumps: Any, patches: Any, points: Any, outputs: Any) -> None:
    """Loads at rest and outputs of a car that has just been put on the road; parameters as in `two_track_tick`."""
    p, s, road = p_rows[0], s_rows[0], road_rows[0]
    grade, bank = slopes_at(road, points, s.x)
    load_wheels(p, s, p.mass * road.gravity / math.sqrt(1.0 + grade * grade + bank * bank))
    _look_at_road(p, s, road, jumps, patches, 0.0)
    write_outputs(p, s, s.mean_brake, grade, bank, outputs)
