"""Pressures that drive a car whose wheel pressures were measured, without their sensors' noise.

The hydraulic unit tells the course of a flank and of an ABS stop better than any smoothing of the samples. Its numbers
are what the pressures themselves tell of them, and what it still lacks is taken from the measurement. Wheels share
their supply, so that what is lacking is looked at as the mean of the four, the differences of the sides and of the
axles, and the rest: each has half a wheel's noise for its size, and most of them hardly move.
"""

from collections.abc import Callable, Mapping, Sequence

import numpy as np
from numpy.typing import NDArray

from model_diagnosis.effects.effect import EffectParameter
from model_diagnosis.huber import huber_loss, huber_weights
from model_diagnosis.replay.smoothing import as_pressure, noise_of, without_noise

FloatArray = NDArray[np.float64]

_PARTS = 0.5 * np.array([[1.0, 1.0, 1.0, 1.0], [1.0, -1.0, 1.0, -1.0], [1.0, 1.0, -1.0, -1.0], [1.0, -1.0, -1.0, 1.0]])
"""Orthonormal: all wheels, the sides, the axles, the diagonals."""

_STEPS = 2
"""Of Gauss and Newton; two more change the pressures that come out of it by less than a tenth of their error. More let
a unit that does not follow its readings at all take numbers of no car (all its conductances halved and more)."""
_STEP_LENGTHS = (1.0, 0.5, 0.25)
"""Shares of a step that are tried: whole ones overshoot at kinks."""
_TRIAL = 0.3
"""Share of its scatter by which a number is moved for its slope; dead times have kinks at whole milliseconds."""


def numbers_by_pressures(
    errors: Callable[[Mapping[str, float]], FloatArray],
    columns: Sequence[str],
    parameters: Sequence[EffectParameter],
    noise: float,
    starts: Sequence[Mapping[str, float]] = ({},),
) -> dict[str, float]:
    """Deviations of a hydraulic unit's numbers, by column, as measured pressures tell them.

    Two steps of Gauss and Newton leave what no fit of these numbers takes away; the rest is for the measurement to add.

    Parameters
    ----------
    errors : measured pressures less the unit's (m,) [Pa] at deviations, the same samples each time
    parameters : of the columns, each off by its ordinary scatter
    noise : standard deviation of the measured pressures' noise [Pa]
    starts : deviations by column, a missing one 0, of which those with the least misfit are the ones to begin with
    """
    scatter = np.array([one.ordinary_std for one in parameters])
    low, high = np.array([(one.low, one.high) for one in parameters]).T

    def deviations_at(sizes: FloatArray) -> dict[str, float]:
        return dict(zip(columns, np.clip(sizes * scatter, low, high).tolist(), strict=True))

    def residuals(sizes: FloatArray) -> FloatArray:
        return errors(deviations_at(sizes)) / noise

    def misfit(sizes: FloatArray, left: FloatArray) -> float:
        # what a lost command does is no number's fault
        return huber_loss(left) + float(sizes @ sizes)

    tried = [np.array([start.get(column, 0.0) for column in columns]) / scatter for start in starts]
    begun = [(sizes, residuals(sizes)) for sizes in tried]
    sizes, left = min(begun, key=lambda one: misfit(*one))
    for _ in range(_STEPS):
        slopes = np.stack([(residuals(sizes + by) - left) / _TRIAL for by in _TRIAL * np.eye(len(sizes))], axis=1)
        weighted = slopes.T * huber_weights(left)
        step = np.linalg.solve(weighted @ slopes + np.eye(len(sizes)), -weighted @ left - sizes)
        trials = [(sizes + length * step, residuals(sizes + length * step)) for length in _STEP_LENGTHS]
        best = min(trials, key=lambda trial: misfit(*trial))
        if misfit(*best) >= misfit(sizes, left):
            break
        sizes, left = best
    return deviations_at(sizes)


def driving_pressures(measured: FloatArray, by_unit: FloatArray, valid: FloatArray) -> FloatArray:
    """True pressures (n, 4) [Pa] by the unit and what the measurement tells beyond it.

    Parameters
    ----------
    measured, by_unit : (n, 4) [Pa]
    valid : (n, 4), 1 where they were measured; between samples with all four the unit's error is a straight line
    """
    known = np.all(valid > 0.0, axis=1)
    if not known.any():
        return by_unit
    lacking = (measured - by_unit)[known] @ _PARTS.T
    lacking = np.stack([without_noise(part) for part in lacking.T], axis=1) @ _PARTS
    places = np.arange(len(known))
    course = by_unit + np.stack([np.interp(places, places[known], one) for one in lacking.T], axis=1)
    return np.stack([as_pressure(measured[:, i], course[:, i], noise_of(measured[:, i])) for i in range(4)], axis=1)
