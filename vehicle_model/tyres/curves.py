"""Friction curves of one direction, compiled: value and slope over slip."""

import math

from numba import njit


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
