"""The ECU's own picture of the wheel pressures: what its valve commands have made of the master pressure."""

from typing import Any

import numpy as np
from numba import njit

from bench.ecu.records import TASK_S


@njit(cache=True)
def estimate_pressures(calibration: Any, state: Any) -> None:
    """Carry the pressures over the last task with the valves as they were commanded."""
    filled = 1.0 - np.exp(-TASK_S / calibration.pressure_increase_time_constant)
    kept = np.exp(-TASK_S / calibration.pressure_decrease_time_constant)
    for wheel in range(4):
        pressure = state.pressure[wheel]
        if state.outlet[wheel]:
            pressure *= kept
        elif not state.inlet[wheel]:
            pressure += filled * (state.master_pressure - pressure)
        # what is next to nothing becomes 0: numbers near the end of the floating-point range are slow
        state.pressure[wheel] = min(pressure, state.master_pressure) if pressure > 1.0 else 0.0
