"""The whole bench on vcan: `bench run` in one process, `bench ecu` in another, can-utils as witness and as stranger.

That kernel compiles slowly: run the tests of tests/bench/whole_runs before, so that compiled code is on disk.
"""

import json
import os
import re
import signal
import subprocess
import sys
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import cantools
import numpy as np
import pytest

import bench
from bench.codec.database import shipped_database
from bench.links.frame import ECU, FOREIGN, TRANSMITTED, payload
from bench.recording.frame_file import read_blf
from bench.recording.reading import Recording
from bench.recording.run_folder import FRAME_FILE
from bench.scenario.resolution import resolve

ROOT = Path(__file__).parents[2]
SCENARIOS = ROOT / "tests" / "bench" / "whole_runs"
STOP, STANDING = SCENARIOS / "short_stop.yaml", SCENARIOS / "standing.yaml"
LINE = re.compile(r"\((?P<time>[\d.]+)\) vcan0 (?P<identifier>[0-9A-F]+)#(?P<data>[0-9A-F]*)")
PATIENCE_S = 240.0
FIRST_ANSWER_S = PATIENCE_S / 2
"""Where an ECU does not answer, the bench says so before the test's own patience ends."""
LONGEST_SILENCE_S = PATIENCE_S / 4
"""That kernel has one core for all, on a machine that has other work too: an ECU may wait its turn for seconds."""
NO_LENGTH_OF_OURS = 7
DATABASE = cantools.database.load_file(str(shipped_database()))
ENVIRONMENT = {**os.environ, "PYTHONPATH": str(ROOT)}


def lockstep(**changes: Any) -> bench.Run:
    """The short stop in virtual time, in memory; by default over vcan0 with the ECU in a process of its own."""
    settings = {"pacing": "lockstep", "ecu.kind": "emulated", "ecu.link": "socketcan:vcan0", **changes}
    return bench.run(resolve(STOP, settings), record=False)


def realtime(folder: Path, scenario: Path, *arguments: str) -> "subprocess.Popen[str]":
    """`bench run` by the wall clock; on one shared core an ECU may take long to start."""
    command = [
        "run",
        str(scenario),
        "--realtime",
        "--link",
        "socketcan:vcan0",
        "--out",
        str(folder),
        "--plain",
        "--set",
        f"ecu.first_answer={FIRST_ANSWER_S} s",
        "--set",
        f"ecu.longest_silence={LONGEST_SILENCE_S} s",
        *arguments,
    ]
    return subprocess.Popen(
        [sys.executable, "-m", "bench.cli", *command], stderr=subprocess.PIPE, text=True, env=ENVIRONMENT
    )


def verdict_of(folder: Path, exit_code: int, errors: str) -> Any:
    """The verdict of a run that has ended."""
    file = folder / "verdict.json"
    files = [entry.name for entry in folder.iterdir()] if folder.exists() else []
    assert file.exists(), f"exit code {exit_code}, {files}: {errors}"
    return json.loads(file.read_text())


@pytest.fixture(scope="module")
def in_process() -> bench.Run:
    return lockstep(**{"ecu.kind": "inprocess", "ecu.link": None})


@contextmanager
def running(*command: str, **options: Any) -> Iterator["subprocess.Popen[str]"]:
    process = subprocess.Popen(command, text=True, **options)
    try:
        yield process
    finally:
        process.terminate()
        process.wait()


def until(condition: Callable[[], bool]) -> None:
    end = time.monotonic() + PATIENCE_S
    while not condition():
        assert time.monotonic() < end, "waited in vain"
        time.sleep(0.1)


@contextmanager
def candump(log: Path) -> Iterator[None]:
    """Log vcan0 from a frame that marks the begin."""
    with log.open("w") as file, running("stdbuf", "-oL", "candump", "-L", "-r", "4000000", "vcan0", stdout=file):
        until(lambda: subprocess.run(["cansend", "vcan0", "001#"], check=True) and bool(log.read_text()))
        yield
        time.sleep(0.5)


def witnessed(log: Path) -> dict[int, list[bytes]]:
    """Payloads by identifier as candump saw them."""
    seen: dict[int, list[bytes]] = {}
    for match in map(LINE.match, log.read_text().splitlines()):
        assert match is not None
        seen.setdefault(int(match["identifier"], 16), []).append(bytes.fromhex(match["data"]))
    seen.pop(0x001)
    return seen


def test_lock_step_equals_the_controller_in_process(in_process: bench.Run, tmp_path: Path) -> None:
    """Same signals bit for bit; candump saw each message of the database as often as its period says."""
    with candump(tmp_path / "log"):
        run = lockstep()
    assert run.data.digest() == in_process.data.digest()
    assert run.verdict.verdict == "pass"
    seen, ticks = witnessed(tmp_path / "log"), len(run.data)
    assert sorted(seen) == sorted(message.frame_id for message in DATABASE.messages)
    for message in DATABASE.messages:
        start = message.dbc.attributes.get("GenMsgStartDelayTime")
        due = len(range(start.value if start else 0, ticks, message.cycle_time))
        recorded = [payload(frame) for frame in run.frames[run.frames["identifier"] == message.frame_id]]
        # what the ECU sends in the last tick is on the bus, but no tick of the bench sees it
        assert seen[message.frame_id][: len(recorded)] == recorded, message.name
        assert len(seen[message.frame_id]) == due, message.name
        assert due - len(recorded) <= 1


