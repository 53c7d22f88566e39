"""Short drives of the bench, recorded: as the vehicle file says, and on worn pads."""

from pathlib import Path

import pytest

import bench

DRIVE = Path(__file__).parent / "short_drive.yaml"
WORN = 0.75


@pytest.fixture(scope="session")
def healthy_drive(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Folder of a recorded drive of the vehicle file's car."""
    folder = tmp_path_factory.mktemp("runs") / "healthy"
    bench.run(DRIVE, out=folder)
    return folder


@pytest.fixture(scope="session")
def worn_drive(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The same on pads that have lost a quarter of their friction."""
    folder = tmp_path_factory.mktemp("runs") / "worn"
    pads = {f"brakes.{axle}.pad_friction": WORN * 0.4 for axle in ("front", "rear")}
    bench.run(DRIVE, out=folder, sets=pads)
    return folder
