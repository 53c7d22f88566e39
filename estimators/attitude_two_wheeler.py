"""Two-wheeler of the attitude document, compiled: motion, specific forces, roll balance, wheel loads (its 2.2 to 2.7).

Vehicle axes x forward, y left, z up; roll positive to the right, pitch positive nose down, elevation angle positive
nose down against the road. The first embodiment has no pitch gyroscope: its pitch rate follows from r tan(phi).
"""

import math
from collections.abc import Mapping
from typing import Any

import numpy as np
from numba import njit
from numpy.typing import NDArray

from estimators.attitude_forms import (
    B_PITCH,
    B_ROLL,
    B_X,
    B_Y,
    B_YAW,
    B_Z,
    PHI,
    ROW_ROLL,
    ROW_SPEED,
    ROW_Y,
    ROW_Z,
    SPEED,
    THETA,
)
from estimators.attitude_settings import AttitudeSettings
from estimators.kalman.covariance import FloatArray
from estimators.vehicle_numbers import required

GRAVITY_M_S2 = 9.80665
"""As the attitude document takes it (2.0)."""

(
    U_ROLL,
    U_PITCH,
    U_YAW,
    U_ROLL_RISE,
    U_PITCH_RISE,
    U_YAW_RISE,
    U_X,
    U_Y,
    U_ELEVATION,
    U_ELEVATION_RATE,
    U_STEER,
) = range(11)
INPUTS = 11
"""Rates [rad/s] and derivatives, G_x, G_y [m/s^2], zeta [rad] and its rate, road-wheel angle [rad]."""

(
    M_ROLL_RATE,
    M_PITCH_RATE,
    M_SPEED_RATE,
    M_GY,
    M_GZ,
    M_AX,
    M_AY,
    M_AZ,
    M_WX,
    M_WY,
    M_WZ,
    M_QX,
    M_QY,
    M_QZ,
    M_FX,
    M_FY,
    M_FZ,
    M_ROLL_RISE,
    M_BALANCE,
    M_WHEEL,
) = range(20)
MECHANICS = 20
"""Euler rates, dV_x, G_y, G_z, a, w, rate of angular momentum, road force, d2phi, Q_x [N m], wheel speed [m/s]."""

L_FRONT, L_REAR, L_FRONT_Y, L_REAR_Y, L_STROKE_F, L_STROKE_R, L_ELEVATION, L_ELEVATION_RATE, L_SLOPE = range(9)
LOADS = 9
"""Wheel loads and side forces [N], strokes [m], zeta [rad], its rate [rad/s], slope [rad]."""

BIKE_RECORD = np.dtype(
    [
        ("gravity", "f8"),
        ("to_rear", "f8"),  # L
        ("to_front", "f8"),  # L'
        ("base", "f8"),  # L, or -L' where the front contact carries the model
        ("height", "f8"),
        ("crown", "f8"),  # R_cr
        ("radius", "f8"),  # R_e
        ("mass", "f8"),
        ("mass_x", "f8"),
        ("mass_z", "f8"),
        ("roll_inertia", "f8"),
        ("pitch_inertia", "f8"),
        ("yaw_inertia", "f8"),
        ("product", "f8"),  # I_xz
        ("drag", "f8"),  # N per (m/s)^2
        ("balance_scale", "f8"),
        ("caster", "f8"),
        ("arm", "f8"),
        ("lever", "f8"),
        ("stiffness", "f8", (2,)),
        ("damping", "f8", (2,)),
        ("preload", "f8", (2,)),
        ("static_elevation", "f8"),
        ("pitches", "f8"),
        ("external_speed", "f8"),
    ]
)


