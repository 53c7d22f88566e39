"""A scenario as one document: its includes laid under it and the values of ``--set`` on top, each with its place."""

import re
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

from signals.errors import FileFaults, InputError, nearest_name
from signals.yaml_files import DataPath, Document, Place, load_yaml, overlay, parse_yaml
from vehicle_model.parameters import VEHICLE_SECTIONS

_PARAMETERS = (*VEHICLE_SECTIONS, "road")
# lists that an include and the file together make: entries of the same name are merged, the others stand in order
_JOINED = {"criteria": "id", "stimuli": "name", "valid_if": ""}

Sets = Sequence[str] | Mapping[str, Any]


def read_document(path: Path, seen: tuple[Path, ...] = (), *, loaded: Document | None = None) -> Document:
    """A scenario file laid over the files that it includes; ``loaded`` is the file itself if it is already read.

    Raises
    ------
    InputError
        If a file cannot be read or is no YAML, or a file includes itself.
    """
    document = loaded or load_yaml(path)
    if not isinstance(document.data, dict):
        return document
    includes = document.data.pop("include", [])
    if isinstance(includes, str):
        includes = [includes]
    if not isinstance(includes, list) or not all(isinstance(name, str) for name in includes):
        fault = document.fault(
            ("include",), "not a list of files", found=repr(includes), allowed="paths relative to it"
        )
        raise FileFaults([fault], document.file)
    chain = (*seen, path.resolve())
    base: Document | None = None
    for number, name in enumerate(includes):
        included = path.parent / name
        if included.resolve() in chain:
            cycle = " → ".join(file.name for file in (*chain, included.resolve()))
            fault = document.fault(("include", number), "the file includes itself", found=cycle)
            raise FileFaults([fault], document.file)
        try:
            part = read_document(included, chain)
        except InputError as error:
            raise _with_includer(error, document, number) from None
        base = part if base is None else _joined(base, part)
    return document if base is None else _joined(base, document)


def _with_includer(error: InputError, document: Document, number: int) -> InputError:
    """Says which line includes a file that does not exist; a fault in the file itself has its own place."""
    if isinstance(error, FileFaults):
        return error
    fault = document.fault(("include", number), error.message, nearest=error.nearest)
    return FileFaults([fault], document.file)


def _joined(base: Document, over: Document) -> Document:
    if not isinstance(base.data, dict):
        return over
    result = overlay(base, over)
    for name, key in _JOINED.items():
        entries = _entries(base, over, name, key)
        if entries is not None:
            _put_list(result, name, entries)
    return result


Entry = tuple[Any, list[tuple[Document, int]]]


def _entries(base: Document, over: Document, name: str, key: str) -> list[Entry] | None:
    """Entries of a joined list with the places that each came from."""
    lower, upper = base.data.get(name), over.data.get(name) if isinstance(over.data, dict) else None
    if not isinstance(lower, list) or not isinstance(upper, list):
        return None
    entries: list[Entry] = [(entry, [(base, number)]) for number, entry in enumerate(lower)]
    for number, entry in enumerate(upper):
        same = next((n for n, (other, _) in enumerate(entries) if _same(other, entry, key)), None)
        if same is None:
            entries.append((entry, [(over, number)]))
        else:
            before, origins = entries[same]
            entries[same] = (before | entry, [*origins, (over, number)])
    return entries


def _same(first: Any, second: Any, key: str) -> bool:
    named = bool(key) and isinstance(first, dict) and isinstance(second, dict)
    return named and first.get(key) is not None and first.get(key) == second.get(key)


def _put_list(document: Document, name: str, entries: list[Entry]) -> None:
    document.data[name] = [entry for entry, _ in entries]
    for places in (document.keys, document.values):
        for path in [path for path in places if path[:1] == (name,) and len(path) > 1]:
            del places[path]
    for number, (_, origins) in enumerate(entries):
        for origin, old in origins:
            _copy_places(origin, document, (name, old), (name, number))


