"""The kinds of files that the bench reads: which one a file is, how it is checked, and its JSON Schema."""

import json
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from importlib import import_module
from pathlib import Path
from typing import Any

from pydantic import BaseModel

from bench.scenario.locate import SHARED, find_scenario
from signals.errors import FileFaults, InputError
from signals.yaml_files import Document, load_yaml, validate


@dataclass(frozen=True)
class Kind:
    """One kind of file.

    Attributes
    ----------
    model : str
        ``module:class`` of its schema.
    partial : bool
        A file may leave out required fields because another file has them.
    """

    name: str
    model: str
    partial: bool = False

    def load_model(self) -> type[BaseModel]:
        """The pydantic model."""
        module, name = self.model.split(":")
        model: type[BaseModel] = getattr(import_module(module), name)
        return model


@dataclass(frozen=True)
class Checked:
    """A file without faults: its kind and a few words about it."""

    kind: str
    note: str = ""


KINDS = (
    Kind("scenario", "bench.scenario.schema:ScenarioFile", partial=True),
    Kind("procedure", "bench.scenario.procedure_file:ProcedureFile"),
    Kind("campaign", "bench.campaign.campaign_file:CampaignFile"),
    Kind("vehicle", "vehicle_model.vehicle_file:VehicleFile", partial=True),
    Kind("tyre", "vehicle_model.tyres.tyre_file:TyreFile"),
    Kind("road", "vehicle_model.road_file:RoadFile"),
    Kind("surfaces", "vehicle_model.road_file:SurfaceFile"),
    Kind("calibration", "bench.ecu.calibration:CalibrationFile"),
    Kind("mapping", "bench.codec.mapping_file:MappingFile"),
    Kind("surface_comparison", "bench.estimation.surfaces_file:SurfaceComparisonFile"),
    Kind("criteria", "bench.verdict.criteria_file:CriteriaFile"),
    Kind("channel_map", "signals.measured.channel_map:ChannelMap"),
    Kind("faults", "can_fault_injector.faults.fault_file:FaultsFile"),
)
SCHEMA_KINDS = tuple(kind.name for kind in KINDS)
_BY_NAME = {kind.name: kind for kind in KINDS}
_TELLING = {
    "hazards": "campaign",
    "manoeuvre": "scenario",
    "compared": "surface_comparison",
    "runs": "procedure",
    "extends": "vehicle",
    "body": "vehicle",
    "surfaces": "surfaces",
    "monitoring": "calibration",
    "channels": "channel_map",
    "ecu": "scenario",
    "include": "scenario",
    "faults": "faults",
}
DATABASES = (".dbc", ".kcd", ".sym", ".arxml")


def kind_of_file(document: Document) -> Kind:
    """The kind whose fields a file has; of several the one with the most of them.

    Raises
    ------
    InputError
        If the file has no field of any kind.
    """
    data = document.data
    if not isinstance(data, dict):
        return _BY_NAME["scenario"]
    only_mapping = isinstance(data.get("ecu"), list) or ("dbc" in data and "signals" in data)
    if only_mapping:
        return _BY_NAME["mapping"]
    for field, name in _TELLING.items():
        if field in data and not (name == "surfaces" and "friction" in data):
            return _BY_NAME[name]
    scores = {kind.name: _fit(data, kind.load_model()) for kind in KINDS}
    best = max(scores, key=lambda name: scores[name])
    if scores[best][0] == 0:
        allowed = f"a file of one of these kinds: {', '.join(SCHEMA_KINDS)}"
        raise FileFaults([document.fault((), "no field of any kind of file", allowed=allowed)], document.file)
    return _BY_NAME[best]


def _fit(data: dict[str, Any], model: type[BaseModel]) -> tuple[int, int]:
    """How well a file fits a kind: its fields that the kind has, then the fewest required ones that it lacks."""
    missing = [name for name, field in model.model_fields.items() if field.is_required() and name not in data]
    return len(set(data) & set(model.model_fields) - {"format"}), -len(missing)


