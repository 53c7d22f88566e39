"""From a file, an id and ``--set`` to a resolved scenario: everything checked, in SI units, with all defaults."""

import copy
import re
from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any

from bench.scenario import checks
from bench.scenario.documents import Sets, apply_sets, parse_sets, read_document
from bench.scenario.locate import find_scenario, id_of
from bench.scenario.schema import ScenarioFile
from bench.scenario.variants import Variant, expand
from signals.errors import Fault, FileFaults, InputError, unknown_name
from signals.yaml_files import DataPath, Document, validate

FIELDS = tuple(ScenarioFile.model_fields)
_PLACEHOLDER_STEPS = {"steps": [{"name": "unknown", "release": True}]}
_FILES: tuple[DataPath, ...] = (
    ("vehicle",),
    ("tyres",),
    ("road",),
    ("ecu", "dbc"),
    ("ecu", "mapping"),
    ("ecu", "calibration"),
    ("faults",),
)
_SUFFIXES = (".yaml", ".yml", ".dbc", ".kcd", ".sym", ".arxml")


def resolve(
    scenario: str | Path,
    sets: Sets = (),
    *,
    seed: int | None = None,
    vehicle: str | None = None,
    plant: str | None = None,
    ecu: str | None = None,
    link: str | None = None,
    pacing: str | None = None,
    variant: str | None = None,
) -> ScenarioFile:
    """The scenario that a run is made of.

    Parameters
    ----------
    scenario : str or Path
        Path of a file, or the id of a scenario in ``./scenarios`` or among the shipped ones.
    sets : sequence of str or mapping
        ``path=value`` as for ``--set``: fields of the scenario, parameters of car and road.
    seed, vehicle, plant, ecu, link, pacing : optional
        In place of what the file says; ``ecu`` is the kind of ECU.
    variant : str, optional
        Name of one of the file's variants.

    Raises
    ------
    InputError
        With every fault of the file and its place.
    """
    path = find_scenario(scenario)
    document = read_document(path)
    changes = parse_sets(sets)
    options = {"seed": seed, "vehicle": vehicle, "plant": plant, "ecu.kind": ecu, "ecu.link": link, "pacing": pacing}
    changes |= {name: value for name, value in options.items() if value is not None}
    chosen = _variant(document, path, variant) if variant is not None else None
    return resolve_document(document, path, changes, chosen)


def _variant(document: Document, path: Path, name: str) -> Variant:
    known = {entry.name: entry for entry in variants_of(document)}
    if name not in known:
        raise unknown_name(f"variant of {path}", name, list(known))
    return known[name]


def variants_of(document: Document) -> list[Variant]:
    """Variants that a scenario declares.

    Raises
    ------
    FileFaults
        If they are faulty.
    """
    from bench.scenario.variants import Variants

    data = document.data.get("variants") if isinstance(document.data, dict) else None
    if data is None:
        return []
    part = Document(document.file, data, _below(document.keys), _below(document.values))
    try:
        return expand(validate(part, Variants))
    except FileFaults as error:
        faults = [replace(fault, field=f"variants.{fault.field}".rstrip(".")) for fault in error.faults]
        raise FileFaults(faults, document.file) from None


def _below(places: dict[DataPath, Any]) -> dict[DataPath, Any]:
    return {path[1:]: place for path, place in places.items() if path[:1] == ("variants",)}


def resolve_document(document: Document, path: Path, sets: Sets = (), variant: Variant | None = None) -> ScenarioFile:
    """The resolved scenario of a document that is already read; the document is left as it is."""
    document = Document(document.file, copy.deepcopy(document.data), dict(document.keys), dict(document.values))
    if isinstance(document.data, dict):
        if variant is not None:
            apply_sets(document, variant.sets, FIELDS, document.place(("variants",), key=True))
        apply_sets(document, sets, FIELDS)
        name = document.data.get("id") or id_of(path)
        document.data["id"] = f"{name}[{variant.name}]" if variant is not None else name
    return _Resolver(document).resolved()


def check_part(document: Document, path: Path) -> None:
    """Check a file that is no scenario by itself but is included by others; what refers to phases is left out."""
    part = Document(document.file, {**document.data, "manoeuvre": _PLACEHOLDER_STEPS}, document.keys, document.values)
    _Resolver(part, knows_phases=False).resolved()


