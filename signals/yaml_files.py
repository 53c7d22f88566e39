"""YAML files read so that every value knows its line and column.

``load_yaml`` gives a `Document`: plain data and the place of each key and value. ``validate`` turns a document into a
pydantic model or raises `FileFaults` with all faults of the file at once.
"""

import copy
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field
from functools import lru_cache
from pathlib import Path
from typing import Any

from ruamel.yaml import YAML
from ruamel.yaml.error import MarkedYAMLError, YAMLError
from ruamel.yaml.nodes import MappingNode, Node, ScalarNode, SequenceNode

from signals.errors import Fault, FileFaults, InputError, nearest_name
from signals.validation import field_name, validate

__all__ = ["DataPath", "Document", "Place", "load_yaml", "parse_yaml", "validate"]

DataPath = tuple[str | int, ...]

LARGEST_FILE_BYTES = 10_000_000
MOST_VALUES = 100_000
_TAG = "tag:yaml.org,2002:"
_TRUE = {"true", "True", "TRUE"}


@dataclass(frozen=True)
class Place:
    """File, line and column, counted from 1."""

    file: str
    line: int
    column: int


@dataclass
class Document:
    """Data of a file with the place of everything in it.

    Attributes
    ----------
    file : str
        Path as the user wrote it.
    data
        Mappings, lists, texts, numbers, truth values and None.
    keys, values : dict
        Place of the key and of the value for the path of each value.
    """

    file: str
    data: Any
    keys: dict[DataPath, Place] = field(default_factory=dict)
    values: dict[DataPath, Place] = field(default_factory=dict)

    @property
    def folder(self) -> Path:
        """Folder that relative paths in the file start from."""
        return Path(self.file).parent

    def place(self, path: Sequence[str | int], *, key: bool = False) -> Place:
        """Place of a value (or of its key), of the nearest enclosing one if the file has none of that path."""
        for end in range(len(path), -1, -1):
            head = tuple(path[:end])
            first, second = (self.keys, self.values) if key or end < len(path) else (self.values, self.keys)
            found = first.get(head) or second.get(head)
            if found is not None:
                return found
        return Place(self.file, 0, 0)

    def value(self, path: Sequence[str | int]) -> Any:
        """Value at a path; KeyError if there is none."""
        value = self.data
        for name in path:
            try:
                value = value[name]
            except (IndexError, TypeError):
                raise KeyError(tuple(path)) from None
        return value

    def fault(
        self,
        path: Sequence[str | int],
        problem: str,
        *,
        found: str = "",
        allowed: str = "",
        nearest: str = "",
        key: bool = False,
    ) -> Fault:
        """A fault at the place of ``path``."""
        place = self.place(path, key=key)
        return Fault(place.file, place.line, place.column, field_name(path), problem, found, allowed, nearest)


def load_yaml(path: str | Path, *, shown_as: str | None = None) -> Document:
    """Read a YAML file.

    Parameters
    ----------
    path : str or Path
        The file.
    shown_as : str, optional
        Name in messages, if it is not the path.

    Raises
    ------
    InputError
        If the file is missing, unreadable, no text, no YAML, or empty.
    """
    shown = shown_as or str(path)
    file = Path(path)
    try:
        if file.is_file() and file.stat().st_size > LARGEST_FILE_BYTES:
            raise InputError(f"{shown}: larger than {LARGEST_FILE_BYTES // 1_000_000} MB, not a file of the bench")
        content = file.read_bytes()
    except OSError as error:
        near, mend = _neighbour(file) if isinstance(error, FileNotFoundError) else ("", "")
        raise InputError(f"{shown}: {_reason(error)}", nearest=near, mend=mend) from None
    try:
        text = content.decode("utf-8-sig")
    except UnicodeDecodeError as error:
        line = content[: error.start].count(b"\n") + 1
        raise InputError(f"{shown}:{line}:1  not a text file (UTF-8)", allowed="YAML") from None
    return parse_yaml(text, shown)


