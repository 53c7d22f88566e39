"""The launcher of the CAN kernel: same folder, environment, output and exit code as without it, and clear messages."""

import os
import shutil
import subprocess
from pathlib import Path

import pytest

from bench.links.available import kernel_has_can

LAUNCHER = Path(__file__).parents[2] / "ci" / "can_kernel"

needs_user_mode_linux = pytest.mark.skipif(
    not kernel_has_can() and shutil.which("linux.uml") is None,
    reason="no AF_CAN and no user-mode Linux: sudo apt-get install user-mode-linux kmod iproute2",
)


def run(*command: str, **options) -> subprocess.CompletedProcess[str]:
    return subprocess.run(
        [str(LAUNCHER), *command], capture_output=True, text=True, timeout=120, check=False, **options
    )


@needs_user_mode_linux
def test_command_runs_as_without_it_but_with_vcan(tmp_path: Path) -> None:
    folder = tmp_path / "a folder"
    folder.mkdir()
    program = 'pwd; echo "$WORD"; cat /sys/class/net/vcan[01]/operstate; [ -t 1 ] || echo pipe; echo "it'
    program += "'" + 's" >&2; echo kept > file; exit 7'
    result = run("bash", "-c", program, cwd=folder, env={**os.environ, "WORD": "two  words $HOME 'q'"})
    assert result.returncode == 7
    lines = result.stdout.splitlines()
    assert lines[:2] == [str(folder), "two  words $HOME 'q'"]
    assert len(lines) == 5
    assert lines[4] == "pipe"
    assert result.stderr == "it's\n"
    assert (folder / "file").read_text() == "kept\n"


@needs_user_mode_linux
def test_command_that_does_not_exist() -> None:
    result = run("no_such_command")
    assert result.returncode == 127 if not kernel_has_can() else result.returncode in (126, 127)
    assert "no_such_command" in result.stderr


@needs_user_mode_linux
def test_command_with_more_pages_than_linux_allows_mappings() -> None:
    """70 000 pages that touch no other one, each a mapping of its own; the limit of an untouched machine is 65 530."""
    program = "import mmap; m = mmap.mmap(-1, 2 * 70_000 * 4096)\nfor i in range(70_000): m[2 * i * 4096] = 1\nprint(7)"
    result = run("python3", "-c", program)
    if result.returncode == 137:
        assert int(Path("/proc/sys/vm/max_map_count").read_text()) < 70_000
        assert "sudo sysctl vm.max_map_count=1048576" in result.stderr
    else:
        assert (result.returncode, result.stdout) == (0, "7\n")


def test_without_a_command() -> None:
    result = run()
    assert result.returncode == 125
    assert "ci/can_kernel COMMAND" in result.stderr


@pytest.mark.skipif(kernel_has_can(), reason="this kernel has CAN")
def test_missing_packages_are_named_with_the_command_that_brings_them(tmp_path: Path) -> None:
    for program in ("bash", "env", "id", "dirname"):
        (tmp_path / program).symlink_to(str(shutil.which(program)))
    result = run("true", env={"PATH": str(tmp_path)})
    assert result.returncode == 125
    assert "sudo apt-get install user-mode-linux" in result.stderr
