"""The five slip definitions of the friction document (section 2.1, S1 to S5), kept apart by name.

v_p is the velocity of the contact point over the road (the vehicle's speed when it drives straight), v_k the
circumferential speed of the wheel (radius times rotational speed), alpha the slip angle. Signs differ: S1 is positive
when braking, S2, S4 and S5 are negative when braking, S3 is negative when braking. All functions take scalars or arrays
and give zero where every speed is zero.
"""

import numpy as np
from numpy.typing import ArrayLike, NDArray

Values = NDArray[np.float64]


def _ratio(numerator: ArrayLike, denominator: ArrayLike) -> Values:
    """Quotient; 0 for 0/0, infinite with the numerator's sign for x/0."""
    top, bottom = np.broadcast_arrays(np.asarray(numerator, float), np.asarray(denominator, float))
    with np.errstate(divide="ignore", invalid="ignore"):
        return np.where((top == 0.0) & (bottom == 0.0), 0.0, top / bottom)


def slip_general(speed_x: ArrayLike, speed_y: ArrayLike, wheel_speed: ArrayLike) -> tuple[Values, Values]:
    """S1: general definition, **positive when braking**.

    Parameters
    ----------
    speed_x, speed_y : m/s
        Velocity v_p of the contact point along and across the wheel.
    wheel_speed : m/s
        Circumferential speed v_k.

    Returns
    -------
    s_x, s_y
        (v_px - v_k)/v_p and v_py/v_p with the magnitude v_p.

    Source: Enisz 2015, eq. 3 and 4, l. 317-325.
    """
    magnitude = np.hypot(speed_x, speed_y)
    return _ratio(np.subtract(speed_x, wheel_speed), magnitude), _ratio(speed_y, magnitude)


def slip_burckhardt(speed: ArrayLike, wheel_speed: ArrayLike, slip_angle: ArrayLike) -> tuple[Values, Values, Values]:
    """S2: Burckhardt's slip, negative when braking.

    Parameters
    ----------
    speed, wheel_speed : m/s
        Magnitude v_p of the contact point's velocity and circumferential speed v_k, both not negative.
    slip_angle : rad
        Angle alpha between the wheel's plane and its velocity.

    Returns
    -------
    s_x, s_y, s
        Components and resultant sqrt(s_x^2 + s_y^2).

    Source: Enisz 2015, eq. 8, l. 381.
    """
    along = np.multiply(wheel_speed, np.cos(slip_angle))
    braking = along <= np.asarray(speed, float)
    longitudinal = _ratio(along - speed, np.where(braking, speed, along))
    lateral = np.where(braking, _ratio(np.multiply(wheel_speed, np.sin(slip_angle)), speed), np.tan(slip_angle))
    return longitudinal, lateral, np.hypot(longitudinal, lateral)


def slip_tmeasy(speed_x: ArrayLike, speed_y: ArrayLike, wheel_speed: ArrayLike) -> tuple[Values, Values]:
    """S3: TMEasy's slip, referred to the wheel; negative when braking, minus infinity for a locked wheel.

    Parameters
    ----------
    speed_x, speed_y, wheel_speed : m/s
        As in :func:`slip_general`.

    Returns
    -------
    s_x, s_y
        -(v_px - v_k)/|v_k| and -v_py/|v_k|.

    Source: Enisz 2015, eq. 11, l. 415.
    """
    magnitude = np.abs(wheel_speed)
    return _ratio(-np.subtract(speed_x, wheel_speed), magnitude), _ratio(np.negative(speed_y), magnitude)


def slip_bicycle(speed: ArrayLike, wheel_speed: ArrayLike) -> Values:
    """S4: (R omega - v)/v, slip of the bicycle model; -1 for a locked wheel, unbounded for a spinning one.

    Parameters
    ----------
    speed, wheel_speed : m/s
        v and R omega.

    Source: Enisz 2015, eq. 71, l. 857.
    """
    return _ratio(np.subtract(wheel_speed, speed), speed)


def slip_friction_filter(speed: ArrayLike, wheel_speed: ArrayLike) -> Values:
    """S5: (R omega - v)/max(R omega, v), slip of the friction EKF, within -1 (locked) and 1 (spinning on the spot).

    Parameters
    ----------
    speed, wheel_speed : m/s
        v and R omega, both not negative.

    Source: Enisz 2015, eq. 97, l. 1016.
    """
    return _ratio(np.subtract(wheel_speed, speed), np.maximum(wheel_speed, speed))
