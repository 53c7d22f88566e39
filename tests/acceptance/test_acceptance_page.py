"""docs/acceptance.md has every target of the shipped scenarios, and a reason for every miss of the MuJoCo car."""

import importlib.util
from pathlib import Path
from types import ModuleType

import pytest

ROOT = Path(__file__).resolve().parents[2]


def _module(path: Path) -> ModuleType:
    specification = importlib.util.spec_from_file_location(path.stem, path)
    assert specification is not None
    assert specification.loader is not None
    module = importlib.util.module_from_spec(specification)
    specification.loader.exec_module(module)
    return module


generate = _module(ROOT / "docs" / "generate_acceptance.py")


@pytest.fixture(scope="module")
def rows() -> dict[tuple[str, str], list[str]]:
    """Cells of the table by run and criterion: single-track, MuJoCo, limits, reason."""
    lines = (ROOT / "docs" / "acceptance.md").read_text("utf-8").splitlines()
    cells = [[cell.strip() for cell in line.strip("|").split("|")] for line in lines if line.startswith("|")]
    return {(row[0], row[1]): row[2:] for row in cells if row[0] in generate.EXPERIMENTS}


@pytest.mark.parametrize("experiment", generate.EXPERIMENTS)
def test_every_target_has_a_row(rows: dict[tuple[str, str], list[str]], experiment: str) -> None:
    listed = [criterion for run, criterion in rows if run == experiment]
    assert listed == generate.criteria_of(generate.EXPERIMENTS[experiment]), "run python docs/generate_acceptance.py"


def test_the_document_s_car_meets_them_and_every_miss_of_the_other_has_a_reason(
    rows: dict[tuple[str, str], list[str]],
) -> None:
    for place, (single_track, mujoco, _limits, reason) in rows.items():
        assert not single_track.startswith("**"), place
        assert bool(reason) == mujoco.startswith("**"), place


def test_every_reason_is_explained() -> None:
    text = (ROOT / "docs" / "acceptance.md").read_text("utf-8")
    for _, names in generate._REASONS:
        for name in names.split(", "):
            assert f"**{name}.**" in text
