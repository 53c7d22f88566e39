"""Vehicle files: every parameter of a car, from body to sensors.

vehicle = load_vehicle("ekf_car")
vehicle.body.mass                          # 1296.0
vehicle.numbers("brakes")                  # {"brakes.booster_gain": ..., "brakes.front.pad_area": ...}
set_parameter(vehicle, "body.mass", "1.4 t")
"""

from pathlib import Path
from typing import Any, Literal

from pydantic import Field, model_validator

from signals.errors import FieldError, FileFaults, InputError, unknown_name
from signals.quantities import FileModel, parameter
from signals.wheels import WHEELS
from signals.yaml_files import Document, load_yaml, overlay, validate, walk
from vehicle_model import parameters
from vehicle_model.actuation_file import Brakes, Driveline, Hydraulics
from vehicle_model.body_file import Aerodynamics, Axles, Body, Steering, Wheels
from vehicle_model.extension_file import Extension
from vehicle_model.extension_terms_file import MOST_TERMS, Terms
from vehicle_model.mass_check import check_masses
from vehicle_model.parameters import VEHICLE_SECTIONS, ParameterInfo
from vehicle_model.reference.planar_file import Planar
from vehicle_model.reference.steered_track_file import SteeredTrackSection
from vehicle_model.reference.two_track_file import TwoTrackSection
from vehicle_model.reference.two_wheeler_file import TwoWheelerSection
from vehicle_model.sensors_file import Sensors
from vehicle_model.suspension_file import Suspension
from vehicle_model.tyres.tyre_file import TirTyre, TyreFile, TyrePair

VEHICLES = Path(__file__).parent / "vehicles"
TYRES = Path(__file__).parent / "tyre_files"
STANDARD_GRAVITY = 9.81


class Scatter(FileModel):
    """Spread of one parameter over cars or runs."""

    std: float = parameter("1", low=0.0, description="standard deviation; of the nominal value if relative")
    kind: Literal["relative", "absolute"] = "relative"


class VehicleFile(FileModel):
    """A car. Each leaf is a number in SI units or a text with its unit."""

    format: Literal[1]
    name: str
    description: str = ""
    extends: str | None = None
    body: Body
    axles: Axles
    wheels: Wheels
    suspension: Suspension
    steering: Steering = Steering()
    brakes: Brakes
    hydraulics: Hydraulics = Hydraulics()
    driveline: Driveline
    aerodynamics: Aerodynamics
    sensors: Sensors = Sensors()
    planar: Planar = Planar()
    two_track: TwoTrackSection = TwoTrackSection()
    steered_track: SteeredTrackSection = SteeredTrackSection()
    two_wheeler: TwoWheelerSection = TwoWheelerSection()
    tyres: TyrePair | str
    terms: Terms = Terms()
    extensions: list[Extension] = Field(default_factory=list)
    scatter: dict[str, Scatter] = Field(default_factory=dict)
    sources: dict[str, str] = Field(default_factory=dict)

    @model_validator(mode="after")
    def _fill_derived(self) -> "VehicleFile":
        if self.aerodynamics.drag_height is None:
            object.__setattr__(self.aerodynamics, "drag_height", self.body.centre_of_gravity_height)
        check_masses(self.body, self.axles, [getattr(self.wheels, wheel) for wheel in WHEELS])
        for wheel, load in zip(WHEELS, self.static_loads(), strict=True):
            entry = getattr(self.wheels, wheel)
            deflection = entry.unloaded_radius - entry.radius
            if deflection <= 0.0:
                raise FieldError(
                    "not larger than the loaded radius",
                    at=("wheels", wheel, "unloaded_radius"),
                    allowed=f"more than {entry.radius} m",
                )
            if entry.vertical_stiffness is None:
                object.__setattr__(entry, "vertical_stiffness", load / deflection)
        return self

    def static_loads(self) -> tuple[float, float, float, float]:
        """Vertical wheel loads [N] on a level road at rest (eq. 73 with zero acceleration)."""
        body = self.body
        weight = body.mass * STANDARD_GRAVITY
        rear = weight * body.centre_of_gravity_to_front_axle / body.wheelbase
        front = weight - rear
        return front / 2.0, front / 2.0, rear / 2.0, rear / 2.0

    @property
    def tyre_pair(self) -> TyrePair:
        """The tyres, once their file is read."""
        if isinstance(self.tyres, str):
            raise InputError(f"tyres: {self.tyres} is not read yet", mend="read the vehicle with load_vehicle()")
        return self.tyres

    def numbers(self, section: str | None = None) -> dict[str, float]:
        """Dotted path → SI value of a section's numbers, or of all sections."""
        if section is None:
            return {path: value for name in VEHICLE_SECTIONS for path, value in self.numbers(name).items()}
        return parameters.numbers(getattr(self, section), f"{section}.")


