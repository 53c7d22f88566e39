"""The ECU without a run around it.

Fed with only the recorded bench→ECU frames of a run, a lone ECU in lock-step gives the same valve frames again; as a
command it tells what it did when Ctrl-C ends it.
"""

import json
import signal
import subprocess
import sys
import time
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray

import bench
from bench.codec.codec import Codec
from bench.ecu.node import EcuNode
from bench.ecu.process import run_in_real_time
from bench.links.barrier import BarrierServer
from bench.links.frame import BENCH, ECU, TRANSMITTED, new_frames, payload
from bench.links.registry import open_link
from bench.recording.reading import Recording
from bench.scenario.schema import ScenarioFile

VALVE_PUMP = 0x210
START_S = 120.0


@pytest.fixture(scope="module")
def recorded(short_stop: Callable[..., ScenarioFile], tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("alone") / "run"
    bench.run(short_stop(), out=folder)
    return folder


def per_tick(frames: NDArray[np.void], ticks: int) -> Iterator[tuple[int, NDArray[np.void]]]:
    """For each tick what the ECU saw in it: the bench's frames of the tick before."""
    edges = np.searchsorted(frames["tick"], np.arange(-1, ticks + 1))
    for tick in range(ticks):
        yield tick, frames[edges[tick] : edges[tick + 1]]


def valve_payloads(frames: NDArray[np.void]) -> list[bytes]:
    return [payload(frame) for frame in frames[frames["identifier"] == VALVE_PUMP]]


def test_a_node_in_this_process(short_stop: Callable[..., ScenarioFile]) -> None:
    run = bench.run(short_stop(), record=False)
    to_ecu = run.frames[run.frames["sender"] == BENCH]
    node, answers, sent = EcuNode("sensitive", Codec.load()), new_frames(64), []
    for tick, frames in per_tick(to_ecu, len(run.data)):
        sent.append(answers[: node.tick(tick, frames, len(frames), answers)].copy())
    again = np.concatenate(sent)
    then = run.frames[run.frames["sender"] == ECU]
    # what the node sends in the last tick reaches nobody
    assert len(then) <= len(again) <= len(then) + 3
    assert [(f["identifier"], payload(f)) for f in again[: len(then)]] == [(f["identifier"], payload(f)) for f in then]


def test_the_process_from_the_file_of_frames(recorded: Path, tmp_path: Path) -> None:
    recording = Recording.open(recorded)
    from_bench = (recording.frames["flags"] & TRANSMITTED) != 0
    to_ecu, then = recording.frames[from_bench].copy(), valve_payloads(recording.frames[~from_bench])
    to_ecu["flags"] &= 255 - TRANSMITTED
    received, answers = new_frames(256), []
    server = BarrierServer(tmp_path / "barrier")
    with open_link("udp_loopback", role="bench") as link:
        arguments = ["--link", link.text, "--barrier", str(server.path)]
        ecu = subprocess.Popen([sys.executable, "-m", "bench.ecu.process", *arguments], cwd=Path(__file__).parents[3])
        try:
            server.wait_for_peer(START_S, lambda: ecu.poll() is None)
            for tick, frames in per_tick(to_ecu, len(recording)):
                link.send(frames, len(frames))
                server.begin(tick, frames, len(frames))
                answers.append(received[: server.finish(link, received)].copy())
        finally:
            server.close()
            ecu.wait(START_S)
    again = valve_payloads(np.concatenate(answers))
    assert len(then) > 300
    assert again[: len(then)] == then


STALL_FROM_TICK, STALL_S, PERIOD_TICKS = 1000, 0.06, 5
"""Twelve periods of the wheel-speed frames; five without a frame are a fault."""


@pytest.mark.real_time
def test_a_stall_of_the_process_is_no_missing_frame(recorded: Path) -> None:
    """The frames that waited in the socket meanwhile came in time."""
    recording = Recording.open(recorded)
    frames = recording.frames[(recording.frames["flags"] & TRANSMITTED) != 0].copy()
    frames["flags"] &= 255 - TRANSMITTED
    node, began, sent, stalled = EcuNode("sensitive", Codec.load()), time.perf_counter(), 0, False
    with open_link("udp_loopback", role="bench") as link, open_link(link.text, role="ecu") as at_ecu:

        def send_what_is_due() -> int:
            """Bench and ECU share this thread: what the machine takes from one it takes from the other."""
            nonlocal sent, stalled
            tick = int((time.perf_counter() - began) * 1e3)
            if tick >= STALL_FROM_TICK and not stalled:
                time.sleep(STALL_S)
                tick, stalled = tick + round(STALL_S * 1e3), True
            elif stalled and tick < STALL_FROM_TICK + STALL_S * 1e3 + PERIOD_TICKS:
                return 0  # the frames that waited are the newest ones until their next period
            due = int(np.searchsorted(frames["tick"], tick, side="right"))
            link.send(frames[sent:due], due - sent)
            sent = due
            return signal.SIGTERM if tick > STALL_FROM_TICK + 500 else 0

        run_in_real_time(node, at_ecu, send_what_is_due)
    assert stalled
    assert node.statistics()["fault_codes"] == []


@pytest.mark.real_time
def test_the_command_tells_its_counts_at_the_end(bench_command: Callable[..., Any]) -> None:
    with open_link("udp_loopback", role="bench") as link:
        process = bench_command("ecu", "--link", link.text, "--json")
        frames, deadline = new_frames(256), time.monotonic() + START_S
        while not (heard := link.receive(frames)) and time.monotonic() < deadline:
            link.wait(0.05)
        process.interrupt()
        code, out, errors = process.end()
        heard += link.receive(frames)
    told = json.loads(out)
    assert (code, errors) == (130, "")
    assert told["link"] == link.text
    assert told["bus"]["sent"] == heard > 0
    assert told["ecu"]["fault_codes"] == []
