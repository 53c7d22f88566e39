"""Progress of a long search on standard error: a bar on a terminal, a line every few seconds elsewhere."""

import sys
import time
from types import TracebackType

from rich.console import Console
from rich.progress import BarColumn, Progress, TextColumn, TimeElapsedColumn

LINE_EVERY_S = 2.0


class SearchProgress:
    """A bar that is called with what is being done and the share done, 0 to 1.

    Parameters
    ----------
    quiet : bool
        Shows nothing.
    """

    def __init__(self, quiet: bool = False) -> None:
        self._quiet = quiet
        self._started = time.perf_counter()
        self._said = ""
        self._next_line_s = 0.0
        self._bar: Progress | None = None
        if sys.stderr.isatty() and not quiet:
            console = Console(stderr=True)
            columns = (TextColumn("{task.description:<28}"), BarColumn(), TextColumn("{task.percentage:>3.0f} %"))
            self._bar = Progress(*columns, TimeElapsedColumn(), console=console, transient=True)
            self._task = self._bar.add_task("reading", total=1.0)

    def __enter__(self) -> "SearchProgress":
        if self._bar is not None:
            self._bar.start()
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        if self._bar is not None:
            self._bar.stop()

    def __call__(self, step: str, share: float) -> None:
        """Show what is being done and how much of the whole is done."""
        if self._bar is not None:
            self._bar.update(self._task, description=step, completed=share)
            return
        seconds = time.perf_counter() - self._started
        if not self._quiet and step != self._said and seconds >= self._next_line_s:
            print(f"{seconds:5.1f} s  {100 * share:3.0f} %  {step}", file=sys.stderr)
            self._said, self._next_line_s = step, seconds + LINE_EVERY_S