def _reason(error: OSError) -> str:
    if isinstance(error, FileNotFoundError):
        return "no such file"
    if isinstance(error, IsADirectoryError):
        return "is a folder, not a file"
    if isinstance(error, PermissionError):
        return "not permitted to read it"
    return (error.strerror or str(error)).lower()


def _neighbour(file: Path) -> tuple[str, str]:
    """The nearest file of the same kind in the same folder, or what to say of the folder."""
    if not file.parent.is_dir():
        return "", f"no such folder: {file.parent}"
    near = nearest_name(file.name, [entry.name for entry in file.parent.iterdir() if entry.suffix == file.suffix])
    return (str(file.parent / near), "") if near else ("", "")


def parse_yaml(text: str, file: str) -> Document:
    """Document of a text.

    Raises
    ------
    InputError
        If the text is no YAML of the kinds that the bench reads, or has nothing in it.
    """
    read = _read_once(text, file)
    return Document(file, copy.deepcopy(read.data), dict(read.keys), dict(read.values))


@lru_cache(maxsize=64)
def _read_once(text: str, file: str) -> Document:
    """A text is read once: a batch of runs would otherwise spend a quarter of its time on the same vehicle file."""
    yaml = YAML(typ="safe", pure=True)
    try:
        node = yaml.compose(text)
    except MarkedYAMLError as error:
        raise FileFaults([_syntax_fault(error, file)], file) from None
    except (YAMLError, RecursionError) as error:
        problem = "too deeply nested" if isinstance(error, RecursionError) else " ".join(str(error).split())
        raise FileFaults([Fault(file, 0, 0, "", f"not YAML: {problem}")], file) from None
    if node is None:
        raise FileFaults([Fault(file, 1, 1, "", "the file is empty")], file)
    document = Document(file, None)
    reader = _Reader(document)
    document.data = reader.read(node, ())
    if reader.faults:
        raise FileFaults(reader.faults, file)
    return document


def _syntax_fault(error: MarkedYAMLError, file: str) -> Fault:
    mark = error.problem_mark or error.context_mark
    line, column = (mark.line + 1, mark.column + 1) if mark is not None else (0, 0)
    problem = " ".join(str(error.problem or error.context).split())
    allowed = ""
    if "'\\t'" in problem:
        problem, allowed = "a tab in the indentation", "spaces"
    elif "mapping values are not allowed" in problem:
        problem, allowed = "a ':' that starts no field", "one field per line, its value indented or quoted"
    elif "found another document" in problem:
        problem, allowed = "a second document ('---')", "one document per file"
    elif "flow" in str(error.context) and error.context_mark is not None:
        opened = f"line {error.context_mark.line + 1}, column {error.context_mark.column + 1}"
        problem, allowed = f"a bracket is not closed: {problem}", f"',' or the bracket that closes the one in {opened}"
    elif "cannot start any token" in problem:
        allowed = "a text that begins with this character stands in quotes"
    return Fault(file, line, column, "", f"not YAML: {problem}", allowed=allowed)


