"""Clocks that drift within a log and between loggers: found in ppm, repaired, and never seen where there are none."""

from pathlib import Path

import kinematic_car
import long_drive
import numpy as np
import pytest

from model_diagnosis.data import read_manoeuvres
from model_diagnosis.data.drift_checks import check_drift
from model_diagnosis.data.geometry import geometry_of
from model_diagnosis.manoeuvre import Manoeuvre
from signals.measured.channel_map import ChannelMap
from vehicle_model.vehicle_file import VehicleFile

INERTIAL = ("longitudinal_acceleration", "lateral_acceleration", "yaw_rate")
TURNING = INERTIAL[1:]
WHEELS = tuple(f"wheel_speed_{wheel}" for wheel in ("fl", "fr", "rl", "rr"))
MAP = ChannelMap(channels={name: {"source": name, "unit": unit} for name, unit in long_drive.UNITS.items()})


def _drive(
    folder: Path,
    vehicle: VehicleFile,
    seed: int,
    drift: dict[str, float],
    *,
    second_logger: tuple[str, ...] = (),
    duration_s: float = 240.0,
    late_s: float = 0.0,
) -> list[Manoeuvre]:
    random = np.random.default_rng(seed)
    stamps, values = long_drive.log(random, *long_drive.drive(random, duration_s), drift, late_s)
    first = {name: series for name, series in values.items() if name not in second_logger}
    paths = [kinematic_car.write_csv(folder / "drive_a.csv", long_drive.columns(stamps, first))]
    if second_logger:
        second = {name: values[name] for name in second_logger}
        paths.append(kinematic_car.write_csv(folder / "drive_b.csv", long_drive.columns(stamps, second)))
    return read_manoeuvres(paths, MAP, vehicle)


@pytest.mark.parametrize("seed", range(12))
def test_clean_logs_have_no_drift(seed: int, tmp_path: Path, vehicle: VehicleFile) -> None:
    second = ((), ("speed",), INERTIAL)[seed % 3]
    faults, repaired = check_drift(_drive(tmp_path, vehicle, seed, {}, second_logger=second), geometry_of(vehicle))
    assert faults == []
    assert len(repaired) > 5


@pytest.mark.parametrize(
    ("channels", "second_logger", "drift"),
    [
        (("speed",), ("speed",), 200e-6),
        (("speed",), ("speed",), -300e-6),
        (TURNING, TURNING, 400e-6),
        (WHEELS, (), 250e-6),
        (("yaw_rate",), (), 500e-6),
    ],
    ids=[
        "reference fast",
        "reference slow",
        "logger of the turning",
        "wheels within a log",
        "one channel within a log",
    ],
)
@pytest.mark.parametrize("seed", [21, 22])
def test_drift_is_named_in_ppm_and_taken_out(
    seed: int,
    channels: tuple[str, ...],
    second_logger: tuple[str, ...],
    drift: float,
    tmp_path: Path,
    vehicle: VehicleFile,
) -> None:
    """A drift of 200 ppm over 240 s is 48 ms; 10 ms of it, one sample, is 42 ppm."""
    geometry = geometry_of(vehicle)
    late = dict.fromkeys(channels, drift)
    faults, repaired = check_drift(_drive(tmp_path, vehicle, seed, late, second_logger=second_logger), geometry)
    assert [(fault.kind, set(fault.channel.split(", "))) for fault in faults] == [("clock_drift", set(channels))]
    assert faults[0].value == pytest.approx(1e6 * drift, abs=42.0)
    assert faults[0].unit == "ppm"
    assert check_drift(repaired, geometry)[0] == []


def test_a_constant_offset_is_no_drift(tmp_path: Path, vehicle: VehicleFile) -> None:
    late = {"speed": 0.0}
    manoeuvres = _drive(tmp_path, vehicle, 31, late, second_logger=("speed",), late_s=0.2)
    assert check_drift(manoeuvres, geometry_of(vehicle))[0] == []


def test_separate_stops_of_ten_seconds_tell_nothing_of_drift(tmp_path: Path, vehicle: VehicleFile) -> None:
    manoeuvres = _drive(tmp_path, vehicle, 41, {"speed": 5e-4}, second_logger=("speed",), duration_s=12.0)
    assert check_drift(manoeuvres, geometry_of(vehicle))[0] == []
