"""Every published name of ISO 16845-1 stands for a test, which carries it."""

import ast
from pathlib import Path

import pytest
from conformance_names import BIT_TIMING, NAMES, TESTS


def test_all_published_names_are_in_the_table() -> None:
    counts = {"7.1": 12, "7.2": 11, "7.3": 4, "7.4": 7, "7.5": 7, "7.6": 23}
    counts |= {"8.1": 8, "8.2": 8, "8.3": 4, "8.4": 5, "8.5": 15, "8.6": 21, "9.6": 2}
    assert {clause: len(tests) for clause, tests in TESTS.items()} == counts
    assert len(NAMES) == 127


@pytest.mark.parametrize("name", [*NAMES, *BIT_TIMING])
def test_name_stands_for_a_test(name: str) -> None:
    module, _, function = {**NAMES, **BIT_TIMING}[name].partition(":")
    tree = ast.parse((Path(__file__).parent / f"{module}.py").read_text(encoding="utf-8"))
    assert function in {node.name for node in tree.body if isinstance(node, ast.FunctionDef)}
