"""Helper processes of a run: recorder, dashboard, emulated ECU. Started on the helper cores, ended with the run."""

import os
import signal
import subprocess
import sys
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import IO

from bench.loop.scheduling import CorePlan

STOP_TIMEOUT_S = 10.0
"""For a helper to end when it is told to: on a busy machine its interpreter alone takes seconds to leave."""


@dataclass
class Child:
    """A helper process and what it is for."""

    role: str
    process: subprocess.Popen[bytes]

    @property
    def exit_code(self) -> int | None:
        """Exit code, None while it runs."""
        return self.process.poll()

    def wait(self, timeout_s: float) -> int | None:
        """Wait for the process to end by itself; None if it has not after ``timeout_s``."""
        try:
            return self.process.wait(timeout_s)
        except subprocess.TimeoutExpired:
            return None

    def stop(self) -> int:
        """End the process, with force if it does not listen, and reap it."""
        if self.process.poll() is None:
            self.process.terminate()
            if self.wait(STOP_TIMEOUT_S) is None:
                self.process.kill()
        return self.process.wait()


@contextmanager
def on_helper_cores(plan: CorePlan) -> Iterator[None]:
    """Processes started inside inherit the helper cores: they never run on the loop's core, not even at first."""
    before = os.sched_getaffinity(0)
    os.sched_setaffinity(0, plan.helpers)
    try:
        yield
    finally:
        os.sched_setaffinity(0, before)


def _leave_interrupts_to_the_run() -> None:
    """Ctrl-C goes to every process of the terminal; only the one that owns the run acts on it, and ends the others."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)


def start_module(
    role: str, module: str, arguments: Sequence[str], *, log: IO[bytes] | None = None, terminal: bool = False
) -> Child:
    """Start ``python -m module arguments`` as a helper.

    Parameters
    ----------
    log : binary file, optional
        Receives standard output and error; without it errors go to this process's standard error.
    terminal : bool
        The helper draws on this process's terminal (the dashboard).
    """
    output = None if terminal else (log or subprocess.DEVNULL)
    environment = dict(os.environ)
    package_root = str(Path(__file__).resolve().parent.parent.parent)
    environment["PYTHONPATH"] = os.pathsep.join(filter(None, (package_root, environment.get("PYTHONPATH"))))
    process = subprocess.Popen(
        [sys.executable, "-m", module, *arguments],
        stdin=None if terminal else subprocess.DEVNULL,
        stdout=output,
        stderr=None if terminal or log is None else log,
        env=environment,
        # before the program starts: Python lets an ignored signal be, so there is no instant without it
        preexec_fn=_leave_interrupts_to_the_run,
    )
    return Child(role, process)
