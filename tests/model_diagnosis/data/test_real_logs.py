"""Real logs through the shipped maps: the traps that their descriptions list are found by the checks themselves."""

import os
import subprocess
import sys
from pathlib import Path

import pytest

from model_diagnosis.data import check_data, read_manoeuvres
from signals.measured.channel_map import load_channel_map
from vehicle_model.vehicle_file import load_vehicle

ROOT = Path(__file__).parents[3]
SHARED = Path(os.environ.get("BENCH_SHARED_DATA", ROOT.parent / "shared" / "data"))
SHIPPED = ROOT / "scenarios" / "diagnosis"


def _checked(name, pattern="*.csv.gz", channel_map="channels.yaml", logs=None):
    if not (SHARED / name).is_dir():
        pytest.skip(f"no reference data in {SHARED / name}")
    vehicle = load_vehicle(SHIPPED / name / "vehicle.yaml")
    channels = load_channel_map(SHIPPED / name / channel_map)
    manoeuvres = read_manoeuvres(logs or sorted((SHARED / name).glob(pattern)), channels, vehicle)
    return manoeuvres, check_data(manoeuvres, vehicle)[0]


def _kinds(faults):
    return {(fault.kind, fault.channel) for fault in faults}


def test_av21_acceleration_is_low_passed_and_its_brake_pressure_a_command():
    manoeuvres, faults = _checked("iac-av21")
    assert sum(m.duration_s for m in manoeuvres) > 300.0
    assert ("low_pass_channel", "longitudinal_acceleration") in _kinds(faults)
    slow = next(f for f in faults if f.kind == "low_pass_channel")
    assert slow.value > 1.0  # described as late by about 2 s
    assert ("command_not_measurement", "master_pressure") in _kinds(faults)
    assert not any(kind in ("channel_unit", "channel_sign", "channel_swap") for kind, _ in _kinds(faults))


def test_250lm_filtered_yaw_rate_is_in_degrees_and_the_plain_one_is_not():
    _, plain = _checked("revs-250lm-2014")
    _, filtered = _checked("revs-250lm-2014", channel_map="channels_filtered.yaml")
    assert not any(kind == "channel_unit" for kind, _ in _kinds(plain))
    assert ("channel_unit", "yaw_rate") in _kinds(filtered)
    assert next(f.value for f in filtered if f.kind == "channel_unit") == pytest.approx(57.29578, rel=1e-6)


def test_rig_loads_are_counted_upwards():
    manoeuvres, faults = _checked("tyre-rig-ttc-deid")
    assert ("channel_sign", "vertical_load_fl") in _kinds(faults)
    assert not any(kind == "missing_channel" for kind, _ in _kinds(faults))  # the slips that drive it were measured
    assert len(manoeuvres) > 20


def test_simulated_slaloms_have_no_data_fault():
    manoeuvres, faults = _checked("carmaker-bosch", "*.CSV.gz")
    assert len(manoeuvres) >= 3
    assert _kinds(faults) == set()


def test_accelerometer_axes_of_the_rav4_under_each_others_name_are_found(tmp_path):
    """ACCEL_X, so named in the DBC, is the one along the car: it follows the change of speed of the wheels."""
    archive = SHARED / "comma2k19-rav4" / "segment40.npz"
    if not archive.is_file():
        pytest.skip(f"no reference data in {archive}")
    shipped = SHIPPED / "comma2k19-rav4"
    subprocess.run([sys.executable, str(shipped / "convert.py"), str(archive), str(tmp_path)], check=True)
    (tmp_path / "car.dbc").write_text((shipped / "car.dbc").read_text("utf-8"))
    text = (shipped / "channels.yaml").read_text("utf-8")
    swapped = text.replace("ACCEL_X", "ACCEL_Z").replace("ACCEL_Y", "ACCEL_X").replace("ACCEL_Z", "ACCEL_Y")
    logs = [tmp_path / "can.log", tmp_path / "steering.csv", tmp_path / "pose.csv"]
    for name, content, found in (("swapped", swapped, True), ("right", text, False)):
        (tmp_path / f"{name}.yaml").write_text(content)
        _, faults = _checked("comma2k19-rav4", channel_map=tmp_path / f"{name}.yaml", logs=logs)
        axes = [f for f in faults if f.kind == "channel_swap"]
        assert [f.channel for f in axes] == ["longitudinal_acceleration, lateral_acceleration"] * found


