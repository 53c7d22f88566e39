"""Compiled code on disk: a second process finds it, and a change anywhere below it is noticed."""

import os
import shutil
import subprocess
import sys
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[2]

DRIVE = """
from vehicle_model.plant import Plant
from vehicle_model.vehicle_file import load_vehicle

car = Plant(load_vehicle("ekf_car"))
car.reset(speed_m_s=20.0)
car.step(500, brake_torque=900.0, steer=0.1)
print([value.hex() for value in car.outputs.tolist()])
"""

CALLEE = """
import numpy as np
from vehicle_model.tyres.coefficients import TYRE_SIZE
from vehicle_model.tyres.kernel import PREPARED_SIZE, along

row = np.zeros(PREPARED_SIZE)
row[4:6] = 2.0, 3.0
row[2:4] = 1.0, 1.0
row[12:16] = 10.0, 1.3, 1.0, 0.0
row[11] = 1000.0
print(along(np.zeros(TYRE_SIZE), row, 0.1, 0.0)[0])
"""


def _run(code: str, folder: Path, environment: dict[str, str]) -> str:
    result = subprocess.run(
        [sys.executable, "-c", code], cwd=folder, env=environment, capture_output=True, text=True, check=False
    )
    assert result.returncode == 0, result.stderr
    return result.stdout


def test_a_second_process_works_from_a_warm_cache(tmp_path: Path) -> None:
    """Code that calls MuJoCo comes from disk; without the registered symbols loading it would kill the process."""
    environment = os.environ | {"NUMBA_CACHE_DIR": os.environ.get("NUMBA_CACHE_DIR", str(tmp_path))}
    first = _run(DRIVE, ROOT, environment)
    folder = Path(environment["NUMBA_CACHE_DIR"])
    compiled = {file: file.stat().st_mtime_ns for file in folder.rglob("*.nbc")}
    assert any("plant_step.advance" in file.name for file in compiled)
    assert _run(DRIVE, ROOT, environment) == first
    again = {file: file.stat().st_mtime_ns for file in folder.rglob("*.nbc") if file in compiled}
    assert again == compiled


@pytest.fixture
def copy_of_the_sources(tmp_path: Path) -> Path:
    for package in ("signals", "vehicle_model"):
        shutil.copytree(ROOT / package, tmp_path / package, ignore=shutil.ignore_patterns("__pycache__"))
    return tmp_path


@pytest.mark.parametrize("variable", [pytest.param("XDG_CACHE_HOME", marks=pytest.mark.nightly), "NUMBA_CACHE_DIR"])
def test_a_changed_callee_in_another_file_is_noticed(copy_of_the_sources: Path, variable: str) -> None:
    """Also where the user, or another program in the same process, has said where compiled code is kept."""
    folder = copy_of_the_sources
    environment = {name: value for name, value in os.environ.items() if name not in ("NUMBA_CACHE_DIR", "PYTHONPATH")}
    environment[variable] = str(folder / "cache")
    before = float(_run(CALLEE, folder, environment))
    assert float(_run(CALLEE, folder, environment)) == before
    callee = folder / "vehicle_model" / "tyres" / "curves.py"
    text = callee.read_text()
    assert "return peak * math.sin(angle)" in text
    callee.write_text(text.replace("return peak * math.sin(angle)", "return 2.0 * peak * math.sin(angle)"))
    assert float(_run(CALLEE, folder, environment)) == pytest.approx(2.0 * before)
