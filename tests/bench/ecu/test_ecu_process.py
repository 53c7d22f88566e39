"""``bench ecu`` as a process: in lock-step, in real time, its ends and exit codes."""

import os
import signal
import subprocess
import sys
import time
from collections.abc import Iterator
from concurrent.futures import ThreadPoolExecutor
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from bench.codec.codec import Codec
from bench.ecu.node import EcuNode
from bench.ecu.process import LEAST_REST_S, MOST_TICKS_WITHOUT_REST, TICK_S, run_in_real_time, serve
from bench.links.barrier import BarrierServer
from bench.links.frame import new_frames
from bench.links.registry import open_link
from bench.loop.scheduling import CorePlan
from signals.errors import InputError

ROOT = Path(__file__).parents[3]
PATIENCE_S = 120.0
"""Time for the process to start, where the first one may have to compile, and to end."""


def start(*arguments: str) -> "subprocess.Popen[str]":
    return subprocess.Popen(
        [sys.executable, "-m", "bench.ecu.process", *arguments],
        cwd=ROOT,
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
    )


@pytest.fixture
def bus() -> Iterator[Any]:
    link = open_link("udp_loopback", role="bench")
    yield link
    link.close()


def wait_for_frames(link: Any, deadline_s: float = PATIENCE_S) -> Any:
    """First frames that the ECU sends."""
    frames, end = new_frames(256), time.monotonic() + deadline_s
    while time.monotonic() < end:
        link.wait(0.05)
        count = link.receive(frames)
        if count:
            return frames[:count].copy()
    raise AssertionError("the ECU sent nothing")


def test_lock_step_in_another_process_equals_the_node_in_this_one(can_car: Any, bus: Any, tmp_path: Path) -> None:
    car = can_car()
    car.drive(0.5, 25.0)
    for dip in (18.0, 24.0, 17.0, 24.0):
        car.drive(0.08, (dip, 24.0, dip + 2.0, 23.0), master_bar=120, acceleration=-8.0)
    path = str(tmp_path / "barrier")
    server = BarrierServer(path)
    ecu = start("--link", bus.text, "--barrier", path)
    try:
        server.wait_for_peer(PATIENCE_S, lambda: ecu.poll() is None)
        received, answers = new_frames(256), []
        sent = new_frames(64)
        for tick, frames in enumerate(car.frames_to_ecu):
            # what the node saw in tick n was sent in tick n - 1
            count = len(frames)
            sent[:count] = frames
            bus.send(sent, count)
            server.begin(tick, sent, count)
            answers.append(received[: server.finish(bus, received)].copy())
    finally:
        server.close()
    assert ecu.wait(PATIENCE_S) == 0
    got, expected = np.concatenate(answers), np.concatenate(car.log)
    assert [(f["identifier"], bytes(f["data"][: f["length"]])) for f in got] == [
        (f["identifier"], bytes(f["data"][: f["length"]])) for f in expected
    ]


@pytest.mark.real_time
def test_real_time_keeps_the_periods_and_ends_cleanly_on_sigterm(bus: Any) -> None:
    ecu = start("--link", bus.text, "--calibration", "coarse")
    try:
        wait_for_frames(bus)
        frames, collected, end = new_frames(1024), [], time.monotonic() + 1.0
        while time.monotonic() < end:
            bus.wait(0.02)
            collected.append(frames[: bus.receive(frames)].copy())
        sent = np.concatenate(collected)
        assert 0 < np.sum(sent["identifier"] == 0x210) <= 210  # 200 in a second; a loaded machine may skip some
        ecu.terminate()
        assert ecu.wait(PATIENCE_S) == 0
    finally:
        ecu.kill()
        ecu.communicate()


class SlowNode(EcuNode):
    """Takes three periods for each tick."""

    def __init__(self) -> None:
        super().__init__("sensitive", Codec.load())
        self.at_work: list[tuple[float, float]] = []

    def tick(self, *arguments: Any) -> int:
        began = time.perf_counter()
        sent = super().tick(*arguments)
        while time.perf_counter() < began + 3 * TICK_S:
            pass
        self.at_work.append((began, time.perf_counter()))
        return sent


