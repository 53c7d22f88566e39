"""Inputs of the longitudinal estimators: which there are, and how wheels become axles.

Both wheels of an axle are merged (friction document 2.4.3): wheel speed is their mean, torque their sum.
"""

from numba import njit

from estimators.inputs import FRESH, VALUE
from estimators.kalman.covariance import FloatArray

# rows of the input guard, in the order of MOTION_INPUTS and TORQUE_INPUTS
IN_ACCELERATION, IN_WHEEL_FL, IN_WHEEL_FR, IN_WHEEL_RL, IN_WHEEL_RR = range(5)
IN_PRESSURE_FL, IN_PRESSURE_FR, IN_PRESSURE_RL, IN_PRESSURE_RR, IN_DRIVE_F, IN_DRIVE_R = range(5, 11)

DRIVE_F, DRIVE_R, BRAKE_F, BRAKE_R = range(4)


@njit(cache=True)
def axle_speeds(guard: FloatArray) -> tuple[float, float]:
    """Mean wheel speed of the front and of the rear axle [rad/s]."""
    front = 0.5 * (guard[IN_WHEEL_FL, VALUE] + guard[IN_WHEEL_FR, VALUE])
    rear = 0.5 * (guard[IN_WHEEL_RL, VALUE] + guard[IN_WHEEL_RR, VALUE])
    return front, rear


@njit(cache=True)
def slower_wheels(guard: FloatArray) -> tuple[float, float]:
    """Speed of the slower wheel of the front and of the rear axle [rad/s]."""
    front = min(guard[IN_WHEEL_FL, VALUE], guard[IN_WHEEL_FR, VALUE])
    rear = min(guard[IN_WHEEL_RL, VALUE], guard[IN_WHEEL_RR, VALUE])
    return front, rear


@njit(cache=True)
def fresh_axles(guard: FloatArray) -> tuple[bool, bool]:
    """Whether both wheel speeds of the front and of the rear axle are new in this tick."""
    front = guard[IN_WHEEL_FL, FRESH] * guard[IN_WHEEL_FR, FRESH] > 0.0
    rear = guard[IN_WHEEL_RL, FRESH] * guard[IN_WHEEL_RR, FRESH] > 0.0
    return front, rear


@njit(cache=True)
def axle_torques(guard: FloatArray, gain_front: float, gain_rear: float, capacity: bool, torques: FloatArray) -> None:
    """Drive torque and brake torque of each axle [N m], the sums over their wheels.

    Parameters
    ----------
    guard : array, shape (11, 7)
        Of :func:`estimators.inputs.accept_inputs`, for motion and torque inputs.
    gain_front, gain_rear : float
        Torque over pressure of one wheel's brake [N m/Pa].
    capacity : bool
        True where a brake's torque is what it can transmit; False where it acts as it is.
    torques : array, shape (4,)
        Filled: drive front, rear, capacity of the brakes front, rear.
    """
    torques[DRIVE_F] = guard[IN_DRIVE_F, VALUE]
    torques[DRIVE_R] = guard[IN_DRIVE_R, VALUE]
    brake_f = gain_front * max(0.0, guard[IN_PRESSURE_FL, VALUE] + guard[IN_PRESSURE_FR, VALUE])
    brake_r = gain_rear * max(0.0, guard[IN_PRESSURE_RL, VALUE] + guard[IN_PRESSURE_RR, VALUE])
    if capacity:
        torques[BRAKE_F], torques[BRAKE_R] = brake_f, brake_r
        return
    torques[BRAKE_F], torques[BRAKE_R] = 0.0, 0.0
    torques[DRIVE_F] -= brake_f
    torques[DRIVE_R] -= brake_r
