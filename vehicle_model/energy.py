"""Energy account of the MuJoCo car, compiled.

What a force takes from the car in a step is the force times the mean of the velocities before and after it, which for a
force that is constant over the step is the change of kinetic energy itself. The account therefore closes but for the
integration's own error, and a missing or doubled force shows.
"""

import numpy as np
from numba import njit
from numpy.typing import NDArray

from vehicle_model.plant_record import POSITION_TRAVEL, VELOCITY_SPIN, VELOCITY_STEER, VELOCITY_TRAVEL, Record
from vehicle_model.suspension_forces import stop_energy


@njit(cache=True)
def update_first_moment(p: Record, s: Record) -> None:
    """First moment of mass about the body's origin [kg m], road axes."""
    r, c, m = s.rotation, p.sprung_centre, p.sprung_mass
    for k in range(3):
        moment = m * (r[k, 0] * c[0] + r[k, 1] * c[1] + r[k, 2] * c[2])
        for i in range(4):
            moment += p.unsprung_mass[i] * s.hub[i, k]
        s.moment[k] = moment


@njit(cache=True)
def keep_before(s: Record, v: NDArray[np.float64]) -> None:
    """Keep the velocities at the start of a step."""
    for k in range(3):
        s.velocity_before[k] = v[k]
        s.moment_before[k] = s.moment[k]
    for i in range(4):
        s.contact_velocity_before[i, 0] = s.contact_velocity[i, 0]
        s.contact_velocity_before[i, 1] = s.contact_velocity[i, 1]
        s.travel_rate_before[i] = v[VELOCITY_TRAVEL[i]]
        s.hub_rate_before[i] = s.hub_velocity[i, 2]
        s.carrier_rate_before[i] = s.carrier_rate[i]
        s.carrier_spin_before[i] = s.carrier_spin[i]
    s.steer_rate_before[0], s.steer_rate_before[1] = v[VELOCITY_STEER[0]], v[VELOCITY_STEER[1]]


@njit(cache=True)
def account(p: Record, s: Record, v: NDArray[np.float64], gravity: NDArray[np.float64], step: float) -> None:
    """Add to the account what the forces of the step that just ended did."""
    mass = p.sprung_mass
    tyres = dampers = rolling = 0.0
    for i in range(4):
        mass += p.unsprung_mass[i]
        mean_x = 0.5 * (s.contact_velocity_before[i, 0] + s.contact_velocity[i, 0])
        mean_y = 0.5 * (s.contact_velocity_before[i, 1] + s.contact_velocity[i, 1])
        turn = s.angular_velocity[2]
        if i < 2:
            steer_rate = 0.5 * (s.steer_rate_before[i] + v[VELOCITY_STEER[i]])
            turn += steer_rate
            dampers -= s.steer_torque[i] * steer_rate
        tyres -= s.ground_force[i, 0] * mean_x + s.ground_force[i, 1] * mean_y + s.moment_z[i] * turn
        rolling += s.rolling_torque[i] * 0.5 * (s.carrier_rate_before[i] + s.carrier_rate[i])
        dampers += s.damper_force[i] * 0.5 * (s.travel_rate_before[i] + v[VELOCITY_TRAVEL[i]])
        rising = s.road_slope[i] * mean_x
        dampers -= s.load_damping[i] * (0.5 * (s.hub_rate_before[i] + s.hub_velocity[i, 2]) - rising)
        if p.carrier_pitch[i] != 0.0:  # half shafts turn the wheel against the body, not against its carrier
            s.drive_energy += step * s.drive_torque[i] * 0.5 * (s.carrier_spin_before[i] + s.carrier_spin[i])
    s.tyre_energy += step * tyres
    s.rolling_energy += step * rolling
    s.damper_energy += step * dampers
    s.air_energy += step * s.air_power
    for k in range(3):
        # MuJoCo moves the car with its new velocity
        s.gravity_energy -= gravity[k] * (mass * step * v[k] + s.moment[k] - s.moment_before[k])


@njit(cache=True)
def mechanical_energy(p: Record, s: Record, q: NDArray[np.float64], v: NDArray[np.float64]) -> float:
    """Kinetic energy, energy of springs and tyres, and height energy since the reset [J]."""
    r, c, turn = s.rotation, p.sprung_centre, s.angular_velocity
    c_x = r[0, 0] * c[0] + r[0, 1] * c[1] + r[0, 2] * c[2]
    c_y = r[1, 0] * c[0] + r[1, 1] * c[1] + r[1, 2] * c[2]
    c_z = r[2, 0] * c[0] + r[2, 1] * c[1] + r[2, 2] * c[2]
    v_x = v[0] + turn[1] * c_z - turn[2] * c_y
    v_y = v[1] + turn[2] * c_x - turn[0] * c_z
    v_z = v[2] + turn[0] * c_y - turn[1] * c_x
    energy = p.sprung_mass * (v_x * v_x + v_y * v_y + v_z * v_z)
    for k in range(3):
        for m in range(3):
            energy += v[3 + k] * p.sprung_inertia[k, m] * v[3 + m]
    body_rate_squared = v[3] * v[3] + v[4] * v[4] + v[5] * v[5]
    for i in range(4):
        hub = s.hub_velocity[i]
        energy += p.unsprung_mass[i] * (hub[0] * hub[0] + hub[1] * hub[1] + hub[2] * hub[2])
        carrier_squared = body_rate_squared
        if i < 2:
            steer_rate = v[VELOCITY_STEER[i]]
            carrier_squared += (2.0 * v[5] + steer_rate) * steer_rate
        along = s.carrier_rate[i] - s.carrier_spin[i]  # of the body alone
        spin = along + v[VELOCITY_SPIN[i]]
        energy += p.transverse_inertia[i] * (carrier_squared - along * along) + p.spin_inertia[i] * spin * spin
        travel = q[POSITION_TRAVEL[i]]
        energy += (p.spring_rate[i] * travel + 2.0 * p.spring_preload[i]) * travel
        # each wheel holds half of the bar, whose energy is half the rate times the square of the difference
        energy += 0.5 * p.anti_roll_rate[i] * (travel - q[POSITION_TRAVEL[i ^ 1]]) ** 2
        if p.stops[i] != 0:
            energy += 2.0 * stop_energy(p, i, travel)
        deflection = p.wheel_z[i] + p.height - (q[2] + s.hub[i, 2]) + s.road_height[i]
        total = max(p.static_load[i] / p.vertical_stiffness[i] + deflection, 0.0)
        energy += p.vertical_stiffness[i] * total * total
    return 0.5 * energy + s.gravity_energy
