from pathlib import Path

import made_up_stop
import pytest

from bench.report import details
from bench.report.run_data import RunData
from bench.report.run_reading import load_run


@pytest.fixture
def run(tmp_path: Path) -> RunData:
    """A run of a shipped scenario in which the front pads are worn."""
    from bench.scenario import dump, resolve

    data = made_up_stop.simulate(1.5)
    verdict = made_up_stop.verdict_of(data)
    counts = {"accepted": 300, "crc_errors": 2}
    verdict["timing"]["frames_from_ecu"] = {"VALVE_PUMP": counts, "ABS_STATUS": {"accepted": 75, "crc_errors": 0}}
    verdict["estimators"]["friction_ekf"]["rmse"]["wheel_speed_front"] = 0.75
    scenario = dump(resolve("stops/dry", {"overrides": {"brakes.front.pad_friction": 0.25}}))
    folder = made_up_stop.write_run_folder(tmp_path / "run", data, verdict, scenario=scenario)
    return load_run(folder)


def test_parameters_show_what_the_scenario_changed_first(run: RunData) -> None:
    table = details.parameter_table(run)
    assert table is not None
    assert table.rows[0][:2] == ["brakes.front.pad_friction", "0.25"]
    assert table.rows[0][3].endswith("in the vehicle file")
    assert all(row[3] == "" for row in table.rows[1:])
    values = {row[0]: (row[1], row[2]) for row in table.rows}
    assert values["body.mass"] == ("1296", "kg")  # friction document 6.1.1


def test_parameters_are_left_out_where_the_scenario_is_of_another_kind(tmp_path: Path) -> None:
    assert details.parameter_table(RunData(tmp_path, {}, {"vehicle": "nowhere", "manoeuvre": 3})) is None


def test_steps_have_their_times_and_speeds(run: RunData) -> None:
    table = details.step_table(run)
    assert table is not None
    assert [row[0] for row in table.rows] == ["coast", "brake"]
    assert table.rows[1][1:4] == ["1.000 s", "1.500 s", "0.500 s"]
    assert table.rows[0][4] == "95.0 km/h"


def test_received_frames_are_a_table_of_their_own(run: RunData) -> None:
    table = details.receiver_table(run)
    assert table is not None
    assert table.heads[1:] == ["accepted", "crc errors"]
    assert table.rows == [["VALVE_PUMP", "300", "2"], ["ABS_STATUS", "75", "0"]]
    assert not any("VALVE" in label for label, _ in details.timing_pairs(run))


def test_percentiles_of_a_real_time_run(run: RunData) -> None:
    table = details.percentile_table(run)
    assert table is not None
    assert table.rows[0] == ["start after the deadline", "0.15 µs", "1.9 µs", "6 µs", "3100 µs"]


def test_estimates_keep_the_unit_of_wheel_speeds(run: RunData) -> None:
    table = details.estimator_table(run)
    assert table is not None
    assert ["friction_ekf", "wheel speed front", "0.75 rad/s", ""] in table.rows
    assert ["friction_ekf", "friction limit front", "0.031", ""] in table.rows


def test_link_statistics_are_flattened(run: RunData) -> None:
    assert ("links received", "1500") in details.timing_pairs(run)