def two_wheeler(vehicle: Mapping[str, float], settings: AttitudeSettings) -> NDArray[np.void]:
    """Read the two-wheeler of a vehicle file; record of shape (1,), dtype ``BIKE_RECORD``.

    Raises
    ------
    InputError
        If the file lacks a number of its section ``two_wheeler``.
    """
    record = np.zeros(1, BIKE_RECORD)
    bike = record[0]

    def number(name: str) -> float:
        return required(vehicle, f"two_wheeler.{name}")

    bike["gravity"] = GRAVITY_M_S2
    bike["to_rear"], bike["to_front"] = number("sensor_to_rear_axle"), number("sensor_to_front_axle")
    front = settings.speed_source == "front"
    bike["base"] = -bike["to_front"] if front else bike["to_rear"]
    bike["height"], bike["crown"] = number("sensor_height"), number("crown_radius")
    bike["radius"] = required(vehicle, "wheels.fl.radius" if front else "wheels.rl.radius")
    bike["mass"], bike["mass_x"], bike["mass_z"] = number("sprung_mass"), number("mass_x"), number("mass_z")
    for name in ("roll_inertia", "pitch_inertia", "yaw_inertia"):
        bike[name] = number(name)
    bike["product"] = number("inertia_product")
    if settings.aerodynamic_force:
        bike["drag"] = 0.5 * required(vehicle, "aerodynamics.air_density") * number("drag_area")
    bike["balance_scale"] = 1.0 / (bike["mass"] * (bike["height"] + bike["mass_z"]))
    bike["caster"], bike["arm"], bike["lever"] = number("caster_angle"), number("arm_angle"), number("lever_ratio")
    for place, axle in enumerate(("front", "rear")):
        bike["stiffness"][place], bike["damping"][place] = number(f"spring_rate_{axle}"), number(f"damping_{axle}")
    bike["preload"] = [
        vehicle.get(f"two_wheeler.preload_{axle}", force)
        for axle, force in zip(("front", "rear"), _static_forces(bike), strict=True)
    ]
    bike["static_elevation"] = number("static_elevation")
    bike["pitches"] = settings.chosen.pitches
    bike["external_speed"] = settings.speed_source == "external"
    return record


def _static_forces(bike: np.void) -> tuple[float, float]:
    """Forces along fork and shock absorber at rest, which leave the strokes at zero."""
    weight = bike["mass"] * bike["gravity"]
    wheelbase = bike["to_rear"] + bike["to_front"]
    front = weight * (bike["to_rear"] + bike["mass_x"]) / wheelbase
    return front * math.cos(bike["caster"]), (weight - front) * math.cos(bike["arm"]) * bike["lever"]


@njit(cache=True)
def motion(
    x: FloatArray, u: FloatArray, bike: Any
) -> tuple[float, float, float, float, float, float, float, float, float, float, float, float, float, float]:
    """Motion of the body (2.2, first row of 2.4 and 2.5).

    Parameters
    ----------
    x : array, shape (10,)
        Full state, offsets included.
    u : array, shape (11,)
        Inputs as measured.

    Returns
    -------
    tuple of float
        sin and cos of the roll angle, rates p, q, r, derivatives dp, dq, dr, dphi, dtheta, q s + r c, theta, a_x, dV_x.
    """
    s, c = math.sin(x[PHI]), math.cos(x[PHI])
    p, r = u[U_ROLL] - x[B_ROLL], u[U_YAW] - x[B_YAW]
    dp, dr = u[U_ROLL_RISE], u[U_YAW_RISE]
    theta, zeta = 0.0, 0.0
    if bike.pitches > 0.0:
        q, dq = u[U_PITCH] - x[B_PITCH], u[U_PITCH_RISE]
        theta, zeta = x[THETA], u[U_ELEVATION]
    else:
        q, dq = r * s / c, dr * s / c + r * p / (c * c)
    turn, nod = q * s + r * c, q * c - r * s
    roll = p + turn * math.tan(theta)
    radius, base = bike.crown, bike.base
    high = bike.height - radius * (1.0 - c)
    a_x = -base * (q * q + r * r) + p * q * radius * s + p * r * high + dq * high
    a_x -= dr * radius * s + 2.0 * radius * roll * turn
    dv = u[U_X] - x[B_X] - x[SPEED] * q * math.tan(zeta) - a_x + bike.gravity * math.sin(theta)
    return s, c, p, q, r, dp, dq, dr, roll, nod, turn, theta, a_x, dv


