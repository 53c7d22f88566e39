"""The dashboard as the process that a run starts: on a terminal, without one, at its run's and its parent's end."""

import os
import re
import subprocess
import sys
import time
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import made_up_stop
import numpy as np
import pytest
from terminal import Terminal

from bench.recording.ring import RingWriter
from bench.recording.schema import RunSchema
from signals.catalogue import catalogue

SIGNALS = (*catalogue(), *made_up_stop.ESTIMATES)
COMMAND = [sys.executable, "-m", "bench.dashboard"]
INFORMATION = {"scenario": "stops/dry", "ecu": "emulated", "link": "udp", "mode": "realtime"}
END_WITHIN_S = 20.0


class Run:
    """A ring that is filled as a loop would."""

    def __init__(self, path: Path) -> None:
        data = made_up_stop.simulate(6.0)
        self.rows = np.column_stack([data.array(signal.name) for signal in SIGNALS])
        schema = RunSchema.of(SIGNALS, phase_names=data.phase_names, information=INFORMATION)
        self.ring = path
        self.writer = RingWriter(path, schema, rows=1 << 13)
        self.frames = made_up_stop.frames_of(6.0)
        self._next = 0

    def advance_to(self, time_s: float) -> None:
        """Write rows and frames up to a time of the run."""
        end = min(round(time_s * 1000) + 1, len(self.rows))
        for tick in range(self._next, end):
            self.writer.write_row(self.rows[tick], tick)
        frames = self.frames[(self.frames["tick"] >= self._next) & (self.frames["tick"] < end)]
        self.writer.write_frames(np.ascontiguousarray(frames), len(frames))
        self._next = end


@pytest.fixture
def run(tmp_path: Path) -> Run:
    return Run(tmp_path / "run.ring")


@pytest.fixture
def terminal(tmp_path: Path) -> Iterator[Callable[..., Terminal]]:
    opened: list[Terminal] = []

    def start(command: list[str], width: int = 100, height: int = 30, **environment: str) -> Terminal:
        variables = {"TERM": "xterm-256color", "PYTHONPATH": str(Path(__file__).parents[3]), **environment}
        opened.append(Terminal(tmp_path / f"tmux{len(opened)}", command, width, height, variables))
        return opened[-1]

    yield start
    for each in opened:
        each.close()


def on_shell(ring: Path) -> list[str]:
    """Command whose parent is the shell that starts it."""
    return ["sh", "-c", f"{' '.join(COMMAND)} {ring}; echo ended with $?"]


def started(ring: Path, **options: Any) -> "subprocess.Popen[str]":
    return subprocess.Popen(
        [*COMMAND, str(ring), "--parent", str(os.getpid())],
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
        **options,
    )


@pytest.mark.parametrize("width", [64, 100])
def test_terminal_shows_the_run_and_keeps_its_last_state(
    run: Run, terminal: Callable[..., Terminal], width: int
) -> None:
    run.advance_to(1.5)
    screen = terminal(on_shell(run.ring), width=width)
    first = screen.wait_for(lambda text: "1.500 s" in text and "╰" in text)
    assert "brake" in first
    run.advance_to(2.4)
    # a screen caught in the middle of a redraw lacks some lines: wait for one with both borders
    second = screen.wait_for(
        lambda text: "2.400 s" in text and "of 2 401" in " ".join(text.split()) and "╭" in text and "╰" in text
    )
    assert second.count("stops/dry") == 1, "the panel is redrawn in place"
    pressure = run.rows[2400, [signal.name for signal in SIGNALS].index("true_brake_pressure_fl")] * 1e-5
    assert f"{pressure:.1f}" in second
    assert "lamp off" in " ".join(second.replace("│", " ").split())
    run.advance_to(6.0)
    run.writer.close()
    last = screen.wait_for(lambda text: "ended with 0" in text)
    assert "6.000 s" in last
    assert last.count("╭") == 1


def test_no_color_is_respected(run: Run, terminal: Callable[..., Terminal]) -> None:
    run.advance_to(2.0)
    plain, coloured = terminal(on_shell(run.ring), NO_COLOR="1"), terminal(on_shell(run.ring))
    for screen in (plain, coloured):
        screen.wait_for(lambda text: "2.000 s" in text and "╰" in text)
    foreground = re.compile(r"\x1b\[(?:\d+;)*3[0-7][;m]")
    assert not foreground.search(plain.text(styles=True))
    assert foreground.search(coloured.text(styles=True))
    run.writer.close()


def test_without_a_terminal_there_is_a_line_per_second(run: Run) -> None:
    process = started(run.ring)
    run.advance_to(6.0)
    run.writer.close()
    output, errors = process.communicate(timeout=END_WITHIN_S)
    assert process.returncode == 0
    assert errors == ""
    lines = output.splitlines()
    assert lines[0] == "stops/dry · emulated ECU · udp · real time"
    assert [line.split()[1] for line in lines[1:]] == ["1.0", "2.0", "3.0", "4.0", "5.0", "6.0"]
    assert "\x1b" not in output


def test_dumb_terminal_gets_lines(run: Run, terminal: Callable[..., Terminal]) -> None:
    run.advance_to(2.0)
    run.writer.close()
    screen = terminal(on_shell(run.ring), width=160, TERM="dumb")
    text = screen.wait_for(lambda text: "ended with 0" in text)
    assert "╭" not in text
    assert "t    2.0 s" in text


def test_it_ends_with_its_parent(run: Run) -> None:
    run.advance_to(1.0)
    # the parent starts the dashboard and dies by kill -9; the dashboard's end closes the pipe it writes to
    script = f"import subprocess, time\nsubprocess.Popen([*{COMMAND!r}, {str(run.ring)!r}])\ntime.sleep(60)\n"
    with subprocess.Popen([sys.executable, "-c", script], stdout=subprocess.PIPE, text=True) as parent:
        assert parent.stdout is not None
        assert parent.stdout.readline().startswith("stops/dry")
        parent.kill()
        began = time.monotonic()
        parent.stdout.read()
        assert time.monotonic() - began < END_WITHIN_S


def test_it_ends_quietly_when_nobody_reads(run: Run) -> None:
    process = started(run.ring)
    assert process.stdout is not None
    process.stdout.readline()
    process.stdout.close()
    run.advance_to(6.0)
    assert process.wait(END_WITHIN_S) == 0
    run.writer.close()


def test_a_ring_that_never_appears_is_an_error(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    from bench.dashboard import process

    monkeypatch.setattr(process, "RING_APPEARS_WITHIN_S", 0.1)
    assert process.main([str(tmp_path / "none.ring")]) == 2


def test_interrupting_the_terminal_leaves_the_end_to_the_run(run: Run) -> None:
    import signal

    process = started(run.ring)
    assert process.stdout is not None
    process.stdout.readline()
    process.send_signal(signal.SIGINT)
    run.advance_to(2.0)
    run.writer.close()
    output, _ = process.communicate(timeout=END_WITHIN_S)
    assert process.returncode == 0
    assert "t    2.0 s" in output
