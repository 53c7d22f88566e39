"""The car of a scenario: as its file says, and as it is driven."""

from typing import TYPE_CHECKING, Any

from signals.errors import InputError

if TYPE_CHECKING:
    from bench.scenario.schema import ScenarioFile
    from vehicle_model.tyres.tyre_file import TyrePair
    from vehicle_model.vehicle_file import VehicleFile


def nominal_vehicle(scenario: "ScenarioFile") -> "VehicleFile":
    """The vehicle file as it is."""
    from vehicle_model.vehicle_file import load_vehicle

    return load_vehicle(scenario.vehicle)


def vehicle_as_driven(scenario: "ScenarioFile") -> "VehicleFile":
    """The vehicle file with the scenario's tyres, sensors and overrides."""
    from vehicle_model.vehicle_file import set_parameter

    vehicle = nominal_vehicle(scenario)
    if scenario.tyres is not None:
        object.__setattr__(vehicle, "tyres", load_tyres(scenario.tyres))
    if scenario.acceleration_source is not None:
        vehicle.sensors.acceleration_source = scenario.acceleration_source
    for path, value in {**flat(scenario.sensors, "sensors"), **scenario.overrides}.items():
        set_parameter(vehicle, path, value)
    return vehicle


def load_tyres(name_or_path: str) -> "TyrePair":
    """Tyres of a tyre file, given by the name of a shipped one or by its path.

    Raises
    ------
    InputError
        If there is no such file, or it has faults.
    """
    from vehicle_model import vehicle_file

    return vehicle_file.load_tyres(name_or_path)


def flat(section: dict[str, Any], prefix: str) -> dict[str, Any]:
    """Nested mappings as dotted path → value."""
    found: dict[str, Any] = {}
    for name, value in section.items():
        path = f"{prefix}.{name}"
        if isinstance(value, dict):
            found |= flat(value, path)
        elif isinstance(value, (int, float, str)) and not isinstance(value, bool):
            found[path] = value
        else:
            raise InputError(f"{path}: not a number with a unit", found=repr(value))
    return found
