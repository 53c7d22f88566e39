"""Contents of the page, read without a browser."""

import base64
import json
import re
from pathlib import Path
from typing import Any

import made_up_stop
import numpy as np
import pytest

from bench.links.frame import BENCH, ECU, ERROR
from bench.recording.run_folder import RunState, write_state
from bench.report import build
from bench.report.bus_charts import message_statistics
from bench.report.instants import find_instant
from bench.report.run_data import RunData
from bench.report.run_reading import load_run
from bench.report.run_report import page_of
from signals.errors import InputError

SIZE_LIMIT = 3_000_000


def data_of(page: str) -> dict[str, Any]:
    found = re.search(r'<script id="data" type="application/json">(.*?)</script>', page, re.DOTALL)
    assert found is not None
    content: dict[str, Any] = json.loads(found[1])
    return content


def test_page_of_ten_seconds_is_small_and_needs_nothing_else(report_page: Path) -> None:
    assert report_page.stat().st_size <= SIZE_LIMIT
    page = report_page.read_text("utf-8")
    addresses = re.findall(r"""(?:src|href|url\()\s*=?\s*["']?([^"')\s>]+)""", page)
    outside = [
        a for a in addresses if not a.startswith(("#", "data:", "`#", "`url")) and ("//" in a or a.startswith("/"))
    ]
    assert outside == []
    assert "plotly" not in page


def test_every_picture_is_there(report_page: Path) -> None:
    charts = {chart["id"]: chart for chart in data_of(report_page.read_text("utf-8"))["charts"]}
    expected = {"speed", "slip", "phases", "friction-front", "friction-rear", "yaw", "steering", "lateral", "frames"}
    expected |= {"load", "lateness", "cpu", "lateness-time", "deceleration"}
    expected |= {f"pressure-{wheel}" for wheel in ("fl", "fr", "rl", "rr")}
    assert expected <= set(charts)
    assert {segment[2] for segment in charts["pressure-fl"]["strips"][0]["segments"]} == {"build", "hold", "release"}
    friction = charts["friction-front"]
    assert [series["label"] for series in friction["series"]] == ["used", "estimate friction_ekf", "road"]
    assert len(friction["areas"]) == 1
    assert sum(charts["lateness"]["counts"]) == 10_001


