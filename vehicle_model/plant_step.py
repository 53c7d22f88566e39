"""One tick of the MuJoCo car, compiled: wheels, forces, MuJoCo's integration, energies, outputs.

Order of an integration step: the kinematics of this instant are known; loads follow from the hubs' heights; each
wheel's spin is integrated in sub-steps with the car's motion held, which gives the mean tyre forces; the generalised
forces go to MuJoCo, which integrates; the wheels' speeds are written back; the new kinematics close the energy account.
"""

import math

import numba
import numpy as np
from numba import njit
from numpy.typing import NDArray

from signals.record_memory import addresses_at, numbers_at, pointer, record_at
from vehicle_model.body_forces import add_air, add_steering, add_terms, add_tyres, clear, vertical_loads
from vehicle_model.energy import account, keep_before, update_first_moment
from vehicle_model.extension_terms import (
    BRAKE,
    BRAKE_FACTOR,
    DRIVE,
    FRICTION_FACTOR,
    SIDE_FORCE,
    TERM_RECORD,
    evaluate_terms,
)
from vehicle_model.extension_terms_file import MOST_TERMS
from vehicle_model.external_mujoco import mj_step
from vehicle_model.kinematics import update_kinematics
from vehicle_model.plant_outputs import write_outputs
from vehicle_model.plant_record import (
    PARAMETER_RECORD,
    POSITION_TRAVEL,
    STATE_RECORD,
    VELOCITY_SPIN,
    Record,
)
from vehicle_model.road import (
    JUMP_SIZE,
    PATCH_SIZE,
    POINT_SIZE,
    ROAD_RECORD,
    friction_at,
    height_at,
    slopes_at,
    water_factor_at,
    write_gravity,
)
from vehicle_model.roughness import POINTS
from vehicle_model.suspension_forces import add_suspension
from vehicle_model.tyres.coefficients import SURFACE_SIZE, TYRE_SIZE
from vehicle_model.tyres.kernel import PEAK_FORCE_X, PREPARED_SIZE, prepare
from vehicle_model.wheel_step import spin_wheel
from vehicle_model.wind import wind_at

TICK_S = 1e-3

# the list of addresses that every entry point gets
ADDRESS_NAMES = (
    "model",
    "data",
    "positions",
    "velocities",
    "forces",
    "gravity",
    "parameters",
    "state",
    "tyres",
    "prepared",
    "road",
    "jumps",
    "patches",
    "points",
    "surfaces",
    "heights",
    "outputs",
    "terms",
    "brake",
    "drive",
)
_MODEL, _DATA, _Q, _V, _FORCE, _GRAVITY, _PARAMETERS, _STATE = range(8)
_TYRES, _PREPARED, _ROAD, _JUMPS, _PATCHES, _POINTS, _SURFACES, _HEIGHTS = range(8, 16)
_OUTPUTS, _TERMS, _BRAKE, _DRIVE = range(16, 20)


@njit(cache=True)
def _meet_road(s: Record, q: NDArray[np.float64], addresses: NDArray[np.int64]) -> None:
    """Unevenness under each wheel; left and right wheels keep to their own track."""
    road = record_at(addresses[_ROAD], ROAD_RECORD)
    if road.rough == 0:
        for i in range(4):
            s.road_height[i] = s.road_slope[i] = 0.0
        return
    heights = numba.carray(pointer(addresses[_HEIGHTS]), (2, POINTS), numba.float64)
    for i in range(4):
        s.road_height[i], s.road_slope[i] = height_at(heights, i & 1, q[0] + s.hub[i, 0])


@njit(cache=True)
def _tyre(addresses: NDArray[np.int64], wheel: int) -> NDArray[np.float64]:
    return numbers_at(addresses[_TYRES] + 8 * TYRE_SIZE * wheel)


@njit(cache=True)
def _prepared(addresses: NDArray[np.int64], wheel: int) -> NDArray[np.float64]:
    return numbers_at(addresses[_PREPARED] + 8 * PREPARED_SIZE * wheel)


