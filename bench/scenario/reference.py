"""docs/scenario_reference.md, written from the models: every field with what it takes, its default and its meaning."""

import types
from collections.abc import Iterator
from typing import Annotated, Any, Literal, Union, get_args, get_origin

from pydantic import BaseModel
from pydantic.fields import FieldInfo
from pydantic_core import PydanticUndefined

from signals.quantities import limits_of, range_text, unit_of
from signals.validation import fields_of

_TYPE_NAMES = {
    str: "text",
    float: "number",
    int: "whole number",
    bool: "true or false",
    dict: "mapping",
    Any: "anything",
}

_HEAD = """# Scenario files

This page is made from the models by `python docs/generate.py`; a test keeps it fresh. Editors read the same from the
JSON Schemas in `scenarios/schemas/` (`bench schema` prints them): the first line of a file names its schema,

    # yaml-language-server: $schema=schemas/scenario.schema.json

- `bench check FILE` tells every fault with file, line, column, what was found and what is allowed;
  [errors.md](errors.md) shows each kind.
- A quantity is a number in the SI unit that stands in brackets, or a text with a unit: `80 km/h`, `120 bar`, `0.3 g`,
  `5 %`. A unit of another dimension is refused.
- `include: [FILE, …]` lays this file over others, field by field; a later file wins, and this one over all. Lists are
  replaced, but `criteria` and `stimuli` of the same `id` or `name` are merged and others appended, `valid_if` appended.
- Relative paths start from the file that they stand in.
- `--set PATH=VALUE` reaches every field (`--set ecu.calibration=coarse`; entries of lists by position, name or id:
  `--set manoeuvre.steps.brake.brake.pedal_force="80 N"`) and every parameter of car and road by its dotted path
  (`--set brakes.front.pad_friction=0.3`, `--set road.friction=0.5`; `bench vehicle list NAME` lists them).
- The run's folder keeps the scenario as run, `scenario.yaml`, with all defaults and overrides in it; it can be run
  again.
"""


def scenario_reference() -> str:
    """The page."""
    from bench.scenario.procedure_file import ProcedureFile
    from bench.scenario.schema import ScenarioFile

    parts = [_HEAD, *_document(ScenarioFile, "Scenario"), *_document(ProcedureFile, "Procedure"), _estimators()]
    return "\n".join(parts).rstrip() + "\n"


def _document(model: type[BaseModel], title: str) -> Iterator[str]:
    """The sections of a kind of file: the file itself, then every object in it, each once."""
    yield _section(model, f"## {title}")
    seen = {model}
    waiting = list(_inner_models(model))
    while waiting:
        inner = waiting.pop(0)
        if inner in seen:
            continue
        seen.add(inner)
        yield _section(inner, f"### {_title(inner)}")
        waiting += _inner_models(inner)


def _title(model: type[BaseModel]) -> str:
    return model.__name__


def _section(model: type[BaseModel], heading: str) -> str:
    lines = [f'<a id="{model.__name__.lower()}"></a>', "", heading, "", _summary(model), ""]
    lines += ["| field | takes | default | meaning |", "|---|---|---|---|"]
    lines += [_row(name, field) for name, field in fields_of(model).items()]
    return "\n".join([*lines, ""])


def _summary(model: type[BaseModel]) -> str:
    text = (model.__doc__ or "").strip().split("\n\n")[0]
    return " ".join(text.split())


def _row(name: str, field: FieldInfo) -> str:
    cells = [f"`{name}`", _takes(field), _default(field), field.description or ""]
    return "| " + " | ".join(cell.replace("|", "\\|") for cell in cells) + " |"


def _takes(field: FieldInfo) -> str:
    unit = unit_of(field)
    low, high = limits_of(field)
    shown = _type(field.annotation)
    if unit is not None and unit != "1":
        shown = shown.replace("number", f"quantity [{unit}]").replace("text or quantity", "quantity")
    if low is not None or high is not None:
        shown += f", {range_text('', low, high)}"
    return shown


def _type(annotation: Any) -> str:
    origin, arguments = get_origin(annotation), get_args(annotation)
    if origin is Annotated:
        return _type(arguments[0])
    if origin in (Union, types.UnionType):
        return " or ".join(dict.fromkeys(_type(kind) for kind in arguments if kind is not type(None)))
    if origin is Literal:
        return ", ".join(f"`{str(choice).lower() if isinstance(choice, bool) else choice}`" for choice in arguments)
    if origin is list:
        return f"list of {_type(arguments[0])}"
    if origin is dict:
        inner = "mapping" if get_origin(arguments[1]) is dict else _type(arguments[1])
        return f"name: {inner}"
    if isinstance(annotation, type) and issubclass(annotation, BaseModel):
        return f"[{_title(annotation)}](#{annotation.__name__.lower()})"
    return _TYPE_NAMES.get(annotation, str(annotation))


def _default(field: FieldInfo) -> str:
    if field.is_required():
        return "**required**"
    if field.default is PydanticUndefined or field.default is None or isinstance(field.default, BaseModel):
        return ""
    if isinstance(field.default, bool):
        return f"`{str(field.default).lower()}`"
    if isinstance(field.default, float):
        return f"`{field.default:g}`"
    return f"`{field.default}`" if field.default not in ("", [], {}) else ""


def _inner_models(model: type[BaseModel]) -> Iterator[type[BaseModel]]:
    for field in model.model_fields.values():
        yield from _models_in(field.annotation)


def _models_in(annotation: Any) -> Iterator[type[BaseModel]]:
    if isinstance(annotation, type) and issubclass(annotation, BaseModel):
        yield annotation
    for inner in get_args(annotation):
        yield from _models_in(inner)


def _estimators() -> str:
    """Settings of every estimator."""
    from estimators import describe, names

    parts = ["## Settings of estimators", ""]
    for name in names():
        description = describe(name)
        parts += [f"`{name}`: {description.summary} ({description.source}).", ""]
    shown: set[type[BaseModel]] = set()
    for name in names():
        settings = describe(name).settings
        if settings in shown:
            continue
        shown.add(settings)
        users = ", ".join(f"`{other}`" for other in names() if describe(other).settings is settings)
        parts.append(_section(settings, f"### Settings of {users}"))
        parts += [_section(inner, f"#### {_title(inner)}") for inner in _inner_models(settings) if inner not in shown]
        shown |= set(_inner_models(settings))
    return "\n".join(parts)
