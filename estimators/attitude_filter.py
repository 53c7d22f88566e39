"""One filter of the attitude bank, compiled: Jacobians by differences, prediction, correction (attitude document 3.5).

What is called many times a step takes single arrays: handing the whole memory on costs more than a small model.
"""

import math
from typing import Any

from numba import njit

from estimators.attitude_car import car_model
from estimators.attitude_forms import PHI, ROW_SPEED
from estimators.attitude_memory import ABS, CAR, LARGEST_ROLL, PERIOD, Memory
from estimators.attitude_two_wheeler import two_wheeler_model
from estimators.kalman.correction import correct
from estimators.kalman.covariance import FloatArray, IntArray, propagate


@njit(cache=True)
def _model(x: FloatArray, u: FloatArray, bike: Any, car: Any, of_car: bool, m: FloatArray, f: Any, h: Any) -> None:
    if of_car:
        car_model(x, u, car, f, h)
    else:
        two_wheeler_model(x, u, bike, m, f, h)


@njit(cache=True)
def differences(
    x: FloatArray,
    u: FloatArray,
    bike: Any,
    car: Any,
    of_car: bool,
    entries: IntArray,
    steps: FloatArray,
    m: FloatArray,
    rates: FloatArray,
    outputs: FloatArray,
    slopes_f: FloatArray,
    slopes_h: FloatArray,
) -> None:
    """Value and Jacobians of system and observation equations at a full state, by central differences.

    Parameters
    ----------
    x : array, shape (10,)
        Comes back as it was.
    entries : array of int, shape (k,)
        Entries of x by which is differentiated.
    steps : array, shape (10,)
    m, rates, outputs : arrays, shapes (20,), (3, 4), (3, 6)
        Scratch; the first rows of ``rates`` and ``outputs`` receive f and h.
    slopes_f, slopes_h : arrays, shapes (k, 4) and (k, 6)
        Receive the derivatives by each of the entries.
    """
    for column in range(entries.shape[0]):
        entry = entries[column]
        kept, step = x[entry], steps[entry]
        x[entry] = kept + step
        _model(x, u, bike, car, of_car, m, rates[1], outputs[1])
        x[entry] = kept - step
        _model(x, u, bike, car, of_car, m, rates[2], outputs[2])
        x[entry] = kept
        scale = 0.5 / step
        for row in range(4):
            slopes_f[column, row] = scale * (rates[1, row] - rates[2, row])
        for row in range(6):
            slopes_h[column, row] = scale * (outputs[1, row] - outputs[2, row])
    _model(x, u, bike, car, of_car, m, rates[0], outputs[0])


@njit(cache=True)
def predict_filter(x: FloatArray, covariance: FloatArray, a: Memory, bike: Any, car: Any) -> None:
    """Explicit Euler over a period with the inputs of the last step; F = I + period df/dx."""
    entries, rates, slopes, period = a.entries, a.rates, a.slopes_f, a.tuning[PERIOD]
    of_car = a.tuning[CAR] > 0.0
    differences(
        x, a.inputs[1], bike, car, of_car, entries, a.steps, a.mechanics, rates, a.outputs, slopes, a.slopes_h
    )
    for row in range(entries.shape[0]):
        moved = entries[row]
        for column in range(entries.shape[0]):
            slope = period * slopes[column, moved] if moved < 4 else 0.0
            a.transition[row, column] = slope + (1.0 if row == column else 0.0)
        if moved < 4:
            x[moved] += period * rates[0, moved]
    x[PHI] = min(max(x[PHI], -a.tuning[LARGEST_ROLL]), a.tuning[LARGEST_ROLL])
    propagate(covariance, a.transition, a.process, a.work[0])


@njit(cache=True)
def correct_filter(x: FloatArray, covariance: FloatArray, a: Memory, bike: Any, car: Any) -> float:
    """Correct with the inputs of this step; normalised innovation squared, the factor of S in ``a.innovation[1]``."""
    entries, rows, outputs, slopes = a.entries, a.rows, a.outputs, a.slopes_h
    of_car = a.tuning[CAR] > 0.0
    differences(
        x, a.inputs[0], bike, car, of_car, entries, a.steps, a.mechanics, a.rates, outputs, a.slopes_f, slopes
    )
    for row in range(rows.shape[0]):
        measured = rows[row]
        # wheels that the ABS slips tell nothing of the speed
        told = 0.0 if measured == ROW_SPEED and a.status[ABS] > 0.0 else 1.0
        a.residual[row] = told * (a.measured[measured] - outputs[0, measured])
        for column in range(entries.shape[0]):
            a.design[row, column] = told * slopes[column, measured]
    for column in range(entries.shape[0]):
        a.correction[column] = 0.0
    squared = correct(
        a.correction, covariance, a.residual, a.design, a.noise, a.gain, a.work, a.wide, a.innovation
    )  # fmt: skip
    if math.isfinite(squared):
        for column in range(entries.shape[0]):
            x[entries[column]] += a.correction[column]
    x[PHI] = min(max(x[PHI], -a.tuning[LARGEST_ROLL]), a.tuning[LARGEST_ROLL])
    return squared
