"""Steady tyre forces of the hidden car, compiled: two families of curves, each with its own combination of slips.

``arctangent``: D sin(C arctan(B s)) on the normalised slip vector (Pacejka, Tire and Vehicle Dynamics, 4.3.1).
``exponential``: c1 (1 − exp(−c2 s)) − c3 s (Burckhardt 1993, eq. 3.20), longitudinal first on a friction circle.
"""

import math

from numba import njit

ARCTANGENT = 0.0
EXPONENTIAL = 1.0
LARGEST_RELATIVE_SLIP = 50.0


@njit(cache=True)
def arctangent(slip: float, shape: float, stiffness: float) -> float:
    """Share of the peak friction at a slip; ``shape`` C, ``stiffness`` B."""
    return math.sin(shape * math.atan(stiffness * slip))


@njit(cache=True)
def peak_slip(shape: float, stiffness: float) -> float:
    """Slip at which the arctangent curve has its peak: C arctan(B s) = pi/2."""
    return math.tan(0.5 * math.pi / shape) / stiffness


@njit(cache=True)
def exponential(slip: float, shape: float, stiffness: float) -> float:
    """Exponential curve with peak 1, of the slope at zero and the locked value of the arctangent one.

    From c1 c2 − c3 = slope, c1 (1 − exp(−c2)) − c3 = locked: fixed-point for c2 with the peak at 1.
    """
    slope = shape * stiffness
    locked = math.sin(shape * math.atan(stiffness))
    c2 = slope
    c1 = 1.0
    for _ in range(30):
        # locked: c3 = c1 (1 - exp(-c2)) - locked; peak: c1 - c3/c2 (1 + ln(c1 c2/c3)) = 1
        c3 = max(c1 * (1.0 - math.exp(-c2)) - locked, 1e-3)
        c1 = 1.0 + c3 / c2 * (1.0 + math.log(c1 * c2 / c3))
        c2 = (slope + c3) / c1
    size = abs(slip)
    value = c1 * (1.0 - math.exp(-c2 * size)) - c3 * size
    return math.copysign(value, slip)


@njit(cache=True)
def steady_forces(
    curve: float,
    slip_x: float,
    slip_y: float,
    peak_x: float,
    peak_y: float,
    shape_x: float,
    shape_y: float,
    stiffness_x: float,
    stiffness_y: float,
    load: float,
) -> tuple[float, float]:
    """Forces [N] in the wheel's axes at a slip vector (driving slip and slip to the left positive).

    Parameters
    ----------
    curve : ``ARCTANGENT`` or ``EXPONENTIAL``
    peak_x, peak_y : friction at the peak
    """
    if load <= 0.0:
        return 0.0, 0.0
    if curve == EXPONENTIAL:
        force_x = peak_x * load * exponential(slip_x, shape_x, stiffness_x)
        force_y = peak_y * load * exponential(slip_y, shape_y, stiffness_y)
        size = math.sqrt((force_x / (peak_x * load)) ** 2 + (force_y / (peak_y * load)) ** 2)
        slip = math.sqrt(slip_x * slip_x + slip_y * slip_y)
        limit = exponential(slip, shape_x, stiffness_x)
        share = min(1.0, max(limit, 0.0) / size) if size > 1e-9 else 1.0
        return force_x * share, force_y * share
    at_x, at_y = peak_slip(shape_x, stiffness_x), peak_slip(shape_y, stiffness_y)
    part_x, part_y = slip_x / at_x, slip_y / at_y
    size = min(math.sqrt(part_x * part_x + part_y * part_y), LARGEST_RELATIVE_SLIP)
    if size < 1e-9:
        return 0.0, 0.0
    force_x = peak_x * load * arctangent(size * at_x, shape_x, stiffness_x) * part_x / size
    force_y = peak_y * load * arctangent(size * at_y, shape_y, stiffness_y) * part_y / size
    return force_x, force_y
