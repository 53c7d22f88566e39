"""The generator of blind cases, run as a program of its own: it is found by its path and never imported."""

import json
import subprocess
import sys
from collections.abc import Callable, Sequence
from importlib import resources
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from signals.errors import BenchError

FAMILIES = (
    "single",
    "pair",
    "data_fault",
    "confounded",
    "unknown",
    "clean",
    "unexcited",
    "wrong_vehicle",
    "one_manoeuvre",
    "detection",
)
GENERATORS = ("first", "second")


def generator_program() -> Path:
    """``generate.py``: in the installed package, else beside the tests."""
    installed = Path(str(resources.files("bench"))) / "data" / "blind" / "generate.py"
    return installed if installed.exists() else Path(__file__).resolve().parents[2] / "tests" / "blind" / "generate.py"


def generate(
    cases: Path,
    sealed: Path,
    *,
    seed: int,
    count: int,
    family: str | None,
    generator: str,
    told: Callable[[str], None] | None = None,
) -> list[Path]:
    """Write cases into ``cases`` and their sealed labels into ``sealed``.

    Returns
    -------
    list of Path
        Folders of the cases, in order.

    Raises
    ------
    BenchError
        If the generator fails.
    """
    words = ["cases", "--seed", str(seed), "--n", str(count), "--out", str(cases), "--sealed", str(sealed)]
    for line in _run([*words, *_choice(family, generator)]).splitlines():
        if told is not None:
            told(line)
    return [cases / f"case_{index:04d}" for index in range(count)]


def separate(
    rivals: Sequence[str], *, seed: int, index: int, family: str | None, generator: str
) -> list[dict[str, float | None]]:
    """Expected log evidence for each hidden effect of a case against rivals, by the generator's own theory.

    None stands for a rival that the generator does not know.
    """
    words = ["separate", "--seed", str(seed), "--index", str(index), "--rivals", *rivals]
    result: list[dict[str, float | None]] = json.loads(_run([*words, *_choice(family, generator)]))
    return result


def value_stds(*, seed: int, index: int, family: str | None, generator: str) -> list[float]:
    """For each hidden effect of a case the smallest standard deviation of its value, over the value, by theory."""
    words = ["precision", "--seed", str(seed), "--index", str(index)]
    result: list[float] = json.loads(_run([*words, *_choice(family, generator)]))
    return result


def torque_courses(*, seed: int, index: int, family: str | None, generator: str) -> dict[str, NDArray[np.float64]]:
    """Manoeuvre -> (n, 4): relative change of each brake's torque by a case's unknown term, every 10 ms."""
    words = ["courses", "--seed", str(seed), "--index", str(index)]
    courses = json.loads(_run([*words, *_choice(family, generator)]))
    return {name: np.array(course, dtype=np.float64) for name, course in courses.items()}


def record_further(
    folder: Path, *, seed: int, index: int, family: str | None, generator: str, script: Path | None, channel: str
) -> None:
    """Write a case again with a further manoeuvre (``script``, JSON) or a channel that was missing ("" for none)."""
    words = ["further", "--seed", str(seed), "--index", str(index), "--out", str(folder), "--channel", channel]
    _run([*words, *(["--script", str(script)] if script is not None else []), *_choice(family, generator)])


def _choice(family: str | None, generator: str) -> list[str]:
    return ["--generator", generator, *(["--family", family] if family is not None else [])]


def _run(words: Sequence[str]) -> str:
    program = generator_program()
    done = subprocess.run([sys.executable, str(program), *words], capture_output=True, text=True, check=False)
    if done.returncode != 0:
        last = done.stderr.strip().splitlines()[-1:] or ["no message"]
        raise BenchError(f"{program}: the generator ended with code {done.returncode}: {last[0]}")
    return done.stdout
