"""A run's folder: what it holds while the run is on, and what it holds at the end.

While it runs: ``run.json``, ``scenario.yaml``, ``log.txt``, ``signals.mcap``, ``frames.blf`` and the ring. At the end:
``verdict.json``, ``junit.xml``, ``report.html``, ``signals.mf4``, ``frames.blf``, ``scenario.yaml``, ``log.txt``, and
``frames.asc`` if it was asked for. ``run.json`` goes last: where it is, the run did not end in order.
"""

import hashlib
import json
import os
from collections.abc import Mapping, Sequence
from dataclasses import asdict, dataclass, field
from datetime import UTC, datetime
from pathlib import Path
from typing import Any

from signals.errors import InputError, RunError

STATE_FILE = "run.json"
STREAM_FILE = "signals.mcap"
FRAME_FILE = "frames.blf"
ASC_FILE = "frames.asc"
MF4_FILE = "signals.mf4"
SCENARIO_FILE = "scenario.yaml"
LOG_FILE = "log.txt"
RESERVE_FILE = ".reserve"
RUNNING, ENDED = "running", "ended"
FINISHED_FILES = ("verdict.json", "junit.xml", "report.html", MF4_FILE, FRAME_FILE, SCENARIO_FILE, LOG_FILE)


@dataclass(frozen=True)
class FileChoice:
    """Which files a run leaves.

    Attributes
    ----------
    mf4, blf, asc : bool
        Whether signals.mf4, frames.blf, frames.asc are wanted.
    mf4_signals : sequence of str
        Names or patterns of the signals in signals.mf4; the time is always there.
    """

    mf4: bool = True
    blf: bool = True
    asc: bool = False
    mf4_signals: Sequence[str] = ("*",)


@dataclass
class RunState:
    """Contents of ``run.json``.

    Attributes
    ----------
    pid, process_start : int
        Process that owns the run, and its start in clock ticks since boot, so that a reused number is not mistaken.
    state : str
        "running", "ended" once everything is recorded and only files are to be made, else what went wrong.
    ring : str
        Path of the ring.
    information : dict
        What the verdict needs when the run is recovered: seed, mode, versions.
    """

    scenario: str
    scenario_hash: str
    pid: int
    process_start: int
    started: str
    state: str = RUNNING
    ring: str = ""
    files: FileChoice = field(default_factory=FileChoice)
    information: dict[str, Any] = field(default_factory=dict)

    @property
    def owner_is_alive(self) -> bool:
        """True while the process that owns the run is there."""
        return self.process_start > 0 and process_start(self.pid) == self.process_start


def process_start(pid: int) -> int:
    """Start of a process in clock ticks since boot; 0 if there is no such process, or only its remains."""
    try:
        text = Path(f"/proc/{pid}/stat").read_text()
    except OSError:
        return 0
    fields = text.rsplit(")", 1)[1].split()
    return 0 if fields[0] in "ZX" else int(fields[19])


def create_run_folder(
    folder: Path,
    *,
    scenario: str,
    scenario_text: str,
    files: FileChoice | None = None,
    information: Mapping[str, Any] | None = None,
) -> RunState:
    """Make a run's folder with its scenario, log and state in one step: it exists with all of them or not at all.

    Parameters
    ----------
    scenario, scenario_text : str
        Id, and the scenario as run with all defaults and overrides resolved (YAML).

    Raises
    ------
    InputError
        If the folder exists and is not empty.
    RunError
        If it cannot be made.
    """
    if folder.exists() and (not folder.is_dir() or any(folder.iterdir())):
        raise InputError(f"{folder}: already there and not empty", mend="give another folder: --out DIR")
    digest = hashlib.sha256(scenario_text.encode()).hexdigest()
    now = datetime.now(UTC).astimezone().isoformat(timespec="seconds")
    pid = os.getpid()
    state = RunState(scenario, digest, pid, process_start(pid), now, files=files or FileChoice())
    state.information = dict(information or {})
    beside = folder.with_name(f".{folder.name}.{os.getpid()}")
    try:
        beside.mkdir(parents=True)
        (beside / SCENARIO_FILE).write_text(scenario_text, "utf-8")
        (beside / LOG_FILE).write_text(f"{now} run of {scenario} started\n", "utf-8")
        write_state(beside, state)
        beside.rename(folder)
    except OSError as error:
        raise RunError(f"{folder}: cannot make the run's folder ({(error.strerror or str(error)).lower()})") from error
    return state


def write_state(folder: Path, state: RunState) -> None:
    """Write ``run.json`` in one step."""
    partial = folder / f".{STATE_FILE}.partial"
    partial.write_text(json.dumps(asdict(state), indent=2) + "\n", "utf-8")
    partial.replace(folder / STATE_FILE)


def read_state(folder: Path) -> RunState | None:
    """State of a run that did not end in order; None if it did."""
    try:
        content = json.loads((folder / STATE_FILE).read_text("utf-8"))
    except FileNotFoundError:
        return None
    except ValueError as error:
        raise InputError(f"{folder / STATE_FILE}: not readable ({error})") from error
    return RunState(**content | {"files": FileChoice(**content.get("files", {}))})


def append_log(folder: Path, text: str) -> None:
    """Add a line with the time to the run's log."""
    now = datetime.now(UTC).astimezone().isoformat(timespec="seconds")
    with (folder / LOG_FILE).open("a", encoding="utf-8") as file:
        file.write(f"{now} {text}\n")


def remove_running_files(folder: Path, ring: Path | None) -> None:
    """Take away what a finished folder does not hold; ``run.json`` goes last."""
    for partial in folder.glob(".*.partial*"):
        partial.unlink(missing_ok=True)
    for path in (folder / RESERVE_FILE, folder / STREAM_FILE, ring):
        if path is not None:
            path.unlink(missing_ok=True)
    (folder / STATE_FILE).unlink(missing_ok=True)


def remove_orphaned_rings(shared: Path = Path("/dev/shm")) -> list[Path]:
    """Delete rings in shared memory whose run's folder is gone or finished; nothing else would."""
    from bench.recording.ring import RingReader

    removed = []
    for path in shared.glob("bench-*.ring"):
        try:
            folder = Path(RingReader(path).schema.information["run_dir"])
            state = read_state(folder)
        except (InputError, KeyError):
            continue
        owner = int(path.name.split("-")[1])
        if process_start(owner) == 0 and (state is None or state.ring != str(path)):
            path.unlink(missing_ok=True)
            removed.append(path)
    return removed
