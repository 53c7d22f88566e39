"""``bench estimate``: recordings give the live estimate bit for bit, measured logs are held as a bus would."""

import json
from pathlib import Path

import numpy as np
import pyarrow.parquet as parquet
import pytest

from bench.cli import main
from bench.estimation.command import estimate_log
from bench.estimation.offline import Request, compare, requests_of, run_offline, with_estimates
from bench.estimation.source import Source, open_source
from bench.recording.arrays import RunArrays
from signals.errors import InputError
from vehicle_model.vehicle_file import load_vehicle

CAR = load_vehicle("ekf_car").numbers()


def test_an_offline_estimate_of_a_recording_is_the_live_one(recorded, capsys):
    """Both signs of the slip rate at once, from MF4 back to every bit."""
    assert main(["estimate", str(recorded), "--json"]) == 0
    printed = json.loads(capsys.readouterr().out)
    live = open_source(recorded).data
    assert [entry["estimator"] for entry in printed["estimators"]] == ["friction_ekf", "friction_ekf_printed_sign"]
    for entry in printed["estimators"]:
        folder = Path(printed["folder"]) / entry["estimator"]
        table = parquet.read_table(folder / "estimates.parquet")
        assert np.array_equal(table["time"].to_numpy(), live.time)
        for name in entry["outputs"]:
            assert np.array_equal(table[name].to_numpy(), live.array(f"{entry['estimator']}.{name}")), name
        assert json.loads((folder / "estimates.json").read_text("utf-8")) == entry
        assert (folder / "estimates.png").stat().st_size > 10_000
    outputs = printed["estimators"][0]["outputs"]
    assert outputs["speed"]["rmse"] < 0.3  # A5 of the friction document
    assert outputs["speed"]["reference"] == "speed"
    assert "rmse" not in outputs["innovation"]
    limit = outputs["friction_limit_front"]  # trusted only where enough friction is used, and good there
    assert limit["rmse_confident"] < limit["rmse"]
    assert limit["rmse_confident"] < 0.06 * 1.12


def test_one_estimator_writes_into_the_folder_itself(recorded, tmp_path):
    result = estimate_log(recorded, ["friction_ekf"], sets=["torque_mode=z2", "process_noise.slip=0.04"], out=tmp_path)
    summary = json.loads((tmp_path / "estimates.json").read_text("utf-8"))
    assert summary == result.summaries[0]
    assert summary["settings"]["torque_mode"] == "z2"
    assert summary["settings"]["process_noise"]["slip"] == 0.04
    assert summary["settings"]["slip_rate_sign"] == 1  # the scenario's own


def test_settings_go_to_those_that_have_them(source):
    names = ["friction_ekf", "simple_braking", "friction_ekf_b"]
    ekf, simple, second = requests_of(names, {"slip_rate_sign": -1, "friction_ekf_b.torque_mode": "z2"}, source)
    assert ekf.settings["slip_rate_sign"] == second.settings["slip_rate_sign"] == -1
    assert simple.settings == {}
    assert (ekf.settings["torque_mode"], second.settings["torque_mode"]) == ("known", "z2")
    with pytest.raises(InputError, match="did you mean torque_mode"):
        requests_of(["friction_ekf"], {"torque_mod": "z2"}, source)
    with pytest.raises(InputError, match="friction_ekf"):
        requests_of(["friction_efk"], {}, source)
    with pytest.raises(InputError, match="which estimator"):
        requests_of([], {}, Source(Path("log"), source.data))


def test_the_error_is_that_of_the_rows_in_which_it_ran(source):
    """RMSE by hand over the rows with ``active``, against the mean of the front wheels' true speeds."""
    (estimate,) = run_offline(source, CAR, [Request("friction_ekf", "friction_ekf", {})])
    found = compare(with_estimates(source.data, [estimate]), estimate)["wheel_speed_front"]
    expected = 0.5 * (source.data.array("true_wheel_speed_fl") + source.data.array("true_wheel_speed_fr"))
    rows = estimate.output("active") > 0.5
    error = (estimate.output("wheel_speed_front") - expected)[rows]
    assert 0 < rows.sum() < len(rows)
    assert found.rmse == pytest.approx(np.sqrt(np.mean(error**2)), rel=1e-12)
    assert found.mean_error == pytest.approx(np.mean(error), rel=1e-9)


