"""The extended vehicle file: found effects as extensions of the vehicle that was diagnosed, with their evidence.

>>> extensions, remarks = extensions_of(vehicle, found, provenance)
>>> write_extended_vehicle("extended_vehicle.yaml", "ekf_car", vehicle, extensions)

``bench run --vehicle extended_vehicle.yaml`` then runs it compiled, the ECU in the loop.
"""

import hashlib
import os
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any, NamedTuple

from ruamel.yaml import YAML

from model_diagnosis.effects.effect import Effect
from model_diagnosis.extension.car_change import CarChange, change_of
from signals.errors import InputError
from vehicle_model.extension_file import Extension, Provenance
from vehicle_model.extension_terms_file import Term
from vehicle_model.vehicle_file import VehicleFile

_HEADER = """\
What measured data showed, as extensions of the vehicle named under 'extends'. Parameters take the place of
the file's, terms are added to the car; 'conditions' belonged to the drive and are told only.
"""


class Interval(NamedTuple):
    """Estimate with the ends of its 90 % interval."""

    value: float
    low: float
    high: float


@dataclass(frozen=True)
class FoundEffect:
    """An effect with what it is believed for.

    Attributes
    ----------
    deviations : parameter of the effect -> deviation from the vehicle file, 0 neutral
    group : names of effects that the data cannot tell from it
    """

    effect: Effect
    deviations: Mapping[str, Interval]
    probability: float | None = None
    log_bayes_factor: float | None = None
    group: Sequence[str] = ()
    evidence: str = ""


@dataclass(frozen=True)
class FoundTerm:
    """A term that no effect of the catalogue explains, ready for the car.

    Attributes
    ----------
    intervals : coefficient of each of the terms
    """

    formula: str
    terms: Sequence[Term]
    intervals: Sequence[Interval]
    evidence: str = ""
    probability: float | None = None


def hash_of_vehicle(vehicle: VehicleFile) -> str:
    """SHA-256 of everything in a vehicle."""
    return hashlib.sha256(vehicle.model_dump_json().encode()).hexdigest()


def hashes_of_logs(logs: Iterable[str | Path]) -> dict[str, str]:
    """File name -> SHA-256 of each log."""
    result = {}
    for log in logs:
        with Path(log).open("rb") as file:
            result[Path(log).name] = hashlib.file_digest(file, "sha256").hexdigest()
    return result


def extensions_of(
    vehicle: VehicleFile,
    effects: Sequence[FoundEffect],
    terms: Sequence[FoundTerm] = (),
    provenance: Provenance | None = None,
) -> tuple[list[Extension], list[str]]:
    """Extensions for a vehicle, each acting on what those before it left, and remarks on effects that have none.

    Parameters
    ----------
    vehicle : VehicleFile
        The one that was diagnosed; not changed.
    """
    provenance = provenance or Provenance()
    provenance = provenance.model_copy(update={"vehicle": provenance.vehicle or hash_of_vehicle(vehicle)})
    present, extensions, remarks = vehicle.model_copy(deep=True), [], []
    for found in effects:
        try:
            change, intervals = _change_with_intervals(present, found)
            change.apply(present)
        except InputError as error:
            remarks.append(f"{found.effect.name} is not in the extended vehicle: {error.message}")
            continue
        extensions.append(
            Extension(
                effect=found.effect.name,
                equation=found.effect.equation,
                parameters=dict(change.parameters),
                terms=list(change.terms),
                intervals=intervals,
                conditions=dict(change.conditions),
                probability=found.probability,
                log_bayes_factor=found.log_bayes_factor,
                group=list(found.group),
                evidence=found.evidence,
                provenance=provenance,
            )
        )
    for term in terms:
        present.terms.stack.extend(one.model_copy(deep=True) for one in term.terms)
        extensions.append(
            Extension(
                effect="discovered_term",
                equation=term.formula,
                terms=list(term.terms),
                intervals={
                    f"terms.{number}.coefficient": [interval.low, interval.high]
                    for number, interval in enumerate(term.intervals)
                },
                probability=term.probability,
                evidence=term.evidence,
                provenance=provenance,
            )
        )
    return extensions, remarks


def _change_with_intervals(vehicle: VehicleFile, found: FoundEffect) -> tuple[CarChange, dict[str, list[float]]]:
    """Change at the estimates, and how far each of its numbers moves within the intervals of the deviations."""
    values = {name: interval.value for name, interval in found.deviations.items()}
    change = change_of(vehicle, found.effect, values)
    numbers = _numbers(change)
    spans = {path: [number, number] for path, number in numbers.items()}
    for name, interval in found.deviations.items():
        for end in (interval.low, interval.high):
            try:
                moved = _numbers(change_of(vehicle, found.effect, values | {name: end}))
            except InputError:  # a form that does not exist at the interval's end bounds nothing
                continue
            for path in spans:
                if path in moved:
                    spans[path] = [min(spans[path][0], moved[path]), max(spans[path][1], moved[path])]
    return change, spans


def _numbers(change: CarChange) -> dict[str, float]:
    coefficients = {f"terms.{number}.coefficient": term.coefficient for number, term in enumerate(change.terms)}
    return dict(change.parameters) | coefficients


def write_extended_vehicle(
    path: str | Path,
    vehicle_argument: str,
    vehicle: VehicleFile,
    extensions: Sequence[Extension],
    remarks: Sequence[str] = (),
) -> Path:
    """Write ``extended_vehicle.yaml``.

    Parameters
    ----------
    vehicle_argument : str
        Name of a shipped car or path of the file that was diagnosed, as given on the command line.

    Returns
    -------
    Path
        The file.
    """
    file = Path(path)
    names = ", ".join(extension.effect for extension in extensions) or "nothing"
    content: dict[str, Any] = {
        "format": 1,
        "name": f"{vehicle.name}_extended",
        "description": " ".join([f"{vehicle.name} with what measured data showed: {names}.", *remarks]),
        "extends": _base(file, vehicle_argument),
        "extensions": [_plain(extension) for extension in extensions],
    }
    yaml = YAML()
    yaml.width = 110
    file.parent.mkdir(parents=True, exist_ok=True)
    with file.open("w", encoding="utf-8") as stream:
        stream.writelines(f"# {line}\n" for line in _HEADER.splitlines())
        yaml.dump(content, stream)
    return file


def _base(file: Path, vehicle_argument: str) -> str:
    """What ``extends`` says: the name of a shipped car, or the way from the file's folder to the vehicle file."""
    given = Path(vehicle_argument)
    if given.suffix not in (".yaml", ".yml"):
        return vehicle_argument
    return os.path.relpath(given.resolve(), file.parent.resolve())


def _plain(extension: Extension) -> dict[str, Any]:
    return extension.model_dump(exclude_none=True, exclude_defaults=True) | {"effect": extension.effect}
