"""Course of a hidden term over a manoeuvre: what the logs do not show and a scorer compares answers with."""

import numpy as np
from numba import njit
from numpy.typing import NDArray

from hidden_effects.outputs import INDEX
from hidden_effects.recording import CYCLE_S
from hidden_effects.sensors import RATE_HZ
from hidden_effects.unknown_terms import torque_factor

FloatArray = NDArray[np.float64]

_PER_CYCLE = round(CYCLE_S * RATE_HZ)


def torque_course(columns: FloatArray, kind: float, size: float) -> FloatArray:
    """Relative change (n, 4) of the brake torques by a term, mean of the 10 ms about each sample of the logs.

    ``columns`` (rows, c) is a simulated manoeuvre. A mean, because valves turn pressures round within a sample.
    """
    pressures = columns[:, INDEX["pressure_fl"] : INDEX["pressure_fl"] + 4]
    rates = np.gradient(pressures, 1.0 / RATE_HZ, axis=0)
    change = _changes(kind, size, columns[:, INDEX["speed"]], columns[:, INDEX["yaw_rate"]], pressures, rates)
    half = _PER_CYCLE // 2
    padded = np.concatenate([change[:1].repeat(half, axis=0), change, change[-1:].repeat(_PER_CYCLE, axis=0)])
    samples = -(-len(change) // _PER_CYCLE)
    return np.stack([padded[k * _PER_CYCLE : (k + 1) * _PER_CYCLE].mean(axis=0) for k in range(samples)])


@njit(cache=True)
def _changes(
    kind: float, size: float, speed: FloatArray, yaw_rate: FloatArray, pressures: FloatArray, rates: FloatArray
) -> FloatArray:
    """Factor on each wheel's torque at each row, less 1."""
    result = np.empty(pressures.shape)
    for row in range(len(pressures)):
        for wheel in range(4):
            pressure, rate = pressures[row, wheel], rates[row, wheel]
            result[row, wheel] = torque_factor(kind, size, speed[row], yaw_rate[row], pressure, rate) - 1.0
    return result
