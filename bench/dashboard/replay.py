"""``bench replay``: a recording through the dashboard's view, at the pace of the clock or as one picture."""

import re
import sys
import time
from pathlib import Path
from typing import Any, TextIO

import numpy as np
from rich.console import Console
from rich.terminal_theme import TerminalTheme

from bench.dashboard.display import LiveDisplay, choose_display
from bench.dashboard.rendering import render
from bench.dashboard.snapshot import FloatArray, RunView
from bench.report.bus_charts import frame_times
from bench.report.run_data import RunData
from bench.report.run_reading import load_run
from bench.verdict.result import plain
from signals.errors import InputError

REFRESH_S = 0.1
PICTURE_WIDTH = 92
TITLE_BAR = 34

# a page without fonts or styles from elsewhere, unlike the one that the library brings
_SVG = """<svg viewBox="0 0 {width} {height}" xmlns="http://www.w3.org/2000/svg">
<style>{styles}
.{unique_id}-matrix {{ font-family: ui-monospace, "DejaVu Sans Mono", Menlo, Consolas, monospace;
 font-size: {char_height}px; line-height: {line_height}px; font-variant-east-asian: full-width; }}
</style>
<defs><clipPath id="{unique_id}-clip-terminal"><rect x="0" y="0" width="{terminal_width}" height="{terminal_height}"/>
</clipPath>{lines}</defs>
<rect width="{width}" height="{height}" rx="8" fill="#0f1318"/>
<g transform="translate({terminal_x}, 14)" clip-path="url(#{unique_id}-clip-terminal)">
{backgrounds}<g class="{unique_id}-matrix">{matrix}</g></g></svg>
"""
_THEME = TerminalTheme(
    (15, 19, 24),
    (232, 236, 242),
    [(60, 68, 80), (255, 130, 150), (95, 214, 148), (245, 192, 91), (106, 176, 255), (215, 155, 242), (63, 181, 172),
     (232, 236, 242)],
)  # fmt: skip


class _Replay:
    """Rows of a recording in the order in which the dashboard takes them."""

    def __init__(self, run: RunData) -> None:
        if run.signals is None or len(run.time) == 0 or not run.has("speed"):
            raise InputError(f"{run.folder}: nothing was recorded that could be replayed")
        self.run = run
        self.time = run.time
        self._rows = np.column_stack([run.array(name) for name in run.signals.names])
        self._position = 0
        frames = run.frames
        self._frame_times = np.sort(frame_times(run, frames)) if frames is not None else np.zeros(0)
        self.view = RunView(run.signals.names, run.signals.phase_names, _information(run))

    def rows_until(self, time_s: float) -> tuple[FloatArray, int]:
        """Rows up to a time that were not taken yet, and the number of frames up to it."""
        end = int(np.searchsorted(self.time, time_s, side="right"))
        rows = self._rows[self._position : end]
        self._position = max(end, self._position)
        return rows, int(np.searchsorted(self._frame_times, time_s, side="right"))

    @property
    def finished(self) -> bool:
        """True once every row was taken."""
        return self._position >= len(self.time)


def _information(run: RunData) -> dict[str, Any]:
    ecu = run.scenario.get("ecu")
    link = run.timing.get("link")
    return {
        "scenario": run.name,
        "mode": run.timing.get("mode"),
        "ecu": ecu.get("kind") if isinstance(ecu, dict) else None,
        "link": link.get("text") if isinstance(link, dict) else None,
    }


def replay(run_dir: str | Path, *, at_s: float = 0.0, speed: float = 1.0, stream: TextIO | None = None) -> None:
    """Show a recording as the dashboard showed the run.

    Parameters
    ----------
    at_s : float
        Time of the run at which to begin, in s.
    speed : float
        1 is the pace at which it happened; without a terminal everything is printed at once.
    stream : text file, optional
        Standard output by default.

    Raises
    ------
    InputError
        If there is nothing to replay, or ``at_s`` lies behind the end, or ``speed`` is not positive.
    """
    if not speed > 0.0:
        raise InputError(f"--speed {speed:g}: not a pace", allowed="a number above 0")
    source = _Replay(load_run(run_dir))
    _check_time(source, at_s)
    note = f"replay ×{speed:g}"
    with choose_display(source.view, stream or sys.stdout, note) as display:
        first, frames = source.rows_until(at_s)
        if isinstance(display, LiveDisplay):
            display.show(first, frames)
            _at_pace(source, display, at_s, speed)
        else:
            source.view.update(first, frames)
            display.show(*source.rows_until(float("inf")))


def _at_pace(source: _Replay, display: LiveDisplay, at_s: float, speed: float) -> None:
    began = time.monotonic()
    while not source.finished:
        time.sleep(REFRESH_S)
        display.show(*source.rows_until(at_s + speed * (time.monotonic() - began)))


def replay_picture(run_dir: str | Path, path: str | Path, *, at_s: float = 0.0) -> Path:
    """The dashboard at one instant of a recording as an SVG picture.

    Raises
    ------
    InputError
        If there is nothing to show at ``at_s``, or the file's ending is not svg.
    """
    path = Path(path)
    if path.suffix.lower() != ".svg":
        raise InputError(f"{path}: the dashboard's picture is an SVG file", allowed=".svg")
    source = _Replay(load_run(run_dir))
    _check_time(source, at_s)
    before = source.rows_until(at_s - REFRESH_S)
    source.view.update(*before)
    source.view.update(*source.rows_until(at_s))
    with Path("/dev/null").open("w") as nowhere:
        console = Console(
            record=True,
            width=PICTURE_WIDTH,
            file=nowhere,
            force_terminal=True,
            color_system="truecolor",
            no_color=False,
        )
        console.print(render(source.view, PICTURE_WIDTH))
    path.parent.mkdir(parents=True, exist_ok=True)
    drawn = console.export_svg(code_format=_SVG, theme=_THEME, unique_id="dashboard")
    path.write_text(_without_title_bar(drawn), encoding="utf-8")
    return path


def instant(run_dir: str | Path, *, at_s: float = 0.0) -> dict[str, Any]:
    """All signals of a recording at one instant: time in s, phase, and value and unit of each signal.

    Raises
    ------
    InputError
        If ``at_s`` is outside the recording.
    """
    run = load_run(run_dir)
    source = _Replay(run)
    _check_time(source, at_s)
    row = int(np.searchsorted(source.time, at_s, side="right")) - 1
    units = run.signals.units if run.signals is not None else {}
    return {
        "scenario": run.name,
        "time_s": float(source.time[row]),
        "signals": {name: {"value": plain(run.array(name)[row]), "unit": unit} for name, unit in units.items()},
    }


def _without_title_bar(svg: str) -> str:
    """Take the height of the window's title bar, which is not drawn, out of the picture's size."""
    height = re.search(r'viewBox="0 0 [\d.]+ ([\d.]+)"', svg)
    if height is None:
        return svg
    return svg.replace(f'{height[1]}"', f'{float(height[1]) - TITLE_BAR:g}"', 2)


def _check_time(source: _Replay, at_s: float) -> None:
    first, last = float(source.time[0]), float(source.time[-1])
    if not first <= at_s <= last:
        raise InputError(f"--at {at_s:g} s is outside the recording", allowed=f"{first:g} s to {last:.3f} s")