@pytest.mark.real_time
def test_ecu_on_a_machine_too_slow_for_it_leaves_time_to_the_bench(bus: Any) -> None:
    """No six ticks without the rest that docs/ecu.md promises: on the only core the bench would starve."""
    node = SlowNode()
    with open_link(bus.text, role="ecu") as at_ecu:
        run_in_real_time(node, at_ecu, lambda: signal.SIGTERM if len(node.at_work) == 60 else 0)
    began, ended = np.array(node.at_work).T
    rested = np.flatnonzero(began[1:] - ended[:-1] >= LEAST_REST_S)
    assert np.diff(rested).max() <= MOST_TICKS_WITHOUT_REST + 1
    assert rested[-1] >= 60 - 1 - (MOST_TICKS_WITHOUT_REST + 1)


@pytest.mark.parametrize(("cores", "fifo"), [(1, False), (2, True)])
def test_no_fixed_priority_on_the_only_core(bus: Any, monkeypatch: pytest.MonkeyPatch, cores: int, fifo: bool) -> None:
    wanted: list[bool] = []

    @contextmanager
    def without_rights(plan: CorePlan, *, fifo: bool = True) -> Iterator[None]:
        wanted.append(fifo)
        yield

    monkeypatch.setattr("os.cpu_count", lambda: cores)
    monkeypatch.setattr("bench.ecu.process.real_time_process", without_rights)
    monkeypatch.setattr("bench.ecu.process.run_in_real_time", lambda node, link, ended: None)
    assert serve(bus.text) == 0
    assert wanted == [fifo]


def test_silent_ecu_stays_silent(bus: Any, tmp_path: Path) -> None:
    path = str(tmp_path / "barrier")
    server = BarrierServer(path)
    ecu = start("--link", bus.text, "--barrier", path, "--silent")
    try:
        server.wait_for_peer(PATIENCE_S, lambda: ecu.poll() is None)
        nothing, received = new_frames(1), new_frames(64)
        for tick in range(50):
            server.begin(tick, nothing, 0)
            assert server.finish(bus, received) == 0
    finally:
        server.close()
    assert ecu.wait(PATIENCE_S) == 0


@pytest.mark.parametrize(
    ("arguments", "code", "message"),
    [
        (("--calibration", "sensitiv"), 2, "did you mean sensitive"),
        (("--link", "virtual"), 2, "virtual"),
        (("--link", "udp_loopback", "--barrier", "/nonexistent/barrier"), 4, "no bench listens"),
        (("--core", "4096"), 2, "no such core"),
        (("--dbc", "/nonexistent.dbc"), 2, "/nonexistent.dbc"),
    ],
)
def test_bad_start_ends_with_one_message(arguments: tuple[str, ...], code: int, message: str) -> None:
    ecu = start(*arguments)
    _, errors = ecu.communicate(timeout=PATIENCE_S)
    assert ecu.returncode == code
    assert message in errors
    assert "Traceback" not in errors


def test_ends_with_its_parent(tmp_path: Path) -> None:
    # a shell-like parent starts the ECU, tells its process id and is killed
    script = (
        "import subprocess, sys, time\n"
        "child = subprocess.Popen([sys.executable, '-m', 'bench.ecu.process', '--link', 'udp_loopback'])\n"
        "print(child.pid, flush=True)\n"
        "time.sleep(60)\n"
    )
    parent = subprocess.Popen([sys.executable, "-c", script], cwd=ROOT, stdout=subprocess.PIPE, text=True)
    assert parent.stdout is not None
    ecu = int(parent.stdout.readline())
    wait_until_armed(ecu)
    parent.send_signal(signal.SIGKILL)
    parent.wait()
    end = time.monotonic() + PATIENCE_S
    while alive(ecu):
        assert time.monotonic() < end, "the ECU outlived its parent"
        time.sleep(0.05)


TERMINATED_WHILE_LEAVING = """
import atexit, os, runpy, signal, sys
atexit.register(lambda: os.kill(os.getpid(), signal.SIGTERM))
runpy.run_module("bench.ecu.process", run_name="__main__", alter_sys=True)
"""
"""The ECU's process, and SIGTERM at an instant at which its interpreter leaves."""


def end_of(script: str, *arguments: str) -> tuple[int, str]:
    """Exit code and errors of a script of Python."""
    command = [sys.executable, "-c", script, *arguments]
    ended = subprocess.run(command, cwd=ROOT, capture_output=True, text=True, timeout=PATIENCE_S, check=False)
    return ended.returncode, ended.stderr