class _Reader:
    """Turns the nodes of one file into plain data and notes their places."""

    def __init__(self, document: Document) -> None:
        self.document = document
        self.faults: list[Fault] = []
        self._open: set[int] = set()
        self._count = 0

    def _fault(self, node: Node, path: DataPath, problem: str, allowed: str = "") -> None:
        place = self._place(node)
        self.faults.append(Fault(place.file, place.line, place.column, field_name(path), problem, allowed=allowed))

    def _place(self, node: Node) -> Place:
        return Place(self.document.file, node.start_mark.line + 1, node.start_mark.column + 1)

    def read(self, node: Node, path: DataPath) -> Any:
        self._count += 1
        if self._count > MOST_VALUES or id(node) in self._open or len(path) > 50:
            if self._count <= MOST_VALUES + 1:
                self._fault(node, path, "too many values, or an alias (*) that contains itself")
            self._count = MOST_VALUES + 1
            return None
        self.document.values.setdefault(path, self._place(node))
        if isinstance(node, ScalarNode):
            return self._scalar(node, path)
        self._open.add(id(node))
        try:
            if isinstance(node, SequenceNode):
                return [self.read(item, (*path, number)) for number, item in enumerate(node.value)]
            return self._mapping(node.value, path)
        finally:
            self._open.discard(id(node))

    def _mapping(self, entries: list[tuple[Node, Node]], path: DataPath) -> dict[Any, Any]:
        result: dict[Any, Any] = {}
        merged = [value for key, value in entries if key.tag == f"{_TAG}merge"]
        for key_node, value_node in (entry for entry in entries if entry[0].tag != f"{_TAG}merge"):
            key = self._key(key_node, path)
            if key is None:
                continue
            inner = (*path, key)
            if key in result:
                line = self.document.keys[inner].line
                self._fault(key_node, inner, f"stands here twice (first in line {line})", "each field once")
                continue
            self.document.keys[inner] = self._place(key_node)
            result[key] = self.read(value_node, inner)
            if result[key] is None:
                self.document.values[inner] = self._place(key_node)
        for node in merged:
            self._merge(node, result, path)
        return result

    def _merge(self, node: Node, result: dict[Any, Any], path: DataPath) -> None:
        """Entries that a merge key (``<<``) brings in; those of the mapping itself win."""
        for source in node.value if isinstance(node, SequenceNode) else [node]:
            if not isinstance(source, MappingNode):
                self._fault(source, path, "a merge key (<<) without a mapping", "<<: *NAME of a mapping")
                continue
            absent = [entry for entry in source.value if entry[0].value not in result]
            result.update(self._mapping(absent, path))

    def _key(self, node: Node, path: DataPath) -> str | int | None:
        key = self._scalar(node, path) if isinstance(node, ScalarNode) else None
        if isinstance(key, bool) or not isinstance(key, (str, int)):
            self._fault(node, path, "a field needs a name", "a text before the ':'")
            return None
        return key

    def _scalar(self, node: ScalarNode, path: DataPath) -> str | int | float | bool | None:
        text = str(node.value)
        kind = str(node.tag).removeprefix(_TAG)
        if kind in ("str", "timestamp"):
            return text
        if kind == "null":
            return None
        if kind == "bool" and text.lower() in ("true", "false"):
            return text in _TRUE
        try:
            if kind == "int":
                return _integer(text)
            if kind == "float":
                return float(text.replace("_", "").replace(".inf", "inf").replace(".nan", "nan"))
        except ValueError:
            pass
        self._fault(node, path, f"found the tag {node.tag!r}", "plain texts, numbers, true, false")
        return None


def _integer(text: str) -> int:
    digits = text.replace("_", "")
    for prefix, base in (("0x", 16), ("0o", 8), ("0b", 2)):
        if digits.lstrip("+-").lower().startswith(prefix):
            return int(digits, base)
    return int(digits)


def overlay(base: Document, over: Document) -> Document:
    """``over`` laid on ``base``, mapping by mapping; lists are replaced whole and every value keeps its place."""
    result = Document(over.file, _overlaid(base.data, over.data), dict(base.keys), dict(base.values))
    for path in [path for path in base.values if path and _hidden(base.data, over.data, path)]:
        result.values.pop(path)
        result.keys.pop(path, None)
    result.keys.update(over.keys)
    result.values.update(over.values)
    return result


def _overlaid(base: Any, over: Any) -> Any:
    if not (isinstance(base, dict) and isinstance(over, dict)):
        return over
    return base | {key: _overlaid(base[key], value) if key in base else value for key, value in over.items()}


def _hidden(base: Any, over: Any, path: DataPath) -> bool:
    """A value of the base at ``path`` that the overlay replaces."""
    for name in path:
        if not isinstance(base, dict) or not isinstance(over, dict):
            return True
        if name not in over:
            return False
        base, over = base[name], over[name]
    return True


def walk(data: Any, path: DataPath = ()) -> Iterator[tuple[DataPath, Any]]:
    """Every leaf of plain data with its path."""
    if isinstance(data, dict):
        for key, value in data.items():
            yield from walk(value, (*path, key))
    elif isinstance(data, list):
        for number, value in enumerate(data):
            yield from walk(value, (*path, number))
    else:
        yield path, data
