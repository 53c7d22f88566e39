"""From an effect's deviations to a change of the car: parameters by dotted path, added terms, and what is no car's.

Most parameters of the catalogue name their path in the vehicle file; the others have a law here. What belongs to the
drive (road, wind, clock, CAN), to how it was recorded or to the ECU is told as a condition and changes no car.
"""

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from fnmatch import fnmatchcase

from model_diagnosis.effects.conditions import everywhere
from model_diagnosis.effects.effect import Application, Effect, EffectParameter, Group
from model_diagnosis.extension.laws import LAWS
from signals.errors import InputError
from signals.quantities import limits_of
from vehicle_model.extension_terms_file import Term
from vehicle_model.parameters import find
from vehicle_model.vehicle_file import VehicleFile, set_parameter

_OF_THE_DRIVE = frozenset({Group.ROAD, Group.CLOCK, Group.CAN})
_WIND = frozenset({"head_wind", "side_wind"})
_OF_THE_RECORDING = frozenset({"accelerometer_levelled"})


@dataclass(frozen=True)
class CarChange:
    """What an effect changes.

    Attributes
    ----------
    parameters : dotted path -> new value, SI units
    terms : added to the car's stack
    conditions : what belongs to the drive, its recording or the ECU: column -> value with unit, for the reader
    """

    parameters: Mapping[str, float] = field(default_factory=dict)
    terms: tuple[Term, ...] = ()
    conditions: Mapping[str, str] = field(default_factory=dict)

    def apply(self, vehicle: VehicleFile) -> None:
        """Change a vehicle in place.

        Raises
        ------
        InputError
            If a value lies outside its parameter's range.
        """
        for path, value in self.parameters.items():
            set_parameter(vehicle, path, value)
        vehicle.terms.stack.extend(term.model_copy(deep=True) for term in self.terms)


Law = Callable[[VehicleFile, Mapping[str, float]], CarChange]


def is_of_the_car(effect: Effect) -> bool:
    """True where an effect is a property of the car, which another drive has too."""
    return not (
        effect.group in _OF_THE_DRIVE
        or effect.name in _WIND | _OF_THE_RECORDING
        or effect.application in (Application.CLOCK, Application.CONTROLLER)
    )


def change_of(vehicle: VehicleFile, effect: Effect, deviations: Mapping[str, float]) -> CarChange:
    """Change that an effect makes to a vehicle.

    Parameters
    ----------
    vehicle : VehicleFile
        Not changed.
    deviations
        Parameter of the effect to its deviation, 0 neutral; one that is left out is neutral.

    Raises
    ------
    InputError
        If the vehicle has no parameter for the effect, say for a tyre of another formula.
    """
    present = {name: value for name, value in deviations.items() if value != 0.0}
    unknown = {everywhere(name) for name in present} - {parameter.name for parameter in effect.parameters}
    if unknown:
        raise InputError(
            f"{effect.name}: no such parameter",
            found=", ".join(sorted(unknown)),
            allowed=", ".join(parameter.name for parameter in effect.parameters),
        )
    if not present:
        return CarChange()
    if not is_of_the_car(effect):
        return CarChange(conditions=_conditions(effect, present))
    law = LAWS.get(effect.name)
    if law is not None:
        parameters, terms = law(vehicle, present)
        return CarChange(parameters, tuple(terms))
    changed: dict[str, float] = {}
    for parameter in effect.parameters:
        if parameter.name in present:
            changed |= _by_path(vehicle, effect, parameter, present[parameter.name], changed)
    limited = {path: _within_limits(vehicle, path, value) for path, value in changed.items()}
    return CarChange(limited)


def _conditions(effect: Effect, present: Mapping[str, float]) -> dict[str, str]:
    units = {parameter.name: parameter.unit for parameter in effect.parameters}
    return {
        f"{effect.name}.{name}": f"{value:g}" + (f" {unit}" if (unit := units[everywhere(name)]) != "1" else "")
        for name, value in present.items()
    }


def _by_path(
    vehicle: VehicleFile,
    effect: Effect,
    parameter: EffectParameter,
    deviation: float,
    changed: Mapping[str, float],
) -> dict[str, float]:
    """Values by path; ``changed`` are those that the effect's other parameters have made already."""
    pattern = parameter.vehicle_path
    numbers = vehicle.numbers(pattern.partition(".")[0]) if pattern else {}
    paths = [path for path in numbers if fnmatchcase(path, pattern)]
    if not paths:
        raise InputError(
            f"{effect.name}.{parameter.name}: this vehicle has no parameter for it",
            allowed=pattern or "an effect that the plant knows",
            mend="its tyres follow another formula" if pattern.startswith("tyres.") else "",
        )
    before = {path: changed.get(path, numbers[path]) for path in paths}
    if parameter.relative:
        return {path: value * (1.0 + deviation) for path, value in before.items()}
    return {path: value + deviation for path, value in before.items()}


def _within_limits(vehicle: VehicleFile, path: str, value: float) -> float:
    """A deviation below what a parameter can be (a relaxation length under zero) is that parameter's limit."""
    section = path.partition(".")[0]
    low, high = limits_of(find(getattr(vehicle, section), path, f"{section}.").field)
    least, most = -math.inf if low is None else low, math.inf if high is None else high
    return min(max(value, least), most)
