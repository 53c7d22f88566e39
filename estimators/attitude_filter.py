"""One filter of the attitude bank, compiled: Jacobians by differences, prediction, correction (attitude document 3.5).

What is called many times a step takes single arrays: handing the whole memory on costs more than a small model.
"""

import math
from typing import Any

from numba import njit

from estimators.attitude_car import car_observation, car_system
from estimators.attitude_forms import B_Y, LATERAL_SPEED, PHI, ROW_SPEED, ROW_Z, ROWS, THETA
from estimators.attitude_memory import ABS, CAR, GRAVITY, LARGEST_ROLL, LEVEL_PITCH, LOG_VOLUME, PERIOD, Memory
from estimators.attitude_two_wheeler import two_wheeler_observation, two_wheeler_system
from estimators.kalman.correction import correct_row
from estimators.kalman.covariance import FloatArray, IntArray, propagate, symmetrise

_RATES = LATERAL_SPEED + 1
"""Entries of the full vector that move; the offsets behind them are constant (2.8)."""


@njit(cache=True)
def system(x: FloatArray, u: FloatArray, bike: Any, car: Any, of_car: bool, f: FloatArray) -> None:
    """System equation of car or two-wheeler into ``f``, shape (4,)."""
    if of_car:
        car_system(x, u, car, f)
    else:
        two_wheeler_system(x, u, bike, f)


@njit(cache=True)
def observation(x: FloatArray, u: FloatArray, bike: Any, car: Any, of_car: bool, m: FloatArray, h: FloatArray) -> None:
    """Observation equation of car or two-wheeler into ``h``, shape (6,)."""
    if of_car:
        car_observation(x, u, car, h)
    else:
        two_wheeler_observation(x, u, bike, m, h)


@njit(cache=True)
def system_slopes(
    x: FloatArray,
    u: FloatArray,
    bike: Any,
    car: Any,
    of_car: bool,
    entries: IntArray,
    steps: FloatArray,
    rates: FloatArray,
    slopes: FloatArray,
) -> None:
    """f and df/dx by central differences.

    Parameters
    ----------
    x : array, shape (10,)
        Comes back as it was.
    entries : array of int, shape (k,)
        Entries of x by which is differentiated.
    steps : array, shape (10,)
    rates : array, shape (3, 4)
        Scratch; its first row receives f.
    slopes : array, shape (k, 4)
        Receives the derivatives by each of the entries.
    """
    for column in range(entries.shape[0]):
        entry = entries[column]
        kept, step = x[entry], steps[entry]
        x[entry] = kept + step
        system(x, u, bike, car, of_car, rates[1])
        x[entry] = kept - step
        system(x, u, bike, car, of_car, rates[2])
        x[entry] = kept
        scale = 0.5 / step
        for row in range(_RATES):
            slopes[column, row] = scale * (rates[1, row] - rates[2, row])
    system(x, u, bike, car, of_car, rates[0])


@njit(cache=True)
def observation_slopes(
    x: FloatArray,
    u: FloatArray,
    bike: Any,
    car: Any,
    of_car: bool,
    entries: IntArray,
    steps: FloatArray,
    m: FloatArray,
    outputs: FloatArray,
    slopes: FloatArray,
) -> None:
    """h and dh/dx by central differences; as ``system_slopes``, ``outputs`` and ``slopes`` of shapes (3, 6), (k, 6)."""
    for column in range(entries.shape[0]):
        entry = entries[column]
        if entry >= B_Y:
            # offsets of G_y and G_z stand in one row each, as they are
            for row in range(ROWS):
                slopes[column, row] = 1.0 if row == entry - B_Y else 0.0
            continue
        kept, step = x[entry], steps[entry]
        x[entry] = kept + step
        observation(x, u, bike, car, of_car, m, outputs[1])
        x[entry] = kept - step
        observation(x, u, bike, car, of_car, m, outputs[2])
        x[entry] = kept
        scale = 0.5 / step
        for row in range(ROWS):
            slopes[column, row] = scale * (outputs[1, row] - outputs[2, row])
    observation(x, u, bike, car, of_car, m, outputs[0])


