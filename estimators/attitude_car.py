"""Car of the attitude filters, compiled (attitude document, 6): single track with anchors for roll and pitch.

A bank alone does not create observability: without an equation that ties the roll angle, an offset of G_y looks like a
constant roll. On a flat road the balances of roll and pitch moment tie them, as Q_x does on the two-wheeler.
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
    LATERAL_SPEED,
    PHI,
    ROW_PITCH,
    ROW_ROLL,
    ROW_SPEED,
    ROW_Y,
    ROW_YAW,
    ROW_Z,
    SPEED,
    THETA,
)
from estimators.attitude_settings import AttitudeSettings
from estimators.attitude_two_wheeler import U_PITCH, U_ROLL, U_STEER, U_X, U_Y, U_YAW, U_YAW_RISE
from estimators.kalman.covariance import FloatArray
from estimators.vehicle_numbers import GRAVITY_M_S2, required
from estimators.vertical_load_car import load_car, slope_of_tyre
from estimators.vertical_load_settings import VerticalLoadSettings
from signals.wheels import WHEELS

CAR_RECORD = np.dtype(
    [
        ("gravity", "f8"),
        ("mass", "f8"),
        ("yaw_inertia", "f8"),
        ("to_front", "f8"),
        ("to_rear", "f8"),
        ("stiffness", "f8", (2,)),  # of the axles, N/rad
        ("limit", "f8", (2,)),  # largest side force of the axles, N
        ("friction", "f8"),
        ("roll_gradient", "f8"),  # rad per m/s^2
        ("pitch_gradient", "f8"),
        ("slowest", "f8"),
        ("external_speed", "f8"),
    ]
)


def attitude_car(vehicle: Mapping[str, float], settings: AttitudeSettings) -> NDArray[np.void]:
    """Read the car from the numbers of a vehicle file; record of shape (1,), dtype ``CAR_RECORD``.

    Raises
    ------
    InputError
        If a number is missing and nothing stands for it.
    """
    record = np.zeros(1, CAR_RECORD)
    car = record[0]
    springs = load_car(vehicle, VerticalLoadSettings())[0]
    car["gravity"] = GRAVITY_M_S2
    for name in ("mass", "yaw_inertia", "to_front", "to_rear"):
        car[name] = springs[name]
    given = settings.cornering_stiffness_front, settings.cornering_stiffness_rear
    for place, (axle, value) in enumerate(zip(("front", "rear"), given, strict=True)):
        load = springs["static_load"][place]
        car["stiffness"][place] = 2.0 * slope_of_tyre(vehicle, axle, 0.5 * load) if value is None else value
        car["limit"][place] = settings.friction * load
    car["friction"], car["slowest"] = settings.friction, settings.minimum_speed
    roll = settings.roll_gradient
    car["roll_gradient"] = _roll_gradient(vehicle, springs) if roll is None else roll
    pitch = settings.pitch_gradient
    car["pitch_gradient"] = _pitch_gradient(vehicle, springs) if pitch is None else pitch
    car["external_speed"] = settings.speed_source == "external"
    return record


def _roll_gradient(vehicle: Mapping[str, float], springs: np.void) -> float:
    """Roll per lateral acceleration [rad/(m/s^2)] of a body on its suspension, and of all on the tyres."""
    moment = springs["sprung_mass"] * springs["roll_arm"]
    tyres = 0.0
    for axle, wheels in (("front", WHEELS[:2]), ("rear", WHEELS[2:])):
        rate = sum(vehicle.get(f"wheels.{wheel}.vertical_stiffness", 0.0) for wheel in wheels)
        tyres += 0.25 * rate * required(vehicle, f"axles.{axle}.track") ** 2
    on_tyres = springs["mass"] * springs["height"] / tyres if tyres > 0.0 else 0.0
    return float(moment / (springs["roll_stiffness"] - moment * GRAVITY_M_S2) + on_tyres)


def _pitch_gradient(vehicle: Mapping[str, float], springs: np.void) -> float:
    """Nose up per acceleration [rad/(m/s^2)] of a body on four springs, without anti-dive and anti-squat."""
    front, rear = (required(vehicle, f"suspension.{axle}.spring_rate") for axle in ("front", "rear"))
    stiffness = 2.0 * (front * springs["to_front"] ** 2 + rear * springs["to_rear"] ** 2)
    return float(springs["sprung_mass"] * springs["height"] / stiffness)


@njit(cache=True)
def axle_force(car: Any, axle: int, slip: float) -> float:
    """Side force of an axle [N] at a slip angle [rad], positive to the left."""
    limit = car.limit[axle]
    return limit * math.tanh(car.stiffness[axle] * slip / limit)


@njit(cache=True)
def car_system(x: FloatArray, u: FloatArray, car: Any, f: FloatArray) -> None:
    """System equation: rates of pitch, roll, speed and lateral speed into ``f``, shape (4,)."""
    g = car.gravity
    s, c = math.sin(x[PHI]), math.cos(x[PHI])
    st, ct = math.sin(x[THETA]), math.cos(x[THETA])
    p, q, r = u[U_ROLL] - x[B_ROLL], u[U_PITCH] - x[B_PITCH], u[U_YAW] - x[B_YAW]
    f[THETA] = q * c - r * s
    f[PHI] = p + (q * s + r * c) * st / ct
    f[SPEED] = 0.0 if car.external_speed > 0.0 else u[U_X] - x[B_X] + g * st + x[LATERAL_SPEED] * r
    f[LATERAL_SPEED] = u[U_Y] - x[B_Y] - x[SPEED] * r - g * ct * s


@njit(cache=True)
def car_observation(x: FloatArray, u: FloatArray, car: Any, h: FloatArray) -> None:
    """Observation equation: all rows of the measurement into ``h``, shape (6,)."""
    g = car.gravity
    r = u[U_YAW] - x[B_YAW]
    v, side = max(x[SPEED], car.slowest), x[LATERAL_SPEED]
    along = u[U_X] - x[B_X] + g * math.sin(x[THETA])
    front = axle_force(car, 0, u[U_STEER] - math.atan((side + car.to_front * r) / v))
    rear = axle_force(car, 1, -math.atan((side - car.to_rear * r) / v))
    push = (front + rear) / car.mass
    h[ROW_SPEED] = x[SPEED]
    h[ROW_Y] = push * (1.0 + g * car.roll_gradient) + x[B_Y]
    h[ROW_Z] = (g * math.cos(x[PHI]) - push * math.sin(x[PHI])) * math.cos(x[THETA]) + x[B_Z]
    turn = car.yaw_inertia * u[U_YAW_RISE] - car.to_front * front + car.to_rear * rear
    h[ROW_YAW] = turn / (car.mass * car.to_front)
    h[ROW_ROLL] = g * (x[PHI] - car.roll_gradient * push)
    h[ROW_PITCH] = g * (x[THETA] + car.pitch_gradient * along)


@njit(cache=True)
def friction_share(x: FloatArray, u: FloatArray, car: Any) -> float:
    """Specific force along the road over what the friction allows."""
    return math.hypot(u[U_X] - x[B_X], u[U_Y] - x[B_Y]) / (car.friction * car.gravity)
