"""A recording of the bench as a log: what the frames carried, at the times at which they came."""

from pathlib import Path

import numpy as np
import pytest

from bench.diagnosis.diagnosing import car_name, default_folder, read
from bench.diagnosis.recordings import LOGGED, WAKING_S, as_log, recording_of
from bench.recording.reading import Recording
from signals.measured.measured_log import read_log
from vehicle_model.vehicle_file import load_vehicle

# periods of the frames that carry them (dbc/brake_bus.dbc) [s]
PERIODS = {
    "wheel_speed_fl": 0.005,
    "yaw_rate": 0.005,
    "master_pressure": 0.010,
    "brake_pressure_rr": 0.010,
    "steering_wheel_angle": 0.020,
    "speed": 0.010,
}


TEETH = 48


@pytest.fixture(scope="module")
def log(healthy_drive: Path, tmp_path_factory: pytest.TempPathFactory) -> tuple[Path, object]:
    return as_log(healthy_drive, tmp_path_factory.mktemp("log"), TEETH)


@pytest.mark.parametrize(("signal", "period"), PERIODS.items())
def test_a_sample_for_each_frame(log: tuple[Path, object], healthy_drive: Path, signal: str, period: float) -> None:
    path, channel_map = log
    channel = read_log(path, channel_map).channels[signal]  # type: ignore[arg-type]
    assert np.median(np.diff(channel.time)) == pytest.approx(period, abs=1e-6)
    assert len(channel.time) == pytest.approx(Recording.open(healthy_drive).time[-1] / period, rel=0.02)


def test_values_are_those_of_the_recording(log: tuple[Path, object], healthy_drive: Path) -> None:
    path, channel_map = log
    recording = Recording.open(healthy_drive)
    logged = read_log(path, channel_map)  # type: ignore[arg-type]
    channel = logged.channels["wheel_speed_fl"]
    rows = np.searchsorted(recording.time, channel.time + logged.start_time_s + 2.5e-3)
    inside = rows < len(recording.time)
    assert channel.values[inside] == pytest.approx(recording.array("wheel_speed_fl")[rows[inside]])
    assert channel.values.min() > 0.0  # the first frame, sent before any edge of the tone ring, is left out
    assert logged.start_time_s >= WAKING_S - 0.005


def test_nothing_of_the_plant_but_the_speed_is_handed_on(log: tuple[Path, object]) -> None:
    path, channel_map = log
    assert set(read_log(path, channel_map).channels) <= {*LOGGED, "speed"}  # type: ignore[arg-type]


def test_manoeuvres_of_a_run_need_neither_map_nor_car(healthy_drive: Path) -> None:
    assert car_name([str(healthy_drive)], None, None) == "ekf_car"
    manoeuvres = read([str(healthy_drive)], load_vehicle("ekf_car"), None)
    assert manoeuvres[0].name == "healthy"
    assert sum(one.duration_s for one in manoeuvres) > 6.0
    assert default_folder([str(healthy_drive)]) == healthy_drive / "diagnosis"


def test_other_logs_are_no_recordings(tmp_path: Path) -> None:
    other = tmp_path / "drive.mf4"
    other.write_bytes(b"MDF     ")
    assert recording_of(str(other)) is None
    assert recording_of("no_such_run") is None
    assert default_folder([str(other)]) == Path("diagnosis/drive")
