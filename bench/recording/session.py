"""Recording of one run, as the loop's side sees it: folder, ring, recorder process, and the files at the end.

>>> session = RecordingSession.start(folder, schema, scenario="stops/dry", scenario_text=text, flow_control=True)
>>> session.write_row(values, tick)
>>> session.write_frames(frames, count)
>>> outcome = session.stop()          # recorder has drained the ring; signals.mf4 is made
>>> write_verdict(folder, verdict)    # and the report
>>> session.seal()                    # the folder is finished
"""

import os
import time
from collections.abc import Callable, Mapping
from contextlib import nullcontext
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from bench.loop.children import Child, start_module
from bench.loop.scheduling import CorePlan
from bench.recording.ring import RECORDING, STARTING, RingWriter, place_for_ring, ring_size
from bench.recording.run_folder import (
    ENDED,
    LOG_FILE,
    MF4_FILE,
    RESERVE_FILE,
    FileChoice,
    RunState,
    append_log,
    create_run_folder,
    remove_orphaned_rings,
    remove_running_files,
    write_state,
)
from bench.recording.schema import RunSchema
from signals.errors import RunError

START_TIMEOUT_S = 120.0
DRAIN_TIMEOUT_S = 60.0
CONVERT_TIMEOUT_S = 300.0


@dataclass(frozen=True)
class RecordingOutcome:
    """What became of a recording.

    Attributes
    ----------
    rows, frames, rows_lost, frames_lost : int
        Written by the loop; overwritten before the recorder could take them.
    problem : str
        Empty if the recording is whole; else what went wrong, for the verdict "error".
    """

    rows: int
    frames: int
    rows_lost: int
    frames_lost: int
    problem: str


class RecordingSession:
    """Ring, recorder process and folder of one run. Start it with :meth:`start`."""

    def __init__(self, folder: Path, state: RunState, writer: RingWriter, recorder: Child) -> None:
        self.folder = folder
        self.writer = writer
        self.recorder = recorder
        self.write_row: Callable[[NDArray[np.float64], int], None] = writer.write_row
        self.write_frames: Callable[[NDArray[np.void], int], None] = writer.write_frames
        self._state = state
        self._outcome: RecordingOutcome | None = None
        writer.recorder_alive = lambda: recorder.exit_code is None

    @classmethod
    def start(
        cls,
        folder: Path,
        schema: RunSchema,
        *,
        scenario: str,
        scenario_text: str,
        flow_control: bool,
        files: FileChoice | None = None,
        cores: CorePlan | None = None,
        information: Mapping[str, Any] | None = None,
    ) -> "RecordingSession":
        """Make the folder and the ring, start the recorder and wait until it records.

        Parameters
        ----------
        folder : Path
            The run's folder; it must not exist, or be empty.
        flow_control : bool
            True in lock-step: the loop waits when the recorder is behind.
        files : FileChoice, optional
            Files to leave; by default MF4 with every signal and BLF.
        cores : CorePlan, optional
            The recorder runs on its helper cores.
        information : mapping, optional
            Plain data for a recovered verdict: seed, mode, versions.

        Raises
        ------
        InputError
            If the folder is in use.
        RunError
            If there is no room, or the recorder does not start.
        """
        folder = folder.absolute()
        remove_orphaned_rings()
        state = create_run_folder(
            folder, scenario=scenario, scenario_text=scenario_text, files=files, information=information
        )
        schema = replace(schema, information={"scenario": scenario, "run_dir": str(folder)} | schema.information)
        ring_path = place_for_ring(folder, ring_size(len(schema.signals)))
        state.ring = str(ring_path)
        write_state(folder, state)
        writer = RingWriter(ring_path, schema, flow_control=flow_control)
        arguments = ["--ring", str(ring_path), "--out", str(folder), "--parent", str(os.getpid())]
        arguments += [f"--{name}" for name in ("blf", "asc") if getattr(state.files, name)]
        with _on(cores), (folder / LOG_FILE).open("ab") as log:
            recorder = start_module("recorder", "bench.recording.recorder", arguments, log=log)
        session = cls(folder, state, writer, recorder)
        session._wait_for_recorder()
        return session

    def _wait_for_recorder(self) -> None:
        deadline = time.monotonic() + START_TIMEOUT_S
        while self.writer.recorder_state == STARTING and self.recorder.exit_code is None:
            if time.monotonic() > deadline:
                break
            time.sleep(2e-3)
        if self.writer.recorder_state != RECORDING:
            self.recorder.stop()
            reason = self.writer.error or f"see {self.folder / LOG_FILE}"
            raise RunError(f"the recorder did not start: {reason}")

    def problem(self) -> str:
        """What is wrong with the recording right now; empty if nothing is."""
        if self.writer.error:
            return f"recording failed: {self.writer.error}"
        if self._outcome is None and self.recorder.exit_code is not None:
            return f"the recorder ended before the run did (exit code {self.recorder.exit_code})"
        return ""

    def stop(self, *, convert: bool = True, cores: CorePlan | None = None) -> RecordingOutcome:
        """End the recording: the recorder takes what is left, then another process makes ``signals.mf4``.

        Never raises for a failed recording: the outcome says what went wrong, and what was recorded stays in the folder
        for ``bench recover``.
        """
        if self._outcome is not None:
            return self._outcome
        problem = self.problem()
        self.writer.close()
        if not problem and self.recorder.wait(DRAIN_TIMEOUT_S) is None:
            problem = f"the recorder did not finish within {DRAIN_TIMEOUT_S:.0f} s"
        exit_code = self.recorder.stop()
        if not problem and exit_code != 0:
            problem = self.writer.error or f"the recorder ended with exit code {exit_code}"
        if not problem:
            self._state.state = ENDED
            write_state(self.folder, self._state)
            problem = self._convert(cores) if convert and self._state.files.mf4 else ""
        if problem:
            (self.folder / RESERVE_FILE).unlink(missing_ok=True)
            append_log(self.folder, f"error: {problem}")
        self._outcome = RecordingOutcome(**self.writer.statistics(), problem=problem)
        return self._outcome

    def _convert(self, cores: CorePlan | None) -> str:
        with _on(cores), (self.folder / LOG_FILE).open("ab") as log:
            converter = start_module(
                "converter", "bench.recording.convert", [str(self.folder), str(os.getpid())], log=log
            )
        exit_code = converter.wait(CONVERT_TIMEOUT_S)
        if exit_code is None:
            converter.stop()
            return f"{MF4_FILE} was not made within {CONVERT_TIMEOUT_S:.0f} s"
        return "" if exit_code == 0 else f"{MF4_FILE} could not be made (see {LOG_FILE})"

    def seal(self) -> None:
        """Take away the files of a running recording: the folder is finished.

        After a failed recording they stay, so that ``bench recover`` can make the missing files once there is room.
        """
        outcome = self.stop()
        if outcome.problem:
            self._state.state = outcome.problem
            write_state(self.folder, self._state)
            return
        remove_running_files(self.folder, self.writer.path)


def _on(cores: CorePlan | None) -> Any:
    from bench.loop.children import on_helper_cores

    return nullcontext() if cores is None else on_helper_cores(cores)