def test_three_loggers_of_the_rav4_become_one_drive(tmp_path):
    archive = SHARED / "comma2k19-rav4" / "segment40.npz"
    if not archive.is_file():
        pytest.skip(f"no reference data in {archive}")
    converter = SHIPPED / "comma2k19-rav4" / "convert.py"
    subprocess.run([sys.executable, str(converter), str(archive), str(tmp_path)], check=True)
    logs = [tmp_path / "can.log", tmp_path / "steering.csv", tmp_path / "pose.csv"]
    manoeuvres, faults = _checked("comma2k19-rav4", logs=logs)
    origins = manoeuvres[0].origins
    assert origins["wheel_speed_fl"] == "can.log:WHEEL_SPEEDS"
    assert origins["yaw_rate"] == "can.log:KINEMATICS"
    assert origins["speed"] == "pose.csv"
    assert sum(m.duration_s for m in manoeuvres) > 50.0
    # 20 Hz poses, 83 Hz frames: only the pose's own samples count
    assert manoeuvres[0].weight("speed").mean() == pytest.approx(0.2, abs=0.05)
    assert not any(kind in ("channel_unit", "channel_sign", "channel_swap") for kind, _ in _kinds(faults))


def test_rig_slip_of_a_free_wheel_is_no_slip(tmp_path):
    """The rig's own slip, SR, is written as −1 while the wheel rolls freely in the cornering sweeps."""
    text = (SHIPPED / "tyre-rig-ttc-deid" / "channels.yaml").read_text("utf-8").replace("source: SL", "source: SR")
    (tmp_path / "channels.yaml").write_text(text)
    _, faults = _checked("tyre-rig-ttc-deid", "cornering*", tmp_path / "channels.yaml")
    free = next(f for f in faults if f.kind == "undefined_value")
    assert (free.channel, free.value) == ("slip_ratio_fl", -1.0)


def test_wheels_declared_in_metres_per_second_are_found_to_be_in_kilometres_per_hour(tmp_path):
    text = (SHIPPED / "iac-av21" / "channels.yaml").read_text("utf-8").replace("unit: km/h", "unit: m/s")
    (tmp_path / "channels.yaml").write_text(text)
    _, faults = _checked("iac-av21", channel_map=tmp_path / "channels.yaml")
    unit = next(f for f in faults if f.kind == "channel_unit")
    assert unit.channel.startswith("wheel_speed_fl")
    assert unit.value == pytest.approx(3.6, rel=1e-6)
    assert unit.repaired


def test_frames_of_the_rav4_without_their_last_zero_bytes_are_completed(tmp_path):
    """As exports by text tools leave them: none of the frames' samples is lost."""
    archive = SHARED / "comma2k19-rav4" / "segment40.npz"
    if not archive.is_file():
        pytest.skip(f"no reference data in {archive}")
    converter = SHIPPED / "comma2k19-rav4" / "convert.py"
    subprocess.run([sys.executable, str(converter), str(archive), str(tmp_path)], check=True)
    lines = (tmp_path / "can.log").read_text().splitlines()
    cut = [
        f"{head}#{bytes.fromhex(data).rstrip(bytes(1)).hex()}" for head, _, data in (x.rpartition("#") for x in lines)
    ]
    (tmp_path / "can.log").write_text("\n".join(cut) + "\n")
    _, faults = _checked("comma2k19-rav4", logs=[tmp_path / "can.log"])
    short = {f.channel: f.value for f in faults if f.kind == "cut_frames"}
    assert set(short) == {"KINEMATICS", "WHEEL_SPEEDS"}
    assert not any(f.kind == "frame_drop_hold" for f in faults)
