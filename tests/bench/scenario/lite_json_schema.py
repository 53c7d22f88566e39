"""Validator for the part of JSON Schema draft-07 that the bench's schemas use; the tests need no library for it."""

import re
from collections.abc import Iterator
from typing import Any

KEYWORDS = {
    "$schema", "$ref", "title", "description", "default", "definitions", "type", "properties", "additionalProperties",
    "required", "items", "minItems", "maxItems", "minLength", "maxLength", "minimum", "maximum", "exclusiveMinimum",
    "exclusiveMaximum", "pattern", "enum", "const", "anyOf", "oneOf", "allOf", "propertyNames", "minProperties",
}  # fmt: skip
_TYPES: dict[str, Any] = {
    "object": dict,
    "array": list,
    "string": str,
    "number": (int, float),
    "integer": int,
    "boolean": bool,
    "null": type(None),
}


def schemas_in(schema: Any, path: str = "#") -> Iterator[tuple[str, dict[str, Any]]]:
    """Every schema inside a schema with its path."""
    if isinstance(schema, bool):
        return
    yield path, schema
    for key in ("properties", "definitions"):
        for name, inner in schema.get(key, {}).items():
            yield from schemas_in(inner, f"{path}/{key}/{name}")
    for key in ("anyOf", "oneOf", "allOf"):
        for number, inner in enumerate(schema.get(key, [])):
            yield from schemas_in(inner, f"{path}/{key}/{number}")
    for key in ("items", "additionalProperties", "propertyNames"):
        if key in schema:
            yield from schemas_in(schema[key], f"{path}/{key}")


def errors_of(value: Any, schema: Any, root: dict[str, Any], path: str = "") -> list[str]:
    """What in a value does not fit a schema."""
    if isinstance(schema, bool):
        return [] if schema else [f"{path}: not allowed"]
    if "$ref" in schema:
        return errors_of(value, root["definitions"][schema["$ref"].removeprefix("#/definitions/")], root, path)
    found = [*_kind_errors(value, schema, path), *_limit_errors(value, schema, path)]
    for inner in schema.get("allOf", []):
        found += errors_of(value, inner, root, path)
    for key in ("anyOf", "oneOf"):
        branches = [errors_of(value, inner, root, path) for inner in schema.get(key, [])]
        if branches and all(branches):
            found += min(branches, key=len)
    if isinstance(value, dict):
        found += _object_errors(value, schema, root, path)
    if isinstance(value, list) and "items" in schema:
        for number, item in enumerate(value):
            found += errors_of(item, schema["items"], root, f"{path}[{number}]")
    return found


def _kind_errors(value: Any, schema: dict[str, Any], path: str) -> list[str]:
    kind = schema.get("type")
    if kind is not None and (not isinstance(value, _TYPES[kind]) or (kind != "boolean" and isinstance(value, bool))):
        return [f"{path}: {value!r} is no {kind}"]
    if "const" in schema and value != schema["const"]:
        return [f"{path}: {value!r} is not {schema['const']!r}"]
    if "enum" in schema and value not in schema["enum"]:
        return [f"{path}: {value!r} is none of {schema['enum']}"]
    return []


def _limit_errors(value: Any, schema: dict[str, Any], path: str) -> list[str]:
    number = isinstance(value, (int, float)) and not isinstance(value, bool)
    wrong = (
        (number and value < schema.get("minimum", value))
        or (number and value > schema.get("maximum", value))
        or (isinstance(value, str) and "pattern" in schema and re.search(schema["pattern"], value) is None)
        or (isinstance(value, list) and len(value) < schema.get("minItems", 0))
        or (isinstance(value, list) and len(value) > schema.get("maxItems", len(value)))
    )
    return [f"{path}: {value!r} is out of its limits"] if wrong else []


def _object_errors(value: dict[str, Any], schema: dict[str, Any], root: dict[str, Any], path: str) -> list[str]:
    properties, rest = schema.get("properties", {}), schema.get("additionalProperties", True)
    found = [f"{path}: {name} is missing" for name in schema.get("required", []) if name not in value]
    for name, inner in value.items():
        found += errors_of(inner, properties.get(name, rest), root, f"{path}.{name}")
    return found
