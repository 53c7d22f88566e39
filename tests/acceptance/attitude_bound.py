"""What an exact model could tell of b_x after the pitch gyroscope has got an offset: two bounds along a true ride.

The filter's own rows, Jacobians, R and Q, taken at the true states and noise-free inputs, so that nothing but the gain
is left: no discretisation, no delay, no wheel loads that have to be estimated. What goes wrong beyond it is a loss.
"""

from dataclasses import dataclass

import numpy as np
from attitude_rides import DEGREE, MILLI_G, ONSET_S, STEPPED, FloatArray, built, delayed

from estimators.attitude_bank import AttitudeFilter
from estimators.attitude_filter import observation_slopes, system_slopes
from estimators.attitude_forms import B_PITCH, B_X, ENTRIES, LATERAL_SPEED, PHI, ROWS, SPEED, THETA
from estimators.attitude_two_wheeler import (
    INPUTS,
    MECHANICS,
    U_ELEVATION,
    U_ELEVATION_RATE,
    U_ROLL,
    U_ROLL_RISE,
    U_X,
    U_Y,
)
from vehicle_model.reference.two_wheeler import SAMPLE_S, Ride


@dataclass(frozen=True)
class Left:
    """After an offset of 1 degree/s of the pitch gyroscope at 30 s, a time later.

    Attributes
    ----------
    mean : float
        Mean error of b_x that the gain of the settings leaves, sensors without noise [mG].
    deviation : float
        Of b_x in the best estimate of the same rows and noises, which knows when an offset may have come on [mG].
    memory : float
        Time in which the filter forgets an error of b_x, of a random walk that it knows with P: P/Q [s].
    """

    mean: float
    deviation: float
    memory: float


def _true_inputs(source: Ride) -> tuple[FloatArray, FloatArray]:
    """States and inputs behind the low-pass of the sensors, at the steps of a filter."""
    n = len(source.time)
    x, u = np.zeros((n, ENTRIES)), np.zeros((n, INPUTS))
    x[:, THETA], x[:, PHI], x[:, SPEED] = (
        delayed(values) for values in (source.pitch_angle, source.roll_angle, source.speed)
    )
    for axis in range(3):
        u[:, U_ROLL + axis] = delayed(source.rates[:, axis])
        u[:, U_ROLL_RISE + axis] = delayed(source.rate_rises[:, axis])
    u[:, U_X], u[:, U_Y] = delayed(source.specific_force[:, 0]), delayed(source.specific_force[:, 1])
    u[:, U_ELEVATION] = delayed(source.elevation)
    u[:, U_ELEVATION_RATE] = np.gradient(u[:, U_ELEVATION], SAMPLE_S)
    return x[STEPPED], u[STEPPED]


def _linear(filter_: AttitudeFilter, x: FloatArray, u: FloatArray) -> tuple[FloatArray, FloatArray]:
    """F and H of a step at a true state."""
    a, (bike, car) = filter_.memory, filter_._bound[1:3]
    n = len(a.entries)
    slopes_f, slopes_h = np.zeros((n, LATERAL_SPEED + 1)), np.zeros((n, ROWS))
    system_slopes(x, u, bike[0], car[0], False, a.entries, a.steps, np.zeros((3, 4)), slopes_f)
    observation_slopes(
        x, u, bike[0], car[0], False, a.entries, a.steps, np.zeros(MECHANICS), np.zeros((3, ROWS)), slopes_h
    )
    transition = np.eye(n)
    for row, entry in enumerate(a.entries):
        if entry <= LATERAL_SPEED:
            transition[row] += filter_.settings.period * slopes_f[:, entry]
    return transition, slopes_h[:, a.rows].T


def _corrected(p: FloatArray, h: FloatArray, r: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Covariance after a correction, and I - K H."""
    gain = np.linalg.solve(h @ p @ h.T + r, h @ p).T
    keep = np.eye(len(p)) - gain @ h
    return keep @ p @ keep.T + gain @ r @ gain.T, keep


def left_by_the_pitch_gyroscope(source: Ride, form: str, after_s: float) -> Left:
    """Bounds of a form on a ride, ``after_s`` after the onset."""
    filter_ = built({"form": form}, "attitude_single")
    a = filter_.memory
    entries = list(a.entries)
    gyroscope, place = entries.index(B_PITCH), entries.index(B_X)
    r, q = np.diag(a.noise), a.process
    p = np.diag(np.square(a.initial))
    told, error = p, np.zeros(len(entries))
    started = False
    states, inputs = _true_inputs(source)
    for time, x, u in zip(source.time[STEPPED], states, inputs, strict=True):
        if time > ONSET_S + after_s:
            break
        transition, h = _linear(filter_, x, u)
        p, told = (transition @ of @ transition.T + q for of in (p, told))
        error = transition @ error
        if time >= ONSET_S and not started:
            started = True
            error[gyroscope] -= DEGREE
            told = p.copy()
            told[gyroscope, gyroscope] += DEGREE**2
        p, keep = _corrected(p, h, r)
        told, _ = _corrected(told, h, r)
        error = keep @ error
    deviation = float(np.sqrt(told[place, place]))
    memory = filter_.settings.period * float(p[place, place] / q[place, place])
    return Left(float(error[place]) / MILLI_G, deviation / MILLI_G, memory)
