"""Kinematics of body and wheels from MuJoCo's positions and velocities, compiled.

The joints of a wheel sit in one body whose centre only travels along a line fixed to the body, so that everything
follows from the body's motion in closed form; MuJoCo's own frames are not needed. The spin coordinate is the turning of
the wheel against the body; against its carrier, which may pitch with the travel, it turns by ``carrier_spin`` less.
"""

import math

import numpy as np
from numba import njit
from numpy.typing import NDArray

from vehicle_model.plant_record import POSITION_STEER, POSITION_TRAVEL, VELOCITY_STEER, VELOCITY_TRAVEL, Record


@njit(cache=True)
def update_kinematics(p: Record, s: Record, q: NDArray[np.float64], v: NDArray[np.float64]) -> None:
    """Write the kinematic part of the state ``s`` for positions ``q`` and velocities ``v``."""
    w, x, y, z = q[3], q[4], q[5], q[6]
    r = s.rotation
    r[0, 0], r[0, 1], r[0, 2] = 1.0 - 2.0 * (y * y + z * z), 2.0 * (x * y - w * z), 2.0 * (x * z + w * y)
    r[1, 0], r[1, 1], r[1, 2] = 2.0 * (x * y + w * z), 1.0 - 2.0 * (x * x + z * z), 2.0 * (y * z - w * x)
    r[2, 0], r[2, 1], r[2, 2] = 2.0 * (x * z - w * y), 2.0 * (y * z + w * x), 1.0 - 2.0 * (x * x + y * y)
    # MuJoCo gives the angular velocity in body axes
    a, b, c = v[3], v[4], v[5]
    turn_x = r[0, 0] * a + r[0, 1] * b + r[0, 2] * c
    turn_y = r[1, 0] * a + r[1, 1] * b + r[1, 2] * c
    turn_z = r[2, 0] * a + r[2, 1] * b + r[2, 2] * c
    s.angular_velocity[0], s.angular_velocity[1], s.angular_velocity[2] = turn_x, turn_y, turn_z
    yaw = math.atan2(r[1, 0], r[0, 0])
    s.yaw = yaw + 2.0 * math.pi * round((s.yaw - yaw) / (2.0 * math.pi))

    for i in range(4):
        travel, travel_rate = q[POSITION_TRAVEL[i]], v[VELOCITY_TRAVEL[i]]
        b_x, b_y, b_z = p.wheel_x[i], p.wheel_y[i], p.wheel_z[i] + travel
        slide = s.slide[i]
        slide[0], slide[1], slide[2] = r[0, 2], r[1, 2], r[2, 2]
        if p.guided[i] != 0:
            a_x, a_y = p.slide_x[i], p.slide_y[i]
            b_x += a_x * travel
            b_y += a_y * travel
            for k in range(3):
                slide[k] += a_x * r[k, 0] + a_y * r[k, 1]
        h_x = r[0, 0] * b_x + r[0, 1] * b_y + r[0, 2] * b_z
        h_y = r[1, 0] * b_x + r[1, 1] * b_y + r[1, 2] * b_z
        h_z = r[2, 0] * b_x + r[2, 1] * b_y + r[2, 2] * b_z
        s.hub[i, 0], s.hub[i, 1], s.hub[i, 2] = h_x, h_y, h_z
        velocity_x = v[0] + turn_y * h_z - turn_z * h_y + travel_rate * slide[0]
        velocity_y = v[1] + turn_z * h_x - turn_x * h_z + travel_rate * slide[1]
        velocity_z = v[2] + turn_x * h_y - turn_y * h_x + travel_rate * slide[2]
        s.hub_velocity[i, 0], s.hub_velocity[i, 1], s.hub_velocity[i, 2] = velocity_x, velocity_y, velocity_z

        angle = p.toe[i]
        carrier_x, carrier_y, carrier_z = turn_x, turn_y, turn_z
        if i < 2:
            angle += q[POSITION_STEER[i]]
            rate = v[VELOCITY_STEER[i]]
            carrier_x += rate * r[0, 2]
            carrier_y += rate * r[1, 2]
            carrier_z += rate * r[2, 2]
        sine, cosine = math.sin(angle), math.cos(angle)
        s.carrier_cosine[i] = cosine
        if p.carrier_pitch[i] != 0.0:
            pitching = p.carrier_pitch[i] * travel_rate
            carrier_x += pitching * r[0, 1]
            carrier_y += pitching * r[1, 1]
            carrier_z += pitching * r[2, 1]
            s.carrier_spin[i] = pitching * cosine
        else:
            s.carrier_spin[i] = 0.0
        axis_x = r[0, 1] * cosine - r[0, 0] * sine
        axis_y = r[1, 1] * cosine - r[1, 0] * sine
        s.axis_z[i] = r[2, 1] * cosine - r[2, 0] * sine
        length = math.sqrt(axis_x * axis_x + axis_y * axis_y)
        s.forward[i, 0], s.forward[i, 1] = axis_y / length, -axis_x / length
        s.carrier_rate[i] = carrier_x * axis_x + carrier_y * axis_y + carrier_z * s.axis_z[i]
        # the carrier's point at the contact lies below the hub by the hub's height
        height = q[2] + h_z
        s.contact_velocity[i, 0] = velocity_x - carrier_y * height
        s.contact_velocity[i, 1] = velocity_y + carrier_x * height
        s.contact_velocity[i, 2] = velocity_z
