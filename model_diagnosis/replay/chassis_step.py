"""Body of the replay's car: loads from heave, pitch and roll on springs and tyres, and the motion in the plane.

Compression of a corner c = -z + x theta - y phi (theta nose down, phi left side up). Spring, bar and tyre act in
series, so that a corner's force is k k_t/(k + k_t) of the axle's mean compression and, with the anti-roll bar a,
(k + 2a) k_t/(k + 2a + k_t) of half its difference. The load transfer lags as the body does. Pitch and heave are coupled
where the springs' centre is not the centre of gravity, unless the body pitches about the former.
"""

import math

from numba import njit

from model_diagnosis.replay.derived import GRAVITY
from model_diagnosis.replay.lanes import some, where
from model_diagnosis.replay.record import Record

_LARGEST_ANGLE = 0.4
"""Pitch and roll [rad] beyond which the small angles of this model mean nothing; a car that tips over stays there."""

_SHORTEST_LAG_S = 1e-6


@njit(cache=True, nogil=True, forceinline=True, error_model="numpy")
def look_ahead(s: Record, step: float) -> None:
    """Motion in the middle of the step, by what the step before has left: forces that act over it follow from there.

    With forces of its beginning a wheel's slip in a stop would be off by the change of speed in half a step.
    """
    half = 0.5 * step
    s.mid_speed = s.speed + half * s.speed_rate
    s.mid_lateral_speed = s.lateral_speed + half * s.lateral_rate
    s.mid_yaw_rate = s.yaw_rate + half * s.yaw_acceleration
    s.mid_pitch_rate = s.pitch_rate + half * s.pitch_acceleration
    s.mid_roll_rate = s.roll_rate + half * s.roll_acceleration
    s.mid_pitch, s.mid_roll = s.pitch + half * s.pitch_rate, s.roll + half * s.roll_rate


@njit(cache=True, nogil=True, forceinline=True, error_model="numpy")
def push_by_links(p: Record, s: Record) -> float:
    """Forces [N] by which each wheel's links push the body up; their sum. They feel what acts along and across it."""
    up = 0.0
    for i in range(4):
        force_x, force_y = s.ground_force_x[i], s.ground_force_y[i]
        # a rigid axle pushes up both sides alike
        supported = force_x + 0.5 * (1.0 - p.support_apart) * (s.ground_force_x[i ^ 1] - force_x)
        push = where(supported < 0.0, p.guide_brake[i], p.guide_drive[i]) * supported + p.guide_side[i] * force_y
        s.link_push[i] = push
        up += push
    return up


@njit(cache=True, nogil=True, forceinline=True, error_model="numpy")
def load_wheels(p: Record, s: Record, step: float) -> None:
    """Loads of the four wheels in the middle of the step, and what springs, dampers and links do to the body."""
    speed, roll, pitch = s.mid_speed, s.mid_roll, s.mid_pitch
    heave, heave_rate = s.heave + 0.5 * step * s.heave_rate, s.heave_rate + 0.5 * step * s.heave_acceleration
    air_speed = speed + p.wind_along
    lift_front, lift_rear = p.lift_front * air_speed * air_speed, p.lift_rear * air_speed * air_speed
    up = lift_front + lift_rear
    nose_down = -p.wheel_x[0] * lift_front - p.wheel_x[2] * lift_rear
    left_up = 0.0
    # of the sum of what links push, as a share of the weight, which takes it back where it lies itself
    held = p.link_lift_held * push_by_links(p, s) * p.inverse_mass / GRAVITY
    for i in range(4):
        x, y = p.wheel_x[i], p.wheel_y[i]
        # the axle's mean compression, and half its difference to the other wheel
        arm = p.pitch_arm[i]
        mean, half = arm * pitch - heave, -y * roll
        mean_share, half_share = p.mean_share[i], p.half_share[i]
        travel = mean_share * mean + half_share * half
        mean_rate, half_rate = mean_share * (arm * s.mid_pitch_rate - heave_rate), -half_share * y * s.mid_roll_rate
        rate = mean_rate + half_rate
        # rated by what its force goes with: where that is 0, nothing jumps
        damped = mean_share * mean_rate + half_share * half_rate
        damping = where(damped > 0.0, p.compression_damping[i], p.rebound_damping[i])
        change = p.mean_rate[i] * mean + p.half_rate[i] * half + damping * damped
        deep = travel - p.bump_clearance[i]
        if some(deep > 0.0):
            deep = max(deep, 0.0)
            change += (p.bump_rate[i] + p.bump_progression[i] * deep) * deep
        change += s.link_push[i] - held * p.static_load[i]
        # the wheel travels along the body's z axis, which leans with the body
        change += p.guide_lean * (roll * s.ground_force_y[i] - pitch * s.ground_force_x[i])
        change = max(change, -p.static_load[i])
        s.load[i], s.travel[i], s.travel_rate[i] = p.static_load[i] + change, travel, rate
        up += change
        nose_down -= x * change
        left_up += y * change
    s.spring_up, s.spring_nose_down, s.spring_left_up = up, nose_down, left_up