def test_lock_step_with_cangen_on_the_bus(in_process: bench.Run) -> None:
    """Random frames that cannot be ours: only the bus load differs.

    Among random frames of every length and identifier are some with an identifier and length of ours: with a wrong
    checksum a fault that an ECU has to count, with a right one (one frame in 300 000) a message that it has to believe.
    The slower the machine, the more of them come in a millisecond of virtual time.
    """
    assert all(message.length != NO_LENGTH_OF_OURS for message in DATABASE.messages)
    strangers = ("cangen", "vcan0", "-g", "5", "-i", "-I", "r", "-L")
    with running(*strangers, "r", "-e"), running(*strangers, str(NO_LENGTH_OF_OURS)):
        run = lockstep()
    assert (run.frames["sender"] == FOREIGN).sum() > 100
    assert run.verdict.timing["frames_unknown"] > 100
    assert run.verdict.verdict == in_process.verdict.verdict
    for name in (*(f"valve_{kind}_{wheel}" for kind in ("inlet", "outlet") for wheel in ("fl", "rr")), "pump", "speed"):
        assert np.array_equal(run.data.array(name), in_process.data.array(name)), name


def test_ecu_killed_mid_stop_in_lock_step(in_process: bench.Run) -> None:
    lost = {"ecu.expect": "lost", "ecu.kill": {"signal": "speed", "below": 12.5}}
    run = lockstep(**lost)
    assert not run.verdict.errors
    assert run.verdict.verdict in ("pass", "fail", "inconclusive")
    killed = int(np.argmax(run.data.array("speed") < 12.5))
    assert run.frames["tick"][run.frames["sender"] == ECU].max() == killed - 1
    assert run.data.array("age_valve_pump")[-1] > 0.3


def test_real_time_with_an_ecu_that_somebody_else_started(tmp_path: Path) -> None:
    """Ids and counts at the witness equal the recording's, whose payloads are those on the bus.

    Without signals.mf4, whose library that kernel reads for 15 s.
    """
    settings = "--set", "recording.mf4=false"
    arguments = ("-m", "bench.ecu.process", "--link", "socketcan:vcan0")
    with running(sys.executable, *arguments, env=ENVIRONMENT), candump(tmp_path / "log"):
        run = realtime(tmp_path / "run", STOP, "--ecu", "external", *settings)
        _, errors = run.communicate(timeout=PATIENCE_S)
    verdict = verdict_of(tmp_path / "run", run.returncode, errors)
    assert not verdict.get("errors"), errors
    # a slow kernel may be late too often
    assert run.returncode == {"pass": 0, "inconclusive": 3}[verdict["verdict"]]
    frames, seen = read_blf(tmp_path / "run" / FRAME_FILE), witnessed(tmp_path / "log")
    assert sorted(seen) == sorted(message.frame_id for message in DATABASE.messages)
    by_us = (frames["flags"] & TRANSMITTED) != 0
    for message in DATABASE.messages:
        of_message = frames["identifier"] == message.frame_id
        recorded = [payload(frame) for frame in frames[of_message]]
        if "BENCH" in message.senders:
            assert by_us[of_message].all()
            assert seen[message.frame_id] == recorded, message.name
        else:  # the ECU was there before the run and after it
            assert not by_us[of_message].any()
            assert contains(seen[message.frame_id], recorded), message.name
    assert verdict["timing"]["link"]["overflows"] == 0
    assert verdict["timing"]["link"]["timestamp_source"]


def contains(whole: list[bytes], part: list[bytes]) -> bool:
    """Whether a sequence lies in another one without gaps."""
    return any(whole[i : i + len(part)] == part for i in range(len(whole) - len(part) + 1))


def test_real_time_kill_of_the_emulated_ecu(tmp_path: Path) -> None:
    """`kill -9` while the scenario wants it alive: verdict error, exit code 4, recording kept; cangen beside it."""
    frames = tmp_path / "run" / FRAME_FILE
    with running("cangen", "vcan0", "-g", "5", "-i", "-I", "r", "-L", "r"):
        run = realtime(tmp_path / "run", STANDING, "--ecu", "emulated")
        until(lambda: run.poll() is not None or (frames.exists() and frames.stat().st_size > 20_000))
        for pid in Path(f"/proc/{run.pid}/task/{run.pid}/children").read_text().split():
            if "bench.ecu" in Path(f"/proc/{pid}/cmdline").read_text():
                os.kill(int(pid), signal.SIGKILL)
        _, errors = run.communicate(timeout=PATIENCE_S)
    verdict = verdict_of(tmp_path / "run", run.returncode, errors)
    assert (verdict["verdict"], run.returncode) == ("error", 4), errors
    assert "the emulated ECU ended during the run (exit code -9)" in "".join(verdict["errors"])
    recording = Recording.open(tmp_path / "run")
    assert len(recording.frames) > 100
    assert len(recording.time) > 0
