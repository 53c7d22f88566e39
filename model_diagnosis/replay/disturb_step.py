"""A force, torque or moment on the replay's car that no equation of it has; compiled."""

from numba import njit

from model_diagnosis.replay.record import Record

NOWHERE = -1
FORCE_X, SLOPE, FORCE_Y, BANK, YAW, WHEEL, PITCH, ROLL = 0, 1, 2, 3, 4, 5, 9, 10
"""Where a disturbance acts: forces on the body along and across the car [N], each as one that an accelerometer feels
and one that it does not; moments about the vertical axis, at the four wheels, in pitch and in roll [N m]."""


@njit(cache=True, nogil=True, error_model="numpy")
def disturb(p: Record, s: Record, place: int, size: float, step: float) -> None:
    """One step of a disturbance of ``size`` [N or N m]."""
    if place in (FORCE_X, SLOPE):
        s.speed += step * size * p.inverse_mass
    elif place in (FORCE_Y, BANK):
        s.lateral_speed += step * size * p.inverse_mass
    elif place == YAW:
        s.yaw_rate += step * size * p.inverse_yaw
    elif place == PITCH:
        s.pitch_rate += step * size * p.inverse_pitch
    elif place == ROLL:
        s.roll_rate += step * size * p.inverse_roll
    else:
        wheel = place - WHEEL
        s.spin[wheel] = max(s.spin[wheel] + step * size / p.spin_inertia[wheel], 0.0)
    felt = size * p.inverse_mass
    if place == FORCE_X:
        s.acceleration_x += (1.0 - s.felt_kept) * felt
        s.felt_rate_x -= s.felt_rate_of * felt
    elif place == FORCE_Y:
        s.acceleration_y += (1.0 - s.felt_kept) * felt
        s.felt_rate_y -= s.felt_rate_of * felt
