"""docs/estimators_consistency.md tells of the attitude filters and the force filter what these tests measure."""

import math
from collections.abc import Callable
from functools import cache
from pathlib import Path

import pytest
from attitude_consistency import FILTERS, attitude_filters
from force_consistency import on_the_documents_drive, where_its_noise_is_true

from estimators.kalman.consistency import Consistency

PAGE = Path(__file__).resolve().parents[2] / "docs" / "estimators_consistency.md"


@cache
def told() -> dict[tuple[str, str], tuple[float, bool]]:
    """Mean, and whether it is inside its band, by filter and statistic of the page."""
    lines = [line for line in PAGE.read_text("utf-8").splitlines() if line.startswith("|")]
    cells = [[cell.strip() for cell in line.strip("|").split("|")] for line in lines]
    return {(row[0], row[1]): (float(row[2]), row[4] == "yes") for row in cells if row[-1] in ("yes", "no")}


def compare(record: Callable[..., None], name: str, statistic: str, found: Consistency) -> None:
    """Record a statistic; the page has to say the same."""
    band = f"{found.low:.3g} ... {found.high:.3g}"
    record(f"{name.replace('`', '')}: {statistic}, 60 runs", found.mean, f"reported: {band} if the noise were true")
    assert math.isfinite(found.mean)
    mean, inside = told()[name, statistic]
    assert found.mean == pytest.approx(mean, rel=0.02, abs=0.01), "run python docs/generate_consistency.py"
    assert found.inside == inside


@pytest.mark.acceptance("B-24")
def test_attitude_filters(record: Callable[..., None]) -> None:
    for name, found in attitude_filters(tuple(FILTERS)).items():
        compare(record, name, "NEES of roll", found.roll)
        compare(record, name, "NEES", found.nees)
        compare(record, name, "NIS", found.nis)


@pytest.mark.acceptance("N-18")
def test_random_walk_force_filter(record: Callable[..., None]) -> None:
    for name, found in (
        ("`random_walk_force_ekf`, S1", on_the_documents_drive()),
        ("`random_walk_force_ekf`, forces drawn from its model", where_its_noise_is_true()),
    ):
        compare(record, name, "NEES", found.nees)
        compare(record, name, "NIS", found.nis)
