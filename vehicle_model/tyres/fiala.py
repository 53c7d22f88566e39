"""Fiala's tyre, compiled, in the form of multibody programs: parabola along, cubic across (Fiala 1954).

Friction falls linearly with the comprehensive slip: U = U_max - (U_max - U_min) sqrt(s_x^2 + s_y^2). The formula has no
combined slip of its own: the side force keeps to the Kamm ellipse that the longitudinal force leaves.
"""

import math

import numpy as np
from numba import njit
from numpy.typing import NDArray

from vehicle_model.tyres.prepared_row import STIFFNESS_X, STIFFNESS_Y

# parameters; kept for one step
STATIC, SLIDING, SLIP_STIFFNESS, CORNERING_STIFFNESS, WIDTH = range(5)
_STATIC, _FALL, _STIFF_X, _STIFF_Y, _WIDTH = range(5)


@njit(cache=True)
def prepare_fiala(
    parameters: NDArray[np.float64],
    friction: float,
    load: float,
    header: NDArray[np.float64],
    kept: NDArray[np.float64],
) -> None:
    """Coefficients for one step; the road's friction scales U, not the stiffnesses. Peaks are found by the caller."""
    kept[_STATIC] = parameters[STATIC] * friction * load
    kept[_FALL] = (parameters[STATIC] - parameters[SLIDING]) * friction * load
    kept[_STIFF_X], kept[_STIFF_Y] = parameters[SLIP_STIFFNESS] * load, parameters[CORNERING_STIFFNESS] * load
    kept[_WIDTH] = parameters[WIDTH]
    header[STIFFNESS_X], header[STIFFNESS_Y] = kept[_STIFF_X], kept[_STIFF_Y]


@njit(cache=True)
def _capacity(kept: NDArray[np.float64], slip_x: float, slip_y: float) -> tuple[float, float]:
    """Friction times load and its derivative by ``slip_x``."""
    slip = math.sqrt(slip_x * slip_x + slip_y * slip_y)
    if slip >= 1.0:
        return kept[_STATIC] - kept[_FALL], 0.0
    return kept[_STATIC] - kept[_FALL] * slip, -kept[_FALL] * slip_x / slip if slip > 0.0 else 0.0


@njit(cache=True)
def _along(kept: NDArray[np.float64], slip_x: float, capacity: float, change: float) -> tuple[float, float]:
    stiffness, size = kept[_STIFF_X], abs(slip_x)
    if 2.0 * stiffness * size <= capacity:
        return stiffness * slip_x, stiffness
    sign = math.copysign(1.0, slip_x)
    quarter = capacity / (4.0 * stiffness * size)
    return sign * capacity * (1.0 - quarter), sign * change * (1.0 - 2.0 * quarter) + capacity * quarter / size


@njit(cache=True)
def forces_fiala(
    kept: NDArray[np.float64], slip_x: float, slip_y: float, direction: float
) -> tuple[float, float, float]:
    """Longitudinal and side force, derivative of the first by ``slip_x``."""
    capacity, change = _capacity(kept, slip_x, slip_y)
    if capacity <= 0.0:
        return 0.0, 0.0, 0.0
    force_x, slope = _along(kept, slip_x, capacity, change)
    height = max(1.0 - kept[_STIFF_Y] * abs(slip_y) / (3.0 * capacity), 0.0)
    used = force_x / capacity
    force_y = math.copysign(capacity * (1.0 - height * height * height), slip_y)
    return force_x, force_y * math.sqrt(max(1.0 - used * used, 0.0)), slope


@njit(cache=True)
def moment_fiala(kept: NDArray[np.float64], slip_x: float, slip_y: float) -> float:
    """Aligning moment [N m] of a wheel that travels forwards: U F_z width (1 - H) H^3 against the slip."""
    capacity, _ = _capacity(kept, slip_x, slip_y)
    if capacity <= 0.0 or slip_y == 0.0:
        return 0.0
    height = max(1.0 - kept[_STIFF_Y] * abs(slip_y) / (3.0 * capacity), 0.0)
    used = min(abs(_along(kept, slip_x, capacity, 0.0)[0]) / capacity, 1.0)
    size = capacity * kept[_WIDTH] * (1.0 - height) * height * height * height * math.sqrt(1.0 - used * used)
    return -math.copysign(size, slip_y)
