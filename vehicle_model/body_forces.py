"""Forces on the car as generalised forces of MuJoCo's coordinates, compiled.

Coordinates: position of the body's origin in road axes, rotation about the body's axes, then per wheel travel, steer
(front) and spin. The torque of a spin coordinate is the wheel's whole change of angular momentum, which the wheel's own
integration gives; the reaction on the body needs no term of its own in these coordinates.
"""

import math

import numpy as np
from numba import njit
from numpy.typing import NDArray

from vehicle_model.extension_terms import BODY_X, BODY_Y, YAW
from vehicle_model.plant_record import (
    POSITION_STEER,
    VELOCITIES,
    VELOCITY_STEER,
    VELOCITY_TRAVEL,
    Record,
)


@njit(cache=True)
def clear(force: NDArray[np.float64]) -> None:
    """Set the generalised forces to zero."""
    for k in range(VELOCITIES):
        force[k] = 0.0


@njit(cache=True)
def vertical_loads(p: Record, s: Record, q: NDArray[np.float64]) -> None:
    """Loads of the four tyres from the heights of their hubs; a lifted tyre has none."""
    for i in range(4):
        deflection = p.wheel_z[i] + p.height - (q[2] + s.hub[i, 2]) + s.road_height[i]
        spring = p.static_load[i] + p.vertical_stiffness[i] * deflection
        rising = s.road_slope[i] * s.hub_velocity[i, 0]
        load = spring - p.vertical_damping[i] * (s.hub_velocity[i, 2] - rising)
        s.load[i] = load if spring > 0.0 and load > 0.0 else 0.0
        s.load_damping[i] = s.load[i] - max(spring, 0.0)


@njit(cache=True)
def _add_world_force(
    s: Record,
    force: NDArray[np.float64],
    f_x: float,
    f_y: float,
    f_z: float,
    at_x: float,
    at_y: float,
    at_z: float,
    moment_x: float,
    moment_y: float,
    moment_z: float,
) -> None:
    """Add a force at a place (from the body's origin) and a moment, all in road axes, to the body's coordinates."""
    force[0] += f_x
    force[1] += f_y
    force[2] += f_z
    m_x = at_y * f_z - at_z * f_y + moment_x
    m_y = at_z * f_x - at_x * f_z + moment_y
    m_z = at_x * f_y - at_y * f_x + moment_z
    r = s.rotation
    force[3] += r[0, 0] * m_x + r[1, 0] * m_y + r[2, 0] * m_z
    force[4] += r[0, 1] * m_x + r[1, 1] * m_y + r[2, 1] * m_z
    force[5] += r[0, 2] * m_x + r[1, 2] * m_y + r[2, 2] * m_z


@njit(cache=True)
def steering_angle(p: Record, wheel: int, steer: float) -> float:
    """Road-wheel angle of a front wheel that the steering linkage asks for at a steering-wheel angle [rad]."""
    angle = steer / p.steering_ratio
    if p.ackermann != 0.0:
        # cot(inner) = cot(mean) - track / (2 wheelbase): the same formula for both sides with the sign of the side
        side = -1.0 if wheel == 0 else 1.0
        tangent = math.tan(angle)
        full = math.atan2(tangent, 1.0 + side * tangent * p.half_track_over_wheelbase)
        angle += p.ackermann * (full - angle)
    return angle + p.steering_offset


@njit(cache=True)
def add_steering(
    p: Record,
    s: Record,
    q: NDArray[np.float64],
    v: NDArray[np.float64],
    steer: float,
    force: NDArray[np.float64],
) -> None:
    """Torques of the steering linkage on the front wheels."""
    for i in range(2):
        wanted = steering_angle(p, i, steer)
        torque = p.steering_stiffness * (wanted - q[POSITION_STEER[i]]) - p.steering_damping * v[VELOCITY_STEER[i]]
        s.steer_torque[i] = torque
        force[VELOCITY_STEER[i]] += torque


