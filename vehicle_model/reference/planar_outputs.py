"""Outputs of the planar car: the block "plant" of the signal catalogue, compiled."""

import math
from typing import Any

from numba import njit

from vehicle_model.interface import PLANT_OUTPUTS

_SLOWEST = 0.02
"""Speed [m/s] below which slip and side slip are reported as zero: they are not defined at standstill."""

_SPEED = PLANT_OUTPUTS.index("speed")
_LATERAL_SPEED = PLANT_OUTPUTS.index("lateral_speed")
_POSITION_X = PLANT_OUTPUTS.index("position_x")
_POSITION_Y = PLANT_OUTPUTS.index("position_y")
_DISTANCE = PLANT_OUTPUTS.index("distance")
_YAW = PLANT_OUTPUTS.index("yaw_angle")
_ROLL = PLANT_OUTPUTS.index("roll_angle")
_PITCH = PLANT_OUTPUTS.index("pitch_angle")
_YAW_RATE = PLANT_OUTPUTS.index("true_yaw_rate")
_ROLL_RATE = PLANT_OUTPUTS.index("true_roll_rate")
_PITCH_RATE = PLANT_OUTPUTS.index("true_pitch_rate")
_ACCELERATION_X = PLANT_OUTPUTS.index("true_longitudinal_acceleration")
_ACCELERATION_Y = PLANT_OUTPUTS.index("true_lateral_acceleration")
_SIDE_SLIP = PLANT_OUTPUTS.index("side_slip_angle")
_WHEEL_SPEED = PLANT_OUTPUTS.index("true_wheel_speed_fl")
_WHEEL_CENTRE = PLANT_OUTPUTS.index("wheel_centre_speed_fl")
_SLIP = PLANT_OUTPUTS.index("slip_ratio_fl")
_SLIP_ANGLE = PLANT_OUTPUTS.index("slip_angle_fl")
_LOAD = PLANT_OUTPUTS.index("vertical_load_fl")
_FORCE_X = PLANT_OUTPUTS.index("longitudinal_force_fl")
_FORCE_Y = PLANT_OUTPUTS.index("lateral_force_fl")
_FRICTION_USED = PLANT_OUTPUTS.index("friction_used_fl")
_FRICTION_LIMIT = PLANT_OUTPUTS.index("friction_limit_fl")
_ROAD_WHEEL = PLANT_OUTPUTS.index("true_road_wheel_angle_fl")
_BRAKE = PLANT_OUTPUTS.index("true_brake_torque_fl")
_DRIVE = PLANT_OUTPUTS.index("true_drive_torque_fl")
_MECHANICAL = PLANT_OUTPUTS.index("mechanical_energy")
_DISSIPATED = PLANT_OUTPUTS.index("dissipated_energy")
_DRIVE_ENERGY = PLANT_OUTPUTS.index("drive_energy")
_GRADE = PLANT_OUTPUTS.index("road_grade")
_BANK = PLANT_OUTPUTS.index("road_bank")


@njit(cache=True)
def write_outputs(p: Any, s: Any, drive: Any, grade: float, bank: float, out: Any) -> None:
    """Write the block after a tick; forces, loads, torques and accelerations are means over it, the rest its end.

    The catalogue's slip refers to the larger of rolling and travelling speed, the document's (2.2) to the latter.
    """
    out[_SPEED], out[_LATERAL_SPEED], out[_DISTANCE] = s.speed, s.lateral_speed, s.distance
    out[_POSITION_X], out[_POSITION_Y], out[_YAW] = s.x, s.y, s.yaw
    out[_ROLL], out[_ROLL_RATE] = s.roll, s.roll_rate
    # the catalogue's pitch is positive nose down
    out[_PITCH], out[_PITCH_RATE] = -s.nose_up, -s.nose_up_rate
    out[_YAW_RATE] = s.yaw_rate
    out[_ACCELERATION_X], out[_ACCELERATION_Y] = s.mean_x, s.mean_y
    moving = max(abs(s.speed), abs(s.lateral_speed)) >= _SLOWEST
    out[_SIDE_SLIP] = math.atan2(s.lateral_speed, abs(s.speed)) if moving else 0.0
    mechanical = 0.5 * p.mass * (s.speed**2 + s.lateral_speed**2) + 0.5 * p.yaw_inertia * s.yaw_rate**2
    for i in range(4):
        v_x = s.speed - s.yaw_rate * p.wheel_y[i]
        v_y = s.lateral_speed + s.yaw_rate * p.wheel_x[i]
        rolling = p.radius[i] * s.omega[i]
        fastest = max(abs(rolling), abs(v_x))
        out[_WHEEL_SPEED + i] = s.omega[i]
        out[_WHEEL_CENTRE + i] = v_x * math.cos(s.steer[i]) + v_y * math.sin(s.steer[i])
        out[_SLIP + i] = (rolling - v_x) / fastest if fastest >= _SLOWEST else 0.0
        out[_SLIP_ANGLE + i] = s.slip_angle[i]
        out[_LOAD + i], out[_FORCE_X + i], out[_FORCE_Y + i] = s.mean_load[i], s.mean_force_x[i], s.mean_force_y[i]
        out[_FRICTION_USED + i] = s.mean_force_x[i] / s.mean_load[i] if s.mean_load[i] > 0.0 else 0.0
        out[_FRICTION_LIMIT + i] = s.friction_limit[i]
        out[_ROAD_WHEEL + i] = s.steer[i]
        out[_BRAKE + i], out[_DRIVE + i] = s.mean_brake[i], drive[i]
        mechanical += 0.5 * p.inertia[i] * s.omega[i] ** 2
    out[_MECHANICAL] = mechanical + s.gravity_energy
    out[_DISSIPATED] = s.brake_energy + s.tyre_energy + s.air_energy + s.rolling_energy
    out[_DRIVE_ENERGY] = s.drive_energy
    out[_GRADE], out[_BANK] = grade, bank
