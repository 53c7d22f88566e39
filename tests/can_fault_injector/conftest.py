"""Testers that several files share stand in modules of this folder; tests carry the published names they stand for."""

import sys
from pathlib import Path

import pytest

HERE = Path(__file__).parent
sys.path.insert(0, str(HERE))


@pytest.hookimpl(tryfirst=True)
def pytest_collection_modifyitems(items: list[pytest.Item]) -> None:
    """``pytest -k iso_7_6_11`` runs the tests of that name; the end of a run counts the names that passed."""
    from conformance_names import names_of

    for item in items:
        if item.path.parent == HERE and isinstance(item, pytest.Function):
            names = names_of(f"{item.path.stem}:{item.originalname}")
            item.extra_keyword_matches.update(names)
            item.user_properties += [("conformance", name) for name in names]
