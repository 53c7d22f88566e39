"""The wheel holds everything that `bench` needs, scenarios and databases too: installed apart, used from elsewhere."""

import os
import subprocess
import sys
import sysconfig
import venv
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[3]


def call(*command: str | Path, cwd: Path) -> "subprocess.CompletedProcess[str]":
    environment = {name: value for name, value in os.environ.items() if name != "PYTHONPATH"}
    return subprocess.run(
        [str(part) for part in command], cwd=cwd, env=environment, capture_output=True, text=True, timeout=300
    )


@pytest.fixture(scope="module")
def installed(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Folder of the programs of a fresh environment with the wheel; dependencies are those of this one."""
    folder = tmp_path_factory.mktemp("wheel")
    pip = (sys.executable, "-m", "pip", "--disable-pip-version-check", "--quiet")
    built = call(*pip, "wheel", "--no-deps", "--wheel-dir", folder, ROOT, cwd=folder)
    if "No matching distribution found for hatchling" in built.stderr:
        pytest.skip("building a wheel needs hatchling: neither a package index nor a cache has it")
    assert built.returncode == 0, built.stderr
    (wheel,) = folder.glob("brake_control_bench-*.whl")
    venv.create(folder / "environment", with_pip=False)
    programs = folder / "environment" / "bin"
    done = call(*pip, "--python", programs / "python", "install", "--no-deps", wheel, cwd=folder)
    assert done.returncode == 0, done.stderr
    site = next((folder / "environment" / "lib").glob("python*/site-packages"))
    (site / "dependencies.pth").write_text(sysconfig.get_path("purelib") + "\n")
    return programs


def test_it_is_the_installed_one(installed: Path, tmp_path: Path) -> None:
    found = call(installed / "python", "-c", "import bench; print(bench.__file__)", cwd=tmp_path)
    assert Path(found.stdout.strip()).is_relative_to(installed.parent)


def test_list_names_every_shipped_scenario(installed: Path, tmp_path: Path) -> None:
    listed = call(installed / "bench", "list", cwd=tmp_path)
    assert (listed.returncode, listed.stderr) == (0, "")
    shipped = ROOT / "scenarios"
    for group in ("stops", "friction"):
        for path in (shipped / group).glob("*.yaml"):
            assert str(path.relative_to(shipped).with_suffix("")) in listed.stdout.split()


@pytest.mark.parametrize("scenario", ["stops/dry", "friction/e4_abs_dry_95", "friction/asphalt_sim_wet_mu090"])
def test_check_finds_car_tyres_and_database(scenario: str, installed: Path, tmp_path: Path) -> None:
    checked = call(installed / "bench", "check", scenario, cwd=tmp_path)
    assert (checked.returncode, checked.stderr) == (0, "")


@pytest.mark.parametrize("folder", ["dbc", "scenarios"])
def test_data_files_are_all_there(folder: str, installed: Path) -> None:
    site = next((installed.parent / "lib").glob("python*/site-packages"))
    here = {path.relative_to(ROOT / folder) for path in (ROOT / folder).rglob("*") if path.suffix in (".dbc", ".yaml")}
    there = {path.relative_to(site / "bench" / "data" / folder) for path in (site / "bench/data" / folder).rglob("*.*")}
    assert here
    assert here <= there


def test_every_package_is_there_with_its_data(installed: Path) -> None:
    """What is not a Python file is the easiest to forget: cars, roads, tyres, calibrations, schemas, page parts."""
    site = next((installed.parent / "lib").glob("python*/site-packages"))
    for package in (
        "signals",
        "vehicle_model",
        "hydraulics",
        "can_fault_injector",
        "estimators",
        "model_diagnosis",
        "bench",
    ):
        here = [path.relative_to(ROOT) for path in (ROOT / package).rglob("*.*") if "__pycache__" not in path.parts]
        assert here
        assert [path for path in here if (ROOT / path).is_file() and not (site / path).is_file()] == []
