"""Whole runs: scenario, car, bus, ECU, verdict. Short stops, so that many fit into a minute."""

import os
import signal
import subprocess
import sys
import time
from collections.abc import Callable, Iterator
from contextlib import suppress
from pathlib import Path
from typing import Any

import pytest

from bench.links.available import multicast_works
from bench.recording.ring import RingReader
from bench.recording.run_folder import read_state
from bench.scenario.resolution import resolve
from bench.scenario.schema import ScenarioFile
from signals.errors import InputError

HERE = Path(__file__).parent
ROOT = HERE.parents[2]
PATIENCE_S = 120.0
"""For a process to end or a file to appear; the first one may have to compile."""

needs_multicast = pytest.param("udp", marks=pytest.mark.skipif(not multicast_works(), reason="no multicast route"))
UDP_LINKS = [needs_multicast, "udp_loopback"]


def pytest_generate_tests(metafunc: pytest.Metafunc) -> None:
    if "udp_link" in metafunc.fixturenames:
        metafunc.parametrize("udp_link", UDP_LINKS)


@pytest.fixture(scope="session")
def short_stop() -> Callable[..., ScenarioFile]:
    """The short stop in lock-step with the controller in this process, and changes of it: ``short_stop(seed=2)``."""

    def make(seed: int | None = None, **sections: Any) -> ScenarioFile:
        resolved = resolve(HERE / "short_stop.yaml", {"pacing": "lockstep", "ecu.kind": "inprocess"}, seed=seed)
        content = resolved.model_dump(by_alias=True)
        content["ecu"] |= sections.pop("ecu", {})
        return ScenarioFile.model_validate(content | sections)

    return make


def wait_for(found: Callable[[], Any]) -> Any:
    """What a function returns once it is true."""
    end = time.monotonic() + PATIENCE_S
    while not (result := found()):
        assert time.monotonic() < end, "waited in vain"
        time.sleep(0.02)
    return result


def rows_recorded(folder: Path) -> int:
    """Ticks that a run has behind it, from its ring."""
    with suppress(InputError):  # the ring is not there yet, or still empty
        state = read_state(folder)
        if state is not None:
            return RingReader(Path(state.ring)).rows_written
    return 0


class BenchProcess:
    """``bench …`` as a user starts it, in a process group of its own."""

    def __init__(self, folder: Path, *arguments: str) -> None:
        self.process = subprocess.Popen(
            [sys.executable, "-m", "bench.cli", *arguments],
            cwd=folder,
            stdin=subprocess.DEVNULL,
            stdout=subprocess.PIPE,
            stderr=subprocess.PIPE,
            text=True,
            env={**os.environ, "PYTHONPATH": str(ROOT)},
            start_new_session=True,
        )

    def end(self) -> tuple[int, str, str]:
        """Exit code, standard output and standard error once it has ended."""
        out, errors = self.process.communicate(timeout=PATIENCE_S)
        return self.process.returncode, out, errors

    def wait_until_recorded(self, folder: Path, ticks: int = 300) -> None:
        """Until so many ticks are behind it."""
        wait_for(lambda: self.process.poll() is not None or rows_recorded(folder) > ticks)
        assert self.process.poll() is None, self.process.communicate()

    def interrupt(self) -> None:
        """Ctrl-C: the terminal sends it to the whole group."""
        os.killpg(self.process.pid, signal.SIGINT)

    def ecu(self) -> int:
        """Process id of its emulated ECU, once there is one."""
        return wait_for(lambda: next((pid for pid, line in self.children().items() if "bench.ecu" in line), 0))

    def children(self) -> dict[int, str]:
        """Process id and command line of its helpers."""
        assert self.process.poll() is None, self.process.communicate()
        found = {}
        for pid in Path(f"/proc/{self.process.pid}/task/{self.process.pid}/children").read_text().split():
            with suppress(FileNotFoundError):
                found[int(pid)] = Path(f"/proc/{pid}/cmdline").read_text().replace("\0", " ")
        return found

    def kill(self) -> None:
        """Leave nothing behind after a failed test."""
        if self.process.poll() is None:
            os.killpg(self.process.pid, signal.SIGKILL)
        self.process.communicate()


@pytest.fixture
def bench_command(tmp_path: Path) -> Iterator[Callable[..., BenchProcess]]:
    """Starts ``bench`` in an empty folder: ``bench_command("run", "stops/dry").end()``."""
    started: list[BenchProcess] = []
    # tests that a shell has started in its background ignore Ctrl-C, and so would all that they start
    if signal.getsignal(signal.SIGINT) == signal.SIG_IGN:
        signal.signal(signal.SIGINT, signal.default_int_handler)

    def start(*arguments: str) -> BenchProcess:
        started.append(BenchProcess(tmp_path, *arguments))
        return started[-1]

    yield start
    for process in started:
        process.kill()
