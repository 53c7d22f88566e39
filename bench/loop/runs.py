"""A run from its resolved scenario to its verdict, in memory or recorded."""

import os
import time
from collections.abc import Callable
from contextlib import nullcontext, suppress
from pathlib import Path
from typing import Any

import numpy as np

from bench.api import Run
from bench.links.frame import FRAME_DTYPE
from bench.loop.children import Child, on_helper_cores, start_module
from bench.loop.connection import Connection, connect, with_link
from bench.loop.memory import MemoryRecorder
from bench.loop.pacing import LockstepPacer, RealtimePacer, TickTimes
from bench.loop.scheduling import SchedulingReport, plan_cores, real_time_process
from bench.loop.session import Pacer, Parts, Session, build_parts, timing_extras
from bench.loop.timing import summarise
from bench.loop.versions import versions
from bench.loop.warm_up import Rehearsal, warm_up
from bench.recording.arrays import RunArrays
from bench.recording.run_folder import FileChoice, append_log
from bench.recording.schema import RunSchema
from bench.recording.session import RecordingSession
from bench.scenario import dump
from bench.scenario.schema import ScenarioFile
from bench.verdict.judge import judge
from bench.verdict.output_files import write_verdict
from bench.verdict.result import Verdict
from signals.errors import BenchError, InputError

FOLDER_TIME = "%Y%m%d-%H%M%S"
DASHBOARD_END_TIMEOUT_S = 3.0


def make_pacer(scenario: ScenarioFile, ticks: int) -> Pacer:
    """The pacer that a scenario asks for."""
    return LockstepPacer(ticks) if scenario.pacing == "lockstep" else RealtimePacer(ticks)


def run_in_memory(scenario: ScenarioFile, *, keep_frames: bool = True) -> Run:
    """Run without files; an error is raised instead of becoming a verdict."""
    rehearsal = None
    if scenario.pacing == "realtime" or scenario.ecu.kind == "emulated":
        # neither a clock nor a process that waits has time for compiling
        rehearsal = warm_up(scenario, lambda text: None)
    parts = build_parts(scenario)
    recorder = MemoryRecorder(parts.ticks, len(parts.vector.names), keep_frames)
    connection = connect(scenario, parts.codec, plan_cores())
    pacer = make_pacer(scenario, parts.ticks)
    began = time.perf_counter()
    realtime = scenario.pacing == "realtime"
    try:
        session = Session(parts, connection)
        cores = plan_cores()
        with (
            real_time_process(cores, fifo=not cores.shared)
            if realtime
            else nullcontext(SchedulingReport()) as scheduling
        ):
            session.run(recorder, pacer, rehearsal.go_on if rehearsal is not None and realtime else None)
    finally:
        connection.close()
    timing = _timing(parts, pacer, connection, scheduling, session.ticks_done, time.perf_counter() - began)
    data = RunArrays.from_matrix(
        recorder.rows, parts.vector.signals, phase_names=parts.manoeuvre.phase_names, timing=timing
    )
    verdict = _judge(scenario, data, [], [])
    return Run(scenario, verdict, data, recorder.frames)


def run_recorded(
    scenario: ScenarioFile,
    out: Path | None,
    *,
    dashboard: bool = False,
    progress: Callable[[str], None] | None = None,
    fifo: bool = True,
    times: list[TickTimes] | None = None,
) -> Run:
    """Run with recording, helper processes, verdict and report; a failure on the way is the verdict "error".

    Parameters
    ----------
    fifo : bool
        False does without SCHED_FIFO.
    times : list, optional
        Receives the times of all ticks of a real-time run.
    """
    say = progress or (lambda text: None)
    say("building the car")
    rehearsal = warm_up(scenario, say)
    parts = build_parts(scenario)
    folder = out if out is not None else default_folder(scenario)
    recorded = _RecordedRun(scenario, parts, rehearsal, folder, dashboard, say, fifo)
    try:
        return recorded.run()
    finally:
        if times is not None:
            times.append(recorded.times)


