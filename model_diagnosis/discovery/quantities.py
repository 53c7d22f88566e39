"""What a search for an unknown term looks at: the error of a balance, variables, and forces that are there already."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace

import numpy as np
from numpy.typing import NDArray
from scipy.signal import savgol_filter

FloatArray = NDArray[np.float64]
_SMOOTHING = 7
"""Samples of 10 ms."""

Series = tuple[FloatArray, ...]
"""One array per manoeuvre: (n,) of the car, or (n, 4) of the wheels."""


@dataclass(frozen=True)
class Variable:
    """A quantity that a term may depend on.

    Attributes
    ----------
    name : as the plant's terms know it
    cumulative : True for a place or a time, whose zero has no meaning: periodic terms have a phase per manoeuvre
    """

    name: str
    unit: str
    values: Series
    cumulative: bool = False

    @property
    def of_wheels(self) -> bool:
        """True for a value per wheel."""
        return self.values[0].ndim == 2

    @property
    def span(self) -> tuple[float, float]:
        """Lowest and highest value but for the outermost half per cent."""
        low, high = np.quantile(np.concatenate([one.ravel() for one in self.values]), [0.005, 0.995])
        return float(low), float(high)

    @property
    def signed(self) -> bool:
        """True where it takes both signs."""
        low, high = self.span
        return low < -0.05 * max(abs(low), abs(high)) and high > 0.05 * max(abs(low), abs(high))


@dataclass(frozen=True)
class Force:
    """A force of the balance that a term may multiply.

    Attributes
    ----------
    values : in the balance's unit and with its sign, of the car or of the wheels (their sum is the balance's)
    target : what the plant multiplies
    """

    values: Series
    target: str


@dataclass(frozen=True)
class Balance:
    """A balance whose error an unknown term shall explain.

    Attributes
    ----------
    name, unit : "longitudinal force", "N"
    error : (n,) per manoeuvre: what the model lacks
    weights : (n,) per manoeuvre, 0 where a sample counts for nothing
    forced : columns that are always fitted along: mass, drag, rolling, scale of each force, offset
    forces : by name, for multiplicative terms
    target : what an additive term adds to in the plant; empty where the plant has no such place
    """

    name: str
    unit: str
    error: Series
    weights: Series
    forced: Mapping[str, Series] = field(default_factory=dict)
    forces: Mapping[str, Force] = field(default_factory=dict)
    target: str = ""

    @property
    def samples(self) -> int:
        """Samples of all manoeuvres."""
        return sum(len(one) for one in self.error)


def smoothed(variable: Variable) -> Variable:
    """A variable less its noise: quadratics fitted over 70 ms; a place or a time stays as it is."""
    if variable.cumulative or any(len(one) < _SMOOTHING for one in variable.values):
        return variable
    return replace(variable, values=tuple(savgol_filter(one, _SMOOTHING, 2, axis=0) for one in variable.values))


def stacked(series: Sequence[FloatArray]) -> FloatArray:
    """All manoeuvres behind each other, (N,) or (N, k)."""
    return np.concatenate(list(series))