@njit(cache=True)
def two_wheeler_system(x: FloatArray, u: FloatArray, bike: Any, f: FloatArray) -> None:
    """System equation (19), (69a): rates of pitch, roll and speed into ``f``, shape (4,).

    The fourth is 0: a two-wheeler's contact point does not slide sideways.
    """
    _, _, _, _, _, _, _, _, roll, nod, _, _, _, dv = motion(x, u, bike)
    f[THETA] = nod if bike.pitches > 0.0 else 0.0
    f[PHI] = roll
    f[SPEED] = 0.0 if bike.external_speed > 0.0 else dv
    f[3] = 0.0


@njit(cache=True)
def mechanics(x: FloatArray, u: FloatArray, bike: Any, m: FloatArray) -> None:
    """Everything that the equations of 2.2 to 2.6 give for a state and its inputs, into ``m``, shape (20,)."""
    s, c, p, q, r, dp, dq, dr, roll, nod, turn, theta, a_x, dv = motion(x, u, bike)
    st, ct = math.sin(theta), math.cos(theta)
    zeta, zeta_rate = 0.0, 0.0
    if bike.pitches > 0.0:
        zeta, zeta_rate = u[U_ELEVATION], u[U_ELEVATION_RATE]
    tz, cz = math.tan(zeta), math.cos(zeta)
    rise = dp + (dq * s + dr * c + nod * roll) * st / ct + turn * nod / (ct * ct)
    radius, base = bike.crown, bike.base
    high = bike.height - radius * (1.0 - c)
    # sensor against contact point (2.4)
    a_y = p * q * base + q * r * high - radius * s * (p * p + r * r) + dr * base - dp * high
    a_y += 2.0 * p * radius * s * roll + radius * (c * rise - s * roll * roll)
    a_z = p * r * base + q * r * radius * s - high * (p * p + q * q) + dp * radius * s - dq * base
    a_z += 2.0 * p * radius * c * roll - radius * (s * rise + c * roll * roll)
    # specific forces (38), (59)
    v = x[SPEED]
    g_y = v * (r - p * tz) + a_y + bike.gravity * ct * s
    g_z = dv * tz + v * (zeta_rate / (cz * cz) - q) + a_z + bike.gravity * ct * c
    # mass centre against sensor (47), angular momentum (48)
    w_x = -bike.mass_x * (q * q + r * r) + p * r * bike.mass_z + dq * bike.mass_z
    w_y = p * q * bike.mass_x + q * r * bike.mass_z + dr * bike.mass_x - dp * bike.mass_z
    w_z = p * r * bike.mass_x - bike.mass_z * (p * p + q * q) - dq * bike.mass_x
    h_x = bike.roll_inertia * p + bike.product * r
    h_y, h_z = bike.pitch_inertia * q, bike.product * p + bike.yaw_inertia * r
    q_x = bike.roll_inertia * dp + bike.product * dr + q * h_z - r * h_y
    f_y, f_z = bike.mass * (g_y + w_y), bike.mass * (g_z + w_z)
    m[M_ROLL_RATE], m[M_PITCH_RATE], m[M_SPEED_RATE], m[M_ROLL_RISE] = roll, nod, dv, rise
    m[M_GY], m[M_GZ] = g_y, g_z
    m[M_AX], m[M_AY], m[M_AZ] = a_x, a_y, a_z
    m[M_WX], m[M_WY], m[M_WZ] = w_x, w_y, w_z
    m[M_QX] = q_x
    m[M_QY] = bike.pitch_inertia * dq + r * h_x - p * h_z
    m[M_QZ] = bike.product * dp + bike.yaw_inertia * dr + p * h_y - q * h_x
    m[M_FX] = bike.mass * (u[U_X] - x[B_X] + w_x) + bike.drag * v * abs(v)
    m[M_FY], m[M_FZ] = f_y, f_z
    # row x of (65): built from modelled forces, so that offsets of G_y and G_z stay out of it
    m[M_BALANCE] = q_x + f_y * (radius * (1.0 - c) - bike.height - bike.mass_z) + f_z * radius * s
    m[M_WHEEL] = v / (cz * (1.0 - radius / bike.radius * (1.0 - c)))


