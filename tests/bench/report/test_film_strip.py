"""The strip of pictures in the report: instants, wheels' states, captions, and what happens without graphics."""

import re
import xml.etree.ElementTree as ElementTree
from pathlib import Path

import numpy as np
import pytest

from bench.recording.arrays import RunArrays
from bench.report.film_strip import caption, drawing, frames_of, strip_of
from bench.report.run_data import RunData
from signals.catalogue import catalogue

CAR = (4.3, 1.7, 2.6)


def made_up_run(folder: Path, **changes: np.ndarray) -> RunData:
    """Two seconds of braking at 8 m/s² from 16 m/s to standstill, the car drifting 0.5 m to the left."""
    time = np.arange(2001) * 1e-3
    values = {signal.name: np.zeros(time.size) for signal in catalogue()}
    values |= {
        "time": time,
        "speed": 16.0 - 8.0 * time,
        "true_longitudinal_acceleration": np.full(time.size, -8.0),
        "position_x": 16.0 * time - 4.0 * time**2,
        "position_y": 0.25 * time,
        "driver_pedal_force": np.full(time.size, 300.0),
        **changes,
    }
    matrix = np.column_stack(list(values.values()))
    signals = RunArrays.from_matrix(matrix, catalogue(), phase_names=("brake",))
    return RunData(folder, {"scenario": "made/up", "verdict": "pass"}, {"vehicle": "ekf_car"}, "", signals)


def test_frames_are_spread_over_the_stop_and_say_what_the_car_does(tmp_path: Path) -> None:
    frames = frames_of(made_up_run(tmp_path), 5)
    assert [frame.time_s for frame in frames] == pytest.approx([0.0, 0.5, 1.0, 1.5, 2.0])
    assert [frame.speed_m_s for frame in frames] == pytest.approx([16.0, 12.0, 8.0, 4.0, 0.0])
    assert frames[2].offset_m == pytest.approx(0.25)
    assert caption(frames[2]) == "1.00\N{NO-BREAK SPACE}s · 29\N{NO-BREAK SPACE}km/h · 8.0\N{NO-BREAK SPACE}m/s²"
    # a car that stands does not decelerate
    assert caption(frames[4]) == "2.00\N{NO-BREAK SPACE}s · 0\N{NO-BREAK SPACE}km/h"


def test_wheels_are_coloured_by_their_slip(tmp_path: Path) -> None:
    rows = 2001
    slips = {"fl": -1.0, "fr": -0.12, "rl": -0.02, "rr": -0.9}
    run = made_up_run(tmp_path, **{f"slip_ratio_{w}": np.full(rows, s) for w, s in slips.items()})
    picture = drawing(frames_of(run)[1], CAR)
    tree = ElementTree.fromstring(picture)
    states = [element.get("class") for element in tree.iter() if (element.get("class") or "").startswith("tyre")]
    assert states == ["tyre locked", "tyre braking", "tyre rolling", "tyre locked"]


def test_heading_steering_and_place_are_those_of_the_run(tmp_path: Path) -> None:
    rows = 2001
    run = made_up_run(
        tmp_path,
        yaw_angle=np.full(rows, 0.1),
        true_road_wheel_angle_fl=np.full(rows, -0.2),
        position_y=np.arange(rows) * 1e-3,
    )
    picture = drawing(frames_of(run, 3)[1], CAR)
    assert f"translate(0 1.000) rotate({np.degrees(0.1):.2f})" in picture
    assert f"rotate({np.degrees(-0.2):.2f})" in picture


def test_machine_without_graphics_gets_the_drawing_and_a_remark(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("bench.report.car_render.LIBRARIES", ("no_such_library",))
    run = made_up_run(tmp_path)
    strip = strip_of(run, render=True)
    assert len(strip) == 6
    assert all(picture.startswith("<svg") for picture, _ in strip)
    assert any("drawn, not rendered" in remark for remark in run.remarks)


def test_run_without_motion_has_no_strip(tmp_path: Path) -> None:
    assert strip_of(RunData(tmp_path, {})) == []


def test_report_page_shows_the_strip(tmp_path: Path) -> None:
    from bench.report.run_report import page_of

    page = page_of(made_up_run(tmp_path))
    assert len(re.findall(r"<figure><svg viewBox", page)) == 6
    assert "The car through the stop" in page
