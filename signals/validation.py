"""From pydantic's errors to faults that a user understands: place, found, allowed, nearest name."""

import types
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Annotated, Any, Literal, TypeVar, Union, get_args, get_origin

from pydantic import BaseModel, ValidationError
from pydantic.fields import FieldInfo
from pydantic_core import ErrorDetails

from signals.errors import FieldError, FieldErrors, FileFaults, nearest_name
from signals.quantities import QuantityError, limits_of, range_text, unit_of

if TYPE_CHECKING:
    from signals.yaml_files import Document

Model = TypeVar("Model", bound=BaseModel)

_RANGE = {"greater_than", "greater_than_equal", "less_than", "less_than_equal"}
_LENGTH = {"too_short", "too_long", "string_too_short", "string_too_long"}
_NUMBER = {"float_type", "float_parsing", "int_type", "int_parsing", "int_from_float"}
_WRONG_KIND = {
    "string_type": "a text",
    "bool_type": "true or false",
    "bool_parsing": "true or false",
    "list_type": "a list",
    "dict_type": "a mapping",
    "finite_number": "a finite number",
}


@dataclass(frozen=True)
class _Problem:
    """A fault before it is given its place."""

    path: tuple[str | int, ...]
    problem: str
    found: str = ""
    allowed: str = ""
    nearest: str = ""
    kind: str = ""
    key: bool = False


def field_name(path: Sequence[str | int]) -> str:
    """``manoeuvre.steps[1].brake`` of a path."""
    text = ""
    for part in path:
        text += f"[{part}]" if isinstance(part, int) else f".{part}"
    return text.removeprefix(".")


def brief(value: Any) -> str:
    """A value as it is shown after "found"."""
    if value is None:
        return "nothing"
    if isinstance(value, bool):
        return "true" if value else "false"
    if isinstance(value, dict):
        return f"a mapping ({', '.join(map(str, list(value)[:3]))}{', …' if len(value) > 3 else ''})"
    if isinstance(value, (list, tuple)):
        return f"a list of {len(value)}"
    text = repr(value) if isinstance(value, str) else f"{value}"
    return text if len(text) <= 60 else f"{text[:57]}…"


def validate(document: "Document", model: type[Model]) -> Model:
    """Model of a document.

    Raises
    ------
    FileFaults
        With every fault of the file and its line and column.
    """
    if not isinstance(document.data, dict):
        allowed = f"fields: {_some(list(model.model_fields))}"
        fault = document.fault((), "the file is not a mapping of fields", found=brief(document.data), allowed=allowed)
        raise FileFaults([fault], document.file)
    try:
        return model.model_validate(document.data)
    except ValidationError as error:
        problems = explain(error, model, document.data)
    faults = [
        document.fault(p.path, p.problem, found=p.found, allowed=p.allowed, nearest=p.nearest, key=p.key)
        for p in problems
    ]
    raise FileFaults(sorted(faults, key=lambda f: (f.file != document.file, f.line, f.column)), document.file)


def explain(error: ValidationError, model: type[BaseModel], data: Any) -> list[_Problem]:
    """Problems of a validation error, a misspelt field only once, alternatives of one value joined."""
    problems: list[_Problem] = []
    for detail in error.errors(include_url=False):
        problems += _problems_of(detail, model, data)
    return _join_typos(_join_alternatives(problems), model, data)


def _problems_of(detail: ErrorDetails, model: type[BaseModel], data: Any) -> Iterator[_Problem]:
    path, field, owners = _locate(detail["loc"], model, data)
    kind, value = detail["type"], detail["input"]
    in_file = _lookup(data, path)
    value = value if in_file is None else in_file  # as it was written, before it was converted to SI units
    context: dict[str, Any] = detail.get("ctx") or {}
    cause = context.get("error")
    if kind == "missing":
        allowed = describe(field) if field else ""
        yield _Problem(path, "required field is missing", allowed=allowed, kind=kind, key=True)
    elif kind == "extra_forbidden":
        yield _Problem(path, "unknown field", brief(value), kind=kind, key=True)
    elif isinstance(cause, FieldErrors):
        yield from (_of_field_error(inner, path, data) for inner in cause.errors)
    elif isinstance(cause, FieldError):
        yield _of_field_error(cause, path, data)
    elif isinstance(cause, QuantityError):
        yield _Problem(path, cause.problem, brief(value), cause.allowed, kind=kind)
    elif kind in _RANGE:
        yield _Problem(path, "out of range", brief(value), describe(field) or _limit(kind, context), kind=kind)
    elif kind == "literal_error":
        yield _unknown_value(path, value, field, str(context.get("expected", "")))
    elif kind in _NUMBER:
        whole = "a whole number" if kind.startswith("int") else "a number"
        yield _Problem(path, f"not {whole}", brief(value), describe(field) or whole, kind="wrong_kind")
    elif kind in ("model_type", "model_attributes_type", "dict_type") and owners:
        allowed = f"fields: {_some(_names(owners))}"
        yield _Problem(path, "not a mapping of fields", brief(value), allowed, kind="wrong_kind")
    elif kind in _WRONG_KIND:
        allowed = "" if kind.startswith("bool") else describe(field)
        yield _Problem(path, f"not {_WRONG_KIND[kind]}", brief(value), allowed, kind="wrong_kind")
    elif kind in _LENGTH:
        yield _Problem(path, _length(kind, context), brief(value), kind=kind)
    elif kind == "string_pattern_mismatch":
        allowed = f"{describe(field)} (pattern {context.get('pattern')})".strip()
        yield _Problem(path, "not of the right form", brief(value), allowed, kind=kind)
    else:
        yield _plain(path, detail["msg"].removeprefix("Value error, "), value, data, kind)