@njit(cache=True, nogil=True, forceinline=True, error_model="numpy")
def move_body(p: Record, s: Record, step: float) -> None:
    """One step of heave, pitch and roll under the forces of this step."""
    s.spin_momentum = 0.0
    about_wheels = 0.0  # moments on the car about the wheels' axes: spin-up, and rolling resistance from the ground
    for i in range(4):
        s.spin_momentum += p.spin_inertia[i] * s.spin[i]
        about_wheels += p.spin_inertia[i] * s.spin_rate[i] + s.rolling_torque[i]
    weight, above = p.mass * GRAVITY, p.height - p.radius[0]
    # tyres push at the road, the air at its height, added terms at the centre of gravity
    over_air = p.height - p.drag_height
    nose_down = s.spring_nose_down + weight * (above + p.pitch_weight_arm) * s.mid_pitch - about_wheels
    nose_down -= p.height * s.ground_x + over_air * s.air_x
    left_up = s.spring_left_up + weight * (above + p.roll_weight_arm) * s.mid_roll
    left_up += p.height * s.ground_y + over_air * s.air_y + s.mid_yaw_rate * s.spin_momentum
    s.heave_acceleration = s.spring_up * p.inverse_sprung
    s.pitch_acceleration, s.roll_acceleration = nose_down * p.inverse_pitch, left_up * p.inverse_roll
    s.heave += step * (s.heave_rate + 0.5 * step * s.heave_acceleration)
    pitch = s.pitch + step * (s.pitch_rate + 0.5 * step * s.pitch_acceleration)
    roll = s.roll + step * (s.roll_rate + 0.5 * step * s.roll_acceleration)
    s.pitch = min(max(pitch, -_LARGEST_ANGLE), _LARGEST_ANGLE)
    s.roll = min(max(roll, -_LARGEST_ANGLE), _LARGEST_ANGLE)
    s.heave_rate += step * s.heave_acceleration
    s.pitch_rate += step * s.pitch_acceleration
    s.roll_rate += step * s.roll_acceleration


@njit(cache=True, nogil=True, forceinline=True, error_model="numpy")
def _air(p: Record, s: Record) -> tuple[float, float, float]:
    """Air forces along and across, and their yaw moment."""
    along, across = s.mid_speed + p.wind_along, s.mid_lateral_speed + p.wind_across
    speed = math.sqrt(along * along + across * across)
    side = -p.side_force * speed * across
    return -p.drag * speed * along, side - p.drag * speed * across, side * p.side_force_position


