"""The car of a scenario: as its file says, and as it is driven."""

from pathlib import Path
from typing import TYPE_CHECKING, Any

from signals.errors import InputError, unknown_name

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
    for path, value in {**flat(scenario.sensors, "sensors"), **scenario.overrides}.items():
        set_parameter(vehicle, path, value)
    return vehicle


def tyre_names() -> tuple[str, ...]:
    """Names of the tyre files that ship with the bench."""
    return tuple(sorted(path.stem for path in _tyre_folder().glob("*.yaml")))


def _tyre_folder() -> Path:
    import vehicle_model

    return Path(vehicle_model.__file__).parent / "tyre_files"


def load_tyres(name_or_path: str) -> "TyrePair":
    """Tyres of a tyre file, given by the name of a shipped one or by its path.

    Raises
    ------
    InputError
        If there is no such file, or it has faults.
    """
    from signals.yaml_files import load_yaml, validate
    from vehicle_model.tyres.tyre_file import TyreFile, TyrePair

    path = Path(name_or_path)
    if path.suffix not in (".yaml", ".yml"):
        path = _tyre_folder() / f"{name_or_path}.yaml"
        if not path.exists():
            raise unknown_name("tyre file", name_or_path, tyre_names(), mend="or give the path of a .yaml file")
    tyres = validate(load_yaml(path), TyreFile)
    return TyrePair(front=tyres.front, rear=tyres.rear)


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