def default_folder(scenario: ScenarioFile) -> Path:
    """``runs/<scenario>-<time>``, with a number behind it where that is taken."""
    stem = f"{scenario.id.replace('/', '-') or 'run'}-{time.strftime(FOLDER_TIME)}"
    for name in (stem, *(f"{stem}-{number}" for number in range(2, 1000))):
        if not (Path("runs") / name).exists():
            return Path("runs") / name
    raise InputError("runs: a thousand runs of one scenario in one second", mend="give a folder: --out DIR")


class _RecordedRun:
    """State of one recorded run between its steps."""

    def __init__(
        self,
        scenario: ScenarioFile,
        parts: Parts,
        rehearsal: Rehearsal,
        folder: Path,
        dashboard: bool,
        say: Callable[[str], None],
        fifo: bool,
    ) -> None:
        self._fifo = fifo
        self._scenario = scenario
        self._wired = with_link(scenario)
        self._parts = parts
        self._rehearsal = rehearsal
        self._folder = folder
        self._dashboard = dashboard
        self._say = say
        self._cores = plan_cores()
        self._scheduling = SchedulingReport()
        self._pacer = make_pacer(scenario, parts.ticks)
        self._errors: list[str] = []
        self._interrupted = False
        self._ticks_done = 0
        self._wall_s = 0.0

    @property
    def times(self) -> TickTimes:
        """Times of the ticks so far."""
        return self._pacer.times

    def run(self) -> Run:
        """From the first process to the sealed folder."""
        recording = self._start_recording()
        self._folder = recording.folder
        connection: Connection | None = None
        dashboard: Child | None = None
        log = (recording.folder / "log.txt").open("ab")
        try:
            connection = connect(self._wired, self._parts.codec, self._cores, log)
            connection.side.origin_ns = recording.writer.schema.start_time_ns
            if self._dashboard:
                dashboard = self._start_dashboard(recording)
            self._loop(recording, connection)
        except KeyboardInterrupt:
            self._interrupted = True
            self._errors.append("interrupted")
        except BenchError as error:
            self._errors.append(str(error))
            self._log(f"error: {error}")
        except Exception as error:
            self._errors.append(f"{type(error).__name__}: {error}")
            self._log_traceback(error)
        finally:
            log.close()
        return self._finish(recording, connection, dashboard)

    def _start_recording(self) -> RecordingSession:
        scenario, parts = self._scenario, self._parts
        realtime = scenario.pacing == "realtime"
        information = {"seed": scenario.seed, "mode": scenario.pacing, "versions": versions()}
        schema = RunSchema.of(
            parts.vector.signals,
            phase_names=parts.manoeuvre.phase_names,
            start_time_ns=time.time_ns() if realtime else 0,
            information={
                **information,
                "time_limit_s": scenario.time_limit,
                "ecu": scenario.ecu.kind,
                "link": self._wired.ecu.link,
            },
        )
        return RecordingSession.start(
            self._folder,
            schema,
            scenario=scenario.id,
            scenario_text=dump(scenario),
            flow_control=not realtime,
            files=_files(scenario),
            cores=self._cores,
            information=information,
        )

    def _start_dashboard(self, recording: RecordingSession) -> Child:
        with on_helper_cores(self._cores):
            return start_module(
                "dashboard",
                "bench.dashboard",
                [str(recording.writer.path), "--parent", str(os.getpid())],
                terminal=True,
            )

    def _loop(self, recording: RecordingSession, connection: Connection) -> None:
        session = Session(self._parts, connection)
        realtime = self._scenario.pacing == "realtime"
        began = time.perf_counter()
        try:
            with (
                # on the only core a loop that is late would never let its helpers and the ECU run
                real_time_process(self._cores, fifo=self._fifo and not self._cores.shared)
                if realtime
                else nullcontext(SchedulingReport()) as report
            ):
                self._scheduling = report
                session.run(recording, self._pacer, self._rehearsal.go_on if realtime else None)
        finally:
            self._wall_s = time.perf_counter() - began
            self._ticks_done = session.ticks_done

    def _log(self, text: str) -> None:
        with suppress(OSError):
            append_log(self._folder, text)

    def _log_traceback(self, error: Exception) -> None:
        import traceback

        self._log("".join(traceback.format_exception(error)))

    def _finish(self, recording: RecordingSession, connection: Connection | None, dashboard: Child | None) -> Run:
        ecu_code = connection.close() if connection is not None else None
        timing: dict[str, Any] = {}
        if connection is not None:
            timing = _timing(
                self._parts, self._pacer, connection, self._scheduling, self._ticks_done, self._wall_s, ecu_code
            )
        if self._parts.injector is not None:
            with suppress(OSError):
                append_log(self._folder, "\n".join(self._parts.injector.log_lines()))
        outcome = recording.stop(cores=self._cores)
        if dashboard is not None and dashboard.wait(DASHBOARD_END_TIMEOUT_S) is None:
            dashboard.stop()
        # the loop may have ended for that very reason, and told it with what mends it
        if outcome.problem and not any(outcome.problem.startswith(told.splitlines()[0]) for told in self._errors):
            self._errors.append(outcome.problem)
        if outcome.rows_lost or outcome.frames_lost:
            self._errors.append(f"recording lost {outcome.rows_lost} rows and {outcome.frames_lost} frames")
        timing["recording"] = {"rows": outcome.rows, "frames": outcome.frames}
        data = self._recorded_data(timing)
        verdict = _judge(self._scenario, data, self._errors, self._scheduling.remarks)
        with suppress(OSError):
            write_verdict(self._folder, verdict)
            self._build_report(data)
        recording.seal()
        if self._interrupted:
            raise KeyboardInterrupt(str(self._folder))
        return Run(self._scenario, verdict, data, np.zeros(0, FRAME_DTYPE), self._folder)

    def _recorded_data(self, timing: dict[str, Any]) -> RunArrays:
        """Rows as recorded: the verdict is on what the files hold, not on what memory held."""
        from bench.recording.stored_rows import read_stored

        stored = read_stored(self._folder)
        values = [block for _, _, block in stored.rows]
        width = len(self._parts.vector.signals)
        matrix = np.concatenate(values) if values else np.zeros((0, width))
        return RunArrays.from_matrix(
            matrix, self._parts.vector.signals, phase_names=self._parts.manoeuvre.phase_names, timing=timing
        )

    def _build_report(self, data: RunArrays) -> None:
        from bench.report import build

        try:
            build(self._folder, signals=data)
        except Exception as error:
            self._log_traceback(error)
            self._say(f"the report could not be made ({error}); see {self._folder / 'log.txt'}")


