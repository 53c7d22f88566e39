"""kill -9 at any instant of the loop, the recorder or both: everything comes back but at most the last second."""

import json
import os
import random
import signal
import subprocess
import sys
import time
from pathlib import Path

import numpy as np
import pytest
from synthetic_loop import FRAMES_PER_TICK, SIGNALS, frame_numbers, rows

from bench.recording.reading import Recording
from bench.recording.recover import recover
from bench.recording.ring import RingReader
from bench.recording.run_folder import (
    FINISHED_FILES,
    STREAM_FILE,
    RunState,
    create_run_folder,
    read_state,
    write_state,
)
from signals.errors import InputError

PROGRAM = Path(__file__).with_name("synthetic_loop.py")
MANDATORY = set(FINISHED_FILES) - {"report.html"}


class Victim:
    """A synthetic run in a process of its own."""

    def __init__(self, folder: Path, mode: str, ticks: int = 10**9) -> None:
        self.folder = folder
        command = [sys.executable, str(PROGRAM), str(folder), mode, str(ticks)]
        environment = os.environ | {"PYTHONPATH": str(PROGRAM.parents[3])}
        self.process = subprocess.Popen(command, stdout=subprocess.PIPE, env=environment, text=True)
        assert self.process.stdout is not None
        self.process.stdout.readline()

    def recorder(self) -> int:
        """Wait for the recorder; its process number."""
        assert self.process.stdout is not None
        return int(self.process.stdout.readline())

    def kill(self) -> None:
        self.process.kill()
        self.process.wait()


def gone(pid: int) -> bool:
    """Wait for a process that is not our child to end."""
    for _ in range(500):
        try:
            state = Path(f"/proc/{pid}/stat").read_text().rsplit(")", 1)[1].split()[0]
        except OSError:
            return True
        if state == "Z":
            return True
        time.sleep(0.01)
    return False


def ring_of(folder: Path) -> Path:
    state = read_state(folder)
    assert state is not None
    return Path(state.ring)


def check_finished(folder: Path, at_least_rows: int, at_least_frames: int) -> Recording:
    names = {path.name for path in folder.iterdir()}
    assert names >= MANDATORY
    assert names <= set(FINISHED_FILES)
    verdict = json.loads((folder / "verdict.json").read_text())
    assert verdict["verdict"] == "error"
    recording = Recording.open(folder)
    assert len(recording) >= at_least_rows
    assert len(recording.frames) >= at_least_frames
    expected = rows(len(recording))
    assert all(np.array_equal(recording.array(s.name), expected[:, i]) for i, s in enumerate(SIGNALS))
    assert np.array_equal(frame_numbers(recording.frames), np.arange(len(recording.frames)))
    return recording


@pytest.mark.parametrize("who", ["loop", "recorder", "all"])
@pytest.mark.parametrize(("mode", "seed"), [("lockstep", 1), ("lockstep", 2), ("realtime", 3), ("realtime", 4)])
def test_a_killed_run_comes_back(tmp_path: Path, who: str, mode: str, seed: int) -> None:
    victim = Victim(tmp_path / "run", mode)
    recorder = victim.recorder()
    time.sleep(random.Random(f"{who}{seed}").uniform(0.0, 0.6))
    if who in ("recorder", "all"):
        os.kill(recorder, signal.SIGKILL)
    if who == "recorder":
        time.sleep(0.1)
    victim.kill()
    assert gone(recorder)
    ring = RingReader(ring_of(victim.folder))
    written, frames = ring.rows_written, ring.frames_written
    recovery = recover(victim.folder)
    # the ring holds whatever the files lack, so not even the last second is lost
    check_finished(victim.folder, written, frames)
    assert (recovery.rows, recovery.frames) == (written, frames)
    assert not ring.path.exists()
    if who == "recorder":
        assert written > 0


@pytest.mark.parametrize("seed", range(3))
def test_without_the_ring_at_most_a_second_is_lost(tmp_path: Path, seed: int) -> None:
    victim = Victim(tmp_path / "run", "realtime")
    recorder = victim.recorder()
    time.sleep(random.Random(seed).uniform(0.3, 0.9))
    os.kill(recorder, signal.SIGKILL)
    victim.kill()
    path = ring_of(victim.folder)
    written = RingReader(path).rows_written
    path.unlink()
    recover(victim.folder)
    check_finished(victim.folder, written - 1000, FRAMES_PER_TICK * (written - 1000))