def _locate(
    location: tuple[int | str, ...], model: type[BaseModel], data: Any
) -> tuple[tuple[str | int, ...], FieldInfo | None, list[type[BaseModel]]]:
    """Path in the data, field and models at that place; members of unions that pydantic names are left out."""
    path: list[str | int] = []
    kinds: list[Any] = [model]
    field: FieldInfo | None = None
    value = data
    for number, part in enumerate(location):
        inside = (isinstance(value, dict) and part in value) or (
            isinstance(value, list) and isinstance(part, int) and 0 <= part < len(value)
        )
        if inside or (number == len(location) - 1 and isinstance(value, dict) and _has_field(kinds, part)):
            path.append(part)
            value = value[part] if inside else None
            field, kinds = _descend(kinds, part)
        else:
            kinds = [kind for kind in kinds if getattr(kind, "__name__", "") == part] or kinds
    return tuple(path), field, [kind for kind in kinds if _is_model(kind)]


def _is_model(kind: Any) -> bool:
    return isinstance(kind, type) and issubclass(kind, BaseModel)


def fields_of(model: type[BaseModel]) -> dict[str, FieldInfo]:
    """Fields under the names that they have in a file."""
    return {field.alias or name: field for name, field in model.model_fields.items()}


def _has_field(kinds: list[Any], name: str | int) -> bool:
    return any(_is_model(kind) and name in fields_of(kind) for kind in kinds)


def alternatives(annotation: Any) -> list[Any]:
    """Members of a union, without None and without annotations."""
    origin = get_origin(annotation)
    if origin is Annotated:
        return alternatives(get_args(annotation)[0])
    if origin in (Union, types.UnionType):
        return [kind for member in get_args(annotation) for kind in alternatives(member) if kind is not type(None)]
    return [annotation]


def _descend(kinds: list[Any], part: str | int) -> tuple[FieldInfo | None, list[Any]]:
    for kind in kinds:
        if _is_model(kind) and part in fields_of(kind):
            field = fields_of(kind)[str(part)]
            return field, alternatives(field.annotation)
        origin, arguments = get_origin(kind), get_args(kind)
        if origin is list and isinstance(part, int):
            return None, alternatives(arguments[0])
        if origin is dict:
            return None, alternatives(arguments[1])
    return None, []


def _names(models: list[type[BaseModel]]) -> list[str]:
    return [name for model in models for name in fields_of(model)]


def _some(names: Sequence[str]) -> str:
    return ", ".join(names) if len(names) <= 14 else f"{', '.join(names[:12])}, …"


def describe(field: FieldInfo | None) -> str:
    """Range and unit of a field with a unit, choices of a literal, else its description."""
    if field is None:
        return ""
    unit = unit_of(field)
    if unit is not None:
        return range_text(unit, *limits_of(field))
    choices = [
        str(choice)
        for kind in alternatives(field.annotation)
        if get_origin(kind) is Literal
        for choice in get_args(kind)
    ]
    if choices:
        return ", ".join(choices)
    low, high = limits_of(field)
    if low is not None or high is not None:
        return range_text("", low, high)
    return field.description or ""


def _of_field_error(error: FieldError, path: tuple[str | int, ...], data: Any) -> _Problem:
    inner = (*path, *error.at)
    found = error.found
    if not found and error.at:
        value = _lookup(data, inner)
        found = brief(value) if value is not None and not isinstance(value, (dict, list)) else ""
    return _Problem(inner, error.problem, found, error.allowed, error.nearest, kind="value_error")


