"""Contents of the dashboard's panel and of the progress lines."""

import io
import re

import made_up_stop
import numpy as np
import pytest
from rich.cells import cell_len
from rich.console import Console

from bench.dashboard.display import PlainDisplay
from bench.dashboard.rendering import horizontal_bar, plain_line, render, sparkline
from bench.dashboard.snapshot import Percentiles, RunView
from bench.recording.arrays import RunArrays

INFORMATION = {"scenario": "stops/dry", "ecu": "emulated", "link": "udp", "mode": "realtime"}


@pytest.fixture(scope="module")
def stop() -> RunArrays:
    return made_up_stop.simulate(6.0)


def rows_of(data: RunArrays) -> np.ndarray:
    return np.column_stack([data.array(name) for name in data.names])


def view_at(data: RunArrays, time_s: float, **changes: float) -> RunView:
    rows = rows_of(data)[: round(time_s * 1000) + 1].copy()
    for name, value in changes.items():
        rows[-1, data.names.index(name)] = value
    view = RunView(data.names, data.phase_names, INFORMATION)
    for begin in range(0, len(rows), 100):
        view.update(rows[begin : begin + 100], 1234)
    return view


def text_of(view: RunView, width: int) -> str:
    console = Console(width=width, file=io.StringIO(), color_system=None)
    with console.capture() as captured:
        console.print(render(view, width))
    return captured.get()


def test_panel_shows_the_numbers_of_the_last_row(stop: RunArrays) -> None:
    view = view_at(stop, 2.4)
    row = 2400
    text = text_of(view, 100)
    assert "stops/dry · emulated ECU · udp · real time" in text
    assert re.search(r"brake\s+t\s+2\.400 s", text)
    assert f"{stop.array('speed')[row] * 3.6:.1f} km/h" in text
    for wheel in ("fl", "fr", "rl", "rr"):
        assert f"{stop.array(f'true_brake_pressure_{wheel}')[row] * 1e-5:.1f} bar" in text
        rim = stop.array("speed")[row] * (1 + stop.array(f"slip_ratio_{wheel}")[row]) * 3.6
        assert f"{rim:.1f} km/h" in text
    assert f"{-100 * stop.array('slip_ratio_fr')[row]:.0f} %" in text
    assert f"front {stop.array('friction_ekf.friction_limit_front')[row]:.2f} ±0.02 sure" in text
    assert "road 0.95" in text
    assert "ABS on · pump on · EBD off · lamp off" in text
    assert "load 31 %" in text or "load 30 %" in text
    assert "1 234 frames" in text
    assert "overruns 0 of 2 401" in text


@pytest.mark.parametrize("width", [40, 48, 60, 80, 100, 200])
def test_panel_fits_every_width_and_keeps_every_field(stop: RunArrays, width: int) -> None:
    text = text_of(view_at(stop, 2.4), width)
    assert max(cell_len(line) for line in text.splitlines()) <= min(width, 100)
    flat = " ".join(line.strip(" │") for line in text.splitlines())
    for word in ("slip", "valve", "friction", "lamp", "load", "frames", "overruns", "km/h", "faults"):
        assert word in flat, f"{word} is missing at width {width}"


def test_lamp_fault_and_silent_ecu_stand_out(stop: RunArrays) -> None:
    view = view_at(stop, 2.4, abs_lamp=1.0, ecu_fault_code=7.0, age_valve_pump=0.31, faults_active=2.0)
    text = text_of(view, 100)
    assert "lamp on" in text
    assert "fault 7" in text
    assert "silent for 0.31 s" in text
    assert "faults 2" in text
    console = Console(width=100, file=io.StringIO(), force_terminal=True, color_system="truecolor")
    with console.capture() as captured:
        console.print(render(view, 100))
    assert "\x1b[1;31mlamp on" in captured.get()


def test_lock_step_has_no_deadlines(stop: RunArrays) -> None:
    view = view_at(stop, 2.4)
    view.information["mode"] = "lockstep"
    text = text_of(view, 100)
    assert "virtual time, no deadlines" in text
    assert "overruns" not in text


def test_split_road_shows_both_sides(stop: RunArrays) -> None:
    assert "road 0.95 | 0.20" in text_of(view_at(stop, 2.4, friction_limit_fr=0.2), 100)


def test_run_without_estimator_has_no_estimate(stop: RunArrays) -> None:
    kept = [name for name in stop.names if "." not in name and not name.startswith("friction")]
    bare = RunArrays(stop.time, {name: stop.array(name) for name in kept}, stop.units, phase_names=stop.phase_names)
    assert "friction" not in text_of(view_at(bare, 2.4), 100)


def test_percentiles_are_within_a_bin_of_the_exact_ones() -> None:
    values = np.random.default_rng(1).lognormal(3.0, 1.0, 20_000)
    percentiles = Percentiles()
    for part in np.array_split(values, 37):
        percentiles.add(part)
    for percent in (50.0, 99.0, 99.9):
        assert percentiles.at(percent) == pytest.approx(np.percentile(values, percent), rel=0.11)
    assert percentiles.largest == values.max()


@pytest.mark.parametrize(
    ("share", "bar"), [(0.0, "    "), (0.5, "██  "), (1.0, "████"), (2.0, "████"), (0.28125, "█▏  ")]
)
def test_bars_have_eighths(share: float, bar: str) -> None:
    assert horizontal_bar(share, 4) == bar


def test_sparkline_scales_to_the_highest() -> None:
    assert sparkline([0.0, 50.0, 100.0], 10, 100.0) == "▁▄█"
    assert sparkline([1.0] * 5, 3, 1.0) == "███"


def test_progress_without_a_terminal_is_one_line_per_second(stop: RunArrays) -> None:
    stream = io.StringIO()
    view = RunView(stop.names, stop.phase_names, INFORMATION)
    rows = rows_of(stop)
    with PlainDisplay(view, stream) as display:
        for begin in range(0, len(rows), 137):
            display.show(rows[begin : begin + 137], begin)
    lines = stream.getvalue().splitlines()
    assert lines[0] == "stops/dry · emulated ECU · udp · real time"
    times = [float(re.search(r"t +([\d.]+) s", line)[1]) for line in lines[1:]]  # type: ignore[index]
    assert times == [1.0, 2.0, 3.0, 4.0, 5.0, 6.0]
    assert f"{stop.array('speed')[3000] * 3.6:.1f} km/h" in lines[3]
    assert "\x1b" not in stream.getvalue()
    assert "ABS" in lines[2].split()


def test_a_run_that_ends_between_seconds_gets_a_last_line(stop: RunArrays) -> None:
    stream = io.StringIO()
    view = RunView(stop.names, stop.phase_names, INFORMATION)
    with PlainDisplay(view, stream) as display:
        display.show(rows_of(stop)[:2345], 0)
    assert "t    2.3 s" in stream.getvalue().splitlines()[-1]


def test_progress_line_names_faults(stop: RunArrays) -> None:
    assert plain_line(view_at(stop, 2.0, faults_active=1.0)).endswith("faults 1")