@njit(cache=True)
def add_tyres(p: Record, s: Record, q: NDArray[np.float64], force: NDArray[np.float64]) -> None:
    """Tyre forces and moments of the last wheel integration, and the loads."""
    r = s.rotation
    for i in range(4):
        forward_x, forward_y = s.forward[i, 0], s.forward[i, 1]
        f_x = s.force_x[i] * forward_x - s.force_y[i] * forward_y
        f_y = s.force_x[i] * forward_y + s.force_y[i] * forward_x
        f_z = s.load[i]
        s.ground_force[i, 0], s.ground_force[i, 1] = f_x, f_y
        # the load stands on the uneven road: what lifts the wheel is taken from the car's motion
        f_x -= f_z * s.road_slope[i]
        # rolling resistance is a moment about the wheel's axis, which lies to the left of its heading
        moment_x, moment_y = s.rolling_torque[i] * forward_y, -s.rolling_torque[i] * forward_x
        height = q[2] + s.hub[i, 2]
        _add_world_force(
            s,
            force,
            f_x,
            f_y,
            f_z,
            s.hub[i, 0],
            s.hub[i, 1],
            s.hub[i, 2] - height,
            moment_x,
            moment_y,
            s.moment_z[i],
        )
        slide = s.slide[i]
        force[VELOCITY_TRAVEL[i]] += f_x * slide[0] + f_y * slide[1] + f_z * slide[2]
        if i < 2:
            # moment about the steer axis: the force acts below the hub by its height
            force[VELOCITY_STEER[i]] += (
                (height * f_y + moment_x) * r[0, 2] + (moment_y - height * f_x) * r[1, 2] + s.moment_z[i] * r[2, 2]
            )


@njit(cache=True)
def add_air(
    p: Record,
    s: Record,
    v: NDArray[np.float64],
    height: float,
    wind_x: float,
    wind_y: float,
    force: NDArray[np.float64],
) -> None:
    """Drag, side force and lift; the power that they take from the car [W] goes into the state.

    Parameters
    ----------
    height : m
        Height of the body's origin over the road.
    wind_x, wind_y : m/s
        Velocity of the air in road axes.
    """
    air_x, air_y = v[0] - wind_x, v[1] - wind_y
    speed = math.sqrt(air_x * air_x + air_y * air_y)
    f_x, f_y = -p.drag * speed * air_x, -p.drag * speed * air_y
    forward_x, forward_y = math.cos(s.yaw), math.sin(s.yaw)
    yaw_moment = 0.0
    if p.side_force != 0.0:
        across = forward_x * air_y - forward_y * air_x
        f_x += p.side_force * speed * across * forward_y
        f_y -= p.side_force * speed * across * forward_x
        yaw_moment = -p.side_force * speed * across * p.side_force_position
    above = p.drag_height - height
    _add_world_force(s, force, f_x, f_y, 0.0, 0.0, 0.0, above, 0.0, 0.0, yaw_moment)
    turn = s.angular_velocity
    power = -f_x * (v[0] + turn[1] * above) - f_y * (v[1] - turn[0] * above) - yaw_moment * turn[2]
    if p.lift_front != 0.0 or p.lift_rear != 0.0:
        along = (forward_x * air_x + forward_y * air_y) ** 2
        for axle in range(2):
            lift = (p.lift_front if axle == 0 else p.lift_rear) * along
            arm = p.wheel_x[2 * axle]
            _add_world_force(s, force, 0.0, 0.0, lift, arm * forward_x, arm * forward_y, 0.0, 0.0, 0.0, 0.0)
            power -= lift * (v[2] + turn[0] * arm * forward_y - turn[1] * arm * forward_x)
    s.air_power = power


@njit(cache=True)
def add_terms(s: Record, v: NDArray[np.float64], force: NDArray[np.float64]) -> None:
    """Forces and yaw moment of the added terms, at the body's origin; the air's account takes their power."""
    forward_x, forward_y = math.cos(s.yaw), math.sin(s.yaw)
    along, across, yaw_moment = s.added[BODY_X, 0], s.added[BODY_Y, 0], s.added[YAW, 0]
    f_x, f_y = forward_x * along - forward_y * across, forward_y * along + forward_x * across
    _add_world_force(s, force, f_x, f_y, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, yaw_moment)
    s.air_power -= f_x * v[0] + f_y * v[1] + yaw_moment * s.angular_velocity[2]
