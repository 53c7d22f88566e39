"""The dashboard's process: reads the ring of a run until the run ends, or the process that started it."""

import argparse
import os
import sys
import time
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import TextIO

from bench.dashboard.display import choose_display
from bench.dashboard.snapshot import RunView
from bench.recording.ring import RingReader
from signals.errors import InputError

REFRESH_S = 0.1
RING_APPEARS_WITHIN_S = 10.0


def follow(ring: Path, stream: TextIO, run_alive: Callable[[], bool]) -> None:
    """Show a run until its writer closes the ring or ``run_alive`` says no.

    Parameters
    ----------
    ring : Path
        File of the ring; it may appear a moment later.
    stream : text file
        A terminal gets the live panel, anything else plain lines.

    Raises
    ------
    InputError
        If no ring appears.
    """
    reader = _open_when_there(ring, run_alive)
    view = RunView(reader.schema.names, reader.schema.phase_names, reader.schema.information)
    with choose_display(view, stream) as display:
        while True:
            ended = reader.closed or not run_alive()
            _, _, rows = reader.take_rows()
            display.show(rows, reader.frames_written)
            if ended:
                return
            time.sleep(REFRESH_S)


def _open_when_there(ring: Path, run_alive: Callable[[], bool]) -> RingReader:
    deadline = time.monotonic() + RING_APPEARS_WITHIN_S
    while True:
        try:
            return RingReader(ring)
        except InputError:
            if time.monotonic() > deadline or not run_alive():
                raise
            time.sleep(0.02)


def main(arguments: Sequence[str] | None = None) -> int:
    """``python -m bench.dashboard RING [--parent PID]``; ends with the run or with its parent."""
    parser = argparse.ArgumentParser(prog="bench.dashboard", description="dashboard of a run")
    parser.add_argument("ring", type=Path, help="file of the run's ring")
    parser.add_argument("--parent", type=int, default=os.getppid(), help="process that owns the run")
    options = parser.parse_args(arguments)
    try:
        follow(options.ring, sys.stdout, lambda: os.getppid() == options.parent)
    except InputError as error:
        print(f"dashboard: {error}", file=sys.stderr)
        return error.exit_code
    except BrokenPipeError:
        return 0  # nobody reads the lines any more; the run goes on
    return 0