def _files(scenario: ScenarioFile) -> FileChoice:
    wanted = scenario.recording
    return FileChoice(wanted.mf4, wanted.blf, wanted.asc, tuple(wanted.signals))


def _timing(
    parts: Parts,
    pacer: Pacer,
    connection: Connection,
    scheduling: SchedulingReport,
    ticks: int,
    wall_s: float,
    ecu_exit_code: int | None = None,
) -> dict[str, Any]:
    """Timing block of ``verdict.json``."""
    timing: dict[str, Any] = {
        "mode": pacer.mode,
        "real_time_factor": ticks * 1e-3 / wall_s if wall_s > 0 else 0.0,
        "ticks": ticks,
        **summarise(pacer.times),
        "scheduler": scheduling.scheduler,
        "memory_locked": scheduling.memory_locked,
        "cores": scheduling.cores,
        "link": {"text": connection.link_text, **connection.statistics()},
        **timing_extras(parts),
    }
    if ecu_exit_code is not None:
        timing["ecu_exit_code"] = ecu_exit_code
    return timing


def _judge(scenario: ScenarioFile, data: RunArrays, errors: list[str], remarks: list[str]) -> Verdict:
    return judge(
        data,
        scenario.criteria,
        valid_if=scenario.valid_if,
        scenario=scenario.id,
        seed=scenario.seed,
        versions=versions(),
        errors=errors,
        remarks=remarks,
    )
