"""``python -m bench.recording.convert FOLDER PARENT``: make ``signals.mf4`` from what a run has recorded.

A process of its own, because the MF4 library takes long to import and much memory, and because an MF4 writer keeps
nothing when it is killed.
"""

import os
import signal
import sys
from pathlib import Path

from bench.loop.scheduling import die_with_parent
from bench.recording.mf4_file import write_mf4
from bench.recording.run_folder import MF4_FILE, read_state
from bench.recording.stored_rows import StoredRun, read_stored
from signals.errors import BenchError, RunError


def convert(folder: Path, stored: StoredRun | None = None) -> int:
    """Make ``signals.mf4`` of a run's folder; returns the number of rows.

    Raises
    ------
    RunError
        If there is nothing to make it from, or no room for it.
    """
    state = read_state(folder)
    if stored is None:
        stored = read_stored(folder, Path(state.ring) if state is not None and state.ring else None)
    if stored.schema is None:
        raise RunError(f"{folder}: nothing was recorded")
    schema, rows = stored.chosen(state.files.mf4_signals if state is not None else ("*",))
    try:
        return write_mf4(folder / MF4_FILE, schema, rows)
    except OSError as error:
        raise RunError(
            f"{folder / MF4_FILE}: {(error.strerror or str(error)).lower()}",
            mend=f"the recording is kept; make room, then: bench recover {folder}",
        ) from error


def main() -> int:
    """Entry point of the converter process: ``FOLDER PARENT``."""
    # killed with its parent, so that it never writes beside a recovery of the same folder
    die_with_parent(signal.SIGKILL)
    if os.getppid() != int(sys.argv[2]):
        return 4
    try:
        convert(Path(sys.argv[1]))
    except BenchError as error:
        sys.stderr.write(f"error: {error}\n")
        return error.exit_code
    return 0


if __name__ == "__main__":
    sys.exit(main())
