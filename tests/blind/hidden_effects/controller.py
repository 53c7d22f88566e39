"""ABS logic of the hidden car, compiled: four channels, a cycle of 10 ms, slip and wheel acceleration thresholds.

After the textbook cycle (Burckhardt, Radschlupf-Regelsysteme): release while slip or deceleration is beyond its
threshold, hold until the wheel runs up, then rebuild in steps.
"""

from typing import Any

import numpy as np
from numba import njit
from numpy.typing import NDArray

CYCLE_S = 0.01
OFF, RELEASE, HOLD, REBUILD = 0, 1, 2, 3
ENTRY_DECELERATION_M_S2 = -80.0
ENTRY_SLIP = 0.1
RUN_UP_M_S2 = -5.0
SLOWEST_M_S = 3.5
STEEPEST_FALL_M_S2 = 11.5
STEEPEST_RISE_M_S2 = 5.0
LONGEST_HOLD_S = 0.08
REBUILD_PERIOD = 3
"""Cycles of a rebuild step, one of which builds pressure."""


@njit(cache=True)
def reference_speed(before: float, rim: NDArray[np.float64]) -> float:
    """Reference speed [m/s] from four rim speeds: the second fastest, no faster than a car brakes or speeds up."""
    ordered = np.sort(rim)
    fallen, risen = before - STEEPEST_FALL_M_S2 * CYCLE_S, before + STEEPEST_RISE_M_S2 * CYCLE_S
    return min(max(ordered[2], fallen), risen)


@njit(cache=True)
def decide(
    car: Any,
    reference: float,
    rim: NDArray[np.float64],
    acceleration: NDArray[np.float64],
    braking: bool,
    phase: NDArray[np.int64],
    timer: NDArray[np.int64],
    inlet: NDArray[np.float64],
    outlet: NDArray[np.float64],
) -> bool:
    """One cycle: new phases and valve commands (1 energised: inlet shut, outlet open); True while the pump runs."""
    pump = False
    for i in range(4):
        slip = (reference - rim[i]) / max(reference, 1.0)
        if not braking or reference < SLOWEST_M_S:
            phase[i] = OFF
        elif slip > car.abs_slip or (acceleration[i] < ENTRY_DECELERATION_M_S2 and slip > ENTRY_SLIP):
            if phase[i] != RELEASE:
                timer[i] = 0
            phase[i] = RELEASE
        elif phase[i] == RELEASE and acceleration[i] > RUN_UP_M_S2:
            phase[i], timer[i] = HOLD, 0
        elif phase[i] == HOLD and timer[i] * CYCLE_S >= (car.abs_hold if slip < 0.6 * car.abs_slip else LONGEST_HOLD_S):
            phase[i], timer[i] = REBUILD, 0
        elif phase[i] == REBUILD and timer[i] > 60:
            phase[i] = OFF
        timer[i] += 1
        build = phase[i] == OFF or (phase[i] == REBUILD and timer[i] % REBUILD_PERIOD == 1)
        inlet[i] = 0.0 if build else 1.0
        outlet[i] = 1.0 if phase[i] == RELEASE and acceleration[i] < RUN_UP_M_S2 else 0.0
        pump = pump or phase[i] != OFF
    return pump
