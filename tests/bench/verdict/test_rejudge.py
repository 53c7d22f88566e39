"""``bench judge``: a recording and a foreign log get the same verdict as the arrays in memory."""

from pathlib import Path

import numpy as np
import pytest
from asammdf import MDF, Signal
from synthetic_run import BRAKE_AT, DECELERATION, SPEED, stop

from bench.recording.mf4_file import write_mf4
from bench.recording.schema import RunSchema
from bench.verdict import judge_recording
from bench.verdict.judge import judge
from bench.verdict.rejudge import load_criteria
from signals.catalogue import catalogue
from signals.errors import FileFaults, InputError

CRITERIA = """\
criteria:
  - {id: distance, value: stopping_distance, at_most: 40 m, requirement: R-7}
  - {id: mfdd, value: mfdd, at_least: 6.43 m/s^2}
  - {id: lock, value: wheel_lock, at_most: 0.1 s}
valid_if: brake_start_speed >= 0.98 * 25
"""

CHANNELS = """\
channels:
  speed: {source: Car.v, unit: km/h}
  pedal_force: {source: Pedal}
  wheel_speed_fl: {source: w1, unit: km/h}
  wheel_speed_fr: {source: w2, unit: km/h}
  wheel_speed_rl: {source: w3, unit: km/h}
  wheel_speed_rr: {source: w4, unit: km/h}
"""


@pytest.fixture
def criteria(tmp_path: Path) -> Path:
    path = tmp_path / "criteria.yaml"
    path.write_text(CRITERIA)
    return path


def foreign_log(path: Path) -> None:
    """The synthetic stop as a car's logger at 100 Hz would have it: one wheel locks for 0.2 s."""
    time = np.arange(0.0, BRAKE_AT + SPEED / DECELERATION + 0.5, 0.01)
    speed = np.maximum(SPEED - DECELERATION * np.maximum(time - BRAKE_AT, 0), 0)
    locked = np.where((time > 2.0) & (time <= 2.2), 0.0, 0.92)
    with MDF() as mdf:
        mdf.append([Signal(3.6 * speed, time + 100.0, name="Car.v")])
        mdf.append([Signal(np.where(time >= BRAKE_AT, 300.0, 0.0), time + 100.0, name="Pedal")])
        mdf.append(
            [Signal(3.6 * speed * (locked if n == 2 else 0.92), time + 100.0, name=f"w{n}") for n in range(1, 5)]
        )
        mdf.save(path)


def test_a_recording_of_the_bench_is_judged_as_in_memory(tmp_path: Path, criteria: Path) -> None:
    data = stop()
    signals = [signal for signal in catalogue() if signal.name in data]
    matrix = np.column_stack([data.array(signal.name) for signal in signals])
    schema = RunSchema.of(signals, phase_names=data.phase_names, information={"scenario": "stops/dry", "seed": 9})
    write_mf4(tmp_path / "signals.mf4", schema, [(0, np.arange(len(matrix)), matrix)])
    again = judge_recording(tmp_path / "signals.mf4", criteria)
    loaded = load_criteria(criteria).file
    direct = judge(data, loaded.criteria, valid_if=loaded.valid_if, scenario="stops/dry", seed=9)
    assert again.as_json() == direct.as_json()
    assert again.verdict == "pass"


def test_a_foreign_mf4_is_judged_through_its_channel_map(tmp_path: Path, criteria: Path) -> None:
    foreign_log(tmp_path / "car.mf4")
    (tmp_path / "map.yaml").write_text(CHANNELS)
    verdict = judge_recording(tmp_path / "car.mf4", criteria, channels=tmp_path / "map.yaml", vehicle="ekf_car")
    distance, mfdd, lock = verdict.criteria
    assert distance.value == pytest.approx(SPEED**2 / (2 * DECELERATION), rel=2e-3)
    assert distance.requirement == "R-7"
    assert mfdd.value == pytest.approx(DECELERATION, rel=1e-3)
    assert lock.value == pytest.approx(0.2, abs=0.011)
    assert [c.verdict for c in verdict.criteria] == ["pass", "pass", "fail"]
    assert verdict.exit_code == 1


def test_what_the_log_lacks_is_inconclusive_where_a_metric_needs_it(tmp_path: Path, criteria: Path) -> None:
    foreign_log(tmp_path / "car.mf4")
    (tmp_path / "map.yaml").write_text("\n".join(CHANNELS.splitlines()[:3]) + "\n")
    verdict = judge_recording(tmp_path / "car.mf4", criteria, channels=tmp_path / "map.yaml")
    assert [c.verdict for c in verdict.criteria] == ["pass", "pass", "inconclusive"]
    assert "slip needs" in verdict.criteria[2].reason
    assert verdict.exit_code == 3


def test_a_criterion_on_a_signal_that_the_log_lacks_has_its_place(tmp_path: Path, criteria: Path) -> None:
    foreign_log(tmp_path / "car.mf4")
    (tmp_path / "map.yaml").write_text(CHANNELS)
    criteria.write_text("criteria:\n  - id: a\n    value: max(abs(yaw_rate))\n  - {id: b, value: speeed, at_most: 3}\n")
    with pytest.raises(FileFaults) as caught:
        judge_recording(tmp_path / "car.mf4", criteria, channels=tmp_path / "map.yaml", vehicle="ekf_car")
    places = [(fault.line, fault.field) for fault in caught.value.faults]
    assert places == [(3, "criteria[0].value"), (4, "criteria[1].value")]
    assert "did you mean speed?" in str(caught.value)
    assert caught.value.exit_code == 2


def test_the_criteria_of_a_scenario_can_be_used(tmp_path: Path) -> None:
    path = tmp_path / "scenario.yaml"
    path.write_text("format: 1\nmanoeuvre: {steps: []}\nvehicle: ekf_car\n" + CRITERIA)
    assert [criterion.id for criterion in load_criteria(path).file.criteria] == ["distance", "mfdd", "lock"]


def test_a_foreign_log_without_a_map_says_what_to_do(tmp_path: Path, criteria: Path) -> None:
    foreign_log(tmp_path / "car.mf4")
    with pytest.raises(InputError, match="--channels MAP"):
        judge_recording(tmp_path / "car.mf4", criteria)


def test_the_tables_of_the_page_are_those_of_the_vocabulary() -> None:
    from bench.verdict.documentation import PAGE, updated

    page = PAGE.read_text("utf-8")
    assert page == updated(page), "run: python -m bench.verdict.documentation"


def test_the_examples_of_the_page_are_valid(tmp_path: Path) -> None:
    from bench.verdict.criteria_file import check_criteria
    from bench.verdict.documentation import PAGE
    from signals.measured.channel_map import load_channel_map

    example = PAGE.read_text("utf-8").split("```yaml\n", 1)[1].split("```", 1)[0]
    (tmp_path / "criteria.yaml").write_text(example)
    file = load_criteria(tmp_path / "criteria.yaml").file
    units = {signal.name: signal.unit for signal in catalogue()}
    assert check_criteria(file.criteria, units, (), file.valid_if) == []
    channels = PAGE.with_name("recording.md").read_text("utf-8").split("```yaml\n", 1)[1].split("```", 1)[0]
    (tmp_path / "map.yaml").write_text(channels)
    assert len(load_channel_map(tmp_path / "map.yaml").channels) == 4
