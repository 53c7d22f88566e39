"""An ECU that is killed, hangs, or never answers: the verdict that the scenario asks for, never a crash."""

import json
import os
import signal
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import bench
from bench.links.frame import ECU
from bench.recording.reading import Recording
from bench.recording.run_folder import FINISHED_FILES
from bench.scenario.schema import ScenarioFile
from signals.errors import RunError

STANDING = str(Path(__file__).parent / "standing.yaml")
KILL_SPEED = 45 / 3.6
KILLED = {"expect": "lost", "kill": {"signal": "speed", "below": KILL_SPEED}}
APART = {"kind": "emulated", "link": "udp_loopback"}


def test_killed_mid_stop_is_judged_and_definite(short_stop: Callable[..., ScenarioFile]) -> None:
    """A controller in this process and one in its own are lost in the same tick; the valves stay as they were."""
    one, other = (bench.run(short_stop(ecu=KILLED | kind), record=False) for kind in ({}, APART))
    assert one.verdict.verdict in ("pass", "fail", "inconclusive")
    assert not one.verdict.errors
    assert one.data.digest() == other.data.digest()
    killed = int(np.argmax(one.data.array("speed") < KILL_SPEED))
    assert 0 < killed < len(one.data) - 200
    # what the ECU sent in the tick before the kill was seen in the tick of the kill
    assert one.frames["tick"][one.frames["sender"] == ECU].max() == killed - 1
    after = [one.data.array(f"valve_{kind}_{wheel}")[killed:] for kind in ("inlet", "outlet") for wheel in ("fl", "rr")]
    assert [np.ptp(valve) for valve in after] == [0.0] * 4
    # the valve frame's period is 5 ms
    assert one.data.array("age_valve_pump")[-1] == pytest.approx((len(one.data) - killed) * 1e-3, abs=6e-3)


@pytest.mark.real_time
def test_killed_mid_stop_in_real_time(short_stop: Callable[..., ScenarioFile]) -> None:
    run = bench.run(short_stop(ecu=KILLED | APART, pacing="realtime"), record=False)
    assert run.verdict.verdict in ("pass", "fail", "inconclusive")
    assert run.data.array("age_valve_pump")[-1] > 0.2
    assert run.data.array("speed")[-1] < 1.0


@pytest.mark.parametrize(
    ("pacing", "number", "message"),
    [
        ("lockstep", signal.SIGKILL, "the ECU ended in tick"),
        pytest.param(
            "realtime",
            signal.SIGKILL,
            "the emulated ECU ended during the run (exit code -9)",
            marks=pytest.mark.real_time,
        ),
        pytest.param("realtime", signal.SIGSTOP, "fell silent: no good frame for 1.", marks=pytest.mark.real_time),
    ],
)
def test_lost_although_wanted_alive(
    pacing: str, number: int, message: str, bench_command: Callable[..., Any], tmp_path: Path
) -> None:
    """`kill -9` of the ECU's process, and one that hangs: verdict error, exit code 4, recording kept."""
    folder = tmp_path / "run"
    how = [f"--{pacing}", "--ecu", "emulated", "--link", "udp_loopback", "--out", "run", "--plain"]
    process = bench_command("run", STANDING, *how)
    process.wait_until_recorded(folder)
    os.kill(process.ecu(), number)
    code, _, errors = process.end()
    assert code == 4
    assert "Traceback" not in errors + (folder / "log.txt").read_text()
    verdict = json.loads((folder / "verdict.json").read_text())
    assert verdict["verdict"] == "error"
    assert message in "".join(verdict["errors"])
    assert {path.name for path in folder.iterdir()} == set(FINISHED_FILES)
    recording = Recording.open(folder)
    assert len(recording) > 300
    assert (recording.frames["identifier"] == 0x210).sum() > 50


@pytest.mark.parametrize("pacing", ["lockstep", pytest.param("realtime", marks=pytest.mark.real_time)])
def test_silent_ecu_as_the_scenario_wants_it(pacing: str) -> None:
    """Also with the controller in this process the ECU of the scenario says nothing."""
    kinds = {
        "lockstep": [("inprocess", None), ("emulated", "udp_loopback")],
        "realtime": [("emulated", "udp_loopback")],
    }
    limits = {"time_limit": "2.5 s"}
    runs = [
        bench.run("stops/ecu_silent", pacing=pacing, ecu=kind, link=link, sets=limits, record=False)
        for kind, link in kinds[pacing]
    ]
    for run in runs:
        assert (run.frames["sender"] == ECU).sum() == 0
        assert run.verdict.verdict != "error"
        assert {c.id: c.verdict for c in run.verdict.criteria}["no_answer"] in ("pass", "inconclusive")
    assert len({run.data.digest() for run in runs}) == 1


def test_how_long_an_ecu_may_be_silent_is_said_by_the_scenario(short_stop: Callable[..., ScenarioFile]) -> None:
    """The ECU sends nothing for 0.5 s: an error where 0.2 s are allowed, none where 1 s is, as by default."""
    off = {"name": "off", "trigger": {"from": 0.5}, "disturbance": {"off": {"node": "ecu"}}, "duration": 0.5}
    run = bench.run(short_stop(faults=[off]), record=False)
    assert 0.4 < run.data.array("age_valve_pump")[500:].max() < 0.6
    assert not run.verdict.errors
    with pytest.raises(RunError, match=r"fell silent: no good frame for 0\.[23] s") as raised:
        bench.run(short_stop(faults=[off], ecu={"longest_silence": 0.2}), record=False)
    assert "ecu.longest_silence" in str(raised.value)


@pytest.mark.real_time
def test_never_answers(short_stop: Callable[..., ScenarioFile]) -> None:
    external = short_stop(ecu={"kind": "external", "link": "udp_loopback", "first_answer": 0.3}, pacing="realtime")
    with pytest.raises(RunError, match=r"sent no frame within 0\.3 s") as raised:
        bench.run(external, record=False)
    assert "bench ecu --link" in str(raised.value)
    assert raised.value.exit_code == 4


@pytest.mark.real_time
def test_never_answers_as_a_user_sees_it(bench_command: Callable[..., Any], tmp_path: Path) -> None:
    external = ["--realtime", "--ecu", "external", "--link", "udp_loopback", "--set", "ecu.first_answer=0.3 s"]
    code, out, errors = bench_command("run", STANDING, *external, "--out", "run").end()
    assert code == 4
    assert "sent no frame within 0.3 s" in out
    assert "mfdd" not in out, "a criterion that nothing was measured for hides the error"
    assert "sent no frame within 0.3 s" in (tmp_path / "run" / "log.txt").read_text()
    assert "Traceback" not in out + errors
    assert json.loads((tmp_path / "run" / "verdict.json").read_text())["verdict"] == "error"
    assert {path.name for path in (tmp_path / "run").iterdir()} == set(FINISHED_FILES)