def _unknown_value(path: tuple[str | int, ...], value: Any, field: FieldInfo | None, expected: str) -> _Problem:
    choices = [choice.strip().strip("'") for choice in expected.replace(" or ", ", ").split(",")]
    near = nearest_name(value, choices) if isinstance(value, str) else ""
    return _Problem(path, "unknown value", brief(value), ", ".join(choices), near, kind="wrong_kind")


def _limit(kind: str, context: dict[str, Any]) -> str:
    word, key = {
        "greater_than": ("more than", "gt"),
        "greater_than_equal": ("at least", "ge"),
        "less_than": ("less than", "lt"),
        "less_than_equal": ("at most", "le"),
    }[kind]
    return f"{word} {context.get(key)}"


def _length(kind: str, context: dict[str, Any]) -> str:
    if kind.endswith("short"):
        return f"too short: at least {context.get('min_length')} needed"
    return f"too long: at most {context.get('max_length')} allowed"


def _plain(path: tuple[str | int, ...], message: str, value: Any, data: Any, kind: str) -> _Problem:
    """A validator's text; one that begins with the name of a field and a colon is put there."""
    head, colon, rest = message.partition(": ")
    parts: tuple[str, ...] = tuple(head.split(".")) if colon and " " not in head else ()
    if parts and isinstance(_lookup(data, path), dict) and parts[0] in _lookup(data, path):
        return _Problem((*path, *parts), rest, kind=kind)
    found = "" if isinstance(value, (dict, list)) or "found" in message else brief(value)
    return _Problem(path, message, found, kind=kind)


def _lookup(data: Any, path: Sequence[str | int]) -> Any:
    for part in path:
        try:
            data = data[part]
        except (KeyError, IndexError, TypeError):
            return None
    return data


def _join_alternatives(problems: list[_Problem]) -> list[_Problem]:
    """One problem per value: members of a union each report it, deeper ones tell more than "wrong kind"."""
    joined: dict[tuple[tuple[str | int, ...], str], _Problem] = {}
    for problem in problems:
        deeper = any(
            len(other.path) > len(problem.path) and other.path[: len(problem.path)] == problem.path
            for other in problems
        )
        if problem.kind == "wrong_kind" and deeper:
            continue
        key = (problem.path, "" if problem.kind == "wrong_kind" else problem.kind + problem.problem)
        before = joined.get(key)
        if before is None:
            joined[key] = problem
        elif problem.problem != before.problem or problem.allowed != before.allowed:
            allowed = f"{_alternative(before)} or {_alternative(problem)}"
            joined[key] = replace(before, problem=_common(before.problem, problem.problem), allowed=allowed)
    return list(joined.values())


def _alternative(problem: _Problem) -> str:
    return problem.allowed or problem.problem.removeprefix("not ")


def _common(first: str, second: str) -> str:
    return first if first == second else "wrong kind of value"


def _join_typos(problems: list[_Problem], model: type[BaseModel], data: Any) -> list[_Problem]:
    """pydantic reports a misspelt required field as "missing" and "unknown": one fault with "did you mean"."""
    missing = {p.path: p for p in problems if p.kind == "missing"}
    result = [p for p in problems if p.kind not in ("missing", "extra_forbidden")]
    for problem in (p for p in problems if p.kind == "extra_forbidden"):
        parent = problem.path[:-1]
        _, _, owners = _locate(parent, model, data)
        absent = [path[-1] for path in missing if path[:-1] == parent]
        names = _names(owners)
        wanted = str(problem.path[-1])
        near = nearest_name(wanted, [str(name) for name in absent]) or nearest_name(wanted, names)
        missing.pop((*parent, near), None)
        for name in _needless(near, absent, owners):
            missing.pop((*parent, name), None)
        allowed = "" if near else _some(sorted(set(names) - set(_lookup(data, parent) or ()), key=names.index))
        result.append(replace(problem, nearest=_with_range(near, owners), allowed=allowed))
    return result + list(missing.values())


def _needless(near: str, absent: Sequence[str | int], owners: list[type[BaseModel]]) -> list[str | int]:
    """Fields that are not missing if the misspelt one is required by another kind of the same object."""
    meant = [fields_of(owner) for owner in owners if near in fields_of(owner) and fields_of(owner)[near].is_required()]
    return [name for name in absent if meant and all(name not in fields for fields in meant)]


def _with_range(name: str, owners: list[type[BaseModel]]) -> str:
    for owner in owners:
        field = fields_of(owner).get(name)
        if field is not None and unit_of(field) is not None:
            return f"{name} ({range_text(unit_of(field) or '', *limits_of(field))})"
    return name
