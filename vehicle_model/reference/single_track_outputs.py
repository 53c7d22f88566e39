"""Outputs of the single-track car: the block "plant" of the signal catalogue, compiled."""

from typing import Any

from numba import njit

from vehicle_model.interface import PLANT_OUTPUTS
from vehicle_model.reference.single_track_record import FRONT, REAR

_SLOWEST = 0.02
"""Speed [m/s] below which slip is reported as zero: it is not defined at standstill."""

_SPEED = PLANT_OUTPUTS.index("speed")
_POSITION_X = PLANT_OUTPUTS.index("position_x")
_POSITION_Y = PLANT_OUTPUTS.index("position_y")
_DISTANCE = PLANT_OUTPUTS.index("distance")
_YAW = PLANT_OUTPUTS.index("yaw_angle")
_ACCELERATION = PLANT_OUTPUTS.index("true_longitudinal_acceleration")
_WHEEL_SPEED = PLANT_OUTPUTS.index("true_wheel_speed_fl")
_WHEEL_CENTRE = PLANT_OUTPUTS.index("wheel_centre_speed_fl")
_SLIP = PLANT_OUTPUTS.index("slip_ratio_fl")
_LOAD = PLANT_OUTPUTS.index("vertical_load_fl")
_FORCE = PLANT_OUTPUTS.index("longitudinal_force_fl")
_FRICTION_USED = PLANT_OUTPUTS.index("friction_used_fl")
_FRICTION_LIMIT = PLANT_OUTPUTS.index("friction_limit_fl")
_BRAKE = PLANT_OUTPUTS.index("true_brake_torque_fl")
_DRIVE = PLANT_OUTPUTS.index("true_drive_torque_fl")
_MECHANICAL = PLANT_OUTPUTS.index("mechanical_energy")
_DISSIPATED = PLANT_OUTPUTS.index("dissipated_energy")
_DRIVE_ENERGY = PLANT_OUTPUTS.index("drive_energy")
_GRADE = PLANT_OUTPUTS.index("road_grade")
_BANK = PLANT_OUTPUTS.index("road_bank")


@njit(cache=True)
def write_outputs(p: Any, s: Any, drive: Any, grade: float, bank: float, out: Any) -> None:
    """Write the block after a tick; forces, loads, torques and acceleration are means over it, the rest its end.

    Both wheels of an axle turn alike; where the road differs under them, they share its force accordingly.
    """
    out[_SPEED], out[_DISTANCE] = s.speed, s.distance
    out[_POSITION_X], out[_POSITION_Y], out[_YAW] = s.x, s.y, s.yaw
    out[_ACCELERATION] = s.mean_acceleration
    for axle in range(2):
        rolling = p.radius[axle] * s.omega[axle]
        fastest = max(abs(rolling), abs(s.speed))
        slip = (rolling - s.speed) / fastest if fastest >= _SLOWEST else 0.0
        load = 0.5 * s.mean_load[axle]
        both = s.wheel_friction[2 * axle] + s.wheel_friction[2 * axle + 1]
        for i in range(2 * axle, 2 * axle + 2):
            force = s.mean_force[axle] * (s.wheel_friction[i] / both if both != 0.0 else 0.5)
            out[_WHEEL_SPEED + i], out[_WHEEL_CENTRE + i], out[_SLIP + i] = s.omega[axle], s.speed, slip
            out[_LOAD + i], out[_FORCE + i] = load, force
            out[_FRICTION_USED + i] = force / load if load > 0.0 else 0.0
            out[_FRICTION_LIMIT + i] = s.friction_limit[i]
            out[_BRAKE + i], out[_DRIVE + i] = 0.5 * s.mean_brake[axle], drive[i]
    out[_MECHANICAL] = (
        0.5 * p.mass * s.speed**2
        + 0.5 * (p.inertia[FRONT] * s.omega[FRONT] ** 2 + p.inertia[REAR] * s.omega[REAR] ** 2)
        + s.gravity_energy
    )
    out[_DISSIPATED] = s.brake_energy + s.tyre_energy + s.air_energy + s.rolling_energy
    out[_DRIVE_ENERGY] = s.drive_energy
    out[_GRADE], out[_BANK] = grade, bank
