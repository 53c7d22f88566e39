"""Outputs of the MuJoCo car: the block "plant" of the signal catalogue, compiled."""

import math

import numpy as np
from numba import njit
from numpy.typing import NDArray

from vehicle_model.energy import mechanical_energy
from vehicle_model.interface import PLANT_OUTPUTS
from vehicle_model.plant_record import POSITION_STEER, POSITION_TRAVEL, VELOCITY_SPIN, Record

_SLOWEST = 0.02
"""Speed [m/s] below which slip is reported as zero: it is not defined at standstill."""

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
_ACCELERATION_Z = PLANT_OUTPUTS.index("true_vertical_acceleration")
_SIDE_SLIP = PLANT_OUTPUTS.index("side_slip_angle")
_WHEEL_SPEED = PLANT_OUTPUTS.index("true_wheel_speed_fl")
_WHEEL_CENTRE = PLANT_OUTPUTS.index("wheel_centre_speed_fl")
_SLIP_RATIO = PLANT_OUTPUTS.index("slip_ratio_fl")
_SLIP_ANGLE = PLANT_OUTPUTS.index("slip_angle_fl")
_LOAD = PLANT_OUTPUTS.index("vertical_load_fl")
_FORCE_X = PLANT_OUTPUTS.index("longitudinal_force_fl")
_FORCE_Y = PLANT_OUTPUTS.index("lateral_force_fl")
_FRICTION_USED = PLANT_OUTPUTS.index("friction_used_fl")
_FRICTION_LIMIT = PLANT_OUTPUTS.index("friction_limit_fl")
_ROAD_WHEEL_ANGLE = PLANT_OUTPUTS.index("true_road_wheel_angle_fl")
_TRAVEL = PLANT_OUTPUTS.index("suspension_travel_fl")
_BRAKE = PLANT_OUTPUTS.index("true_brake_torque_fl")
_DRIVE = PLANT_OUTPUTS.index("true_drive_torque_fl")
_MECHANICAL = PLANT_OUTPUTS.index("mechanical_energy")
_DISSIPATED = PLANT_OUTPUTS.index("dissipated_energy")
_DRIVE_ENERGY = PLANT_OUTPUTS.index("drive_energy")
_GRADE = PLANT_OUTPUTS.index("road_grade")
_BANK = PLANT_OUTPUTS.index("road_bank")


@njit(cache=True)
def write_outputs(
    p: Record, s: Record, q: NDArray[np.float64], v: NDArray[np.float64], out: NDArray[np.float64]
) -> None:
    """Write the block for the state after a tick; forces and torques are means over its last integration step."""
    forward_x, forward_y = math.cos(s.yaw), math.sin(s.yaw)
    speed = forward_x * v[0] + forward_y * v[1]
    lateral = forward_x * v[1] - forward_y * v[0]
    out[_SPEED], out[_LATERAL_SPEED] = speed, lateral
    out[_POSITION_X], out[_POSITION_Y], out[_DISTANCE] = q[0], q[1], s.distance
    r = s.rotation
    out[_YAW] = s.yaw
    out[_ROLL] = math.atan2(r[2, 1], r[2, 2])
    out[_PITCH] = -math.asin(r[2, 0])
    out[_ROLL_RATE], out[_PITCH_RATE], out[_YAW_RATE] = v[3], v[4], v[5]
    out[_ACCELERATION_X] = forward_x * s.acceleration[0] + forward_y * s.acceleration[1]
    out[_ACCELERATION_Y] = forward_x * s.acceleration[1] - forward_y * s.acceleration[0]
    out[_ACCELERATION_Z] = s.acceleration[2]
    moving = max(abs(speed), abs(lateral)) >= _SLOWEST
    out[_SIDE_SLIP] = math.atan2(lateral, abs(speed)) if moving else 0.0
    for i in range(4):
        heading_x, heading_y = s.forward[i, 0], s.forward[i, 1]
        along = heading_x * s.hub_velocity[i, 0] + heading_y * s.hub_velocity[i, 1]
        across = heading_x * s.hub_velocity[i, 1] - heading_y * s.hub_velocity[i, 0]
        omega = v[VELOCITY_SPIN[i]] - s.carrier_spin[i]
        rolling = p.radius[i] * omega
        fastest = max(abs(rolling), abs(along))
        out[_WHEEL_SPEED + i] = omega
        out[_WHEEL_CENTRE + i] = along
        out[_SLIP_RATIO + i] = (rolling - along) / fastest if fastest >= _SLOWEST else 0.0
        out[_SLIP_ANGLE + i] = math.atan2(across, abs(along)) if max(abs(across), abs(along)) >= _SLOWEST else 0.0
        load = s.load[i]
        out[_LOAD + i], out[_FORCE_X + i], out[_FORCE_Y + i] = load, s.force_x[i], s.force_y[i]
        out[_FRICTION_USED + i] = s.force_x[i] / load if load > 0.0 else 0.0
        out[_FRICTION_LIMIT + i] = s.peak_friction[i]
        out[_ROAD_WHEEL_ANGLE + i] = p.toe[i] + (q[POSITION_STEER[i]] if i < 2 else 0.0)
        out[_TRAVEL + i] = q[POSITION_TRAVEL[i]]
        out[_BRAKE + i], out[_DRIVE + i] = s.brake_torque[i], s.drive_torque[i]
    out[_MECHANICAL] = mechanical_energy(p, s, q, v)
    out[_DISSIPATED] = s.brake_energy + s.tyre_energy + s.rolling_energy + s.damper_energy + s.air_energy
    out[_DRIVE_ENERGY] = s.drive_energy
    out[_GRADE], out[_BANK] = s.grade, s.bank