@pytest.mark.parametrize("seed", range(4))
def test_killed_while_starting(tmp_path: Path, seed: int) -> None:
    victim = Victim(tmp_path / "run", "lockstep")
    time.sleep(random.Random(seed).uniform(0.0, 0.35))
    victim.kill()
    time.sleep(0.2)
    if not victim.folder.exists():
        # killed before the folder: no run has begun
        return
    recover(victim.folder)
    check_finished(victim.folder, 0, 0)


def test_killed_while_finishing(tmp_path: Path) -> None:
    # from the end of the run (1 000 ticks) to the sealed folder: conversion, verdict, removal
    for attempt, delay in enumerate(np.linspace(0.05, 1.5, 4)):
        folder = tmp_path / f"run{attempt}"
        victim = Victim(folder, "finish", ticks=1000)
        victim.recorder()
        time.sleep(delay)
        victim.kill()
        time.sleep(0.3)
        if read_state(folder) is None:
            assert json.loads((folder / "verdict.json").read_text())["verdict"] == "pass"
            continue
        ring = ring_of(folder)
        left = RingReader(ring) if ring.exists() else None
        written, frames = (left.rows_written, left.frames_written) if left else (1000, FRAMES_PER_TICK * 1000)
        recover(folder)
        check_finished(folder, written, frames)


def test_recovery_is_idempotent_and_can_itself_be_killed(tmp_path: Path) -> None:
    victim = Victim(tmp_path / "run", "lockstep")
    victim.recorder()
    time.sleep(0.3)
    victim.kill()
    time.sleep(0.5)
    for delay in (0.3, 0.9, 1.3):
        code = f"from bench.recording.recover import recover; recover({str(victim.folder)!r})"
        process = subprocess.Popen([sys.executable, "-c", code], cwd=PROGRAM.parents[3])
        time.sleep(delay)
        process.kill()
        process.wait()
    first = recover(victim.folder)
    recording = check_finished(victim.folder, first.rows, first.frames)
    content = {path.name: path.read_bytes() for path in victim.folder.iterdir()}
    assert recover(victim.folder).already_finished
    assert {path.name: path.read_bytes() for path in victim.folder.iterdir()} == content
    assert len(recording) > 0


def test_the_last_steps_of_a_finished_run_keep_its_recording(tmp_path: Path) -> None:
    # run.json was the only thing left to remove
    victim = Victim(tmp_path / "run", "finish", ticks=200)
    victim.recorder()
    victim.process.wait()
    before = (victim.folder / "signals.mf4").read_bytes()
    write_state(victim.folder, RunState("synthetic", "", pid=1, process_start=1, started="", state="ended"))
    recover(victim.folder)
    assert (victim.folder / "signals.mf4").read_bytes() == before
    check_finished(victim.folder, 200, 400)


def test_the_verdict_of_a_killed_run_shows_its_figures_as_open(tmp_path: Path) -> None:
    victim = Victim(tmp_path / "run", "lockstep", ticks=10**9)
    victim.recorder()
    time.sleep(0.2)
    victim.kill()
    time.sleep(0.3)
    recover(victim.folder)
    verdict = json.loads((victim.folder / "verdict.json").read_text())
    fast, ends = verdict["criteria"]
    assert (fast["verdict"], ends["verdict"]) == ("inconclusive", "inconclusive")
    assert fast["requirement"] == "R-1"
    assert fast["value"] > 0
    assert "did not end" in fast["reason"]
    assert verdict["seed"] == 5
    assert verdict["versions"] == {"bench": "0.1"}
    assert "killed while the run was on" in verdict["errors"][0]
    assert "<error" in (victim.folder / "junit.xml").read_text()
    assert "recovered" in (victim.folder / "log.txt").read_text()


def test_a_run_that_is_on_is_left_alone(tmp_path: Path) -> None:
    create_run_folder(tmp_path / "run", scenario="s", scenario_text="name: s\n")
    with pytest.raises(InputError, match="still on"):
        recover(tmp_path / "run")


@pytest.mark.parametrize("name", ["missing", "empty"])
def test_another_folder_is_refused(tmp_path: Path, name: str) -> None:
    (tmp_path / "empty").mkdir()
    with pytest.raises(InputError):
        recover(tmp_path / name)
    assert not (tmp_path / "empty" / STREAM_FILE).exists()
