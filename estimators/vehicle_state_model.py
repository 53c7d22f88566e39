"""Models of the vehicle-state document that its observers share (2.2 to 2.7), in its axes and wheel order, compiled.

Wheels are 0 front right, 1 front left, 2 rear right, 3 rear left; y points right, yaw rate is positive to the right.
"""

import math
from typing import Any

from numba import njit

from estimators.kalman.covariance import FloatArray
from estimators.vehicle_state_car import GRAVITY, MOST_GEARS

_SLOWEST = 0.3
"""Speed of a wheel centre [m/s] to which a slip angle refers at least: a car that spins has wheels that stand."""
LEFT = (-1.0, 1.0, -1.0, 1.0)
"""The document's signs '+' for left and '-' for right wheels."""


@njit(cache=True)
def road_wheel_angle(wheel_angle: float, steering: FloatArray, row: int) -> float:
    """Steering map: linear between its points and on beyond its ends (2.8) [rad]."""
    places, k = steering[0], 1
    while k < places.shape[0] - 1 and places[k] < wheel_angle:
        k += 1
    share = (wheel_angle - places[k - 1]) / (places[k] - places[k - 1])
    return steering[row, k - 1] + share * (steering[row, k] - steering[row, k - 1])


@njit(cache=True)
def wheel_speeds(v_x: float, v_y: float, w_z: float, car: Any, i: int) -> tuple[float, float]:
    """Velocity of a wheel centre along and across the car (2.2, l. 3698-3720)."""
    track = car.b_1 if i < 2 else car.b_2
    side = LEFT[i]
    return v_x + side * w_z * 0.5 * track, v_y + (w_z * car.l_1 if i < 2 else -w_z * car.l_2)


@njit(cache=True)
def slip_angle(v_x: float, v_y: float, w_z: float, theta: float, car: Any, i: int) -> float:
    """Slip angle, which already carries its minus (l. 3725, 3730): a positive one gives a force to the right."""
    v_kx, v_ky = wheel_speeds(v_x, v_y, w_z, car, i)
    return theta - math.atan(v_ky / max(v_kx, _SLOWEST))


@njit(cache=True)
def slip(v_kx: float, omega: float, radius: float) -> float:
    """Longitudinal slip (l. 3738), clipped to [-1, 1]; -1 is a locked wheel."""
    return min(max((omega * radius - v_kx) / v_kx, -1.0), 1.0)


@njit(cache=True)
def magic_formula(x: float, b: float, c: float, d: float) -> float:
    """Reduced Magic Formula D sin(C arctan(B x)), E = 0 (l. 2684-2713)."""
    return d * math.sin(c * math.atan(b * x))


@njit(cache=True)
def magic_formula_full(x: float, b: float, c: float, d: float, e: float) -> float:
    """Magic Formula of pure slip with four coefficients (l. 3480-3492)."""
    return d * math.sin(c * math.atan(b * x - e * (b * x - math.atan(b * x))))


@njit(cache=True)
def rolling_coefficient(v: float, car: Any) -> float:
    """Rolling resistance coefficient f_0 + k_fv v^2 (l. 3601)."""
    return car.f_0 + car.k_fv * v * v


@njit(cache=True)
def air_drag(v: float, car: Any) -> float:
    """Drag of the air [N] (l. 3690)."""
    return car.drag * v * v


@njit(cache=True)
def rear_load(a_x: float, theta_r: float, drag: float, rolling: float, car: Any) -> float:
    """Load of the rear axle [N], eq. 3.2 (4); ``rolling`` is the sum of the rolling moments [N m]."""
    weight = car.m * GRAVITY * math.cos(theta_r)
    inertia = car.m * car.h * (a_x + GRAVITY * math.sin(theta_r))
    return (weight * car.l_1 + inertia + drag * car.h_w + rolling) / (car.l_1 + car.l_2)


@njit(cache=True)
def static_loads(
    a_x: float, a_y: float, theta_r: float, drag: float, rolling: float, car: Any, loads: FloatArray
) -> None:
    """Normal reactions that balance at once, eq. 3.2 (1) to (4) [N]."""
    weight = car.m * GRAVITY * math.cos(theta_r)
    rear = rear_load(a_x, theta_r, drag, rolling, car)
    # (3): R_12 B_1 + R_22 B_2; (2): the sums over both diagonals are half of the weight each
    moment = car.m * a_y * car.h + weight * 0.25 * (car.b_1 + car.b_2)
    loads[3] = (moment - car.b_1 * (0.5 * weight - rear)) / (car.b_1 + car.b_2)
    loads[2] = rear - loads[3]
    loads[1] = 0.5 * weight - loads[2]
    loads[0] = 0.5 * weight - loads[3]


@njit(cache=True)
def rolling_loads(
    a_x: float,
    roll: float,
    roll_rate: float,
    theta_r: float,
    drag: float,
    rolling: float,
    car: Any,
    loads: FloatArray,
) -> None:
    """Normal reactions with roll as a state (l. 5900-5926); each axle takes half of the roll moment [N]."""
    weight = car.m * GRAVITY * math.cos(theta_r)
    rear = rear_load(a_x, theta_r, drag, rolling, car)
    moment = 0.5 * (car.roll_stiffness * roll + car.roll_damping * roll_rate)
    for i in range(4):
        axle, track = (weight - rear, car.b_1) if i < 2 else (rear, car.b_2)
        loads[i] = max(0.5 * axle + LEFT[i] * moment / track, 0.0)


@njit(cache=True)
def roll_step(roll: float, roll_rate: float, force_y: float, dt: float, car: Any) -> tuple[float, float]:
    """Roll after a step under the side force at the road (l. 5426-5430); positive leans to the left.

    Linearly implicit: a step of 10 ms is not short beside the period of the roll.
    """
    left = 1.0 + dt * car.roll_damping / car.j_xx + dt * dt * car.roll_stiffness / car.j_xx
    rate = (roll_rate + dt * (force_y * car.h - car.roll_stiffness * roll) / car.j_xx) / left
    return roll + dt * rate, rate


@njit(cache=True)
def pitch_step(pitch: float, pitch_rate: float, force_x: float, dt: float, car: Any) -> tuple[float, float]:
    """Pitch after a step under the longitudinal forces at the road (2.7); positive nose up, linearly implicit."""
    left = 1.0 + dt * car.pitch_damping / car.j_y + dt * dt * car.pitch_stiffness / car.j_y
    rate = (pitch_rate + dt * (force_x * car.h - car.pitch_stiffness * pitch) / car.j_y) / left
    return pitch + dt * rate, rate


@njit(cache=True)
def axle_torque(engine_torque: float, engine_acceleration: float, gear: int, car: Any) -> float:
    """Torque of the driven axle from the engine's (l. 3576-3591) [N m].

    The document has the car driven, with the efficiency as a factor; in overrun the friction of the gears helps the
    engine to brake, and it becomes a divisor.
    """
    if gear < 1 or gear > MOST_GEARS:
        return 0.0
    torque = (engine_torque - car.j_e * engine_acceleration) * car.ratio[gear]
    return torque * car.efficiency if torque >= 0.0 else torque / car.efficiency
