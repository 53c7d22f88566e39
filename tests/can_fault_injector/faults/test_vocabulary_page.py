"""docs/can_faults.md has the vocabulary as the models have it."""

import importlib.util
from pathlib import Path

PAGE_MAKER = Path(__file__).resolve().parents[3] / "docs" / "generate_can_faults.py"


def test_the_table_is_fresh() -> None:
    specification = importlib.util.spec_from_file_location(PAGE_MAKER.stem, PAGE_MAKER)
    assert specification is not None
    module = importlib.util.module_from_spec(specification)
    specification.loader.exec_module(module)
    assert module.PAGE.read_text("utf-8") == module.page(), "run: python docs/generate_can_faults.py"
