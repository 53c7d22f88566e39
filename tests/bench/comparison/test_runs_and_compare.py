import io
import json
from pathlib import Path
from typing import Any

import made_up_stop
import pytest
from browser import Browser
from rich.console import Console
from typer import Typer
from typer.testing import CliRunner

from bench.commands.compare import compare as compare_command
from bench.commands.runs import runs as runs_command
from bench.comparison.compare import compare, figure_texts, print_comparison
from bench.comparison.overlay_page import build_page, default_page
from bench.comparison.runs import list_runs
from bench.report.run_reading import load_run
from signals.errors import InputError


@pytest.fixture(scope="module")
def runs_folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Two finished runs, one that was cut off, one folder that is no run."""
    root = tmp_path_factory.mktemp("work") / "runs"
    with_abs = made_up_stop.simulate(5.0)
    made_up_stop.write_run_folder(root / "dry-1", with_abs, made_up_stop.verdict_of(with_abs, failing=True))
    without = made_up_stop.simulate(5.0, brake_at_s=1.4, abs_control=False, seed=2, real_time=False)
    verdict = made_up_stop.verdict_of(without)
    verdict["metrics"] = {**verdict["metrics"], "stopping_distance_m": 61.2, "lock_time_s": [1.2, 1.1, None, 0.0]}
    scenario = made_up_stop.SCENARIO.replace("kind: emulated", "kind: none")
    made_up_stop.write_run_folder(root / "no_ecu-2", without, verdict, scenario=scenario)
    (root / "no_ecu-2" / "log.txt").write_text("2026-03-02T11:00:00+01:00 run of stops/no_ecu started\n")
    (root / "cut").mkdir()
    (root / "cut" / "run.json").write_text(json.dumps({"scenario": "stops/wet", "state": "running"}))
    (root / "notes").mkdir()
    return root


def command(function: Any, *arguments: str) -> Any:
    app = Typer()
    app.command()(function)
    return CliRunner().invoke(app, list(arguments))


def test_runs_are_listed_in_the_order_of_their_start(runs_folder: Path) -> None:
    entries = {Path(entry.path).name: entry for entry in list_runs(runs_folder)}
    assert set(entries) == {"dry-1", "no_ecu-2", "cut"}
    finished = [name for name in entries if name != "cut"]
    assert finished == ["dry-1", "no_ecu-2"]
    assert entries["dry-1"].verdict == "fail"
    assert entries["dry-1"].longest_lock_s == 0.04
    assert entries["dry-1"].lateness_p99_us == 1.9
    assert entries["no_ecu-2"].lateness_p99_us is None, "lock-step has no lateness"
    assert entries["no_ecu-2"].longest_lock_s == 1.2
    assert (entries["cut"].verdict, entries["cut"].scenario) == ("unfinished", "stops/wet")


def test_runs_command(runs_folder: Path, tmp_path: Path) -> None:
    table = command(runs_command, str(runs_folder))
    assert table.exit_code == 0
    for text in ("dry-1", "✗ fail", "44.8 m", "61.2 m", "unfinished", "8.61 m/s²"):
        assert text in table.output
    content = json.loads(command(runs_command, str(runs_folder), "--json").output)
    assert {entry["scenario"] for entry in content} == {"stops/dry", "stops/wet"}
    (tmp_path / "empty").mkdir()
    assert "no runs yet" in command(runs_command, str(tmp_path / "empty")).output


def test_missing_folder_is_an_input_error(tmp_path: Path) -> None:
    with pytest.raises(InputError, match="no such folder"):
        list_runs(tmp_path / "nowhere")


def test_differences_are_second_minus_first(runs_folder: Path) -> None:
    comparison = compare(load_run(runs_folder / "dry-1"), load_run(runs_folder / "no_ecu-2"))
    figures = {figure.name: figure for figure in comparison.figures}
    distance = figures["stopping_distance_m"]
    assert distance.difference == pytest.approx(61.2 - 44.8)
    assert distance.relative == pytest.approx((61.2 - 44.8) / 44.8)
    assert figure_texts(distance) == ("stopping distance", "44.8 m", "61.2 m", "+16.4 m", "+36.6 %")
    assert figures["lock_time_s fl"].b == 1.2
    assert figures["lock_time_s rl"].b is None
    assert figure_texts(figures["lock_time_s fl"])[0] == "lock time FL"
    assert figures["lateness p99_us"].b is None
    assert figure_texts(figures["lateness p99_us"])[:3] == ("lateness p99", "1.9 µs", "–")


def test_settings_that_differ_are_named_by_their_path(runs_folder: Path) -> None:
    comparison = compare(load_run(runs_folder / "dry-1"), load_run(runs_folder / "no_ecu-2"))
    assert [(s.path, s.a, s.b) for s in comparison.settings] == [("ecu.kind", "emulated", "none")]


def test_a_run_compared_with_itself_shows_no_difference(runs_folder: Path) -> None:
    run = load_run(runs_folder / "dry-1")
    comparison = compare(run, run)
    assert comparison.settings == []
    assert all(figure.difference == 0 for figure in comparison.figures)
    assert {figure_texts(figure)[3] for figure in comparison.figures} == {"="}


def test_terminal_table_has_criteria_and_figures(runs_folder: Path) -> None:
    comparison = compare(load_run(runs_folder / "dry-1"), load_run(runs_folder / "no_ecu-2"))
    stream = io.StringIO()
    print_comparison(comparison, Console(file=stream, width=120))
    text = stream.getvalue()
    for expected in ("set differently", "wheel lock", "B − A", "+16.4 m", "no_ecu-2"):
        assert expected in text


def test_compare_command_makes_the_page_and_pure_json(runs_folder: Path, tmp_path: Path) -> None:
    page = tmp_path / "overlay.html"
    a, b = str(runs_folder / "dry-1"), str(runs_folder / "no_ecu-2")
    content = json.loads(command(compare_command, a, b, "--json", "--out", str(page)).output)
    assert content["metrics"]["stopping_distance_m"]["difference"] == pytest.approx(16.4)
    assert content["runs"][0]["verdict"] == "fail"
    assert content["page"] == str(page)
    assert "page:" in command(compare_command, a, b, "--out", str(page)).output


def test_page_counts_time_from_each_brake_start(runs_folder: Path, tmp_path: Path) -> None:
    comparison = compare(load_run(runs_folder / "dry-1"), load_run(runs_folder / "no_ecu-2"))
    path = build_page(comparison, tmp_path / "overlay.html")
    page = path.read_text("utf-8")
    assert path.stat().st_size < 3_000_000
    data = json.loads(page.split('type="application/json">', 1)[1].split("</script>", 1)[0])
    assert data["span"] == pytest.approx([-1.0, 4.0], abs=2e-3)
    charts = {chart["id"]: chart for chart in data["charts"]}
    assert [series["label"] for series in charts["speed"]["series"]] == ["A", "B"]
    assert {"slip-fl", "pressure-rr", "friction-front", "yaw", "lateral", "distance"} <= set(charts)
    assert default_page(comparison) == runs_folder / "compare-dry-1-no_ecu-2.html"


def test_runs_without_signals_still_compare(runs_folder: Path, tmp_path: Path) -> None:
    for name in ("a", "b"):
        (tmp_path / name).mkdir()
        text = (runs_folder / "dry-1" / "verdict.json").read_text()
        (tmp_path / name / "verdict.json").write_text(text)
    comparison = compare(load_run(tmp_path / "a"), load_run(tmp_path / "b"))
    page = build_page(comparison, tmp_path / "overlay.html").read_text("utf-8")
    assert "stopping distance" in page


@pytest.mark.browser
@pytest.mark.parametrize(("width", "dark"), [(400, False), (400, True), (1600, False), (1600, True)])
def test_page_is_drawn_without_complaint(
    chromium: Browser, runs_folder: Path, tmp_path: Path, width: int, dark: bool
) -> None:
    comparison = compare(load_run(runs_folder / "dry-1"), load_run(runs_folder / "no_ecu-2"))
    page = chromium.open(build_page(comparison, tmp_path / "overlay.html"), width=width, dark=dark)
    assert page.console_messages() == []
    assert [url for url in page.requests() if not url.startswith(("file:", "data:"))] == []
    assert page.run("return document.documentElement.scrollWidth") <= width
    lengths = page.run(
        "return [...document.querySelectorAll('path.curve[data-series]')].map((c) => c.getAttribute('d').length)"
    )
    assert len(lengths) >= 30
    assert min(lengths) > 20
