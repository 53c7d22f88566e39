"""Commands that have to be quick never import a heavy library; what else they cost is measured by the benchmark."""

import subprocess
import sys
from pathlib import Path

import pytest

# named by the requirement, and what those bring or would cost as much
FORBIDDEN = {"scipy", "mujoco", "numba", "asammdf", "matplotlib", "can", "cantools", "pandas", "pint"}


@pytest.mark.parametrize(
    "command",
    [
        ["--help"],
        ["run", "--help"],
        ["list"],
        ["check", "stops/dry"],
        ["check", "stops/abs_against_locked"],
        ["vehicle", "list", "ekf_car"],
        ["schema", "scenario"],
    ],
    ids=" ".join,
)
def test_quick_commands_import_nothing_heavy(command: list[str], tmp_path: Path) -> None:
    done = subprocess.run(
        [sys.executable, "-X", "importtime", "-m", "bench.cli", *command],
        capture_output=True,
        text=True,
        check=False,
        cwd=Path(__file__).resolve().parents[3],
    )
    assert done.returncode == 0
    imported = {line.rpartition("|")[2].strip().split(".")[0] for line in done.stderr.splitlines() if "|" in line}
    assert "bench" in imported
    assert imported & FORBIDDEN == set()


def test_the_doctor_imports_nothing_heavy() -> None:
    code = "import sys, bench.cli, bench.doctor; list(bench.doctor.findings()); print(*sys.modules)"
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert {name.split(".")[0] for name in done.stdout.split()} & FORBIDDEN == set()