def test_signals_are_thinned(report_page: Path) -> None:
    signals = data_of(report_page.read_text("utf-8"))["signals"]
    assert len(signals) > 25
    points = {
        name: sum(len(base64.b64decode(piece["data"])) // 4 for piece in pieces) for name, pieces in signals.items()
    }
    assert max(points.values()) <= 2000


def test_text_tells_verdict_requirements_parameters_seed_and_versions(report_page: Path) -> None:
    page = report_page.read_text("utf-8")
    for text in ("R13-H A5 2.1.1", "SPEC 4.8 A7", "vehicle: ekf_car", "mujoco", "3.11.7", "frames.blf", "−31 %", "udp"):
        assert text in page
    assert page.index("wheel lock") < page.index("friction settling") < page.index("distance from the brake start")


def test_texts_of_the_run_cannot_become_markup(tmp_path: Path) -> None:
    data = made_up_stop.simulate(1.0)
    verdict = made_up_stop.verdict_of(data)
    verdict["scenario"] = "</script><script>alert(1)</script>"
    verdict["criteria"][0]["description"] = "<img src=x onerror=alert(1)>"
    run = RunData(tmp_path, verdict, {"title": "<b>bold</b>"}, "a: '</pre><script>'", data)
    page = page_of(run)
    assert page.count("<script") == 2
    assert "<img" not in page
    assert "<b>bold" not in page


def test_ecu_frames_are_told_from_the_benchs_own(finished_run: Path) -> None:
    statistics = {message.identifier: message for message in message_statistics(load_run(finished_run))}
    assert statistics[0x120].sender == BENCH
    assert statistics[0x120].name == "WHEEL_SPEED_FRONT"
    assert statistics[0x120].count == 2000
    assert statistics[0x120].period_ms == pytest.approx(5.0, abs=0.01)
    assert statistics[0x210].sender == ECU
    assert statistics[0x210].largest_gap_ms == pytest.approx(205.0, abs=1.0)


def test_error_frames_get_a_lane(tmp_path: Path) -> None:
    data = made_up_stop.simulate(1.0)
    frames = made_up_stop.frames_of(1.0)
    frames["flags"][[100, 300]] |= ERROR
    run = RunData(tmp_path, made_up_stop.verdict_of(data), signals=data, frames=frames)
    charts = {chart["id"]: chart for chart in data_of(page_of(run))["charts"]}
    lane = charts["frames"]["lanes"][-1]
    assert lane["label"] == "error frames"
    np.testing.assert_allclose(sorted(lane["events"]), frames["tick"][[100, 300]] * 1e-3, atol=1e-9)


def test_criteria_lead_to_the_instant_that_decided_them(finished_run: Path) -> None:
    run = load_run(finished_run)
    by_id = {criterion["id"]: criterion for criterion in run.verdict["criteria"]}
    lock, stop = find_instant(run, by_id["wheel_lock"]), find_instant(run, by_id["stopping_distance"])
    late = find_instant(run, by_id["overruns"])
    assert lock is not None
    assert stop is not None
    assert late is not None
    slip = np.where(run.array("speed") > 15 / 3.6, np.abs(run.array("slip_ratio_fl")), 0.0)
    assert (lock.chart, lock.time_s) == ("slip", pytest.approx(run.time[np.argmax(slip)]))
    assert (stop.chart, stop.time_s) == ("speed", pytest.approx(1.001, abs=1e-3))
    assert (late.chart, late.time_s) == ("lateness-time", pytest.approx(5.0, abs=1e-3))


def test_lock_step_run_shows_no_deadlines(other_run: Path) -> None:
    charts = {chart["id"] for chart in data_of(build(other_run).read_text("utf-8"))["charts"]}
    assert "lateness" not in charts
    assert "cpu" in charts


def test_run_without_estimator_and_ecu_signals_still_has_a_report(tmp_path: Path) -> None:
    data = made_up_stop.simulate(2.0)
    kept = {name: data.array(name) for name in ("time", "speed", "driver_pedal_force", "true_brake_pressure_fl")}
    bare = type(data)(data.time, kept, data.units)
    page = page_of(RunData(tmp_path, {"scenario": "x", "verdict": "pass", "criteria": []}, signals=bare))
    assert {chart["id"] for chart in data_of(page)["charts"]} == {"speed", "pedal"}
    assert "This run has no criteria" in page


def test_run_that_broke_off_says_so(tmp_path: Path) -> None:
    folder = tmp_path / "broken"
    folder.mkdir()
    state = RunState("stops/dry", "0" * 64, pid=1, process_start=0, started="2026-03-02T10:11:12+01:00")
    write_state(folder, state)
    page = build(folder).read_text("utf-8")
    assert "This run has no verdict" in page
    assert "error" in page
    assert "no charts" in page


@pytest.mark.parametrize(
    ("make", "text"),
    [
        (lambda folder: None, "no such run folder"),
        (lambda folder: folder.mkdir(), "not the folder of a run"),
        (lambda folder: (folder.mkdir(), (folder / "verdict.json").write_text("{half")), "not readable"),
        (lambda folder: (folder.mkdir(), (folder / "verdict.json").write_text("[1]")), "not a JSON object"),
    ],
)
def test_wrong_folders_give_one_message_with_a_mend(tmp_path: Path, make: Any, text: str) -> None:
    folder = tmp_path / "run"
    make(folder)
    with pytest.raises(InputError, match=text) as caught:
        build(folder)
    assert caught.value.exit_code == 2
    assert caught.value.mend


def test_page_opens_its_footer_with_the_command_to_judge_again(report_page: Path) -> None:
    assert f"bench judge {report_page.parent.name} --criteria FILE" in report_page.read_text("utf-8")
