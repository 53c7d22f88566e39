"""Where the dashboard goes: a live panel on a terminal, else one line for each simulated second."""

import math
import os
from types import TracebackType
from typing import Protocol, TextIO

import numpy as np
from numpy.typing import NDArray
from rich.console import Console
from rich.live import Live

from bench.dashboard.rendering import describe_run, plain_line, render
from bench.dashboard.snapshot import RunView


class Display(Protocol):
    """Shows a run that is fed to it."""

    def show(self, rows: NDArray[np.float64], frames: int) -> None:
        """Take new rows and the number of frames so far, and show the newest instant."""

    def __enter__(self) -> "Display": ...

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None: ...


class LiveDisplay:
    """Panel that is redrawn in place; its last state stays on the terminal."""

    def __init__(self, view: RunView, console: Console, note: str = "") -> None:
        self._view, self._console, self._note = view, console, note
        self._live = Live(console=console, auto_refresh=False, vertical_overflow="crop")

    def __enter__(self) -> "LiveDisplay":
        self._live.start()
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        self._live.stop()

    def show(self, rows: NDArray[np.float64], frames: int) -> None:
        """Redraw with what is new."""
        self._view.update(rows, frames)
        self._live.update(render(self._view, self._console.width, self._note), refresh=True)


class PlainDisplay:
    """A line when the run begins, one for each simulated second, one at the end."""

    def __init__(self, view: RunView, stream: TextIO, every_s: float = 1.0) -> None:
        self._view, self._stream, self._every_s = view, stream, every_s
        self._time_column = view.column("time")
        self._next_s: float | None = None
        self._printed_s = -math.inf

    def __enter__(self) -> "PlainDisplay":
        self._write(f"{self._view.information.get('scenario') or 'run'} · {describe_run(self._view)}".rstrip(" ·"))
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        if self._view.snapshot.ticks and self._view.snapshot.time_s > self._printed_s:
            self._write(plain_line(self._view))

    def show(self, rows: NDArray[np.float64], frames: int) -> None:
        """Print the lines that are due within the new rows."""
        begin = 0
        for row, time_s in enumerate(rows[:, self._time_column]):
            if self._next_s is None:
                self._next_s = math.floor(time_s / self._every_s) * self._every_s + self._every_s
            if time_s >= self._next_s - 1e-9:
                self._view.update(rows[begin : row + 1], frames)
                self._write(plain_line(self._view))
                self._printed_s = self._view.snapshot.time_s
                self._next_s += self._every_s
                begin = row + 1
        self._view.update(rows[begin:], frames)

    def _write(self, line: str) -> None:
        self._stream.write(line + "\n")
        self._stream.flush()


def choose_display(view: RunView, stream: TextIO, note: str = "") -> Display:
    """Live panel where ``stream`` is a terminal that can move its cursor, else plain lines."""
    if stream.isatty() and os.environ.get("TERM", "dumb") != "dumb":
        return LiveDisplay(view, Console(file=stream), note)
    return PlainDisplay(view, stream)
