"""JSON Schemas: within draft-07, fresh, and satisfied by every shipped file."""

import importlib.util
import json
import re
from pathlib import Path
from types import ModuleType
from typing import Any

import pytest

from bench.scenario.file_kinds import SCHEMA_KINDS, schema_of
from signals.yaml_files import load_yaml

ROOT = Path(__file__).resolve().parents[3]
MODELINE = re.compile(r"^# yaml-language-server: \$schema=(\S+)$")
SHIPPED = sorted(
    path for folder in ("scenarios", "vehicle_model", "bench/ecu") for path in (ROOT / folder).rglob("*.yaml")
)


def _module(path: Path) -> ModuleType:
    specification = importlib.util.spec_from_file_location(path.stem, path)
    assert specification is not None
    assert specification.loader is not None
    module = importlib.util.module_from_spec(specification)
    specification.loader.exec_module(module)
    return module


lite = _module(Path(__file__).with_name("lite_json_schema.py"))
generate = _module(ROOT / "docs" / "generate.py")


@pytest.mark.parametrize("kind", SCHEMA_KINDS)
def test_a_schema_keeps_to_draft_07(kind: str) -> None:
    schema = schema_of(kind)
    assert schema["$schema"] == "http://json-schema.org/draft-07/schema#"
    for path, inner in lite.schemas_in(schema):
        assert set(inner) <= lite.KEYWORDS, path
        assert "$ref" not in inner or set(inner) == {"$ref"}, f"{path}: draft-07 ignores what stands beside $ref"
        assert not isinstance(inner.get("items"), list), f"{path}: no tuples"
        if "$ref" in inner:
            assert inner["$ref"].removeprefix("#/definitions/") in schema["definitions"]


def test_a_quantity_is_a_number_or_a_text_with_a_unit() -> None:
    schema = schema_of("scenario")
    field = schema["properties"]["initial_speed"]
    assert "[m/s]" in field["description"]
    fits = {
        value: not lite.errors_of(value, field, schema)
        for value in (80, 22.2, -1, 500, "80 km/h", "-3 m/s", "fast", True)
    }
    assert fits == {
        80: True,
        22.2: True,
        -1: False,
        500: False,
        "80 km/h": True,
        "-3 m/s": True,
        "fast": False,
        True: False,
    }


@pytest.mark.parametrize("path", SHIPPED, ids=lambda path: str(path.relative_to(ROOT)))
def test_a_shipped_file_names_its_schema_and_satisfies_it(path: Path) -> None:
    match = MODELINE.match(path.read_text("utf-8").splitlines()[0])
    assert match is not None, "the first line is no modeline of the YAML language server"
    schema: dict[str, Any] = json.loads((path.parent / match[1]).read_text("utf-8"))
    assert lite.errors_of(load_yaml(path).data, schema, schema) == []


def test_a_wrong_file_does_not_satisfy_its_schema() -> None:
    schema = schema_of("scenario")
    wrong = {"manoeuvre": {"steps": [{"name": "brake", "brake": {"pedal_forse": 400}}]}, "ecu": {"kind": "emulatd"}}
    found = lite.errors_of(wrong, schema, schema)
    assert any("pedal_forse" in text for text in found)
    assert any("emulatd" in text for text in found)


@pytest.mark.parametrize("path", sorted(generate.pages()), ids=lambda path: str(path.relative_to(ROOT)))
def test_generated_files_are_fresh(path: Path) -> None:
    assert path.read_text("utf-8") == generate.pages()[path], "stale: run python docs/generate.py"
