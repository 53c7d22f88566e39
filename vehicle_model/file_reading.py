"""Reading of vehicle, tyre and road files: mappings, one laid over another, checked against a model."""

from pathlib import Path
from typing import Any, TypeVar

from pydantic import BaseModel, ValidationError
from ruamel.yaml import YAML
from ruamel.yaml.error import YAMLError

from signals.errors import InputError

Model = TypeVar("Model", bound=BaseModel)


def read_mapping(path: Path) -> dict[str, Any]:
    """Content of a YAML file whose top is a mapping.

    Raises
    ------
    InputError
        If the file cannot be read, is no YAML or is no mapping.
    """
    try:
        content = YAML(typ="safe", pure=True).load(path.read_text(encoding="utf-8"))
    except (OSError, YAMLError) as error:
        raise InputError(f"{path}: {error}") from None
    if not isinstance(content, dict):
        raise InputError(f"{path}: found {type(content).__name__}, allowed: a mapping of names to values")
    return content


def validated(path: Path, data: dict[str, Any], model: type[Model]) -> Model:
    """The model filled from ``data``; faults are reported as those of the file ``path``."""
    try:
        return model.model_validate(data)
    except ValidationError as error:
        lines = [f"{path}: {'.'.join(map(str, fault['loc']))}: {fault['msg']}" for fault in error.errors()]
        raise InputError("\n".join(lines)) from None


def merged(base: dict[str, Any], change: dict[str, Any]) -> dict[str, Any]:
    """``change`` laid over ``base``, mapping by mapping; a source of a value that changed is dropped."""
    result = _merged(base, change)
    changed = set(_paths(change, ""))
    kept = {path: text for path, text in base.get("sources", {}).items() if path not in changed}
    result["sources"] = kept | change.get("sources", {})
    return result


def _merged(base: dict[str, Any], change: dict[str, Any]) -> dict[str, Any]:
    result = dict(base)
    for key, value in change.items():
        below = result.get(key)
        result[key] = _merged(below, value) if isinstance(below, dict) and isinstance(value, dict) else value
    return result


def _paths(data: dict[str, Any], prefix: str) -> list[str]:
    found = []
    for key, value in data.items():
        found += [f"{prefix}{key}", *(_paths(value, f"{prefix}{key}.") if isinstance(value, dict) else [])]
    return found
