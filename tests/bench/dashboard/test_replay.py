import io
import json
import re
import sys
import xml.etree.ElementTree as ElementTree
from collections.abc import Iterator
from pathlib import Path

import made_up_stop
import numpy as np
import pytest
from terminal import Terminal
from typer import Typer
from typer.testing import CliRunner

from bench.commands.replay import replay as replay_command
from bench.dashboard.replay import replay, replay_picture
from bench.report.run_reading import load_run
from signals.errors import InputError

APP = Typer()
APP.command()(replay_command)


@pytest.fixture(scope="module")
def recorded(tmp_path_factory: pytest.TempPathFactory) -> Path:
    data = made_up_stop.simulate(4.0)
    folder = tmp_path_factory.mktemp("runs") / "stops-dry-1"
    return made_up_stop.write_run_folder(folder, data, made_up_stop.verdict_of(data))


def test_without_a_terminal_the_recording_is_printed_at_once(recorded: Path) -> None:
    stream = io.StringIO()
    replay(recorded, stream=stream)
    lines = stream.getvalue().splitlines()
    assert lines[0].startswith("stops/dry · emulated ECU")
    assert [line.split()[1] for line in lines[1:]] == ["1.0", "2.0", "3.0", "4.0"]


def test_it_begins_where_it_is_told(recorded: Path) -> None:
    stream = io.StringIO()
    replay(recorded, at_s=2.5, stream=stream)
    assert [line.split()[1] for line in stream.getvalue().splitlines()[1:]] == ["3.0", "4.0"]


def test_one_instant_as_json_holds_every_recorded_signal(recorded: Path) -> None:
    shown = CliRunner().invoke(APP, [str(recorded), "--at", "2.4005", "--json"])
    at = json.loads(shown.stdout)
    run = load_run(recorded)
    assert run.signals is not None
    assert set(at["signals"]) == set(run.signals.names)
    row = int(np.flatnonzero(run.time <= 2.4005)[-1])
    assert at["time_s"] == run.time[row]
    assert at["signals"]["speed"] == {"value": run.array("speed")[row], "unit": "m/s"}


@pytest.fixture
def screen(recorded: Path, tmp_path: Path) -> Iterator[Terminal]:
    script = f"from bench.dashboard.replay import replay; replay({str(recorded)!r}, at_s=1.5, speed=20.0)"
    environment = {"TERM": "xterm-256color", "PYTHONPATH": str(Path(__file__).parents[3])}
    opened = Terminal(tmp_path / "tmux", [sys.executable, "-c", script], 100, 30, environment)
    yield opened
    opened.close()


def test_on_a_terminal_it_plays_to_the_end(screen: Terminal) -> None:
    # all of it at once: a screen caught in the middle of a redraw lacks some lines
    screen.wait_for(lambda text: all(part in text for part in ("stops/dry", "replay ×20", "4.000 s", "╰")))


def test_picture_needs_nothing_from_elsewhere(recorded: Path, tmp_path: Path) -> None:
    path = replay_picture(recorded, tmp_path / "images" / "dashboard.svg", at_s=2.4)
    content = path.read_text("utf-8")
    assert path.stat().st_size < 100_000
    addresses = set(re.findall(r"https?://[^\"' )]+", content))
    assert addresses == {"http://www.w3.org/2000/svg"}
    ElementTree.fromstring(content)
    assert "stops/dry" in content
    assert "2.400" in content


@pytest.mark.parametrize(
    ("options", "text"),
    [
        ({"at_s": 99.0}, "outside the recording"),
        ({"at_s": -1.0}, "outside the recording"),
        ({"speed": 0.0}, "not a pace"),
        ({"speed": float("nan")}, "not a pace"),
    ],
)
def test_wrong_options_are_refused(recorded: Path, options: dict[str, float], text: str) -> None:
    with pytest.raises(InputError, match=text):
        replay(recorded, stream=io.StringIO(), **options)


def test_picture_of_another_kind_is_refused(recorded: Path, tmp_path: Path) -> None:
    with pytest.raises(InputError, match="SVG"):
        replay_picture(recorded, tmp_path / "dashboard.png")


def test_command(recorded: Path, tmp_path: Path) -> None:
    result = CliRunner().invoke(APP, [str(recorded), "--at", "2", "--picture", str(tmp_path / "a.svg")])
    assert result.exit_code == 0
    assert (tmp_path / "a.svg").exists()
