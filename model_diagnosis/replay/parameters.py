"""Parameters of the effects as they hold for one vehicle: nominal values, scatter, bounds that the vehicle sets."""

from collections.abc import Mapping
from dataclasses import replace
from fnmatch import fnmatchcase
from typing import TypeVar

from model_diagnosis.effects.effect import EffectParameter
from vehicle_model.vehicle_file import Scatter, VehicleFile, parameter_table

T = TypeVar("T")

Values = Mapping[str, tuple[float, str]]
"""Dotted path of a vehicle file to value and unit."""


def values_of(vehicle: VehicleFile) -> Values:
    """Every number of a vehicle with its unit."""
    return {info.path: (info.value, info.unit) for info in parameter_table(vehicle)}


def nominal_value(parameter: EffectParameter, values: Values) -> tuple[float, str]:
    """Nominal physical value and unit: the mean of the vehicle's parameters on the path, which may be a pattern.

    Without one a factor counts from 1 and an addition from 0.
    """
    found = _on_path(values, parameter.vehicle_path)
    if not found or (parameter.relative and found[0][0] == 0.0):
        return (1.0 if parameter.relative else 0.0), parameter.unit
    nominal = sum(value for value, _ in found) / len(found)
    return nominal, found[0][1] if parameter.relative else parameter.unit


def adjusted_parameter(parameter: EffectParameter, values: Values, scatter: Mapping[str, Scatter]) -> EffectParameter:
    """The parameter with the scatter that the vehicle file states, and no reduction below what the car has."""
    nominal, _ = nominal_value(parameter, values)
    stated = next(iter(_on_path(scatter, parameter.vehicle_path or parameter.common_path)), None)
    width = parameter.nuisance_std
    if stated is not None:
        width = stated.std
        if parameter.relative and stated.kind == "absolute":
            width = stated.std / abs(nominal)
        elif not parameter.relative and stated.kind == "relative":
            width = stated.std * abs(nominal)
    low = max(parameter.low, -nominal) if parameter.never_negative else parameter.low
    return replace(parameter, nuisance_std=width, low=low)


def _on_path(entries: Mapping[str, T], path: str) -> list[T]:
    """Entries whose place a path names, or fits as a pattern; none for no path."""
    if not any(sign in path for sign in "*?["):
        return [entries[path]] if path in entries else []
    return [entry for place, entry in entries.items() if fnmatchcase(place, path)]
