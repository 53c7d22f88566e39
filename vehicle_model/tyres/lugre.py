"""LuGre and Dahl tyres, average lumped, in steady state, compiled.

dz/dt = v_r - sigma0 |v_r|/g(v_r) z - kappa |R omega| z, F = F_z (sigma0 z + sigma2 v_r),
g = mu_c + (mu_s - mu_c) exp(-sqrt(|v_r|/v_s)) (Canudas de Wit et al. 2003; both directions: Velenis, Tsiotras 2005).
The lag of z is the plant's relaxation length, 1/kappa at small slip. Dahl: g constant, no viscous friction.
"""

import math

import numpy as np
from numba import njit
from numpy.typing import NDArray

from vehicle_model.tyres.prepared_row import STIFFNESS_X, STIFFNESS_Y
from vehicle_model.tyres.slip_shares import faded_trail, shares

# parameters; kept for one step
STATIC, COULOMB, STRIBECK, VISCOUS, SIGMA_X, SIGMA_Y, RENEWAL, TRAIL = range(8)
_STATIC, _COULOMB, _STRIBECK, _VISCOUS, _SIGMA_X, _SIGMA_Y, _RENEWAL, _TRAIL, _LOAD = range(9)


@njit(cache=True)
def prepare_lugre(
    parameters: NDArray[np.float64],
    friction: float,
    load: float,
    speed: float,
    header: NDArray[np.float64],
    kept: NDArray[np.float64],
) -> None:
    """Coefficients for one step; the road's friction scales g and sigma2, not sigma0. Peaks are found by the caller."""
    kept[_STATIC], kept[_COULOMB] = parameters[STATIC] * friction, parameters[COULOMB] * friction
    kept[_STRIBECK] = speed / parameters[STRIBECK]
    kept[_VISCOUS] = parameters[VISCOUS] * friction * speed
    kept[_SIGMA_X], kept[_SIGMA_Y] = parameters[SIGMA_X], parameters[SIGMA_Y]
    kept[_RENEWAL], kept[_TRAIL], kept[_LOAD] = parameters[RENEWAL], parameters[TRAIL], load
    header[STIFFNESS_X] = load * (parameters[SIGMA_X] / parameters[RENEWAL] + kept[_VISCOUS])
    header[STIFFNESS_Y] = load * (parameters[SIGMA_Y] / parameters[RENEWAL] + kept[_VISCOUS])


@njit(cache=True)
def forces_lugre(
    kept: NDArray[np.float64], slip_x: float, slip_y: float, direction: float
) -> tuple[float, float, float]:
    """Longitudinal and side force, derivative of the first by ``slip_x`` (driving: at constant speed of sliding)."""
    rolling, travelling = shares(slip_x, direction)
    slip = math.sqrt(slip_x * slip_x + slip_y * slip_y)
    root = math.sqrt(kept[_STRIBECK] / travelling * slip)
    fading = (kept[_STATIC] - kept[_COULOMB]) * math.exp(-root)
    g = max(kept[_COULOMB] + fading, 1e-9)
    viscous = kept[_VISCOUS] / travelling
    lost_x = kept[_SIGMA_X] * slip / g + kept[_RENEWAL] * rolling
    lost_y = kept[_SIGMA_Y] * slip / g + kept[_RENEWAL] * rolling
    stuck = kept[_SIGMA_X] / lost_x
    by_slip = slip_x / slip if slip > 0.0 else 0.0
    # d(slip/g): the friction falls with the root of the sliding speed
    rise = by_slip / g * (1.0 + 0.5 * root * fading / g)
    of_rolling = -math.copysign(kept[_RENEWAL], slip_x) if rolling < 1.0 else 0.0
    slope = stuck - stuck * slip_x * (kept[_SIGMA_X] * rise + of_rolling) / lost_x
    load = kept[_LOAD]
    force_x = load * (stuck + viscous) * slip_x
    return force_x, load * (kept[_SIGMA_Y] / lost_y + viscous) * slip_y, load * (slope + viscous)


@njit(cache=True)
def trail_lugre(kept: NDArray[np.float64], slip_x: float, slip_y: float, direction: float) -> float:
    """Pneumatic trail [m]: that of a brush of the same stiffness."""
    rolling, _ = shares(slip_x, direction)
    wanted = math.sqrt((kept[_SIGMA_X] * slip_x) ** 2 + (kept[_SIGMA_Y] * slip_y) ** 2) / kept[_RENEWAL]
    return faded_trail(kept[_TRAIL], wanted, kept[_STATIC] * rolling)
