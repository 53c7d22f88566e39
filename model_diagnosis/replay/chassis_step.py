"""Body of the replay's car: loads from heave, pitch and roll on springs and tyres, and the motion in the plane.

Compression of a corner c = -z + x theta - y phi (theta nose down, phi left side up). Spring, bar and tyre act in
series, so that a corner's force is k k_t/(k + k_t) of the axle's mean compression and, with the anti-roll bar a,
(k + 2a) k_t/(k + 2a + k_t) of half its difference. The load transfer lags as the body does. Pitch and heave are coupled
where the springs' centre is not the centre of gravity, unless the body pitches about the former.
"""

import math

from numba import njit

from model_diagnosis.replay.derived import GRAVITY
from model_diagnosis.replay.record import Record

_LARGEST_ANGLE = 0.4
"""Pitch and roll [rad] beyond which the small angles of this model mean nothing; a car that tips over stays there."""


@njit(cache=True, nogil=True, error_model="numpy")
def move_body(p: Record, s: Record, step: float) -> None:
    """Loads of the four wheels, then one step of heave, pitch and roll under them."""
    speed = s.speed
    lift_front, lift_rear = p.lift_front * speed * speed, p.lift_rear * speed * speed
    up = lift_front + lift_rear
    nose_down = -p.wheel_x[0] * lift_front - p.wheel_x[2] * lift_rear
    left_up = 0.0
    s.spin_momentum = 0.0
    about_wheels = 0.0  # moments on the car about the wheels' axes: spin-up, and rolling resistance from the ground
    for i in range(4):
        x, y = p.wheel_x[i], p.wheel_y[i]
        # the axle's mean compression, and half its difference to the other wheel
        arm = p.pitch_arm[i]
        mean, half = arm * s.pitch - s.heave, -y * s.roll
        mean_share, half_share = p.mean_share[i], p.half_share[i]
        travel = mean_share * mean + half_share * half
        mean_rate, half_rate = mean_share * (arm * s.pitch_rate - s.heave_rate), -half_share * y * s.roll_rate
        rate = mean_rate + half_rate
        damping = p.compression_damping[i] if rate > 0.0 else p.rebound_damping[i]
        change = p.mean_rate[i] * mean + p.half_rate[i] * half
        change += damping * (mean_share * mean_rate + half_share * half_rate)
        deep = travel - p.bump_clearance[i]
        if deep > 0.0:
            change += (p.bump_rate[i] + p.bump_progression[i] * deep) * deep
        force_x = s.tyre_x[i]
        change += (p.guide_brake[i] if force_x < 0.0 else p.guide_drive[i]) * force_x
        # the wheel travels along the body's z axis, which leans with the body
        change += (p.guide_side[i] + p.guide_lean * s.roll) * s.tyre_y[i] - p.guide_lean * s.pitch * force_x
        change = max(change, -p.static_load[i])
        s.load[i], s.travel[i], s.travel_rate[i] = p.static_load[i] + change, travel, rate
        up += change
        nose_down -= x * change
        left_up += y * change
        s.spin_momentum += p.spin_inertia[i] * s.spin[i]
        about_wheels += p.spin_inertia[i] * s.spin_rate[i] + s.rolling_torque[i]
    weight, above = p.mass * GRAVITY, p.height - p.radius[0]
    drag = p.drag * speed * speed
    nose_down += weight * (above + p.pitch_weight_arm) * s.pitch - about_wheels
    nose_down -= p.height * (s.force_x + drag) + (p.drag_height - p.height) * drag
    left_up += weight * (above + p.roll_weight_arm) * s.roll + p.height * s.force_y + s.yaw_rate * s.spin_momentum
    s.heave_rate += step * up * p.inverse_sprung
    s.pitch_acceleration, s.roll_acceleration = nose_down * p.inverse_pitch, left_up * p.inverse_roll
    s.pitch_rate += step * s.pitch_acceleration
    s.roll_rate += step * s.roll_acceleration
    s.heave += step * s.heave_rate
    s.pitch = min(max(s.pitch + step * s.pitch_rate, -_LARGEST_ANGLE), _LARGEST_ANGLE)
    s.roll = min(max(s.roll + step * s.roll_rate, -_LARGEST_ANGLE), _LARGEST_ANGLE)


@njit(cache=True, nogil=True, error_model="numpy")
def _air(p: Record, s: Record) -> tuple[float, float, float]:
    """Air forces along and across, and their yaw moment."""
    along, across = s.speed + p.wind_along, s.lateral_speed + p.wind_across
    speed = math.sqrt(along * along + across * across)
    side = -p.side_force * speed * across
    return -p.drag * speed * along, side - p.drag * speed * across, side * p.side_force_position


@njit(cache=True, nogil=True, error_model="numpy")
def felt_share(p: Record, step: float) -> float:
    """Share of a step's acceleration that its end shows: the accelerometer's lag counts from the middle of the step."""
    return min(step / (p.accelerometer_lag + 0.5 * step), 1.0)


@njit(cache=True, nogil=True, error_model="numpy")
def move_in_plane(p: Record, s: Record, step: float) -> None:
    """One step of speed, lateral speed and yaw rate under tyre forces, air and slope."""
    force_x, force_y, moment = _air(p, s)
    for i in range(4):
        sine, cosine = s.sine[i], s.cosine[i]
        at_x = cosine * s.tyre_x[i] - sine * s.tyre_y[i]
        at_y = sine * s.tyre_x[i] + cosine * s.tyre_y[i]
        force_x += at_x
        force_y += at_y
        moment += p.wheel_x[i] * at_y - p.wheel_y[i] * at_x + s.aligning[i]
    s.force_x, s.force_y = force_x, force_y
    along, across, turn = force_x * p.inverse_mass, force_y * p.inverse_mass, s.yaw_rate
    acceleration_x = along + s.lateral_speed * turn - GRAVITY * (p.grade + s.grade)
    acceleration_y = across - s.speed * turn - GRAVITY * (p.bank + s.bank)
    s.yaw_acceleration = (moment - p.guide_lean * s.roll_rate * s.spin_momentum) * p.inverse_yaw
    s.speed_rate = acceleration_x
    s.speed = max(s.speed + step * acceleration_x, 0.0)
    s.lateral_speed += step * acceleration_y
    s.yaw_rate += step * s.yaw_acceleration
    s.distance += step * s.speed
    # the accelerometer stands at its place in the body and leans with it
    felt_x = along - GRAVITY * s.pitch - turn * turn * p.place_x - s.yaw_acceleration * p.place_y
    felt_y = across + GRAVITY * s.roll - turn * turn * p.place_y + s.yaw_acceleration * p.place_x
    share = felt_share(p, step)
    s.acceleration_x += share * (felt_x - s.acceleration_x)
    s.acceleration_y += share * (felt_y - s.acceleration_y)
