"""`bench run` as a user starts it: in real time over the default link, with a wrong link, and interrupted."""

import json
import os
import signal
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from bench.links.available import kernel_has_can
from bench.links.frame import TRANSMITTED
from bench.recording.reading import Recording
from bench.recording.run_folder import FINISHED_FILES
from bench.verdict.result import EXIT_CODES

HERE = Path(__file__).parent
SHORT_STOP, STANDING = str(HERE / "short_stop.yaml"), str(HERE / "standing.yaml")


@pytest.mark.real_time
def test_real_time_over_the_default_link(bench_command: Callable[..., Any], tmp_path: Path) -> None:
    """Exit code as the verdict says, every file there, and the timing block complete."""
    process = bench_command("run", SHORT_STOP, "--realtime", "--ecu", "emulated", "--out", "run", "--json")
    code, out, _ = process.end()
    printed = json.loads(out)
    folder = tmp_path / "run"
    verdict = json.loads((folder / "verdict.json").read_text())
    assert {path.name for path in folder.iterdir()} == set(FINISHED_FILES)
    assert printed.pop("folder") == str(folder)
    assert printed == verdict
    assert verdict["verdict"] in ("pass", "inconclusive")  # a busy machine may be late too often
    assert code == EXIT_CODES[verdict["verdict"]]

    timing, recording = verdict["timing"], Recording.open(folder)
    assert timing["mode"] == "realtime"
    assert timing["ticks"] == len(recording) == timing["recording"]["rows"]
    for times in ("lateness_us", "tick_cpu_us", "tick_duration_us"):
        assert sorted(timing[times]) == ["max", "p50", "p99", "p999"]
        assert 0 <= timing[times]["p50"] <= timing[times]["p99"] <= timing[times]["p999"] <= timing[times]["max"]
    assert timing["late_ticks"] == timing["late_ticks_ours"] + timing["late_ticks_machine"]
    assert timing["late_ticks"] == np.sum(recording.array("lateness") > 1e-3)
    assert timing["lateness_us"]["max"] == pytest.approx(recording.array("lateness").max() * 1e6, rel=1e-9)
    assert {"overruns", "skipped_ticks", "scheduler", "memory_locked", "cores", "ecu_exit_code"} <= timing.keys()
    assert timing["ecu_exit_code"] == 0

    link, frames = timing["link"], recording.frames
    by_us = (frames["flags"] & TRANSMITTED) != 0
    assert link["sent"] == by_us.sum()
    assert timing["recording"]["frames"] == len(frames)
    assert link["received"] >= (~by_us).sum()  # those that came before the first tick are not recorded
    assert (link["overflows"], link["malformed"], link["send_refused"]) == (0, 0, 0)
    assert link["timestamp_source"]
    from_ecu = timing["frames_from_ecu"]["VALVE_PUMP"]
    assert from_ecu["accepted"] == np.sum(frames["identifier"] == 0x210)
    assert (from_ecu["crc_errors"], timing["frames_unknown"], timing["frames_rejected"]) == (0, 0, 0)


WRONG_LINKS = [
    pytest.param(("--link", "socketcan:nope"), 4, "nope", id="no_such_interface"),
    pytest.param(("--link", "slcan:/dev/none", "--realtime"), 4, "/dev/none: no such serial device", id="no_device"),
    pytest.param(("--link", "virtual", "--ecu", "emulated"), 2, "virtual link reaches no other process", id="virtual"),
    pytest.param(
        ("--link", "udp_loopback", "--lockstep", "--ecu", "external"), 2, "it has its own clock", id="external_lockstep"
    ),
    pytest.param(("--link", "slcan:/dev/none", "--lockstep"), 2, "keeps its own time", id="slcan_lockstep"),
    pytest.param(("--link", "socketcam:can0"), 2, "did you mean socketcan", id="misspelt"),
    pytest.param(("--link", "udp:239.1.1.1:http"), 2, "'http' is no number", id="no_number"),
    pytest.param(("--link", "udp_loopback", "--ecu", "inprocess"), 2, "needs no link", id="link_and_inprocess"),
]


@pytest.mark.parametrize(("arguments", "code", "message"), WRONG_LINKS)
def test_wrong_link_ends_in_one_message(
    arguments: tuple[str, ...], code: int, message: str, bench_command: Callable[..., Any], tmp_path: Path
) -> None:
    ended, _, errors = bench_command("run", SHORT_STOP, *arguments, "--plain").end()
    assert (ended, errors.count("error:")) == (code, 1), errors
    assert message in errors
    assert "Traceback" not in errors
    assert len(errors.splitlines()) <= 6
    assert list(tmp_path.iterdir()) == []  # nothing ran, nothing is left


@pytest.mark.skipif(kernel_has_can() or os.name != "posix", reason="this kernel has CAN")
def test_no_can_in_the_kernel_names_the_command_that_mends_it(bench_command: Callable[..., Any]) -> None:
    _, _, errors = bench_command("run", SHORT_STOP, "--link", "socketcan:vcan0").end()
    assert "sudo modprobe can-raw vcan" in errors
    assert "--link udp" in errors


def test_a_recorder_that_dies_is_told_once(bench_command: Callable[..., Any], tmp_path: Path) -> None:
    """`kill -9` of the recorder's process: verdict error with one message and what mends it, recording kept."""
    folder = tmp_path / "run"
    process = bench_command("run", STANDING, "--lockstep", "--ecu", "inprocess", "--out", "run", "--plain")
    process.wait_until_recorded(folder)
    recorder = next(pid for pid, line in process.children().items() if "recorder" in line)
    os.kill(recorder, signal.SIGKILL)
    code, out, errors = process.end()
    assert code == 4
    assert "Traceback" not in out + errors + (folder / "log.txt").read_text()
    verdict = json.loads((folder / "verdict.json").read_text())
    assert verdict["verdict"] == "error"
    (told,) = verdict["errors"]
    assert "the recorder ended before the run did" in told
    assert len(Recording.open(folder)) > 0


@pytest.mark.parametrize("pacing", [pytest.param("realtime", marks=pytest.mark.real_time), "lockstep"])
def test_interrupted(pacing: str, bench_command: Callable[..., Any], tmp_path: Path) -> None:
    """Ctrl-C: exit code 130, and a finished folder whose verdict says so."""
    folder = tmp_path / "run"
    how = [f"--{pacing}", "--ecu", "emulated", "--link", "udp_loopback", "--out", "run"]
    process = bench_command("run", STANDING, *how)
    process.wait_until_recorded(folder)
    process.interrupt()
    code, out, errors = process.end()
    assert code == 130
    assert f"interrupted; the recording is in {folder}" in errors
    assert "Traceback" not in out + errors + (folder / "log.txt").read_text()
    verdict = json.loads((folder / "verdict.json").read_text())
    assert (verdict["verdict"], verdict["errors"]) == ("error", ["interrupted"])
    assert {path.name for path in folder.iterdir()} == set(FINISHED_FILES)
    assert len(Recording.open(folder)) > 300
