"""``bench diagnose map``: the file it writes is a channel map, tells why, and never replaces one made by hand."""

import json
from pathlib import Path

import numpy as np
import pytest

from bench.cli import main
from signals.measured.channel_map import load_channel_map


@pytest.fixture
def logs(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> list[str]:
    """Two loggers of one drive."""
    monkeypatch.chdir(tmp_path)
    time = np.arange(400) * 0.01
    for name, columns in (("car", "t,WheelSpeedFL,[Wheel]FR (km/h),oil"), ("gnss", "t,speed (km/h)")):
        values = [time, *(80.0 - 5.0 * time + number for number in range(columns.count(",")))]
        np.savetxt(tmp_path / f"{name}.csv", np.column_stack(values), delimiter=",", header=columns, comments="")
    return ["car.csv", "gnss.csv"]


def test_one_map_for_all_loggers_with_reasons_and_what_is_lacking(
    logs: list[str], capsys: pytest.CaptureFixture[str]
) -> None:
    assert main(["diagnose", "map", *logs, "--vehicle", "ekf_car", "--out", "map.yaml"]) == 0
    shown = capsys.readouterr().out
    assert "[Wheel]FR (km/h)" in shown
    assert "no column found: yaw_rate" in shown
    text = Path("map.yaml").read_text()
    assert "by its name" in text
    assert "# no column found: yaw_rate. Without it" in text
    assert "# not used: oil" in text
    read = load_channel_map("map.yaml")
    assert {name: channel.source for name, channel in read.channels.items()} == {
        "speed": "speed (km/h)",
        "wheel_speed_fl": "WheelSpeedFL",
        "wheel_speed_fr": "[Wheel]FR (km/h)",
    }
    assert read.clock.column == "t"


def test_as_json_it_says_the_same(logs: list[str], capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["diagnose", "map", *logs, "--vehicle", "ekf_car", "--json"]) == 0
    answer = json.loads(capsys.readouterr().out)
    assert answer["file"] == "car_channels.yaml"
    assert [one["name"] for one in answer["channels"]] == ["speed", "wheel_speed_fl", "wheel_speed_fr"]
    assert answer["unused"] == ["oil"]
    assert "yaw_rate" in answer["missing"]


def test_units_that_nobody_tells_are_to_be_checked(logs: list[str], capsys: pytest.CaptureFixture[str]) -> None:
    """Of a pressure in the unit that is likely by its size, of a force in ours; a switch has none."""
    rows = (f"{0.01 * k:g},{20 + 0.1 * k:g},{k},{4 * k},{k // 50}" for k in range(100))
    Path("brakes.csv").write_text("\n".join(["t,speed,THZ_Druck,PedalForce,BrakeSwitch", *rows]))
    assert main(["diagnose", "map", "brakes.csv", "--vehicle", "ekf_car"]) == 0
    lines = {line.split(":")[0].strip(): line for line in Path("brakes_channels.yaml").read_text().splitlines()}
    assert "unit: bar} # by its name; CHECK THE UNIT, bar is taken" in lines["master_pressure"]
    assert "CHECK THE UNIT, N is taken" in lines["pedal_force"]
    assert "CHECK" not in lines["brake_switch"]


def test_a_map_that_is_there_stays(logs: list[str], capsys: pytest.CaptureFixture[str]) -> None:
    Path("car_channels.yaml").write_text("mine")
    assert main(["diagnose", "map", *logs, "--vehicle", "ekf_car"]) == 2
    assert "is there already" in capsys.readouterr().err
    assert Path("car_channels.yaml").read_text() == "mine"


def test_a_log_of_unknown_columns_is_told(logs: list[str], capsys: pytest.CaptureFixture[str]) -> None:
    Path("odd.csv").write_text("t,oil,water\n0,1,2\n0.01,2,3\n")
    assert main(["diagnose", "map", "odd.csv", "--vehicle", "ekf_car"]) == 2
    message = capsys.readouterr().err
    assert "no column is a signal that we know" in message
    assert "oil, water" in message
    assert not Path("odd_channels.yaml").exists()
