"""Two prior widths for each deviation: an ordinary car's and that of an effect which is present."""

from collections.abc import Iterable, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from model_diagnosis.effects.effect import EffectParameter
from model_diagnosis.effects.in_common import common_columns

FloatArray = NDArray[np.float64]

NUISANCE_FLOOR = 1e-3
"""Nuisance width of a deviation that an ordinary car does not have, as a share of its effect width."""


def is_scattering(parameter: EffectParameter) -> bool:
    """True for a number of the vehicle file that is off in every car."""
    return bool(parameter.vehicle_path) and parameter.nuisance_std > NUISANCE_FLOOR * parameter.effect_std


COMMON_SHARE = 0.5
"""Share of a scatter's variance that both axles of a car have in common. No vehicle file states it: half lies between
none (each axle's parts drawn for themselves) and all (one parts bin), and is off by a half at most."""


def with_commons(theta: FloatArray, parameters: Sequence[EffectParameter]) -> FloatArray:
    """The same car (p,) with what moves both axles counted to each one's own number, and none left in common."""
    whole, commons = theta.copy(), common_columns(parameters)
    for own, common in commons.items():
        whole[own] += theta[common]
    whole[list(commons.values())] = 0.0
    return whole


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
    def of(cls, parameters: Sequence[EffectParameter], in_common: bool = True) -> "Priors":
        """Priors as catalogue and vehicle file state them; without ``in_common`` each axle is off for itself alone."""
        effect = np.array([parameter.effect_std for parameter in parameters])
        nuisance = np.array([parameter.ordinary_std for parameter in parameters])
        commons = common_columns(parameters)
        share = COMMON_SHARE if in_common else 0.0
        nuisance[list(commons)] *= np.sqrt(1.0 - share)
        nuisance[sorted(set(commons.values()))] *= np.sqrt(share)
        return cls(
            centre=np.zeros(len(effect)),
            nuisance=np.maximum(nuisance, NUISANCE_FLOOR * effect),
            effect=np.maximum(effect, nuisance),
            low=np.array([parameter.low for parameter in parameters]),
            high=np.array([parameter.high for parameter in parameters]),
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
