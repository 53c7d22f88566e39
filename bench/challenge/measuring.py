"""What a score needs more runs for: held-out gain of the true effect, look-alikes with the proposed data, and how
precisely a case tells a value at best.

In worker processes like the diagnoses; what a run that was broken off has measured is kept.
"""

import json
import shutil
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from bench.challenge.answering import in_workers
from bench.challenge.generator import value_stds
from bench.challenge.planned import separated_by_plan
from bench.challenge.true_gain import gain_share
from bench.verdict.output_files import replace_file


@dataclass(frozen=True)
class Measurement:
    """One case to measure at.

    Attributes
    ----------
    case : its folder
    beside : folder of the whole challenge, for the result and for the case with more data
    label, diagnosis : what is hidden and what was answered
    drawn_with : seed, index, family and generator of the case
    wanted : of ``separated``, ``gain_share`` and ``value_std``
    """

    case: Path
    beside: Path
    label: Mapping[str, Any]
    diagnosis: Mapping[str, Any]
    drawn_with: Mapping[str, Any]
    wanted: frozenset[str]

    @property
    def file(self) -> Path:
        """Where the result goes."""
        return self.beside / "measured" / f"{self.case.name}.json"

    def known(self) -> dict[str, Any]:
        """What was measured before."""
        return json.loads(self.file.read_text(encoding="utf-8")) if self.file.is_file() else {}


def measure_all(
    measurements: Sequence[Measurement], jobs: int, told: Callable[[str, int, int], None] | None = None
) -> dict[str, dict[str, Any]]:
    """What is wanted of each, by name of the case."""
    missing = [one for one in measurements if not one.wanted <= one.known().keys()]
    done = len(measurements) - len(missing)
    for number in in_workers(_measure, [(one,) for one in missing], jobs):
        done += 1
        if told is not None:
            told(missing[number].case.name, done, len(measurements))
    return {one.case.name: one.known() for one in measurements}


def _measure(one: Measurement) -> None:
    found = one.known()
    for name in sorted(one.wanted - found.keys()):
        found[name] = _MEASURES[name](one)
    one.file.parent.mkdir(parents=True, exist_ok=True)
    replace_file(one.file, json.dumps(found).encode())


def _separated(one: Measurement) -> bool | None:
    folder = one.beside / "planned" / one.case.name
    shutil.rmtree(folder, ignore_errors=True)  # of a run that was broken off here
    return separated_by_plan(folder, one.label, one.diagnosis, **one.drawn_with)


def _gain_share(one: Measurement) -> float | None:
    return gain_share(one.case, one.label, one.diagnosis, one.drawn_with)


def _value_std(one: Measurement) -> float:
    return value_stds(**one.drawn_with)[0]


_MEASURES: dict[str, Callable[[Measurement], Any]] = {
    "separated": _separated,
    "gain_share": _gain_share,
    "value_std": _value_std,
}
