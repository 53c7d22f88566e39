import io
import json
from pathlib import Path
from typing import Any

import made_up_stop
import pytest
from rich.cells import cell_len
from rich.console import Console
from typer import Typer
from typer.testing import CliRunner

from bench.commands.report import report as report_command
from bench.report import build, draw_picture, print_summary
from signals.errors import InputError


def summary(run: Path, width: int, **options: Any) -> str:
    stream = io.StringIO()
    print_summary(run, console=Console(file=stream, width=width, **options))
    return stream.getvalue()


def test_summary_has_verdict_table_files_and_the_next_command(report_page: Path) -> None:
    run = report_page.parent
    text = summary(run, 120)
    lines = text.splitlines()
    assert "FAIL" in lines[1]
    assert "7 criteria: 5 pass, 1 inconclusive, 1 fail" in lines[1]
    assert "wheel lock" in lines[3]
    for expected in (
        "0.131 s",
        "≤ 0.1 s",
        "−31 %",
        "FMVSS 135 S7.5",
        "the road's friction does not jump",
        "signals.mf4",
    ):
        assert expected in text
    assert lines[-1].startswith("next:   bench report ")
    assert lines[-1].endswith(" --open")


@pytest.mark.parametrize("width", [50, 80, 100])
def test_summary_fits_the_terminal(finished_run: Path, width: int) -> None:
    build(finished_run)
    table = [line for line in summary(finished_run, width).splitlines() if "/" not in line]
    assert max(cell_len(line) for line in table) <= width


def test_summary_without_colour_has_no_escapes(finished_run: Path) -> None:
    assert "\x1b" not in summary(finished_run, 100)
    assert "\x1b[" in summary(finished_run, 100, force_terminal=True)


def test_summary_of_an_error_says_what_happened(tmp_path: Path) -> None:
    data = made_up_stop.simulate(1.0)
    verdict = made_up_stop.verdict_of(data) | {"verdict": "error", "errors": ["the ECU never answered"], "criteria": []}
    (tmp_path / "run.json").write_text("{}")
    stream = io.StringIO()
    print_summary(tmp_path, verdict, Console(file=stream, width=100))
    assert "error: the ECU never answered" in stream.getvalue()
    assert "bench recover" in stream.getvalue()


@pytest.mark.parametrize(("name", "begins"), [("a.png", b"\x89PNG"), ("a.svg", b"<?xml"), ("a.pdf", b"%PDF")])
def test_picture(finished_run: Path, tmp_path: Path, name: str, begins: bytes) -> None:
    path = draw_picture(finished_run, tmp_path / name)
    assert path.read_bytes().startswith(begins)
    assert path.stat().st_size < 1_000_000


def test_picture_of_another_kind_is_refused(finished_run: Path, tmp_path: Path) -> None:
    with pytest.raises(InputError, match="unknown kind of picture"):
        draw_picture(finished_run, tmp_path / "a.bmp")


def test_report_command(finished_run: Path, tmp_path: Path) -> None:
    app = Typer()
    app.command()(report_command)
    result = CliRunner().invoke(app, [str(finished_run), "--json", "--picture", str(tmp_path / "a.png")])
    assert result.exit_code == 0
    paths = json.loads(result.output)
    assert Path(paths["report"]).exists()
    assert Path(paths["picture"]).exists()
    assert "report: " in CliRunner().invoke(app, [str(finished_run)]).output
