"""Dugoff's tyre, compiled (Dugoff, Fancher, Segel 1969), with friction that falls with the sliding speed.

F_x = C_s kappa/(1 + kappa) f, F_y = C_a tan(alpha)/(1 + kappa) f, f = l (2 - l) for l < 1,
l = mu F_z (1 + kappa)/(2 sqrt((C_s kappa)^2 + (C_a tan(alpha))^2)), mu = mu0 (1 - e_r v_slide).
Written in slip S5, 1 + kappa is the share of the rolling speed, and nothing is divided by it where the tyre slides.
"""

import math

import numpy as np
from numba import njit
from numpy.typing import NDArray

from vehicle_model.tyres.prepared_row import STIFFNESS_X, STIFFNESS_Y
from vehicle_model.tyres.slip_shares import faded_trail, shares

# parameters; kept for one step
FRICTION, REDUCTION, SLIP_STIFFNESS, CORNERING_STIFFNESS, TRAIL = range(5)
_CAPACITY, _REDUCTION, _STIFF_X, _STIFF_Y, _TRAIL = range(5)
_LEAST_FRICTION = 0.05
"""Of mu0, that is left at any sliding speed."""


@njit(cache=True)
def prepare_dugoff(
    parameters: NDArray[np.float64],
    friction: float,
    load: float,
    speed: float,
    header: NDArray[np.float64],
    kept: NDArray[np.float64],
) -> None:
    """Coefficients for one step; the road's friction scales mu0, not the stiffnesses. Peaks are found by the caller."""
    kept[_CAPACITY] = parameters[FRICTION] * friction * load
    kept[_REDUCTION] = parameters[REDUCTION] * speed
    kept[_STIFF_X], kept[_STIFF_Y] = parameters[SLIP_STIFFNESS] * load, parameters[CORNERING_STIFFNESS] * load
    kept[_TRAIL] = parameters[TRAIL]
    header[STIFFNESS_X], header[STIFFNESS_Y] = kept[_STIFF_X], kept[_STIFF_Y]


@njit(cache=True)
def forces_dugoff(
    kept: NDArray[np.float64], slip_x: float, slip_y: float, direction: float
) -> tuple[float, float, float]:
    """Longitudinal and side force, derivative of the first by ``slip_x``."""
    rolling, travelling = shares(slip_x, direction)
    pull_x, pull_y = kept[_STIFF_X] * slip_x, kept[_STIFF_Y] * slip_y
    wanted = math.sqrt(pull_x * pull_x + pull_y * pull_y)
    slip = math.sqrt(slip_x * slip_x + slip_y * slip_y)
    left = 1.0 - kept[_REDUCTION] / travelling * slip
    capacity = kept[_CAPACITY] * max(left, _LEAST_FRICTION)
    if 2.0 * wanted <= capacity * rolling:
        slope = kept[_STIFF_X] / (rolling * rolling if rolling < 1.0 else 1.0)
        return pull_x / rolling, pull_y / rolling, slope
    # l < 1: C s/(1 + kappa) l (2 - l)
    per_wanted = capacity / wanted
    quarter = 0.25 * per_wanted * per_wanted
    share = per_wanted - quarter * rolling
    change = 0.0  # of the capacity over itself
    if left > _LEAST_FRICTION and slip > 0.0:
        change = -kept[_REDUCTION] / travelling * slip_x / slip / left
    of_rolling = -math.copysign(1.0, slip_x) if rolling < 1.0 else 0.0
    of_wanted = kept[_STIFF_X] * pull_x / (wanted * wanted)
    share_slope = per_wanted * (change - of_wanted) - quarter * (rolling * 2.0 * (change - of_wanted) + of_rolling)
    return pull_x * share, pull_y * share, kept[_STIFF_X] * share + pull_x * share_slope


@njit(cache=True)
def trail_dugoff(kept: NDArray[np.float64], slip_x: float, slip_y: float, direction: float) -> float:
    """Pneumatic trail [m]: that of a brush of the same stiffness; the formula itself has none."""
    rolling, _ = shares(slip_x, direction)
    wanted = math.sqrt((kept[_STIFF_X] * slip_x) ** 2 + (kept[_STIFF_Y] * slip_y) ** 2)
    return faded_trail(kept[_TRAIL], wanted, kept[_CAPACITY] * rolling)
