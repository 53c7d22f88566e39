"""docs/corrections.csv: every correction of a source document has a switch that exists or a test that exists."""

import ast
import csv
from functools import cache
from pathlib import Path

import pytest

import estimators

ROOT = Path(__file__).resolve().parent.parent


def rows() -> list[dict[str, str]]:
    with (ROOT / "docs" / "corrections.csv").open(newline="", encoding="utf-8") as file:
        return list(csv.DictReader(file))


@cache
def functions(path: Path) -> frozenset[str]:
    tree = ast.parse(path.read_text(encoding="utf-8"))
    return frozenset(node.name for node in ast.walk(tree) if isinstance(node, ast.FunctionDef))


@pytest.mark.acceptance("F-41")
def test_every_erratum_of_the_friction_document_is_listed():
    items = {row["item"] for row in rows() if row["spec"] == "friction"}
    assert {f"A{number}" for number in range(1, 32)} <= items


def test_every_line_of_annex_b_of_the_vehicle_state_document_is_listed():
    places = " ".join(row["place"] for row in rows() if row["spec"] == "vehicle-state")
    lines = (5375, 5384, 5440, 5505, 5698, 5684, 5839, 5849, 5904, 5961, 6064, 6101, 6119, 6007, 6161, 6188)
    assert not [line for line in lines if str(line) not in places]
    assert "whole listing B" in places


@pytest.mark.parametrize("row", rows(), ids=lambda row: f"{row['spec']} {row['item']}")
def test_switch_or_test_exists(row):
    assert row["printed"]
    assert row["here"]
    if row["kept_by"] == "test":
        file, *_, name = row["name"].split("::")
        assert name in functions(ROOT / file), row["name"]
    elif row["kept_by"] == "switch":
        owner, _, key = row["name"].partition(": ")
        if owner == "vehicle file":
            schema = (ROOT / "vehicle_model" / "schemas" / "vehicle.schema.json").read_text("utf-8")
            assert key.partition(".")[2] in schema
        else:
            assert key.partition(".")[0] in estimators.describe(owner).settings.model_fields
    else:
        assert row["kept_by"] == "text"  # a name, a caption, a reference: nothing that could compute