@njit(cache=True, nogil=True, forceinline=True, error_model="numpy")
def prepare_accelerometer(p: Record, s: Record, step: float) -> None:
    """What a step leaves of the accelerometer's second-order low-pass, exact for an acceleration that rests over it.

    x'' = w^2 (a - x) - 2 z w x' with the lag 2 z/w at low frequencies; damping from 1 on acts like 0.999.
    """
    damping = min(p.accelerometer_damping, 0.999)
    lags = (p.accelerometer_lag >= _SHORTEST_LAG_S) & (damping > 0.0)
    frequency = 2.0 * damping / max(p.accelerometer_lag, _SHORTEST_LAG_S)
    swing = frequency * math.sqrt(1.0 - damping * damping)
    falls = damping * frequency
    left = math.exp(-falls * step)
    cosine, sine = left * math.cos(swing * step), left * math.sin(swing * step) / swing
    s.felt_kept, s.felt_of_rate = where(lags, cosine + falls * sine, 0.0), where(lags, sine, 0.0)
    s.felt_rate_of = where(lags, -frequency * frequency * sine, 0.0)
    s.felt_rate_kept = where(lags, cosine - falls * sine, 0.0)


@njit(cache=True, nogil=True, forceinline=True, error_model="numpy")
def feel(s: Record, felt_x: float, felt_y: float) -> None:
    """One step of the accelerometer under specific forces that rest over it."""
    off_x, off_y = s.acceleration_x - felt_x, s.acceleration_y - felt_y
    s.acceleration_x = felt_x + s.felt_kept * off_x + s.felt_of_rate * s.felt_rate_x
    s.acceleration_y = felt_y + s.felt_kept * off_y + s.felt_of_rate * s.felt_rate_y
    s.felt_rate_x = s.felt_rate_of * off_x + s.felt_rate_kept * s.felt_rate_x
    s.felt_rate_y = s.felt_rate_of * off_y + s.felt_rate_kept * s.felt_rate_y


@njit(cache=True, nogil=True, forceinline=True, error_model="numpy")
def move_in_plane(p: Record, s: Record, step: float) -> None:
    """One step of speed, lateral speed and yaw rate under tyre forces, air and slope."""
    s.air_x, s.air_y, moment = _air(p, s)
    s.ground_x = s.ground_y = 0.0
    for i in range(4):
        sine, cosine = s.sine[i], s.cosine[i]
        at_x = cosine * s.tyre_x[i] - sine * s.tyre_y[i]
        at_y = sine * s.tyre_x[i] + cosine * s.tyre_y[i]
        s.ground_force_x[i], s.ground_force_y[i] = at_x, at_y
        s.ground_x += at_x
        s.ground_y += at_y
        moment += p.wheel_x[i] * at_y - p.wheel_y[i] * at_x + s.aligning[i]
    moment += s.term_yaw_moment
    along = (s.ground_x + s.air_x + s.term_force_x) * p.inverse_mass
    across, turn = (s.ground_y + s.air_y + s.term_force_y) * p.inverse_mass, s.mid_yaw_rate
    s.speed_rate = along + s.mid_lateral_speed * turn - GRAVITY * (p.grade + s.grade)
    s.lateral_rate = across - s.mid_speed * turn - GRAVITY * (p.bank + s.bank)
    s.yaw_acceleration = (moment - p.guide_lean * s.mid_roll_rate * s.spin_momentum) * p.inverse_yaw
    before = s.speed
    s.speed = max(before + step * s.speed_rate, 0.0)
    s.lateral_speed += step * s.lateral_rate
    s.yaw_rate += step * s.yaw_acceleration
    s.distance += 0.5 * step * (before + s.speed)
    # the accelerometer stands at its place in the body and leans with it and the road; a levelled one reads no gravity
    leaning, level = p.accelerometer_leaning, 1.0 - p.accelerometer_leaning
    weight_x = GRAVITY * (leaning * s.mid_pitch + level * (p.grade + s.grade))
    weight_y = GRAVITY * (leaning * s.mid_roll - level * (p.bank + s.bank))
    felt_x = along - weight_x - turn * turn * p.place_x - s.yaw_acceleration * p.place_y
    felt_y = across + weight_y - turn * turn * p.place_y + s.yaw_acceleration * p.place_x
    feel(s, felt_x, felt_y)
