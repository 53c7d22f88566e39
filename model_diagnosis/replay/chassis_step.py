"""Body of the replay's car: loads from heave, pitch and roll on springs and tyres, and the motion in the plane.

Compression of a corner c = -z + x theta - y phi (theta nose down, phi left side up). Spring, bar and tyre act in
series, so that a corner's force is k k_t/(k + k_t) of the axle's mean compression and, with the anti-roll bar a,
(k + 2a) k_t/(k + 2a + k_t) of half its difference. The load transfer lags as the body does.
"""

import math

import numpy as np
from numba import njit
from numpy.typing import NDArray

from model_diagnosis.replay.record import INPUT_BANK, INPUT_GRADE, Record
from model_diagnosis.replay.state import (
    ACCELERATION_X,
    ACCELERATION_Y,
    ALIGNING,
    ANGLE,
    DISTANCE,
    FORCE_X,
    FORCE_Y,
    HEAVE,
    HEAVE_RATE,
    LATERAL_SPEED,
    LOAD,
    PITCH,
    PITCH_RATE,
    ROLL,
    ROLL_RATE,
    SPEED,
    SPIN_RATE,
    TRAVEL,
    TYRE_X,
    TYRE_Y,
    YAW_ACCELERATION,
    YAW_RATE,
)

GRAVITY = 9.81


@njit(cache=True, nogil=True)
def wheel_x(p: Record, i: int) -> float:
    """Place of a wheel ahead of the centre of gravity."""
    return p.front_arm if i < 2 else p.front_arm - p.wheelbase


@njit(cache=True, nogil=True)
def wheel_y(p: Record, i: int) -> float:
    """Place of a wheel left of the centre of gravity."""
    half = 0.5 * (p.track_front if i < 2 else p.track_rear)
    return half if i % 2 == 0 else -half


@njit(cache=True, nogil=True)
def static_load(p: Record, i: int) -> float:
    """Load of a wheel at rest."""
    arm = p.wheelbase - p.front_arm if i < 2 else p.front_arm
    return 0.5 * p.mass * GRAVITY * arm / p.wheelbase


@njit(cache=True, nogil=True)
def _corner_force(
    p: Record, i: int, mean: float, half: float, mean_rate: float, half_rate: float
) -> tuple[float, float]:
    """Change of the force of a corner on the body and the suspension's travel, compression positive.

    ``mean`` and ``half`` are the axle's mean compression and half the difference of this wheel to the other, with the
    tyres' part in them.
    """
    tyre, spring = p.vertical_stiffness[i], p.spring_rate[i]
    rolling = spring + 2.0 * p.anti_roll_rate[i]
    mean_share, half_share = tyre / (spring + tyre), tyre / (rolling + tyre)
    travel = mean_share * mean + half_share * half
    rate = mean_share * mean_rate + half_share * half_rate
    force = mean_share * spring * mean + half_share * rolling * half
    force += mean_share * (p.compression_damping[i] if rate > 0.0 else p.rebound_damping[i]) * rate
    deep = travel - p.bump_clearance[i]
    if deep > 0.0:
        force += (p.bump_rate[i] + p.bump_progression[i] * deep) * deep
    return force, travel


@njit(cache=True, nogil=True)
def _guided_force(p: Record, wheels: NDArray[np.float64], i: int) -> float:
    """Part of the load that the links carry past the spring: support of braking and driving, roll centre."""
    force_x, force_y = wheels[TYRE_X, i], wheels[TYRE_Y, i]
    support = p.brake_support[i] if force_x < 0.0 else p.drive_support[i]
    forward = 1.0 if i < 2 else -1.0
    leftward = 1.0 if i % 2 == 0 else -1.0
    track = p.track_front if i < 2 else p.track_rear
    return -forward * support * force_x - leftward * 2.0 * p.roll_centre_height[i] / track * force_y


