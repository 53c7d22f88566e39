"""One tick of the four-state car that the force document defines (15c), compiled: fourth-order Runge-Kutta over 1 ms.

Longitudinal and lateral speed, yaw rate, road-wheel angle. Linear tyres of constant stiffness at every angle,
small-angle terms at every steer, no rolling, drag or grade: as the document has it, far outside what a tyre does at 40
degrees.
"""

import math
from typing import Any

import numpy as np
from numba import njit

from vehicle_model.interface import TIME_STEP_S
from vehicle_model.reference.planar_outputs import write_outputs
from vehicle_model.reference.state_fields import WRITTEN_OUT

PARAMETER_RECORD = np.dtype(
    [
        ("mass", "f8"),
        ("yaw_inertia", "f8"),
        ("to_front", "f8"),
        ("to_rear", "f8"),
        ("stiffness", "f8", (2,)),
        ("time_constant", "f8"),
        ("steering_ratio", "f8"),
        ("load", "f8", (4,)),
        ("wheel_x", "f8", (4,)),
        ("wheel_y", "f8", (4,)),
        ("radius", "f8", (4,)),
        ("inertia", "f8", (4,)),  # 0: the document's wheels have no mass
    ]
)
STATE_RECORD = np.dtype([*WRITTEN_OUT, ("angle", "f8"), ("slopes", "f8", (4, 4)), ("trial", "f8", (4,))])
_SLOWEST = 0.3
"""Smallest speed [m/s] in the divisors of slip angles, which are not defined at standstill."""


@njit(cache=True)
def motion(p: Any, at: Any, force_f: float, force_r: float, command: float, slope: Any) -> None:
    """Right side of (15c): speeds, yaw rate and road-wheel angle ``at`` (shape (4,)), their rates into ``slope``."""
    speed = max(abs(at[0]), _SLOWEST)
    front = p.stiffness[0] * (at[3] - (at[1] + p.to_front * at[2]) / speed)
    rear = -p.stiffness[1] * (at[1] - p.to_rear * at[2]) / speed
    slope[0] = at[1] * at[2] + (force_f + force_r - front * at[3]) / p.mass
    slope[1] = -at[0] * at[2] + (force_f * at[3] + front + rear) / p.mass
    slope[2] = (p.to_front * (force_f * at[3] + front) - p.to_rear * rear) / p.yaw_inertia
    slope[3] = (command - at[3]) / p.time_constant


@njit(cache=True)
def _show_wheels(p: Any, s: Any) -> None:
    """Wheels roll freely: speeds, slip angles and side forces of the state at the end of the tick."""
    speed = max(abs(s.speed), _SLOWEST)
    front = p.stiffness[0] * (s.angle - (s.lateral_speed + p.to_front * s.yaw_rate) / speed)
    rear = -p.stiffness[1] * (s.lateral_speed - p.to_rear * s.yaw_rate) / speed
    for i in range(4):
        s.steer[i] = s.angle if i < 2 else 0.0
        drift = s.lateral_speed + p.wheel_x[i] * s.yaw_rate
        s.slip_angle[i] = drift / speed - s.steer[i]
        s.mean_force_y[i] = 0.5 * (front if i < 2 else rear)
        s.omega[i] = s.speed / p.radius[i]
        s.mean_load[i] = p.load[i]


@njit(cache=True)
def steered_track_tick(p_rows: Any, s_rows: Any, outputs: Any, brake: Any, drive: Any, wheel_angle: float) -> None:
    """Advance by 1 ms.

    Parameters
    ----------
    p_rows, s_rows : shape (1,), dtypes ``PARAMETER_RECORD`` and ``STATE_RECORD``
    outputs
        Block "plant" of the catalogue.
    brake, drive : shape (4,), N m
        Capacity of the brakes and drive torques per wheel; both act as forces of their axle.
    wheel_angle : rad
        Steering-wheel angle, over the ratio the command of the steering actuator.
    """
    p, s = p_rows[0], s_rows[0]
    h = TIME_STEP_S
    # a brake takes at most the motion that is left in this step
    still = p.mass * abs(s.speed) / (4.0 * h)
    for i in range(4):
        braking = math.copysign(min(max(brake[i], 0.0) / p.radius[i], still), s.speed)
        s.mean_force_x[i], s.mean_brake[i] = drive[i] / p.radius[i] - braking, braking * p.radius[i]
        s.brake_energy += h * braking * s.speed
        s.drive_energy += h * drive[i] / p.radius[i] * s.speed
    force_f, force_r = s.mean_force_x[0] + s.mean_force_x[1], s.mean_force_x[2] + s.mean_force_x[3]
    command = wheel_angle / p.steering_ratio
    before_x, before_y, before_turn, before_angle = s.speed, s.lateral_speed, s.yaw_rate, s.angle
    for stage in range(4):
        reach = 0.0 if stage == 0 else h if stage == 3 else 0.5 * h
        last = max(stage - 1, 0)
        s.trial[0] = before_x + reach * s.slopes[last, 0]
        s.trial[1] = before_y + reach * s.slopes[last, 1]
        s.trial[2] = before_turn + reach * s.slopes[last, 2]
        s.trial[3] = before_angle + reach * s.slopes[last, 3]
        motion(p, s.trial, force_f, force_r, command, s.slopes[stage])
    for i in range(4):
        rate = (s.slopes[0, i] + 2.0 * s.slopes[1, i] + 2.0 * s.slopes[2, i] + s.slopes[3, i]) / 6.0
        s.trial[i] = h * rate
    s.speed, s.lateral_speed = before_x + s.trial[0], before_y + s.trial[1]
    s.yaw_rate, s.angle = before_turn + s.trial[2], before_angle + s.trial[3]
    s.mean_x = s.trial[0] / h - 0.5 * (before_y * before_turn + s.lateral_speed * s.yaw_rate)
    s.mean_y = s.trial[1] / h + 0.5 * (before_x * before_turn + s.speed * s.yaw_rate)
    cosine, sine = math.cos(s.yaw), math.sin(s.yaw)
    s.x += h * (s.speed * cosine - s.lateral_speed * sine)
    s.y += h * (s.speed * sine + s.lateral_speed * cosine)
    s.yaw += h * s.yaw_rate
    s.distance += h * math.hypot(s.speed, s.lateral_speed)
    _show_wheels(p, s)
    drift_f, drift_r = s.lateral_speed + p.to_front * s.yaw_rate, s.lateral_speed - p.to_rear * s.yaw_rate
    side_f, side_r = 2.0 * s.mean_force_y[0], 2.0 * s.mean_force_y[2]
    s.tyre_energy -= h * (side_f * (drift_f - s.speed * s.angle) + side_r * drift_r + force_f * s.angle * drift_f)
    write_outputs(p, s, drive, 0.0, 0.0, outputs)


@njit(cache=True)
def show(p_rows: Any, s_rows: Any, outputs: Any) -> None:
    """Outputs of a car that has just been put on the road; parameters as in `steered_track_tick`."""
    _show_wheels(p_rows[0], s_rows[0])
    write_outputs(p_rows[0], s_rows[0], s_rows[0].mean_brake, 0.0, 0.0, outputs)