@njit(cache=True)
def _prepare_tyres(
    p: Record,
    s: Record,
    q: NDArray[np.float64],
    addresses: NDArray[np.int64],
    time: float,
) -> None:
    """Friction under each wheel and the rows that hold for this step; direction of gravity."""
    road = record_at(addresses[_ROAD], ROAD_RECORD)
    jumps = numba.carray(pointer(addresses[_JUMPS]), (road.jumps, JUMP_SIZE), numba.float64)
    patches = numba.carray(pointer(addresses[_PATCHES]), (road.patches, PATCH_SIZE), numba.float64)
    points = numba.carray(pointer(addresses[_POINTS]), (road.points, POINT_SIZE), numba.float64)
    gravity = numbers_at(addresses[_GRAVITY])
    s.grade, s.bank = slopes_at(road, points, q[0])
    write_gravity(road.gravity, s.grade, s.bank, gravity)
    for i in range(4):
        x, y = q[0] + s.hub[i, 0], q[1] + s.hub[i, 1]
        friction, surface = friction_at(road, jumps, patches, x, y, time)
        speed = math.sqrt(s.hub_velocity[i, 0] ** 2 + s.hub_velocity[i, 1] ** 2)
        friction *= water_factor_at(road, patches, x, y, speed)
        speed = math.copysign(speed, s.forward[i, 0] * s.hub_velocity[i, 0] + s.forward[i, 1] * s.hub_velocity[i, 1])
        load = max(s.load[i], 1e-3)
        camber = math.asin(s.axis_z[i])
        if p.camber[i] != 0.0 or p.camber_gain[i] != 0.0:
            camber += p.camber[i] + p.camber_gain[i] * q[POSITION_TRAVEL[i]]
        friction *= p.friction_factor[i]
        if p.terms > 0:
            friction *= max(1.0 + s.added[FRICTION_FACTOR, i], 0.0)
        tyre, prepared = _tyre(addresses, i), _prepared(addresses, i)
        on = numbers_at(addresses[_SURFACES] + 8 * SURFACE_SIZE * surface)
        prepare(tyre, on, friction, load, speed, camber, prepared)
        s.peak_friction[i] = prepared[PEAK_FORCE_X] / load


@njit(cache=True)
def _integrate(
    p: Record,
    s: Record,
    addresses: NDArray[np.int64],
    steer: float,
    time: float,
    step: float,
) -> None:
    """One step of MuJoCo with the forces of this instant."""
    q = numbers_at(addresses[_Q])
    v = numbers_at(addresses[_V])
    force = numbers_at(addresses[_FORCE])
    gravity = numbers_at(addresses[_GRAVITY])
    brake, drive = numbers_at(addresses[_BRAKE]), numbers_at(addresses[_DRIVE])
    road = record_at(addresses[_ROAD], ROAD_RECORD)

    _meet_road(s, q, addresses)
    vertical_loads(p, s, q)
    if p.terms > 0:
        terms = numba.carray(pointer(addresses[_TERMS]), MOST_TERMS, TERM_RECORD)
        evaluate_terms(p, s, terms, q, v, brake, drive, steer, time, step)
    _prepare_tyres(p, s, q, addresses, time)
    for i in range(4):
        heading_x, heading_y = s.forward[i, 0], s.forward[i, 1]
        at_x, at_y = s.contact_velocity[i, 0], s.contact_velocity[i, 1]
        along, across = heading_x * at_x + heading_y * at_y, heading_x * at_y - heading_y * at_x
        spin = v[VELOCITY_SPIN[i]] - s.carrier_spin[i]
        braking, driving = max(brake[i], 0.0), drive[i]
        if p.terms > 0:
            braking = max(braking * (1.0 + s.added[BRAKE_FACTOR, i]) + s.added[BRAKE, i], 0.0)
            driving += s.added[DRIVE, i]
        tyre, prepared = _tyre(addresses, i), _prepared(addresses, i)
        s.new_spin[i] = spin_wheel(p, s, i, tyre, prepared, spin, braking, driving, along, across, step)
        if p.terms > 0:
            s.force_y[i] += s.added[SIDE_FORCE, i]

    clear(force)
    add_suspension(p, s, q, v, force, step)
    add_steering(p, s, q, v, steer, force)
    add_tyres(p, s, q, force)
    wind_x, wind_y = wind_at(road, time)
    add_air(p, s, v, q[2], wind_x, wind_y, force)
    if p.terms > 0:
        add_terms(s, v, force)
    for i in range(4):
        change = (s.new_spin[i] - (v[VELOCITY_SPIN[i]] - s.carrier_spin[i])) / step + s.carrier_acceleration[i]
        force[VELOCITY_SPIN[i]] = p.spin_inertia[i] * change

    keep_before(s, v)
    mj_step(addresses[_MODEL], addresses[_DATA])
    for i in range(4):
        v[VELOCITY_SPIN[i]] = s.new_spin[i]
    update_kinematics(p, s, q, v)
    for i in range(4):
        if p.carrier_pitch[i] != 0.0:
            v[VELOCITY_SPIN[i]] += s.carrier_spin[i]
    update_first_moment(p, s)
    account(p, s, v, gravity, step)
    for i in range(4):
        s.carrier_acceleration[i] = (s.carrier_rate[i] - s.carrier_rate_before[i]) / step
    before = math.sqrt(s.velocity_before[0] ** 2 + s.velocity_before[1] ** 2)
    s.distance += 0.5 * step * (before + math.sqrt(v[0] * v[0] + v[1] * v[1]))


