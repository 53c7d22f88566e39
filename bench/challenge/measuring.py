"""What a score needs more fits for: the held-out gain of the true effect, and look-alikes with the proposed data.

In worker processes like the diagnoses; what a run that was broken off has measured is kept.
"""

import json
import shutil
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from bench.challenge.answering import in_workers
from bench.challenge.planned import LOOK_ALIKES, separated_by_plan
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
    """

    case: Path
    beside: Path
    label: Mapping[str, Any]
    diagnosis: Mapping[str, Any]
    drawn_with: Mapping[str, Any]

    @property
    def file(self) -> Path:
        """Where the result goes."""
        return self.beside / "measured" / f"{self.case.name}.json"


def measure_all(
    measurements: Sequence[Measurement], jobs: int, told: Callable[[str, int, int], None] | None = None
) -> dict[str, dict[str, Any]]:
    """``separated`` of look-alikes and ``gain_share`` of all others, by name of the case."""
    missing = [one for one in measurements if not one.file.is_file()]
    done = len(measurements) - len(missing)
    for number in in_workers(_measure, [(one,) for one in missing], jobs):
        done += 1
        if told is not None:
            told(missing[number].case.name, done, len(measurements))
    return {one.case.name: json.loads(one.file.read_text(encoding="utf-8")) for one in measurements}


def _measure(one: Measurement) -> None:
    found: dict[str, Any]
    if one.label["family"] == LOOK_ALIKES:
        folder = one.beside / "planned" / one.case.name
        shutil.rmtree(folder, ignore_errors=True)  # of a run that was broken off here
        found = {"separated": separated_by_plan(folder, one.label, one.diagnosis, **one.drawn_with)}
    else:
        found = {"gain_share": gain_share(one.case, one.label, one.diagnosis, one.drawn_with)}
    one.file.parent.mkdir(parents=True, exist_ok=True)
    replace_file(one.file, json.dumps(found).encode())
