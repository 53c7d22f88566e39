"""Two prior widths for each deviation: an ordinary car's and that of an effect which is present."""

from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass
from fnmatch import fnmatchcase
from typing import Protocol

import numpy as np
from numpy.typing import NDArray

from model_diagnosis.effects.effect import EffectParameter

FloatArray = NDArray[np.float64]

NUISANCE_FLOOR = 1e-3
"""Nuisance width of a deviation that an ordinary car does not have, as a share of its effect width."""


class Scatter(Protocol):
    """Spread of one parameter as a vehicle file states it."""

    @property
    def std(self) -> float:
        """Standard deviation; of the nominal value if relative."""

    @property
    def kind(self) -> str:
        """``relative`` or ``absolute``."""


def stated_scatter(
    parameters: Sequence[EffectParameter],
    scatter: Mapping[str, Scatter],
    nominal: Callable[[int], float],
) -> FloatArray:
    """Nuisance widths (p,) of the deviations: the vehicle file's scatter where it states one, else the catalogue's.

    ``nominal`` gives the nominal physical value of a column. Paths match with ``*`` for each wheel or axle.
    """
    widths = np.array([parameter.nuisance_std for parameter in parameters])
    for column, parameter in enumerate(parameters):
        if not parameter.vehicle_path:
            continue
        for path, spread in scatter.items():
            if fnmatchcase(path, parameter.vehicle_path) or fnmatchcase(parameter.vehicle_path, path):
                value = abs(nominal(column))
                if parameter.relative == (spread.kind == "relative"):
                    widths[column] = spread.std
                elif parameter.relative and value > 0.0:
                    widths[column] = spread.std / value
                elif not parameter.relative:
                    widths[column] = spread.std * value
                break
    return widths


@dataclass(frozen=True)
class Priors:
    """Priors of all p deviations, each in its own unit.

    Attributes
    ----------
    centre : (p,) mean under every hypothesis; not 0 where the form calibration moved the base
    nuisance : (p,) width in an ordinary car
    effect : (p,) width where the effect is present
    low, high : (p,) bounds
    """

    centre: FloatArray
    nuisance: FloatArray
    effect: FloatArray
    low: FloatArray
    high: FloatArray

    @classmethod
    def of(cls, parameters: Sequence[EffectParameter], nuisance: FloatArray | None = None) -> "Priors":
        """Priors as the catalogue states them, or with other nuisance widths (p,)."""
        effect = np.array([parameter.effect_std for parameter in parameters])
        if nuisance is None:
            nuisance = np.array([parameter.nuisance_std for parameter in parameters])
        return cls(
            centre=np.zeros(len(effect)),
            nuisance=np.maximum(nuisance, NUISANCE_FLOOR * effect),
            effect=np.maximum(effect, nuisance),
            low=np.array([parameter.low for parameter in parameters]),
            high=np.array([parameter.high for parameter in parameters]),
        )

    def recentred(self, shift: FloatArray, spread: FloatArray) -> "Priors":
        """Priors moved by the shift that form errors cause and widened by what of it varies (anchor 3.4a)."""
        nuisance = np.hypot(self.nuisance, spread)
        return Priors(
            centre=np.clip(self.centre + shift, self.low, self.high),
            nuisance=nuisance,
            effect=np.maximum(self.effect, nuisance),
            low=self.low,
            high=self.high,
        )

    def widths(self, present: Iterable[int] = ()) -> FloatArray:
        """Prior widths (p,) where the named columns belong to effects that are present."""
        widths = self.nuisance.copy()
        chosen = list(present)
        widths[chosen] = self.effect[chosen]
        return widths

    def saturated(self) -> FloatArray:
        """Widths (p,) where every effect may be present."""
        return np.maximum(self.nuisance, self.effect)
