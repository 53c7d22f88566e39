"""Values of a deviation to try besides those that sensitivities lead to."""

import numpy as np
from numpy.typing import NDArray

from model_diagnosis.evidence.fitting import Problem

FloatArray = NDArray[np.float64]

GRID = (-1.5, -0.75, 0.75, 1.5)
"""In widths of the effect's prior."""


def trial_values(problem: Problem, theta: FloatArray, column: int, widths: FloatArray) -> list[float]:
    """Values of one column within its bounds that are worth a step of all others from them.

    What acts in pulses (a delay of a valve) has a valley of its own at every pulse that it meets, a few trial steps
    wide: of values that far apart the one that comes nearest by itself is taken, one replay each.
    """
    centre, scale = problem.priors.centre[column], problem.scale[column]
    low, high = problem.priors.low[column], problem.priors.high[column]
    step = problem.replay.parameters[column].trial_step
    if step == 0.0:
        return [value for value in (centre + multiple * scale for multiple in GRID) if low <= value <= high]
    values = centre + step * np.arange(np.ceil((low - centre) / step), np.floor((high - centre) / step) + 1.0)
    costs = []
    for value in values:
        tried = theta.copy()
        tried[column] = value
        costs.append(problem.cost(problem.rows(tried), tried, widths))
    return [float(values[int(np.argmin(costs))])]
