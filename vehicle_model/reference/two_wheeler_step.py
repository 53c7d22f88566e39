"""Rigid-body motion of the reference two-wheeler, compiled: plain vector mechanics, none of the filters' equations.

The body turns and tilts as its profiles say, its contact point runs along the road without sliding; the yaw
acceleration is the one with which road forces hold the roll moment (attitude document, 7.1).
"""

import math
from typing import Any

import numpy as np
from numba import njit
from numpy.typing import NDArray

FloatArray = NDArray[np.float64]

GRAVITY_M_S2 = 9.80665

PARAMETER_RECORD = np.dtype(
    [
        ("base", "f8"),  # from the contact point that carries the constraint forward to the sensor
        ("to_rear", "f8"),
        ("to_front", "f8"),
        ("height", "f8"),
        ("crown", "f8"),
        ("mass", "f8"),
        ("mass_x", "f8"),
        ("mass_z", "f8"),
        ("inertia", "f8", (3, 3)),
        ("drag", "f8"),
        ("caster", "f8"),
        ("arm", "f8"),
        ("lever", "f8"),
        ("stiffness", "f8", (2,)),
        ("damping", "f8", (2,)),
        ("preload", "f8", (2,)),
        ("static_elevation", "f8"),
    ]
)

(P_ROLL, P_PITCH, P_ELEVATION, P_SPEED) = range(4)
"""Profiles; each has value, first and second derivative."""

(V_RATES, V_ACCELERATION, V_SENSOR, V_FORCE, V_WORK) = (0, 3, 6, 9, 12)
"""Places in the scratch vector: rates, their derivatives, specific force of the sensor, road force, moment."""
WORK = 15


@njit(cache=True)
def _cross(a: FloatArray, b: FloatArray, into: FloatArray, sign: float) -> None:
    """into += sign a x b."""
    into[0] += sign * (a[1] * b[2] - a[2] * b[1])
    into[1] += sign * (a[2] * b[0] - a[0] * b[2])
    into[2] += sign * (a[0] * b[1] - a[1] * b[0])


@njit(cache=True)
def _carry(point: FloatArray, rates: FloatArray, rise: FloatArray, into: FloatArray, spare: FloatArray) -> None:
    """into += acceleration of a point fixed to the body against its origin."""
    _cross(rise, point, into, 1.0)
    spare[:] = 0.0
    _cross(rates, point, spare, 1.0)
    _cross(rates, spare, into, 1.0)


@njit(cache=True)
def rates_of(profile: FloatArray, yaw_rate: float, yaw_rise: float, rates: FloatArray, rise: FloatArray) -> None:
    """Body rates and their derivatives from Euler angles z-y-x, for rows ``P_ROLL`` and ``P_PITCH`` of a profile."""
    phi, dphi, ddphi = profile[P_ROLL, 0], profile[P_ROLL, 1], profile[P_ROLL, 2]
    theta, dtheta, ddtheta = profile[P_PITCH, 0], profile[P_PITCH, 1], profile[P_PITCH, 2]
    s, c, st, ct = math.sin(phi), math.cos(phi), math.sin(theta), math.cos(theta)
    rates[0] = dphi - yaw_rate * st
    rates[1] = dtheta * c + yaw_rate * ct * s
    rates[2] = -dtheta * s + yaw_rate * ct * c
    rise[0] = ddphi - yaw_rise * st - yaw_rate * ct * dtheta
    rise[1] = ddtheta * c - dtheta * dphi * s + yaw_rise * ct * s + yaw_rate * (ct * c * dphi - st * s * dtheta)
    rise[2] = -ddtheta * s - dtheta * dphi * c + yaw_rise * ct * c - yaw_rate * (ct * s * dphi + st * c * dtheta)


@njit(cache=True)
def moment_left(
    p: Any, profile: FloatArray, yaw_rate: float, yaw_rise: float, v: FloatArray, spare: FloatArray
) -> float:
    """Roll moment [N m] that the road forces would leave unbalanced; specific force and road force go into ``v``.

    Parameters
    ----------
    profile : array, shape (4, 3)
        Value, first and second derivative of roll, pitch, elevation angle and speed along the road.
    v, spare : arrays, shapes (15,) and (4, 3)
        Results and scratch.
    """
    rates, rise = v[V_RATES : V_RATES + 3], v[V_ACCELERATION : V_ACCELERATION + 3]
    rates_of(profile, yaw_rate, yaw_rise, rates, rise)
    phi, dphi, ddphi = profile[P_ROLL, 0], profile[P_ROLL, 1], profile[P_ROLL, 2]
    theta, zeta, dzeta = profile[P_PITCH, 0], profile[P_ELEVATION, 0], profile[P_ELEVATION, 1]
    speed, dspeed = profile[P_SPEED, 0], profile[P_SPEED, 1]
    s, c, sz, cz = math.sin(phi), math.cos(phi), math.sin(zeta), math.cos(zeta)
    force, contact, arm, other = v[V_SENSOR : V_SENSOR + 3], spare[0], spare[1], spare[2]
    # contact point along the road, which the body sees tilted by zeta
    contact[0], contact[1], contact[2] = speed * cz, 0.0, speed * sz
    force[0], force[1], force[2] = dspeed * cz - speed * sz * dzeta, 0.0, dspeed * sz + speed * cz * dzeta
    _cross(rates, contact, force, 1.0)
    # sensor over the contact point, which wanders round the crown of the tyre
    arm[0], arm[1], arm[2] = p.base, p.crown * s, p.height - p.crown * (1.0 - c)
    _carry(arm, rates, rise, force, other)
    arm[0], arm[1], arm[2] = 0.0, p.crown * c * dphi, -p.crown * s * dphi
    _cross(rates, arm, force, 2.0)
    force[1] += p.crown * (c * ddphi - s * dphi * dphi)
    force[2] += -p.crown * (s * ddphi + c * dphi * dphi)
    g = GRAVITY_M_S2
    force[0] += -g * math.sin(theta)
    force[1] += g * math.cos(theta) * s
    force[2] += g * math.cos(theta) * c
    # mass centre, road force, moment about the mass centre
    road, moment = v[V_FORCE : V_FORCE + 3], v[V_WORK : V_WORK + 3]
    road[0], road[1], road[2] = force[0], force[1], force[2]
    arm[0], arm[1], arm[2] = p.mass_x, 0.0, p.mass_z
    _carry(arm, rates, rise, road, other)
    for axis in range(3):
        road[axis] *= p.mass
        contact[axis] = moment[axis] = 0.0
        for k in range(3):
            contact[axis] += p.inertia[axis, k] * rates[k]
            moment[axis] += p.inertia[axis, k] * rise[k]
    road[0] += p.drag * (speed * cz) ** 2
    _cross(rates, contact, moment, 1.0)
    # both contact points lie at the same y and z against the mass centre
    y, z = -p.crown * s, p.crown * (1.0 - c) - p.height - p.mass_z
    return moment[0] - (y * road[2] - z * road[1])