@njit(cache=True)
def two_wheeler_observation(x: FloatArray, u: FloatArray, bike: Any, m: FloatArray, h: FloatArray) -> None:
    """Observation equation (21), (70a).

    Parameters
    ----------
    m : array, shape (20,)
        Scratch; see :func:`mechanics`.
    h : array, shape (6,)
        Receives the rows of the measurement that a two-wheeler has.
    """
    mechanics(x, u, bike, m)
    h[ROW_Y] = m[M_GY] + x[B_Y]
    h[ROW_Z] = m[M_GZ] + x[B_Z]
    h[ROW_SPEED] = m[M_WHEEL]
    h[ROW_ROLL] = m[M_BALANCE] * bike.balance_scale


@njit(cache=True)
def wheel_loads(x: FloatArray, m: FloatArray, bike: Any, loads: FloatArray) -> None:
    """Block 60: vertical loads and side forces of both wheels (75)-(78) from ``m`` of :func:`mechanics`."""
    s, c = math.sin(x[PHI]), math.cos(x[PHI])
    low = bike.crown * (1.0 - c) - bike.height - bike.mass_z
    wheelbase = bike.to_rear + bike.to_front
    e_z = m[M_FX] * low + m[M_FZ] * bike.mass_x - m[M_QY]
    e_y = m[M_QZ] - m[M_FX] * bike.crown * s + m[M_FY] * bike.mass_x
    loads[L_FRONT] = (bike.to_rear * m[M_FZ] + e_z) / wheelbase
    loads[L_REAR] = (bike.to_front * m[M_FZ] - e_z) / wheelbase
    loads[L_FRONT_Y] = (bike.to_rear * m[M_FY] + e_y) / wheelbase
    loads[L_REAR_Y] = (bike.to_front * m[M_FY] - e_y) / wheelbase


@njit(cache=True)
def longitudinal_share(force: float, front: float, rear: float) -> float:
    """Front wheel's part of a longitudinal force [N]: none when driving, by vertical load when braking (80), (81)."""
    if force >= 0.0 or front + rear <= 0.0:
        return 0.0
    return min(max(front / (front + rear), 0.0), 1.0) * force


@njit(cache=True)
def follow_springs(force_x: float, bike: Any, step: float, pole: float, loads: FloatArray) -> None:
    """Blocks 70 and 80: strokes (84), (85), exact for a force held over the step, then zeta (89) and its rate.

    Parameters
    ----------
    force_x : float
        Longitudinal road force [N].
    pole : float
        Share of the new value that the low-pass of zeta takes in a step.
    """
    front_x = longitudinal_share(force_x, loads[L_FRONT], loads[L_REAR])
    along_front = loads[L_FRONT] * math.cos(bike.caster) - front_x * math.sin(bike.caster)
    along_rear = loads[L_REAR] * math.cos(bike.arm) - (force_x - front_x) * math.sin(bike.arm)
    along_rear *= bike.lever
    keep = math.exp(-bike.stiffness[0] * step / bike.damping[0])
    rest = (along_front - bike.preload[0]) / bike.stiffness[0]
    loads[L_STROKE_F] = keep * loads[L_STROKE_F] + (1.0 - keep) * rest
    keep = math.exp(-bike.stiffness[1] * step / bike.damping[1])
    rest = (along_rear - bike.preload[1]) / bike.stiffness[1]
    loads[L_STROKE_R] = keep * loads[L_STROKE_R] + (1.0 - keep) * rest
    wheel = bike.lever * loads[L_STROKE_R]
    up = loads[L_STROKE_F] * math.cos(bike.caster) - wheel * math.cos(bike.arm)
    span = bike.to_front - loads[L_STROKE_F] * math.sin(bike.caster) + bike.to_rear + wheel * math.sin(bike.arm)
    zeta = bike.static_elevation + math.atan(up / span)
    before = loads[L_ELEVATION]
    loads[L_ELEVATION] += pole * (zeta - before)
    loads[L_ELEVATION_RATE] = (loads[L_ELEVATION] - before) / step


@njit(cache=True)
def road_slope(theta: float, phi: float, zeta: float) -> float:
    """Block 90: slope of the road [rad], positive downhill (91)."""
    value = math.sin(theta) * math.cos(zeta) - math.cos(theta) * math.cos(phi) * math.sin(zeta)
    return math.asin(min(max(value, -1.0), 1.0))