class _Resolver:
    def __init__(self, document: Document, *, knows_phases: bool = True) -> None:
        self.document = document
        self.knows_phases = knows_phases
        self.context = checks.Context(document)

    def resolved(self) -> ScenarioFile:
        """The scenario; raises with all faults, those of the schema and those of its meaning."""
        if isinstance(self.document.data, dict):
            self._absolute_paths()
            self._read_road()
            self._read_faults()
        scenario = self._validated()
        context = self.context
        checks.check_car(scenario, context)
        checks.check_road(scenario, context)
        numbers = checks.check_overrides(scenario, context)
        estimators = checks.check_estimators(scenario, context)
        checks.check_faults(scenario, context)
        checks.check_conditions(scenario, context)
        checks.check_all_criteria(scenario, context)
        stimuli = checks.check_stimuli(scenario, context)
        checks.check_ecu(scenario, context)
        if context.faults:
            raise FileFaults(_in_order(context.faults, self.document.file), self.document.file)
        road = scenario.road.model_copy(deep=True)
        self._set_road(road, numbers)
        return scenario.model_copy(
            update={
                "include": [],
                "overrides": {path: value for path, value in numbers.items() if not path.startswith("road.")},
                "sensors": {},
                "road": road,
                "stimuli": stimuli,
                "estimators": estimators,
                "variants": None,
            }
        )

    def _set_road(self, road: Any, numbers: dict[str, float]) -> None:
        from vehicle_model.parameters import set_parameter

        for path, value in numbers.items():
            if path.startswith("road."):
                set_parameter(road, path, value, "road.")

    def _absolute_paths(self) -> None:
        """Paths of files in the scenario start from the file that names them."""
        for path in _FILES:
            try:
                value = self.document.value(path)
            except KeyError:
                continue
            if isinstance(value, str) and value.endswith(_SUFFIXES):
                place = self.document.place(path)
                folder = Path(place.file).parent if place.line else Path()
                self.document.value(path[:-1])[path[-1]] = str((folder / value).resolve())

    def _read_road(self) -> None:
        """A road given by its name or path, as the road itself."""
        from vehicle_model.road_file import load_road

        name = self.document.data.get("road")
        if not isinstance(name, str):
            return
        try:
            self.document.data["road"] = load_road(name).model_dump(exclude_none=True)
        except InputError as error:
            self.context.add_error(("road",), error)
            del self.document.data["road"]

    def _read_faults(self) -> None:
        """Faults given by the path of a file, as the faults themselves."""
        from can_fault_injector.faults.fault_file import load_faults

        path = self.document.data.get("faults")
        if not isinstance(path, str):
            return
        try:
            faults = load_faults(path)
        except InputError as error:
            self.context.add_error(("faults",), error)
            del self.document.data["faults"]
            return
        self.document.data["faults"] = [fault.model_dump(exclude_none=True) for fault in faults]

    def _validated(self) -> ScenarioFile:
        """The model; sections with faults are noted and left out so that the others can be checked too."""
        try:
            scenario = validate(self.document, ScenarioFile)
        except FileFaults as error:
            self.context.faults += error.faults
            scenario = self._without(error.faults)
        else:
            self.context.phases = scenario.manoeuvre.phase_names if self.knows_phases else None
        self._check_surfaces(scenario)
        return scenario

    def _without(self, faults: Sequence[Fault]) -> ScenarioFile:
        if not isinstance(self.document.data, dict):
            raise FileFaults(faults, self.document.file)
        bad = {re.split(r"[.\[]", fault.field)[0] for fault in faults}
        if "" in bad:
            raise FileFaults(_in_order(self.context.faults, self.document.file), self.document.file)
        data = {name: value for name, value in self.document.data.items() if name not in bad}
        data.setdefault("manoeuvre", _PLACEHOLDER_STEPS)
        scenario = ScenarioFile.model_validate(data)
        self.context.phases = scenario.manoeuvre.phase_names if "manoeuvre" not in bad else self._step_names()
        return scenario

    def _step_names(self) -> list[str] | None:
        """Names of the steps of a faulty manoeuvre, so that what refers to them can be checked."""
        try:
            steps = self.document.value(("manoeuvre", "steps"))
        except KeyError:
            return None
        if not isinstance(steps, list):
            return None
        return [str(step["name"]) for step in steps if isinstance(step, dict) and step.get("name")]

    def _check_surfaces(self, scenario: ScenarioFile) -> None:
        try:
            scenario.road.used_surfaces()
        except InputError as error:
            self.context.add_error(("road",), error)


def _in_order(faults: Sequence[Fault], file: str) -> list[Fault]:
    unique = list(dict.fromkeys(faults))
    return sorted(unique, key=lambda fault: (fault.file != file, fault.file, fault.line, fault.column))


def dump(scenario: ScenarioFile) -> str:
    """YAML text of a resolved scenario; read back it gives the identical model."""
    from io import StringIO

    from ruamel.yaml import YAML

    yaml = YAML(typ="safe", pure=True)
    yaml.default_flow_style = False
    yaml.sort_base_mapping_type_on_output = False  # type: ignore[assignment]
    yaml.width = 120
    stream = StringIO()
    yaml.dump(scenario.model_dump(mode="json", exclude_none=True), stream)
    return stream.getvalue()