def parameter_table(vehicle: VehicleFile) -> list[ParameterInfo]:
    """Every parameter of a vehicle with unit, value, default, range, neutral value and source."""
    return [
        info
        for section in VEHICLE_SECTIONS
        for info in parameters.parameter_infos(getattr(vehicle, section), f"{section}.", vehicle.sources)
    ]


def set_parameter(vehicle: VehicleFile, path: str, value: float | str) -> None:
    """Change one parameter in place; InputError if there is none of that path or the value is refused."""
    section = path.partition(".")[0]
    if section not in VEHICLE_SECTIONS:
        raise unknown_name("section of a vehicle", section, VEHICLE_SECTIONS)
    parameters.set_parameter(getattr(vehicle, section), path, value, f"{section}.")


def vehicle_names() -> tuple[str, ...]:
    """Names of the cars that ship with the bench."""
    return tuple(sorted(path.stem for path in VEHICLES.glob("*.yaml")))


def load_vehicle(name_or_path: str | Path) -> VehicleFile:
    """Read a vehicle file, the file that it extends and its tyres; apply its extensions.

    Parameters
    ----------
    name_or_path
        Name of a shipped car (``ekf_car``) or path of a file.

    Raises
    ------
    InputError
        If there is no such car or file, or the file has faults.
    """
    document = _read_with_base(_resolve(name_or_path), ())
    if isinstance(document.data.get("tyres"), str):
        tyres = _read_tyres(Path(document.data["tyres"]), document)
        document.data["sources"] = _tyre_sources(tyres) | document.data.get("sources", {})
        document.data["tyres"] = {"front": tyres.front, "rear": tyres.rear}
    vehicle = validate(document, VehicleFile)
    _check_tir_files(document, ("tyres",), vehicle.tyre_pair)
    _apply_extensions(document, vehicle)
    return vehicle


def _apply_extensions(document: Document, vehicle: VehicleFile) -> None:
    """Set the parameters and stack the terms of the extensions, in their order: a later one acts on an earlier one."""
    faults = []
    for number, extension in enumerate(vehicle.extensions):
        for target, value in extension.parameters.items():
            try:
                set_parameter(vehicle, target, value)
            except InputError as error:
                place = ("extensions", number, "parameters", target)
                faults.append(
                    document.fault(
                        place, error.message, found=error.found, allowed=error.allowed, nearest=error.nearest
                    )
                )
        vehicle.terms.stack.extend(term.model_copy(deep=True) for term in extension.terms)
    if faults:
        raise FileFaults(faults, document.file)
    if len(vehicle.terms.stack) > MOST_TERMS:
        count = len(vehicle.terms.stack)
        fault = document.fault(("extensions",), "too many terms", found=str(count), allowed=f"at most {MOST_TERMS}")
        raise FileFaults([fault], document.file)


def load_tyres(name_or_path: str | Path) -> TyrePair:
    """Read a tyre file, given by the name of a shipped one (``reduced_set_t``) or by its path."""
    path = _by_name(name_or_path, TYRES, "tyre file")
    tyres = _read_tyre_file(path)
    return TyrePair(front=tyres.front, rear=tyres.rear)


def _read_tyre_file(path: Path) -> TyreFile:
    document = load_yaml(path)
    _resolve_tir_paths(document.data, path.parent)
    tyres = validate(document, TyreFile)
    _check_tir_files(document, (), tyres)
    return tyres