@njit(cache=True)
def level_pitch(x: FloatArray, entries: IntArray, gravity: float, slopes: FloatArray) -> None:
    """Take the slope of g cos(theta) cos(phi) by the pitch angle out of G_z, as on the level, where it is zero.

    Straight on no row tells the pitch angle from an offset of G_x. That slope, -g sin(theta), is the estimate and not
    the road: where it has drifted, G_z seems to tell it, drives it further off the level and lets P shrink (Huang,
    Mourikis, Roumeliotis 2010: linearisation must not add to what can be observed).

    Parameters
    ----------
    gravity : float
        [m/s^2].
    slopes : array, shape (k, 6)
        dh/dx of :func:`observation_slopes`, changed.
    """
    for column in range(entries.shape[0]):
        if entries[column] == THETA:
            slopes[column, ROW_Z] += gravity * math.sin(x[THETA]) * math.cos(x[PHI])


@njit(cache=True)
def predict_filter(x: FloatArray, covariance: FloatArray, a: Memory, bike: Any, car: Any) -> None:
    """Explicit Euler over a period with the inputs of its middle or its start; F = I + period df/dx."""
    entries, rates, slopes, period = a.entries, a.rates, a.slopes_f, a.tuning[PERIOD]
    system_slopes(x, a.inputs[2], bike, car, a.tuning[CAR] > 0.0, entries, a.steps, rates, slopes)
    for row in range(entries.shape[0]):
        moved = entries[row]
        for column in range(entries.shape[0]):
            slope = period * slopes[column, moved] if moved < _RATES else 0.0
            a.transition[row, column] = slope + (1.0 if row == column else 0.0)
        if moved < _RATES:
            x[moved] += period * rates[0, moved]
    x[PHI] = min(max(x[PHI], -a.tuning[LARGEST_ROLL]), a.tuning[LARGEST_ROLL])
    propagate(covariance, a.transition, a.process, a.work)


@njit(cache=True)
def correct_filter(x: FloatArray, covariance: FloatArray, a: Memory, bike: Any, car: Any) -> float:
    """Correct with the inputs of this step, row by row, which is the same as all at once: R is diagonal.

    Returns
    -------
    float
        e' S^-1 e with e and S = R + H P H' of the prediction; ln det S goes into ``a.status[LOG_VOLUME]``.
    """
    entries, rows, outputs, slopes = a.entries, a.rows, a.outputs, a.slopes_h
    of_car = a.tuning[CAR] > 0.0
    observation_slopes(x, a.inputs[0], bike, car, of_car, entries, a.steps, a.mechanics, outputs, slopes)
    if a.tuning[LEVEL_PITCH] > 0.0:
        level_pitch(x, entries, a.tuning[GRAVITY], slopes)
    n = entries.shape[0]
    for column in range(n):
        a.correction[column] = 0.0
    squared, volume = 0.0, 0.0
    for row in range(rows.shape[0]):
        measured = rows[row]
        # wheels that the ABS slips tell nothing of the speed
        told = 0.0 if measured == ROW_SPEED and a.status[ABS] > 0.0 else 1.0
        for column in range(n):
            a.design[row, column] = told * slopes[column, measured]
        residual = told * (a.measured[measured] - outputs[0, measured])
        variance = a.noise[row]
        for i in range(n):
            for j in range(n):
                variance += a.design[row, i] * covariance[i, j] * a.design[row, j]
        volume += math.log(variance)
        squared += correct_row(
            a.correction, covariance, residual, a.design[row], a.columns, a.noise[row], 0.0, a.wide
        )  # fmt: skip
    symmetrise(covariance)
    for column in range(n):
        x[entries[column]] += a.correction[column]
    x[PHI] = min(max(x[PHI], -a.tuning[LARGEST_ROLL]), a.tuning[LARGEST_ROLL])
    a.status[LOG_VOLUME] = volume
    return squared
