"""From wheels to the axles of a single-track model: everything per axle, or nothing (friction document 2.4.3).

A single-track model merges the two wheels of an axle. Its forces are axle forces, so inertia and torque have to be the
axle's too: the tables give the inertia of one wheel and the figures the mean torque of two wheels, and neither may meet
an axle force unconverted.
"""


def axle_inertia(left: float, right: float) -> float:
    """Spin inertia of an axle [kg m^2] from those of its wheels: their sum, twice one wheel's for equal wheels."""
    return left + right


def axle_torque(left: float, right: float) -> float:
    """Torque of an axle [N m] from those of its wheels: their sum."""
    return left + right


def axle_torque_from_mean(mean: float) -> float:
    """Torque of an axle [N m] from the mean torque of its two wheels, as the source's figures show it."""
    return 2.0 * mean


def axle_speed(left: float, right: float) -> float:
    """Rotational speed of an axle [rad/s]: the mean of its wheels."""
    return 0.5 * (left + right)


def axle_acceleration(torque: float, force_x: float, radius: float, inertia: float) -> float:
    """Rotational acceleration [rad/s^2] of a free axle: (M - F_x R)/Theta, all of the axle (eq. 69 [REC], eq. 91)."""
    return (torque - force_x * radius) / inertia