def check_file(argument: str) -> Checked:
    """Check a file of any kind, or the scenario of an id.

    Raises
    ------
    InputError
        With every fault of the file.
    """
    if argument.endswith(DATABASES):
        return _check_database(argument)
    if argument.lower().endswith(".tir"):
        return _check_tir(argument)
    path = find_scenario(argument)
    document = load_yaml(path)
    kind = kind_of_file(document)
    check = _CHECKS.get(kind.name)
    if check is not None:
        return Checked(kind.name, check(path, document))
    validate(document, kind.load_model())
    return Checked(kind.name)


def _check_scenario(path: Path, loaded: Document) -> str:
    from bench.scenario.documents import read_document
    from bench.scenario.resolution import check_part, resolve_document, variants_of

    document = read_document(path, loaded=loaded)
    if SHARED in path.parts and "manoeuvre" not in document.data:
        check_part(document, path)
        return ", a part that others include"
    scenario = resolve_document(document, path)
    variants = variants_of(document)
    for entry in _few(variants):
        resolve_document(document, path, variant=entry)
    count = f", {len(variants)} variants" if variants else ""
    return f" {scenario.id}, {len(scenario.criteria)} criteria{count}"


def _few(entries: Sequence[Any], most: int = 12) -> Sequence[Any]:
    """The first and last ones of many: they show every path and the ends of every range."""
    return entries if len(entries) <= most else [*entries[: most // 2], *entries[-most // 2 :]]


def _check_procedure(path: Path, loaded: Document) -> str:
    from bench.scenario.procedure import read_procedure

    procedure = read_procedure(path)
    return f" of {len(procedure.runs)} kinds of runs, {len(procedure.criteria)} criteria"


def _check_campaign(path: Path, loaded: Document) -> str:
    from bench.campaign.engine import read_campaign
    from bench.campaign.fault_space import FaultSpace

    campaign = read_campaign(path)
    return f" of {len(campaign.faults)} kinds of faults, {FaultSpace(campaign).singles} single ones"


def _check_vehicle(path: Path, loaded: Document) -> str:
    from vehicle_model.vehicle_file import load_vehicle, parameter_table

    return f", {len(parameter_table(load_vehicle(path)))} parameters"


def _check_tyres(path: Path, loaded: Document) -> str:
    from vehicle_model.vehicle_file import load_tyres

    load_tyres(path)
    return ""


def _check_road(path: Path, loaded: Document) -> str:
    from vehicle_model.road_file import load_road

    load_road(path)
    return ""


def _check_database(argument: str) -> Checked:
    from bench.codec.resolve import load_layout

    layout = load_layout(argument)
    return Checked("CAN database", f", {len(layout.carriers)} messages")


def _check_tir(argument: str) -> Checked:
    from vehicle_model.tyres.tir_check import read_checked, version_of

    tir = read_checked(argument)
    return Checked("tyre of the Magic Formula", f" {version_of(tir) / 10.0:.1f}, {len(tir.numbers)} numbers")


def _check_mapping(path: Path, loaded: Document) -> str:
    from bench.codec.resolve import load_layout

    layout = load_layout(None, path)
    return f", {len(layout.carriers)} messages"


_CHECKS: dict[str, Callable[[Path, Document], str]] = {
    "scenario": _check_scenario,
    "procedure": _check_procedure,
    "campaign": _check_campaign,
    "vehicle": _check_vehicle,
    "tyre": _check_tyres,
    "road": _check_road,
    "mapping": _check_mapping,
}


def schema_of(kind: str) -> dict[str, Any]:
    """JSON Schema (draft-07) of a kind of file."""
    from signals.json_schema import draft7_schema

    entry = _BY_NAME[kind]
    return draft7_schema(entry.load_model(), f"{kind} file of the bench", partial=entry.partial)


def write_schemas(folder: Path, kinds: Sequence[str] = SCHEMA_KINDS) -> list[Path]:
    """Write ``<kind>.schema.json`` for each kind; returns the files.

    Raises
    ------
    InputError
        If the folder cannot be written.
    """
    written = []
    try:
        folder.mkdir(parents=True, exist_ok=True)
        for kind in kinds:
            path = folder / f"{kind}.schema.json"
            path.write_text(json.dumps(schema_of(kind), indent=2, ensure_ascii=False) + "\n", encoding="utf-8")
            written.append(path)
    except OSError as error:
        raise InputError(f"{folder}: {(error.strerror or str(error)).lower()}") from None
    return written
