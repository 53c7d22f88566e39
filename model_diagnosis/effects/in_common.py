"""Which numbers both axles of a car have in common, beside each one's own: stated by their paths in the catalogue."""

from collections.abc import Sequence
from fnmatch import fnmatchcase

from model_diagnosis.effects.effect import EffectParameter
from model_diagnosis.effects.form import REPLAYED


def common_columns(parameters: Sequence[EffectParameter]) -> dict[int, int]:
    """Column of one axle's number -> column that moves it together with the other axle's."""
    return {
        own: common
        for common, moved in enumerate(parameters)
        for own, parameter in enumerate(parameters)
        if moved.common_path and parameter.vehicle_path and fnmatchcase(parameter.vehicle_path, moved.common_path)
    }


def _by_name() -> dict[str, tuple[str, ...]]:
    names = [column for effect in REPLAYED for column in effect.columns]
    found: dict[str, tuple[str, ...]] = {}
    for own, common in common_columns([one for effect in REPLAYED for one in effect.parameters]).items():
        found[names[common]] = (*found.get(names[common], ()), names[own])
    return found


IN_COMMON = _by_name()
"""Column of what both axles are off by -> each one's own columns, to which it adds. Were both factors, a fit that moves
a deviation from the common column to the axles' own would have to follow a curve, and would end on the way."""