@njit(cache=True)
def _yaw_rise(p: Any, profile: FloatArray, yaw_rate: float, v: FloatArray, spare: FloatArray) -> float:
    """Yaw acceleration that leaves no moment; the moment is linear in it."""
    none = moment_left(p, profile, yaw_rate, 0.0, v, spare)
    one = moment_left(p, profile, yaw_rate, 1.0, v, spare)
    return none / (none - one)


@njit(cache=True)
def solve_yaw(p_rows: Any, profiles: FloatArray, step: float, yaw_rates: FloatArray, backwards: bool) -> None:
    """Yaw rate at every second sample by fourth-order Runge-Kutta over two samples.

    Parameters
    ----------
    profiles : array, shape (n, 4, 3)
        n odd.
    yaw_rates : array, shape ((n + 1)/2,)
    backwards : bool
        From the last sample to the first. The yaw rate that a constraint at the front wheel asks for can be found no
        other way: forwards its error grows, as it does for a car that drives in reverse.
    """
    p = p_rows[0]
    v, spare = np.zeros(WORK), np.zeros((4, 3))
    n = yaw_rates.shape[0]
    way, at = (-1, n - 1) if backwards else (1, 0)
    h, now = 2.0 * step * way, 0.0
    yaw_rates[at] = now
    for _ in range(n - 1):
        k1 = _yaw_rise(p, profiles[2 * at], now, v, spare)
        k2 = _yaw_rise(p, profiles[2 * at + way], now + 0.5 * h * k1, v, spare)
        k3 = _yaw_rise(p, profiles[2 * at + way], now + 0.5 * h * k2, v, spare)
        k4 = _yaw_rise(p, profiles[2 * (at + way)], now + h * k3, v, spare)
        now += h * (k1 + 2.0 * k2 + 2.0 * k3 + k4) / 6.0
        at += way
        yaw_rates[at] = now


@njit(cache=True)
def ride_along(p_rows: Any, profiles: FloatArray, yaw: FloatArray, results: FloatArray) -> None:
    """Rates, specific force, road force, wheel loads at every sample.

    Parameters
    ----------
    yaw : array, shape (n, 2)
        Yaw rate and yaw acceleration.
    results : array, shape (n, 14)
        Receives rates, their derivatives, specific force at the sensor, road force, loads of front and rear wheel.
    """
    p = p_rows[0]
    v, spare = np.zeros(WORK), np.zeros((4, 3))
    wheelbase = p.to_rear + p.to_front
    for k in range(profiles.shape[0]):
        moment_left(p, profiles[k], yaw[k, 0], yaw[k, 1], v, spare)
        for column in range(12):
            results[k, column] = v[column]
        z = p.crown * (1.0 - math.cos(profiles[k, P_ROLL, 0])) - p.height - p.mass_z
        pull = z * v[V_FORCE] - v[V_WORK + 1]
        front = (pull + (p.to_rear + p.mass_x) * v[V_FORCE + 2]) / wheelbase
        results[k, 12], results[k, 13] = front, v[V_FORCE + 2] - front


@njit(cache=True)
def springs(p_rows: Any, results: FloatArray, step: float, pole: float, elevation: FloatArray) -> None:
    """Elevation angle of the body on its springs under the loads of ``ride_along``; ``pole`` [1/s] of the tyres."""
    p = p_rows[0]
    strokes = np.zeros(2)
    angle = p.static_elevation
    for k in range(results.shape[0]):
        force, front, rear = results[k, V_FORCE], results[k, 12], results[k, 13]
        braked = force * front / (front + rear) if force < 0.0 else 0.0
        along = front * math.cos(p.caster) - braked * math.sin(p.caster)
        strokes[0] += step / p.damping[0] * (along - p.preload[0] - p.stiffness[0] * strokes[0])
        along = p.lever * (rear * math.cos(p.arm) - (force - braked) * math.sin(p.arm))
        strokes[1] += step / p.damping[1] * (along - p.preload[1] - p.stiffness[1] * strokes[1])
        travel = p.lever * strokes[1]
        drop = strokes[0] * math.cos(p.caster) - travel * math.cos(p.arm)
        span = p.to_front - strokes[0] * math.sin(p.caster) + p.to_rear + travel * math.sin(p.arm)
        angle += step * pole * (p.static_elevation + math.atan(drop / span) - angle)
        elevation[k] = angle
