"""``bench recover RUN``: a finished folder out of whatever a kill -9 has left.

The rows are those of ``signals.mcap`` and, after them, of the ring; the frames those of ``frames.blf`` and of the ring.
Every file is made beside its place and moved there, and ``run.json`` goes last, so recovery can itself be killed and
repeated.
"""

from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

from bench.recording.arrays import RunArrays
from bench.recording.convert import convert
from bench.recording.frame_file import AscFile, BlfFile
from bench.recording.reading import Recording
from bench.recording.run_folder import (
    ASC_FILE,
    ENDED,
    FRAME_FILE,
    MF4_FILE,
    RUNNING,
    SCENARIO_FILE,
    STREAM_FILE,
    RunState,
    append_log,
    read_state,
    remove_running_files,
)
from bench.recording.schema import RunSchema
from bench.recording.stored_rows import StoredRun, read_stored
from signals.catalogue import catalogue
from signals.errors import BenchError, InputError, RunError

if TYPE_CHECKING:
    from bench.verdict.criteria_file import CriteriaFile
    from bench.verdict.result import Verdict


@dataclass(frozen=True)
class Recovery:
    """What was saved.

    Attributes
    ----------
    already_finished : bool
        The run had ended in order; nothing was touched.
    rows, frames : int
        In the folder's files now.
    last_time_s : float
        Time of the last row.
    remarks : list of str
        What could not be made, and why.
    """

    folder: Path
    already_finished: bool
    rows: int = 0
    frames: int = 0
    last_time_s: float = 0.0
    remarks: tuple[str, ...] = ()

    def __str__(self) -> str:
        if self.already_finished:
            return f"{self.folder}: finished, nothing to recover"
        lines = [f"{self.folder}: recovered {self.rows} rows up to {self.last_time_s:.3f} s and {self.frames} frames"]
        return "\n".join([*lines, *self.remarks])


def recover(folder: str | Path) -> Recovery:
    """Bring a run's folder to the files of a finished run, with the verdict "error".

    Raises
    ------
    InputError
        If the folder is no run's, or its run is still on.
    RunError
        If there is no room for the files; the recording is kept.
    """
    folder = Path(folder)
    if not folder.is_dir():
        raise InputError(f"{folder}: no such folder")
    state = read_state(folder)
    if state is None:
        if (folder / "verdict.json").is_file():
            return Recovery(folder, already_finished=True)
        raise InputError(f"{folder}: not the folder of a run (no run.json, no verdict.json)")
    if state.state in (RUNNING, ENDED) and state.owner_is_alive:
        raise InputError(f"{folder}: the run is still on (process {state.pid})", mend="end it first")
    ring = Path(state.ring) if state.ring else None
    stored = read_stored(folder, ring)
    if stored.schema is None:
        stored = StoredRun(RunSchema.of(catalogue(), information={"scenario": state.scenario}))
    remarks = _make_files(folder, state, stored)
    arrays = _arrays(folder, stored)
    rows, frames = len(arrays), len(stored.frames)
    append_log(folder, f"recovered {rows} rows and {frames} frames; the run was left as: {state.state}")
    remove_running_files(folder, ring)
    return Recovery(folder, False, rows, frames, float(arrays.time[-1]) if rows else 0.0, tuple(remarks))


def _make_files(folder: Path, state: RunState, stored: StoredRun) -> list[str]:
    """Files of a finished run; returns remarks on what could not be made."""
    from bench.verdict.output_files import write_verdict

    if not _files_are_whole(folder, state):
        if state.files.mf4:
            convert(folder, stored)
        try:
            _write_frames(folder, state, stored)
        except OSError as error:
            raise RunError(
                f"{folder}: {(error.strerror or str(error)).lower()}", mend="make room and repeat"
            ) from error
    remarks = _lost_rows(stored)
    verdict = _verdict(folder, state, stored)
    verdict.remarks += remarks
    write_verdict(folder, verdict)
    return remarks + _report(folder)