def _copy_places(origin: Document, target: Document, old: DataPath, new: DataPath) -> None:
    for source, places in ((origin.keys, target.keys), (origin.values, target.values)):
        for path, place in source.items():
            if path[: len(old)] == old:
                places[(*new, *path[len(old) :])] = place


def parse_sets(sets: Sets) -> dict[str, Any]:
    """``path=value`` texts as a mapping; values are read as YAML.

    Raises
    ------
    InputError
        If a text has no ``=``.
    """
    if isinstance(sets, Mapping):
        return dict(sets)
    values: dict[str, Any] = {}
    for text in sets:
        path, equals, value = text.partition("=")
        if not equals or not path.strip():
            raise InputError(f"--set {text}", allowed="PATH=VALUE, e.g. --set road.friction=0.5")
        values[path.strip()] = _read_value(value.strip())
    return values


def _read_value(text: str) -> Any:
    try:
        return parse_yaml(f"value: {text}", "--set").data["value"]
    except InputError:
        return text


def apply_sets(document: Document, sets: Sets, fields: Sequence[str], origin: Place | None = None) -> None:
    """Put the values of ``--set``, or of a variant that stands at ``origin``, into the document.

    A path that begins with a field of scenarios names that field (entries of lists by position, name or id); one that
    begins with a section of vehicle files or with ``road`` names a parameter.

    Raises
    ------
    InputError
        If a path is neither.
    """
    for text, value in parse_sets(sets).items():
        parts = [part for part in re.split(r"[.\[\]]+", text) if part]
        place = origin or Place(f"--set {text}={value}", 0, 0)
        if parts[0] == "road" and len(parts) > 1 and isinstance(document.data.get("road", {}), dict):
            _put(document, _path_in(document, parts), value, place)
        elif parts[0] in _PARAMETERS and len(parts) > 1:
            _put(document, ("overrides", ".".join(parts)), value, place)
        elif parts[0] == "overrides" and len(parts) > 1:
            _put(document, ("overrides", ".".join(parts[1:])), value, place)
        elif parts[0] in fields:
            _put(document, _path_in(document, parts), value, place)
        else:
            known = [*fields, *_PARAMETERS]
            near = nearest_name(parts[0], known)
            allowed = "a field of scenarios or a parameter of car or road (bench vehicle list NAME)"
            raise InputError(f"--set {text}: unknown name {parts[0]!r}", nearest=near, allowed=allowed)


def _path_in(document: Document, parts: Sequence[str]) -> DataPath:
    """Path in the data; an entry of a list may be given by its position, name or id."""
    path: list[str | int] = []
    value: Any = document.data
    for part in parts:
        if isinstance(value, list):
            index = _index(value, part)
            if index is None:
                names = [str(entry.get("name") or entry.get("id")) for entry in value if isinstance(entry, dict)]
                near = nearest_name(part, names)
                raise InputError(
                    f"--set {'.'.join(parts)}: no entry {part!r}", nearest=near, allowed=", ".join(names[:12])
                )
            path.append(index)
            value = value[index]
        else:
            path.append(part)
            value = value.get(part) if isinstance(value, dict) else None
    return tuple(path)


def _index(entries: list[Any], part: str) -> int | None:
    if part.isdigit() and int(part) < len(entries):
        return int(part)
    named = (n for n, e in enumerate(entries) if isinstance(e, dict) and part in (e.get("name"), e.get("id")))
    return next(named, None)


def _put(document: Document, path: DataPath, value: Any, place: Place) -> None:
    target = document.data
    for position, part in enumerate(path[:-1]):
        if isinstance(target, list):
            target = target[int(part)]
            continue
        if not isinstance(target.get(part), (dict, list)):
            target[part] = {}
            document.keys[path[: position + 1]] = place
        target = target[part]
    target[path[-1]] = value
    for places in (document.keys, document.values):
        for old in [old for old in places if old[: len(path)] == path]:
            del places[old]
        places[path] = place
