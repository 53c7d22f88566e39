"""Bad input to the real command: clear words, an exit code, no traceback, no invented cause.

The logs are those of a healthy car of the generator that shares no code with the diagnosis.
"""

import csv
import json
import subprocess
import sys
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import pytest
from numpy.typing import NDArray

Table = dict[str, NDArray[np.float64]]
BLIND = Path(__file__).parents[2] / "blind"
SEED = 104
TIME = "Time [s]"


@dataclass(frozen=True)
class HealthyCar:
    """Folder with channel map and vehicle file, and the columns of each log."""

    folder: Path
    logs: dict[str, Table]


@pytest.fixture(scope="module")
def healthy(tmp_path_factory: pytest.TempPathFactory) -> HealthyCar:
    folder = tmp_path_factory.mktemp("healthy")
    arguments = ["cases", "--seed", str(SEED), "--n", "6", "--family", "clean"]
    arguments += ["--out", str(folder), "--sealed", str(folder / "sealed")]
    subprocess.run([sys.executable, str(BLIND / "generate.py"), *arguments], check=True, timeout=300)
    case = next(path for path in sorted(folder.glob("case_*")) if any((path / "logs").glob("*.csv")))
    return HealthyCar(case, {path.stem: _read(path) for path in (case / "logs").glob("*.csv")})


def _read(path: Path) -> Table:
    with path.open(encoding="utf-8", newline="") as file:
        rows = list(csv.reader(file, delimiter=";"))
    values = np.array([[float(cell) if cell else np.nan for cell in row] for row in rows[1:]])
    return {name: values[:, column] for column, name in enumerate(rows[0])}


def _write(path: Path, table: Table) -> Path:
    with path.open("w", encoding="utf-8", newline="") as file:
        writer = csv.writer(file, delimiter=";")
        writer.writerow(table)
        rows = zip(*table.values(), strict=True)
        writer.writerows([f"{cell:.9g}" if np.isfinite(cell) else "" for cell in row] for row in rows)
    return path


def _rows(table: Table, keep: NDArray[np.bool_]) -> Table:
    return {name: values[keep] for name, values in table.items()}


def _short(table: Table) -> Table:
    return _rows(table, table[TIME] < 1.5)


def _blank(table: Table) -> Table:
    return {name: values if name == TIME else np.full_like(values, np.nan) for name, values in table.items()}


def _constant(table: Table) -> Table:
    return {name: values if name == TIME else np.full_like(values, 50.0) for name, values in table.items()}


def _without_speeds(table: Table) -> Table:
    return {name: values for name, values in table.items() if not name.startswith(("WheelSpeed", "Speed"))}


def _with_gaps(table: Table) -> Table:
    """A fifth of the time is missing, in gaps of 0.3 s."""
    random, time = np.random.default_rng(3), table[TIME]
    keep = np.ones(len(time), dtype=np.bool_)
    while keep.mean() > 0.8:
        begin = random.uniform(time[0], time[-1] - 0.3)
        keep &= ~((time > begin) & (time < begin + 0.3))
    return _rows(table, keep)


def _with_holes(table: Table) -> Table:
    """A fifth of all numbers is blank."""
    random = np.random.default_rng(4)
    return {
        name: values if name == TIME else np.where(random.random(len(values)) < 0.2, np.nan, values)
        for name, values in table.items()
    }


def _without_turning(table: Table) -> Table:
    return {name: values for name, values in table.items() if not name.startswith(("YawRate", "LateralAcceleration"))}


def _diagnose(
    healthy: HealthyCar, change: Callable[[Table], Table], folder: Path, names: tuple[str, ...], vehicle: str = ""
) -> subprocess.CompletedProcess[str]:
    logs = [str(_write(folder / f"{name}.csv", change(healthy.logs[name]))) for name in names]
    command = [str(Path(sys.executable).with_name("bench")), "diagnose", *logs]
    command += ["--vehicle", vehicle or str(healthy.folder / "vehicle.yaml")]
    command += ["--channels", str(healthy.folder / "channels.yaml"), "--out", str(folder / "out")]
    return subprocess.run(command, capture_output=True, text=True, timeout=1200, check=False)


@pytest.mark.parametrize(
    ("change", "words"),
    [
        (_short, ("too short for a diagnosis", "2 s in one piece")),
        (_blank, ("gentle_stops.csv", "no header that names the columns of a row of numbers")),
        (_constant, ("no speed", "wheel_speed_fl is constant (50) in every manoeuvre")),
        (_without_speeds, ("no speed", "no log has a channel", "wheel's slip is unknown")),
    ],
    ids=["shorter than a manoeuvre", "nothing but blanks", "constant signals", "no speed at all"],
)
def test_what_cannot_be_diagnosed_is_refused_in_words(
    change: Callable[[Table], Table], words: tuple[str, ...], healthy: HealthyCar, tmp_path: Path
) -> None:
    done = _diagnose(healthy, change, tmp_path, ("gentle_stops",))
    told = " ".join((done.stdout + done.stderr).split())
    assert done.returncode == 2, told
    assert "Traceback" not in told
    for word in words:
        assert word in told
    assert not (tmp_path / "out" / "diagnosis.json").exists()


@pytest.mark.nightly
@pytest.mark.parametrize(
    ("change", "faults", "words"),
    [
        (dict, set(), ("one manoeuvre only", "not excited by this data")),
        (_without_turning, {"missing_channel"}, ("Without it steering, cornering stiffness and yaw inertia",)),
        (_with_gaps, {"gap"}, ("of the time is without samples",)),
        (_with_holes, {"not_a_number"}, ("hold no number",)),
    ],
    ids=["one log only", "missing channel", "gaps of a fifth", "blanks of a fifth"],
)
def test_what_is_left_is_diagnosed_and_no_cause_is_invented(
    change: Callable[[Table], Table], faults: set[str], words: tuple[str, ...], healthy: HealthyCar, tmp_path: Path
) -> None:
    done = _diagnose(healthy, change, tmp_path, ("gentle_stops",))
    told = " ".join((done.stdout + done.stderr).split())
    assert done.returncode in (0, 3), told
    assert "Traceback" not in told
    for word in words:
        assert word in told
    answer = json.loads((tmp_path / "out" / "diagnosis.json").read_text("utf-8"))
    assert answer["causes"] == []
    assert answer["discovered_terms"] == []
    assert faults <= {fault["kind"] for fault in answer["data_faults"]}


@pytest.mark.nightly
def test_another_car_is_a_wrong_vehicle_and_no_list_of_causes(healthy: HealthyCar, tmp_path: Path) -> None:
    """Stops and cornering of the 1.3 t car against the file of a large SUV."""
    done = _diagnose(healthy, dict, tmp_path, ("gentle_stops", "brake_in_turn"), "e_class_suv")
    told = " ".join((done.stdout + done.stderr).split())
    assert done.returncode == 0, told
    assert "Traceback" not in told
    answer = json.loads((tmp_path / "out" / "diagnosis.json").read_text("utf-8"))
    assert answer["verdict"] == "wrong_vehicle"
    assert answer["causes"] == []
    assert any("times its scatter off the vehicle file" in remark for remark in answer["remarks"])