def _files_are_whole(folder: Path, state: RunState) -> bool:
    """True if the stream was taken away after signals.mf4 was made: only the last steps were missing."""
    made = (folder / MF4_FILE).is_file() or (state.state == ENDED and not state.files.mf4)
    return made and not (folder / STREAM_FILE).exists()


def _write_frames(folder: Path, state: RunState, stored: StoredRun) -> None:
    start_ns = stored.schema.start_time_ns if stored.schema is not None else 0
    writers: list[tuple[type[BlfFile | AscFile], str, bool]] = [
        (BlfFile, FRAME_FILE, state.files.blf),
        (AscFile, ASC_FILE, state.files.asc),
    ]
    for make, name in ((make, name) for make, name, wanted in writers if wanted):
        partial = folder / f".{Path(name).stem}.partial{Path(name).suffix}"
        file = make(partial, start_ns)
        file.write(stored.frames)
        file.stop()
        partial.replace(folder / name)


def _lost_rows(stored: StoredRun) -> list[str]:
    """Remark on rows that are missing between two that are there."""
    ends = [first + len(ticks) for first, ticks, _ in stored.rows]
    starts = [first for first, _, _ in stored.rows]
    lost = sum(start - end for end, start in zip(ends[:-1], starts[1:], strict=True) if start > end)
    lost += starts[0] if starts else 0
    return [f"{lost} rows were overwritten before they could be recorded"] if lost else []


def _verdict(folder: Path, state: RunState, stored: StoredRun) -> "Verdict":
    """Verdict "error" with the figures that the recorded part has; its criteria are inconclusive."""
    from bench.verdict.judge import judge, missing_signals
    from bench.verdict.result import INCONCLUSIVE

    recording = _arrays(folder, stored)
    recording.timing = {"mode": state.information.get("mode", "")}
    criteria, remarks = _criteria(folder)
    if criteria is not None and missing_signals(recording, criteria.criteria, criteria.valid_if):
        criteria, remarks = None, ["the criteria of the scenario do not fit the recording"]
    verdict = judge(
        recording,
        criteria.criteria if criteria is not None else (),
        valid_if=criteria.valid_if if criteria is not None else (),
        scenario=state.scenario,
        seed=state.information.get("seed"),
        versions=state.information.get("versions"),
        errors=[_what_happened(state, stored)],
        remarks=remarks,
    )
    for criterion in verdict.criteria if state.state != ENDED else ():
        criterion.verdict = INCONCLUSIVE
        if criterion.value is not None:
            criterion.reason = "the run did not end: the value is that of the recorded part"
    return verdict


def _arrays(folder: Path, stored: StoredRun) -> RunArrays:
    """Rows that are left, or those of signals.mf4 where the stream was already taken away."""
    return Recording.open(folder) if not stored.rows and (folder / MF4_FILE).is_file() else stored.arrays()


def _what_happened(state: RunState, stored: StoredRun) -> str:
    if state.state == ENDED:
        return "the bench was killed after the run had ended, before its files were complete"
    if state.state == RUNNING:
        return f"the bench was killed while the run was on; recorded up to {stored.last_time_s:.3f} s"
    return f"{state.state}; recorded up to {stored.last_time_s:.3f} s"


def _criteria(folder: Path) -> tuple["CriteriaFile | None", list[str]]:
    """Criteria of the scenario as run, if they can be read."""
    from bench.verdict.criteria_file import CriteriaFile
    from signals.yaml_files import load_yaml

    try:
        data: Any = load_yaml(folder / SCENARIO_FILE).data
        chosen = {name: data[name] for name in ("criteria", "valid_if") if data.get(name) is not None}
        return CriteriaFile.model_validate({"criteria": []} | chosen), []
    except (BenchError, ValueError, AttributeError, TypeError) as error:
        return None, [f"the criteria of {SCENARIO_FILE} could not be read: {str(error).splitlines()[0]}"]


def _report(folder: Path) -> list[str]:
    """Make ``report.html``; a failure leaves the recovered data as they are."""
    try:
        from bench.report import build

        build(folder)
    except Exception as error:
        return [f"report.html could not be made: {error}"]
    return []