@njit(cache=True)
def advance(memory: int, steer: float, time: float, ticks: int) -> None:
    """Advance by ``ticks`` milliseconds with constant inputs and write the outputs.

    Parameters
    ----------
    memory
        Address of the list of addresses of ``ADDRESS_NAMES``. Of these, brake and drive are the torque that each brake
        can transmit and the drive torque [N m].
    steer : rad
        Steering-wheel angle.
    time : s
        Time of the run at the start.
    """
    addresses = addresses_at(memory)
    p = record_at(addresses[_PARAMETERS], PARAMETER_RECORD)
    s = record_at(addresses[_STATE], STATE_RECORD)
    q = numbers_at(addresses[_Q])
    v = numbers_at(addresses[_V])
    out = numbers_at(addresses[_OUTPUTS])
    step = TICK_S / p.steps
    for tick in range(ticks):
        start_x, start_y, start_z = v[0], v[1], v[2]
        for part in range(p.steps):
            _integrate(p, s, addresses, steer, time + tick * TICK_S + part * step, step)
        s.acceleration[0] = (v[0] - start_x) / TICK_S
        s.acceleration[1] = (v[1] - start_y) / TICK_S
        s.acceleration[2] = (v[2] - start_z) / TICK_S
    _meet_road(s, q, addresses)
    write_outputs(p, s, q, v, out)


@njit(cache=True)
def refresh(memory: int, time: float) -> None:
    """Kinematics, loads, friction and outputs of a state that was set from outside."""
    addresses = addresses_at(memory)
    p = record_at(addresses[_PARAMETERS], PARAMETER_RECORD)
    s = record_at(addresses[_STATE], STATE_RECORD)
    q = numbers_at(addresses[_Q])
    v = numbers_at(addresses[_V])
    out = numbers_at(addresses[_OUTPUTS])
    update_kinematics(p, s, q, v)
    update_first_moment(p, s)
    _meet_road(s, q, addresses)
    vertical_loads(p, s, q)
    _prepare_tyres(p, s, q, addresses, time)
    write_outputs(p, s, q, v, out)


@njit(cache=True)
def support_forces(memory: int, steer: float, time: float) -> None:
    """Generalised forces of springs and loads alone, for the static equilibrium."""
    addresses = addresses_at(memory)
    p = record_at(addresses[_PARAMETERS], PARAMETER_RECORD)
    s = record_at(addresses[_STATE], STATE_RECORD)
    q = numbers_at(addresses[_Q])
    v = numbers_at(addresses[_V])
    force = numbers_at(addresses[_FORCE])
    update_kinematics(p, s, q, v)
    _meet_road(s, q, addresses)
    vertical_loads(p, s, q)
    _prepare_tyres(p, s, q, addresses, time)
    clear(force)
    add_suspension(p, s, q, v, force, 0.0)
    add_steering(p, s, q, v, steer, force)
    add_tyres(p, s, q, force)
