"""Road grade by discrete accumulation over blocks (3.6), with the pitch of the sprung mass (2.7), compiled."""

import math
from typing import Any

from numba import njit

from estimators.vehicle_state_car import GRAVITY
from estimators.vehicle_state_model import pitch_step
from estimators.vehicle_state_record import INERTIAL


@njit(cache=True)
def model_acceleration(s: Any, t: Any) -> float:
    """a_x,calc [m/s^2]: what the model's accelerometer would show at the grade of the last block.

    The inertial acceleration of eq. 3.1 in its place counts the grade twice and runs away (3.6).
    """
    inertial = s.dv_x - s.v_y * s.w_z
    if t.grade_model == INERTIAL:
        return inertial
    return inertial + GRAVITY * math.sin(s.theta_r)


@njit(cache=True)
def _close_block(s: Any, t: Any) -> None:
    count = s.grade_count
    mean = s.grade_sum / count
    spread = max(s.grade_squares / count - mean * mean, 0.0)
    # variance of the mean, of one value where the block is too short to tell
    s.grade_variance = spread / max(count - 1, 1)
    limit = math.sin(t.largest_grade)
    s.theta_with_pitch = math.asin(min(max(mean, -limit), limit))
    s.theta_r = s.theta_with_pitch - (s.pitch if t.pitch_compensation == 1 else 0.0)
    s.theta_r = min(max(s.theta_r, -t.largest_grade), t.largest_grade)
    s.grade_sum = s.grade_squares = 0.0
    s.grade_count = 0
    s.grade_known = 1


@njit(cache=True)
def accumulate_grade(s: Any, t: Any, measured_x: float) -> None:
    """Take a tick into the block; the grade changes only where a block ends."""
    value = (measured_x - model_acceleration(s, t)) / GRAVITY + math.sin(s.theta_r)
    s.grade_sum += value
    s.grade_squares += value * value
    s.grade_count += 1
    if s.grade_count >= t.block_ticks:
        _close_block(s, t)


@njit(cache=True)
def stand_on_grade(s: Any, t: Any, measured_x: float) -> None:
    """Standstill: the accelerometer alone tells the grade (theta_r0), the longer the better."""
    s.grade_sum += measured_x / GRAVITY
    s.grade_squares += (measured_x / GRAVITY) ** 2
    s.grade_count += 1
    if s.grade_count >= t.block_ticks and s.standing_time >= t.standstill_time:
        _close_block(s, t)


@njit(cache=True)
def follow_pitch(s: Any, car: Any, t: Any) -> None:
    """Pitch under the longitudinal forces at the road, which give the car its acceleration and hold it on the grade."""
    force = car.m * (s.a_x + GRAVITY * math.sin(s.theta_r)) + car.drag * s.v_x * s.v_x
    s.pitch, s.pitch_rate = pitch_step(s.pitch, s.pitch_rate, force, t.dt, car)