def log_of(source: Source, path: Path, *, period: int = 5, repeat: bool = False, backwards: bool = False) -> Path:
    """A CSV log of every ``period``-th millisecond, with our signals under foreign names and units."""
    rows = list(range(0, len(source.data), period))
    if repeat:
        rows = sorted([*rows, *rows[10:20]])
    if backwards:
        rows[30], rows[31] = rows[31], rows[30]
    data = source.data
    columns = {"t": data.time * 1e3, "ax": data.array("longitudinal_acceleration") / 9.81}
    columns |= {f"v_{w}": 3.6 * 0.278 * data.array(f"wheel_speed_{w}") for w in ("fl", "fr", "rl", "rr")}
    columns["v_ref"] = data.array("speed") * 3.6
    text = ["t,ax,v_fl,v_fr,v_rl,v_rr,v_ref"]
    text += [",".join(f"{column[row]:.9g}" for column in columns.values()) for row in rows]
    path.write_text("\n".join(text) + "\n", encoding="utf-8")
    return path


@pytest.fixture
def channels(tmp_path: Path) -> Path:
    path = tmp_path / "map.yaml"
    wheels = "\n".join(f"  wheel_speed_{w}: {{source: v_{w}, unit: km/h}}" for w in ("fl", "fr", "rl", "rr"))
    path.write_text(
        "clock: {column: t, unit: ms}\nchannels:\n  longitudinal_acceleration: {source: ax, unit: g}\n"
        f"{wheels}\n  speed: {{source: v_ref, unit: km/h}}\n",
        encoding="utf-8",
    )
    return path


def test_a_measured_log_is_held_between_its_samples(source, channels, tmp_path):
    """Samples of 5 ms: between them the last value and a growing age, infinite before the first."""
    log = open_source(log_of(source, tmp_path / "log.csv"), channels, "ekf_car")
    assert log.data.time[1] == pytest.approx(1e-3)
    inputs = ("longitudinal_acceleration", "wheel_speed_fl")
    ages = log.ages(inputs)
    assert ages["age_inertial"][100:106] == pytest.approx([0.0, 1e-3, 2e-3, 3e-3, 4e-3, 0.0], abs=1e-9)
    values = log.columns(inputs)["wheel_speed_fl"]
    assert (values[100:105] == values[100]).all()
    assert values[100] == pytest.approx(source.data.array("wheel_speed_fl")[100], rel=1e-6)


def test_an_estimate_of_a_measured_log_has_the_error_against_its_reference(source, channels, tmp_path):
    result = estimate_log(
        log_of(source, tmp_path / "log.csv"), ["friction_ekf"], channels=channels, vehicle="ekf_car",
        sets=["torque_mode=z2"], out=tmp_path / "out",
    )  # fmt: skip
    outputs = result.summaries[0]["outputs"]
    assert outputs["speed"]["rmse"] < 0.3
    assert "rmse" not in outputs["friction_limit_front"]  # the log has no truth of it


def test_repeated_samples_change_nothing_and_late_ones_are_refused(source, channels, tmp_path):
    once = open_source(log_of(source, tmp_path / "once.csv"), channels, "ekf_car")
    twice = open_source(log_of(source, tmp_path / "twice.csv", repeat=True), channels, "ekf_car")
    assert np.array_equal(once.data.array("wheel_speed_fl"), twice.data.array("wheel_speed_fl"))
    with pytest.raises(InputError, match="runs backwards"):
        open_source(log_of(source, tmp_path / "late.csv", backwards=True), channels, "ekf_car")


def test_a_sensor_that_dies_makes_its_group_old(source):
    """Wheel speeds share an age: the oldest of the four counts."""
    time = source.data.time
    ages = {f"wheel_speed_{w}": np.zeros(len(time)) for w in ("fl", "fr", "rl", "rr")}
    ages["wheel_speed_rr"] = time - 1.0
    log = Source(Path("log"), source.data, ages)
    assert log.ages(tuple(ages))["age_wheel_speed"][-1] == pytest.approx(time[-1] - 1.0)


def test_missing_channels_are_named_with_what_can_be_done(source, channels, tmp_path, capsys):
    log = log_of(source, tmp_path / "log.csv")
    command = ["estimate", str(log), "--estimator", "friction_ekf", "--vehicle", "ekf_car", "--channels", str(channels)]
    assert main(command) == 2
    text = capsys.readouterr().err
    assert "friction_ekf needs brake_pressure_fl, brake_pressure_fr" in text
    assert "or do without: --set torque_mode=z2" in text


def test_what_a_recording_left_out_is_named(source):
    data = RunArrays(source.data.time, {"time": source.data.time, "speed": source.data.array("speed")}, {})
    with pytest.raises(InputError, match="simple_braking needs longitudinal_acceleration"):
        run_offline(Source(Path("run"), data), CAR, [Request("simple_braking", "simple_braking", {})])