@njit(cache=True, nogil=True)
def move_body(p: Record, body: NDArray[np.float64], wheels: NDArray[np.float64], step: float) -> None:
    """Loads of the four wheels, then one step of heave, pitch and roll under them."""
    lift_front, lift_rear = p.lift_front * body[SPEED] ** 2, p.lift_rear * body[SPEED] ** 2
    up = lift_front + lift_rear
    nose_down = -p.front_arm * lift_front - (p.front_arm - p.wheelbase) * lift_rear
    left_up = 0.0
    for axle in range(2):
        first = 2 * axle
        x, y = wheel_x(p, first), wheel_y(p, first)
        mean = x * body[PITCH] - body[HEAVE]
        mean_rate = x * body[PITCH_RATE] - body[HEAVE_RATE]
        for i in range(first, first + 2):
            side = -y if i == first else y
            change, travel = _corner_force(p, i, mean, side * body[ROLL], mean_rate, side * body[ROLL_RATE])
            change += _guided_force(p, wheels, i)
            rest = static_load(p, i)
            change = max(change, -rest)
            wheels[LOAD, i], wheels[TRAVEL, i] = rest + change, travel
            up += change
            nose_down -= x * change
            left_up -= side * change
    spin_change = 0.0
    for i in range(4):
        spin_change += p.spin_inertia[i] * wheels[SPIN_RATE, i]
    arm = p.height - p.radius[0]
    drag = p.drag * body[SPEED] ** 2
    nose_down += p.mass * GRAVITY * arm * body[PITCH] - spin_change
    nose_down += -p.height * (body[FORCE_X] + drag) - (p.drag_height - p.height) * drag
    left_up += p.mass * GRAVITY * arm * body[ROLL] + p.height * body[FORCE_Y]
    sprung = p.mass - p.unsprung_mass[0] - p.unsprung_mass[1] - p.unsprung_mass[2] - p.unsprung_mass[3]
    body[HEAVE_RATE] += step * up / sprung
    body[PITCH_RATE] += step * nose_down / p.pitch_inertia
    body[ROLL_RATE] += step * left_up / p.roll_inertia
    body[HEAVE] += step * body[HEAVE_RATE]
    body[PITCH] += step * body[PITCH_RATE]
    body[ROLL] += step * body[ROLL_RATE]


@njit(cache=True, nogil=True)
def _air(p: Record, body: NDArray[np.float64]) -> tuple[float, float, float]:
    """Air forces along and across, and their yaw moment."""
    along, across = body[SPEED] + p.wind_along, body[LATERAL_SPEED] + p.wind_across
    speed = math.sqrt(along * along + across * across)
    side = -p.side_force * speed * across
    return -p.drag * speed * along, side - p.drag * speed * across, side * p.side_force_position


@njit(cache=True, nogil=True)
def move_in_plane(
    p: Record, body: NDArray[np.float64], wheels: NDArray[np.float64], inputs: NDArray[np.float64], step: float
) -> None:
    """One step of speed, lateral speed and yaw rate under tyre forces, air and slope."""
    force_x, force_y, moment = _air(p, body)
    for i in range(4):
        sine, cosine = math.sin(wheels[ANGLE, i]), math.cos(wheels[ANGLE, i])
        at_x = cosine * wheels[TYRE_X, i] - sine * wheels[TYRE_Y, i]
        at_y = sine * wheels[TYRE_X, i] + cosine * wheels[TYRE_Y, i]
        force_x += at_x
        force_y += at_y
        moment += wheel_x(p, i) * at_y - wheel_y(p, i) * at_x + wheels[ALIGNING, i]
    body[FORCE_X], body[FORCE_Y] = force_x, force_y
    along, across, turn = force_x / p.mass, force_y / p.mass, body[YAW_RATE]
    acceleration_x = along + body[LATERAL_SPEED] * turn - GRAVITY * (p.grade + inputs[INPUT_GRADE])
    acceleration_y = across - body[SPEED] * turn - GRAVITY * (p.bank + inputs[INPUT_BANK])
    body[YAW_ACCELERATION] = moment / p.yaw_inertia
    body[SPEED] = max(body[SPEED] + step * acceleration_x, 0.0)
    body[LATERAL_SPEED] += step * acceleration_y
    body[YAW_RATE] += step * body[YAW_ACCELERATION]
    body[DISTANCE] += step * body[SPEED]
    # the accelerometer stands at its place in the body and leans with it
    felt_x = along - GRAVITY * body[PITCH] - turn * turn * p.place_x - body[YAW_ACCELERATION] * p.place_y
    felt_y = across + GRAVITY * body[ROLL] - turn * turn * p.place_y + body[YAW_ACCELERATION] * p.place_x
    share = step / (p.accelerometer_lag + step)
    body[ACCELERATION_X] += share * (felt_x - body[ACCELERATION_X])
    body[ACCELERATION_Y] += share * (felt_y - body[ACCELERATION_Y])