def _resolve_tir_paths(pair: Any, folder: Path) -> None:
    """Paths of ``.tir`` files in a pair of tyres start from the file that names them."""
    for axle in ("front", "rear"):
        tyre = pair.get(axle) if isinstance(pair, dict) else None
        if isinstance(tyre, dict) and isinstance(tyre.get("tir"), str):
            tyre["tir"] = str(folder / tyre["tir"])


def _check_tir_files(document: Document, place: tuple[str, ...], pair: TyrePair) -> None:
    """Refuse a pair whose ``.tir`` files are missing or bad."""
    for axle in ("front", "rear"):
        tyre = getattr(pair, axle)
        if not isinstance(tyre, TirTyre):
            continue
        if not Path(tyre.tir).exists():
            fault = document.fault((*place, axle, "tir"), "no such .tir file", found=tyre.tir)
            raise FileFaults([fault], document.file)
        # brings numpy, which most checks do without
        from vehicle_model.tyres.relaxation import fill_in
        from vehicle_model.tyres.tir_check import read_checked

        read_checked(tyre.tir)
        fill_in(tyre)


def _by_name(name_or_path: str | Path, folder: Path, kind: str) -> Path:
    path = Path(name_or_path)
    if path.suffix in (".yaml", ".yml"):
        return path
    shipped = folder / f"{name_or_path}.yaml"
    if not shipped.exists():
        names = tuple(sorted(file.stem for file in folder.glob("*.yaml")))
        raise unknown_name(kind, str(name_or_path), names, mend="or give the path of a .yaml file")
    return shipped


def _resolve(name_or_path: str | Path) -> Path:
    return _by_name(name_or_path, VEHICLES, "vehicle")


def _read_with_base(path: Path, seen: tuple[Path, ...]) -> Document:
    """Content of a file laid over that of the file that it extends; relative paths in it are resolved."""
    if path.resolve() in seen:
        names = " → ".join(file.name for file in (*seen, path))
        raise InputError(f"{path}: extends itself", found=names, mend="take out one of the lines 'extends:'")
    document = load_yaml(path)
    data = document.data
    if not isinstance(data, dict):
        return document
    if isinstance(data.get("tyres"), str):
        data["tyres"] = str(path.parent / data["tyres"])
    _resolve_tir_paths(data.get("tyres"), path.parent)
    base_name = data.get("extends")
    if not isinstance(base_name, str):
        return document
    beside = path.parent / base_name
    base = beside if beside.suffix in (".yaml", ".yml") else _resolve(base_name)
    return _laid_over(_read_with_base(base, (*seen, path.resolve())), document)


def _laid_over(base: Document, change: Document) -> Document:
    """``change`` on ``base``; a source that the base gives for a value that changed is dropped."""
    result = overlay(base, change)
    if isinstance(base.data, dict):
        _stack_extensions(result, base, change)
        changed = {".".join(map(str, path)) for path, _ in walk(change.data)}
        kept = {
            path: text
            for path, text in base.data.get("sources", {}).items()
            if not any(leaf == path or leaf.startswith(f"{path}.") for leaf in changed)
        }
        result.data["sources"] = kept | change.data.get("sources", {})
    return result


def _stack_extensions(result: Document, base: Document, change: Document) -> None:
    """Extensions of the file that is extended stand before those of the file that extends it."""
    before, after = base.data.get("extensions"), change.data.get("extensions")
    if not (isinstance(before, list) and isinstance(after, list)):
        return
    result.data["extensions"] = before + after
    for places, old, new in (
        (result.keys, base.keys, change.keys),
        (result.values, base.values, change.values),
    ):
        places.update({path: place for path, place in old.items() if path[:1] == ("extensions",)})
        for path, place in new.items():
            if len(path) > 1 and path[0] == "extensions" and isinstance(path[1], int):
                places[("extensions", path[1] + len(before), *path[2:])] = place


def _read_tyres(path: Path, document: Document) -> TyreFile:
    if not path.exists():
        raise FileFaults([document.fault(("tyres",), "no such tyre file", found=str(path))], document.file)
    return _read_tyre_file(path)


def _tyre_sources(tyres: TyreFile) -> dict[str, str]:
    return {f"tyres.{path}": text for path, text in tyres.sources.items()}
