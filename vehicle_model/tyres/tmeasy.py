"""TMeasy, compiled (Enisz 2015, eqs 11 to 22; load dependence: Rill, Road Vehicle Dynamics, TMeasy).

Slip is S3: sliding over the rolling speed, so that a locked wheel is at the far end of the sliding branch.
"""

import math

import numpy as np
from numba import njit
from numpy.typing import NDArray

from vehicle_model.tyres.prepared_row import (
    PEAK_FORCE_X,
    PEAK_FORCE_Y,
    PEAK_SLIP_X,
    PEAK_SLIP_Y,
    STIFFNESS_X,
    STIFFNESS_Y,
)
from vehicle_model.tyres.slip_shares import SMALLEST_SHARE, shares

# parameters: nominal load, then rows of five (dF0, F^M, s^M, F^G, s^G) for x and y at nominal and twice nominal load,
# contact length, then rows of three ((n/L)0, s_y^0, s_y^G)
NOMINAL_LOAD, X, X_DOUBLE, Y, Y_DOUBLE, LENGTH, TRAIL, TRAIL_DOUBLE = 0, 1, 6, 11, 16, 21, 22, 25
# kept for one step: five numbers per direction, then trail, s_y^0, s_y^G
_X, _Y, _TRAIL = 0, 5, 10
_HIGHEST = 3.0
"""Load over nominal load beyond which the parabola of the forces is not followed."""


@njit(cache=True)
def _at_load(
    parameters: NDArray[np.float64], single: int, double: int, place: int, load: float, quadratic: bool
) -> float:
    """A force (parabola through zero) or a slip (straight line) at a load over the nominal one."""
    one, two = parameters[single + place], parameters[double + place]
    if not quadratic:
        return one + (two - one) * (min(load, _HIGHEST) - 1.0)
    inside = min(load, _HIGHEST)
    return load * (2.0 * one - 0.5 * two - (one - 0.5 * two) * inside)


@njit(cache=True)
def prepare_tmeasy(
    parameters: NDArray[np.float64],
    friction: float,
    load: float,
    header: NDArray[np.float64],
    kept: NDArray[np.float64],
) -> None:
    """Characteristic at the load; the road's friction scales forces and slips at the peak and of sliding, not dF0."""
    friction = max(friction, 1e-6)  # slips are divided by those of the characteristic
    relative = load / parameters[NOMINAL_LOAD]
    for place, single, double in ((_X, X, X_DOUBLE), (_Y, Y, Y_DOUBLE)):
        for k in range(5):
            value = _at_load(parameters, single, double, k, relative, k == 0 or k == 1 or k == 3)
            kept[place + k] = value if k == 0 else value * friction
    for place in (_X, _Y):  # the parabolas of peak and sliding may cross at a light load
        kept[place + 3] = min(kept[place + 3], kept[place + 1])
    relative_slip = min(relative, _HIGHEST) - 1.0
    for k in range(3):
        one, two = parameters[TRAIL + k], parameters[TRAIL_DOUBLE + k]
        kept[_TRAIL + k] = one + (two - one) * relative_slip
    kept[_TRAIL] *= parameters[LENGTH]
    kept[_TRAIL + 1] *= friction
    kept[_TRAIL + 2] *= friction
    header[PEAK_FORCE_X], header[PEAK_FORCE_Y] = kept[_X + 1], kept[_Y + 1]
    header[PEAK_SLIP_X] = kept[_X + 2] / (1.0 + kept[_X + 2])  # slip S5 of a braked wheel
    header[PEAK_SLIP_Y] = kept[_Y + 2]
    header[STIFFNESS_X], header[STIFFNESS_Y] = kept[_X], kept[_Y]


@njit(cache=True)
def _resultant(
    slip: float, slope: float, peak: float, at: float, sliding: float, from_slip: float
) -> tuple[float, float]:
    """Force and its derivative at a normalised slip, eq. 20."""
    if slip <= at:
        share = slip / at
        divisor = 1.0 + share * (share + slope * at / peak - 2.0)
        return at * slope * share / divisor, slope * (1.0 - share * share) / (divisor * divisor)
    if slip <= from_slip:
        q = (slip - at) / (from_slip - at)
        return peak - (peak - sliding) * q * q * (3.0 - 2.0 * q), -(peak - sliding) * 6.0 * q * (1.0 - q) / (
            from_slip - at
        )
    return sliding, 0.0


@njit(cache=True)
def forces_tmeasy(
    kept: NDArray[np.float64], slip_x: float, slip_y: float, direction: float
) -> tuple[float, float, float]:
    """Longitudinal and side force, derivative of the first by ``slip_x`` (change of the resultant curve left out)."""
    rolling = max(shares(slip_x, direction)[0], SMALLEST_SHARE)
    hat_x, hat_y = kept[_X + 1] / kept[_X], kept[_Y + 1] / kept[_Y]  # eq. 13
    along, across = slip_x / rolling / hat_x, slip_y / rolling / hat_y
    growth = 1.0 / (rolling * rolling * hat_x) if rolling < 1.0 else 1.0 / hat_x
    slip = math.sqrt(along * along + across * across)
    if slip < 1e-9:
        return kept[_X + 1] * along, kept[_Y + 1] * across, kept[_X + 1] * growth
    cosine, sine = along / slip, across / slip  # eq. 19
    peak = math.sqrt((kept[_X + 1] * cosine) ** 2 + (kept[_Y + 1] * sine) ** 2)  # eqs 14 to 18; dF0 of eq. 14 equals it
    at = math.sqrt((kept[_X + 2] / hat_x * cosine) ** 2 + (kept[_Y + 2] / hat_y * sine) ** 2)
    sliding = math.sqrt((kept[_X + 3] * cosine) ** 2 + (kept[_Y + 3] * sine) ** 2)
    from_slip = math.sqrt((kept[_X + 4] / hat_x * cosine) ** 2 + (kept[_Y + 4] / hat_y * sine) ** 2)
    force, rise = _resultant(slip, peak, peak, at, sliding, from_slip)
    slope = (rise * cosine * cosine + force / slip * sine * sine) * growth
    return force * cosine, force * sine, slope  # eq. 21


@njit(cache=True)
def trail_tmeasy(kept: NDArray[np.float64], slip_x: float, slip_y: float, direction: float) -> float:
    """Pneumatic trail [m], eq. 22."""
    rolling = max(shares(slip_x, direction)[0], SMALLEST_SHARE)
    slip, zero, sliding = abs(slip_y) / rolling, kept[_TRAIL + 1], kept[_TRAIL + 2]
    if slip <= zero:
        return kept[_TRAIL] * (1.0 - slip / zero)
    if slip <= sliding:
        left = (sliding - slip) / (sliding - zero)
        return -kept[_TRAIL] * (slip - zero) / zero * left * left
    return 0.0
