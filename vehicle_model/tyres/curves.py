"""Friction curves of one direction, compiled: value and slope over slip."""

import math

import numpy as np
from numba import njit
from numpy.typing import NDArray


@njit(cache=True)
def magic_formula(slip: float, stiffness: float, shape: float, peak: float, curvature: float) -> tuple[float, float]:
    """Friction or force and its slope at a slip (eq. 5, 7; eq. 88 with curvature 0).

    Parameters
    ----------
    slip
        Slip, any sign.
    stiffness, shape, peak, curvature
        B, C, D and E; the result has the unit of the peak.
    """
    x = stiffness * slip
    if curvature == 0.0:
        y, y_slope = x, stiffness
    else:
        y = x - curvature * (x - math.atan(x))
        y_slope = stiffness * (1.0 - curvature * (x * x / (1.0 + x * x)))
    angle = shape * math.atan(y)
    return peak * math.sin(angle), peak * math.cos(angle) * shape * y_slope / (1.0 + y * y)


LEAST_PEAK_SLIP, MOST_PEAK_SLIP = 0.01, 1.0
"""Limits of what `magic_formula_peak` finds."""


@njit(cache=True)
def magic_formula_peak(stiffness: float, shape: float, curvature: float) -> float:
    """Slip at the peak, within its limits: B s - E (B s - arctan(B s)) = tan(pi/(2 C)) by Newton's method."""
    if shape <= 1.0 or stiffness == 0.0:
        return MOST_PEAK_SLIP
    wanted = math.tan(math.pi / (2.0 * shape))
    x = wanted
    for _ in range(6):
        x -= (x - curvature * (x - math.atan(x)) - wanted) / max(1.0 - curvature * x * x / (1.0 + x * x), 0.05)
    return min(max(abs(x / stiffness), LEAST_PEAK_SLIP), MOST_PEAK_SLIP)


@njit(cache=True)
def load_dependent(a: NDArray[np.float64], load: float) -> tuple[float, float, float, float]:
    """B, C, D over the load and E at a load [N] from a0 to a8 of eq. 6; D and B C D keep 1 % of a2 and a4 at least."""
    shape = a[0]
    peak = max(a[1] * load + a[2], 0.01 * a[2])
    slope = max(a[3] * load + a[4], 0.01 * a[4]) * math.exp(-a[5] * load)
    curvature = min(a[6] * load * load + a[7] * load + a[8], 1.0)
    return slope / max(shape * peak, 1e-9), shape, peak, curvature


@njit(cache=True)
def burckhardt(slip: float, c1: float, c2: float, c3: float, c4: float, speed: float) -> tuple[float, float]:
    """Friction and its slope at the magnitude of the resultant slip (eq. 10 without its load factor; eq. 9: c4 = 0).

    Parameters
    ----------
    slip
        Magnitude of the resultant slip, not negative.
    c1, c2, c3
        Coefficients of Table 3.
    c4 : s/m
        Influence of the speed, 0 in eq. 9.
    speed : m/s
        Speed of the car.
    """
    decay = math.exp(-c2 * slip)
    base = c1 * (1.0 - decay) - c3 * slip
    base_slope = c1 * c2 * decay - c3
    if c4 == 0.0:
        return base, base_slope
    fade = math.exp(-c4 * slip * speed)
    return base * fade, (base_slope - c4 * speed * base) * fade