def test_sigterm_while_the_interpreter_leaves_changes_nothing(bus: Any, tmp_path: Path) -> None:
    """As a run ends its ECU: the barrier closes, the process is on its way out, and is told to end once more."""
    path = str(tmp_path / "barrier")
    server = BarrierServer(path)
    arguments = ("--link", bus.text, "--barrier", path)
    with ThreadPoolExecutor(1) as pool:
        ending = pool.submit(end_of, TERMINATED_WHILE_LEAVING, *arguments)
        try:
            server.wait_for_peer(PATIENCE_S, lambda: not ending.done())
        finally:
            server.close()
        assert ending.result() == (0, "")
    code, errors = end_of(TERMINATED_WHILE_LEAVING, "--core", "4096")
    assert (code, "Traceback" in errors) == (2, False)


TERMINATED_WHERE_EXCEPTIONS_ARE_LOST = """
import os, signal, sys, weakref
from bench.codec.codec import Codec
from bench.ecu import process

class Compiled:
    pass

def load(*files, really=Codec.load):
    compiled = Compiled()
    kept = weakref.ref(compiled, lambda _: os.kill(os.getpid(), signal.SIGTERM))
    del compiled
    return really(*files)

Codec.load = load
sys.exit(process.main(sys.argv[1:]))
"""
"""The ECU's process, and SIGTERM while it starts, in a callback of the interpreter, whose exceptions go nowhere."""


def test_sigterm_whose_exception_is_lost_ends_the_process() -> None:
    code, errors = end_of(TERMINATED_WHERE_EXCEPTIONS_ARE_LOST, "--link", "udp_loopback")
    assert "Stopped" in errors  # the interpreter's word that it was lost
    assert code == 0


TERMINATED_AT_EACH_LINE = """
import os, signal, sys
from bench.ecu import process

def ended_at(line):  # exit code of a bad usage with SIGTERM at a line of the module, and how many lines it ran
    seen = 0
    def count(frame, event, _):
        nonlocal seen
        if event == "line" and signal.getsignal(signal.SIGTERM) not in (signal.SIG_DFL, signal.SIG_IGN):
            seen += 1
            if seen == line:
                os.kill(os.getpid(), signal.SIGTERM)
        return count
    sys.settrace(lambda frame, event, _: count if frame.f_code.co_filename == process.__file__ else None)
    code = process.main(["--core", "4096"])
    sys.settrace(None)
    signal.signal(signal.SIGTERM, signal.SIG_DFL)
    return code, seen

line, codes = 1, set()
while True:
    code, seen = ended_at(line)
    codes.add(code)
    if seen < line:
        break
    line += 1
print(line, sorted(codes), file=sys.stderr)
"""


def test_sigterm_at_any_line_ends_in_an_exit_code() -> None:
    code, told = end_of(TERMINATED_AT_EACH_LINE)
    assert code == 0, told
    lines, codes = told.splitlines()[-1].split(" ", 1)
    assert int(lines) > 3
    assert codes == "[0, 2]"  # terminated, or the bad usage that it was going to tell


def wait_until_armed(pid: int) -> None:
    """Until the process catches SIGTERM, which is when it has asked to end with its parent."""
    end = time.monotonic() + PATIENCE_S
    while time.monotonic() < end:
        caught = [line for line in Path(f"/proc/{pid}/status").read_text().splitlines() if line.startswith("SigCgt")]
        if int(caught[0].split()[1], 16) >> (signal.SIGTERM - 1) & 1:
            return
        time.sleep(0.05)
    raise AssertionError("the ECU did not start")


def alive(pid: int) -> bool:
    try:
        os.kill(pid, 0)
    except ProcessLookupError:
        return False
    return Path(f"/proc/{pid}/stat").read_text().split(")")[1].split()[0] != "Z"


def test_serving_a_link_that_stays_in_the_process_is_refused() -> None:
    with pytest.raises(InputError, match="does not leave"):
        serve("virtual")


def test_node_needs_a_valid_calibration() -> None:
    with pytest.raises(InputError, match="unknown calibration"):
        EcuNode("none", Codec.load())
