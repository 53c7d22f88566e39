"""A terminal for a process under test: what it draws, read from tmux as text."""

import os
import shlex
import shutil
import subprocess
import time
from collections.abc import Callable, Mapping, Sequence
from pathlib import Path

import pytest

INSTALL = "sudo apt-get install tmux"


class Terminal:
    """A tmux session of its own server with one command in it."""

    def __init__(
        self, socket: Path, command: Sequence[str], width: int, height: int, environment: Mapping[str, str]
    ) -> None:
        if shutil.which("tmux") is None:
            pytest.skip(f"no tmux here: {INSTALL}")
        self._tmux = ["tmux", "-S", str(socket), "-f", "/dev/null"]
        variables = [f"{name}={value}" for name, value in environment.items()]
        # parallel test runners state a size of their own; the terminal's counts
        line = shlex.join(["env", "-u", "COLUMNS", "-u", "LINES", *variables, *command])
        subprocess.run(
            [*self._tmux, "new-session", "-d", "-x", str(width), "-y", str(height), f"{line}; sleep 60"],
            check=True,
            env={**os.environ, "LC_ALL": "C.UTF-8"},
        )

    def text(self, *, styles: bool = False) -> str:
        """What stands on the screen, with escape sequences if ``styles``."""
        arguments = ["capture-pane", "-p", *(["-e"] if styles else [])]
        return subprocess.run([*self._tmux, *arguments], check=True, capture_output=True, text=True).stdout

    def wait_for(self, condition: Callable[[str], bool], timeout_s: float = 20.0) -> str:
        """Screen as soon as a condition holds; fails with the screen if it never does."""
        deadline = time.monotonic() + timeout_s
        while True:
            screen = self.text()
            if condition(screen):
                return screen
            if time.monotonic() > deadline:
                pytest.fail(f"never on the screen; last seen:\n{screen}")
            time.sleep(0.05)

    def close(self) -> None:
        """End the session."""
        subprocess.run([*self._tmux, "kill-server"], check=False, capture_output=True)
