"""The traceability table is well formed and names tests that exist."""

import ast
import csv
import importlib.util
import sys
from functools import cache
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parent.parent


def rows() -> list[dict[str, str]]:
    with (ROOT / "docs" / "traceability.csv").open(newline="", encoding="utf-8") as file:
        return list(csv.DictReader(file))


@cache
def functions(path: Path) -> frozenset[str]:
    tree = ast.parse(path.read_text(encoding="utf-8"))
    return frozenset(node.name for node in ast.walk(tree) if isinstance(node, ast.FunctionDef))


@pytest.mark.acceptance("F-42")
def test_every_requirement_of_the_documents_has_a_row():
    """Section 7 and 4.8 of the friction document, then the lists of state, load, force and attitude document."""
    ids = {row["id"] for row in rows()}
    lists = {"F-": 42, "F-A": 21, "V-": 61, "L-": 20, "N-": 22, "B-": 57}
    expected = {f"{prefix}{number}" for prefix, count in lists.items() for number in range(1, count + 1)}
    assert len(expected) == 223
    assert ids == expected


def test_every_named_test_exists():
    for row in rows():
        assert row["source_line"]
        assert row["verdict"] in ("pass", "fail", "skipped", "open")
        assert (row["verdict"] == "open") == (row["test_node_id"] == "")
        if row["test_node_id"]:
            file, *_, name = row["test_node_id"].split("::")
            assert name in functions(ROOT / file), row["test_node_id"]


def test_the_page_of_the_state_observers_results_is_that_of_the_table():
    """``python docs/generate_state_results.py`` writes it."""
    path = ROOT / "docs" / "generate_state_results.py"
    specification = importlib.util.spec_from_file_location(path.stem, path)
    module = importlib.util.module_from_spec(specification)
    specification.loader.exec_module(module)
    assert module.PAGE.read_text("utf-8") == module.page(), "stale: run python docs/generate_state_results.py"


def test_a_row_is_written_per_requirement_and_test(pytestconfig: pytest.Config):
    """Values of several cases become a range; rows of tests that did not run stay."""
    plugin = pytestconfig.pluginmanager.get_plugin("traceability-writer")
    merge = sys.modules[type(plugin).__module__].merge
    before = [
        {"id": "F-1", "source_line": "a:1", "test_node_id": "", "measured": "", "limit": "", "verdict": "open"},
        {"id": "F-2", "source_line": "a:2", "test_node_id": "t::x", "measured": "", "limit": "", "verdict": "pass"},
    ]
    results = {
        ("F-1", "t::y"): {"outcomes": {"passed", "failed"}, "measured": {"k": [2.0, 1.0]}, "limit": ["k: 3"]},
        ("F-2", "t::z"): {"outcomes": {"passed"}, "measured": {"k": [1.0]}, "limit": ["k: 3"]},
    }
    after = merge(before, results)
    assert [(row["id"], row["test_node_id"], row["verdict"]) for row in after] == [
        ("F-1", "t::y", "fail"),
        ("F-2", "t::x", "pass"),
        ("F-2", "t::z", "pass"),
    ]
    assert after[0]["measured"] == "k = 1 ... 2 (2 cases)"
