"""Parameters of a file by dotted path: list them, read them, change them."""

import math
from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any

from pydantic import BaseModel, ValidationError
from pydantic.fields import FieldInfo

from signals.errors import InputError, unknown_name
from signals.quantities import QuantityError, limits_of, range_text, to_si, unit_of

VEHICLE_SECTIONS = (
    "body",
    "axles",
    "wheels",
    "suspension",
    "steering",
    "brakes",
    "hydraulics",
    "driveline",
    "aerodynamics",
    "sensors",
    "planar",
    "two_track",
    "steered_track",
    "two_wheeler",
    "tyres",
    "terms",
)
"""Sections of a vehicle file that have parameters."""


@dataclass(frozen=True)
class ParameterInfo:
    """One parameter.

    Attributes
    ----------
    path, unit
        Dotted path in the file, SI unit ("1" where there is none).
    value, default
        SI values; ``default`` is None where the file has to give the value.
    low, high, neutral
        Closed range and the value at which an optional effect changes nothing; None where there is none.
    description, source
        One line each; ``source`` tells where the value comes from.
    """

    path: str
    unit: str
    value: float
    default: float | None
    low: float | None
    high: float | None
    neutral: float | None
    description: str
    source: str


@dataclass(frozen=True)
class _Leaf:
    path: str
    model: BaseModel
    name: str
    position: int | None
    field: FieldInfo

    def value(self) -> float | None:
        value = getattr(self.model, self.name)
        if self.position is not None:
            value = value[self.position]
        return None if value is None else float(value)


def _leaves(model: BaseModel, prefix: str) -> Iterator[_Leaf]:
    for name, field in type(model).model_fields.items():
        value = getattr(model, name)
        path = f"{prefix}{name}"
        if isinstance(value, BaseModel):
            yield from _leaves(value, f"{path}.")
        elif isinstance(value, list):
            for position, item in enumerate(value):
                if isinstance(item, BaseModel):
                    yield from _leaves(item, f"{path}.{position}.")
                elif isinstance(item, (int, float)):
                    yield _Leaf(f"{path}.{position}", model, name, position, field)
        elif unit_of(field) is not None:
            yield _Leaf(path, model, name, None, field)


def numbers(model: BaseModel, prefix: str = "") -> dict[str, float]:
    """Every number of a file model by dotted path, in SI units; ``prefix`` is put before each path."""
    return {leaf.path: value for leaf in _leaves(model, prefix) if (value := leaf.value()) is not None}


def parameter_infos(model: BaseModel, prefix: str = "", sources: dict[str, str] | None = None) -> list[ParameterInfo]:
    """Table of the parameters of a file model in file order; ``sources`` (path → text) wins over declared sources."""
    return [_info(leaf, value, sources or {}) for leaf in _leaves(model, prefix) if (value := leaf.value()) is not None]


def _info(leaf: _Leaf, value: float, sources: dict[str, str]) -> ParameterInfo:
    field = leaf.field
    extra: dict[str, Any] = field.json_schema_extra if isinstance(field.json_schema_extra, dict) else {}
    default = field.default if isinstance(field.default, (int, float)) else None
    low, high = limits_of(field)
    declared = str(extra.get("source", ""))
    return ParameterInfo(
        path=leaf.path,
        unit=str(extra.get("unit", "1")),
        value=value,
        default=None if default is None else float(default),
        low=low,
        high=high,
        neutral=extra.get("neutral"),
        description=field.description or "",
        source=_source_of(leaf.path, sources) or (declared if value == default or default is None else ""),
    )


def _source_of(path: str, sources: dict[str, str]) -> str:
    """Source of the longest dotted prefix of ``path``."""
    parts = path.split(".")
    for count in range(len(parts), 0, -1):
        text = sources.get(".".join(parts[:count]))
        if text is not None:
            return text
    return ""


def find(model: BaseModel, path: str, prefix: str = "") -> _Leaf:
    """The parameter of that path.

    Raises
    ------
    InputError
        If there is none; the message names the nearest path.
    """
    leaf = _leaf_at(model, path, prefix)
    if leaf is not None:
        return leaf
    raise unknown_name("parameter", path, [leaf.path for leaf in _leaves(model, prefix)])


def _leaf_at(model: BaseModel, path: str, prefix: str) -> _Leaf | None:
    """The parameter at the end of a path, None if the path leads nowhere.

    Walks the path instead of the whole file: a stimulus may set a parameter each millisecond.
    """
    if not path.startswith(prefix):
        return None
    names = path[len(prefix) :].split(".")
    while names:
        name = names.pop(0)
        field = type(model).model_fields.get(name)
        if field is None:
            return None
        value: Any = getattr(model, name)
        if isinstance(value, list):
            position = int(names.pop(0)) if names and names[0].isdecimal() else len(value)
            if position >= len(value):
                return None
            value = value[position]
            if not names and isinstance(value, (int, float)):
                return _Leaf(path, model, name, position, field)
        elif not names and unit_of(field) is not None and not isinstance(value, BaseModel):
            return _Leaf(path, model, name, None, field)
        if not isinstance(value, BaseModel):
            return None
        model = value
    return None


def get_parameter(model: BaseModel, path: str, prefix: str = "") -> float:
    """Value of one parameter in SI units; InputError if there is none of that path."""
    value = find(model, path, prefix).value()
    if value is None:
        raise InputError(f"{path}: has no value")
    return value


def set_parameter(model: BaseModel, path: str, value: float | str, prefix: str = "") -> None:
    """Change one parameter of a file model in place.

    Parameters
    ----------
    value
        Number in SI units, or a text with its unit.

    Raises
    ------
    InputError
        If there is no such parameter, or the value has another dimension or is out of its range.
    """
    leaf = find(model, path, prefix)
    unit = unit_of(leaf.field) or "1"
    try:
        number = to_si(value, unit)
    except QuantityError as error:
        raise InputError(f"{path}: {error}") from None
    low, high = limits_of(leaf.field)
    if (low is not None and number < low) or (high is not None and number > high) or not math.isfinite(number):
        raise InputError(f"{path}: out of range", found=f"{number:g}", allowed=range_text(unit, low, high))
    if leaf.position is not None:
        getattr(leaf.model, leaf.name)[leaf.position] = number
        return
    try:
        leaf.model.__pydantic_validator__.validate_assignment(leaf.model, leaf.name, number)
    except ValidationError as error:
        raise InputError(f"{path}: {error.errors()[0]['msg']}") from None
