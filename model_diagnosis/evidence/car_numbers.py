"""Numbers of a car as the data say them: another car's, or this one's within the scatter that its file states."""

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from model_diagnosis.effects.effect import Application
from model_diagnosis.evidence.fitting import Linearisation, Problem
from model_diagnosis.evidence.priors import Priors, is_scattering, with_commons
from model_diagnosis.evidence.stage import ratios

FloatArray = NDArray[np.float64]

SCATTERS_OF_A_REFIT = 2.0
"""Scatters up to which a refit puts a number off: 95 of 100 ordinary cars are inside. Without an end it would say an
effect of many scatters by other numbers that are off by many scatters, which is no ordinary car."""


@dataclass(frozen=True)
class CarNumbers:
    """What the vehicle file would say.

    Attributes
    ----------
    theta : (p,) fit of the car
    columns : of the numbers that make it
    std : of these, standard deviation of what the fit says
    """

    theta: FloatArray
    columns: Sequence[int]
    std: Sequence[float]


def nominal_columns(problem: Problem) -> NDArray[np.int64]:
    """Columns of parameters that stand in the vehicle file and scatter from car to car."""
    replay = problem.replay
    return np.array(
        [
            column
            for column, parameter in enumerate(replay.parameters)
            if is_scattering(parameter) and replay.effects[int(replay.owner[column])].application == Application.PLANT
        ],
        dtype=np.int64,
    )


def within_scatter(problem: Problem) -> Priors:
    """Priors with bounds at two stated scatters, each axle for itself: in common they would add up to more."""
    priors, apart = problem.priors, Priors.of(problem.replay.parameters, in_common=False)
    way = SCATTERS_OF_A_REFIT * apart.nuisance
    return replace(
        priors,
        nuisance=apart.nuisance,
        low=np.maximum(priors.low, priors.centre - way),
        high=np.minimum(priors.high, priors.centre + way),
    )


def refit_within_scatter(problem: Problem, linearisation: Linearisation, start: FloatArray) -> FloatArray:
    """Deviations (p,) that fit best while no number is off by more than two of its scatters, and nothing is wrong."""
    inside = within_scatter(problem)
    bounded = replace(problem, priors=inside)
    begin = np.clip(with_commons(start, problem.replay.parameters), inside.low, inside.high)
    return bounded.fit(linearisation, inside.nuisance, begin).theta


def numbers_within_scatter(problem: Problem, linearisation: Linearisation, start: FloatArray) -> CarNumbers:
    """The same as numbers of the car, each with what the data leave open of its scatter."""
    columns = nominal_columns(problem)
    precision = linearisation.information + np.diag(ratios(problem, ()) ** -2.0)
    std = np.sqrt(np.diag(np.linalg.inv(precision))) * problem.scale
    return CarNumbers(refit_within_scatter(problem, linearisation, start), columns.tolist(), std[columns].tolist())
