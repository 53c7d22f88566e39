"""What a process that touches frames loads: the recorder starts without the libraries that make and read MF4."""

import subprocess
import sys
from pathlib import Path

ROOT = Path(__file__).parents[3]
SCRIPT = """
import sys
import bench.recording.recorder
print(sorted({"asammdf", "pandas", "sympy", "matplotlib", "mujoco"} & set(sys.modules)))
import asammdf
print(asammdf.MDF.__name__)
"""


def test_the_recorder_loads_no_library_of_mf4_and_leaves_it_to_others() -> None:
    told = subprocess.run([sys.executable, "-c", SCRIPT], capture_output=True, text=True, check=True, cwd=ROOT)
    assert told.stdout.splitlines() == ["[]", "MDF"]
