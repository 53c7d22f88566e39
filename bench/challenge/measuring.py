"""What a score needs more fits for: the held-out gain of the true effect, and look-alikes with the proposed data.

In worker processes like the diagnoses; what a run that was broken off has measured is kept.
"""

import json
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from bench.challenge.answering import in_workers, write_whole
from bench.challenge.planned import separated_by_plan
from bench.challenge.true_gain import GAINING_FAMILIES, gain_share


@dataclass(frozen=True)
class Measurement:
    """One case to measure at, and where the result goes.

    Attributes
    ----------
    case, planned, file : the case's folder, an empty one for it with more data, the result
    label, diagnosis : what is hidden and what was answered
    drawn_with : seed, index, family and generator of the case
    with_gain, with_plan : which of the two is asked for
    """

    case: Path
    planned: Path
    file: Path
    label: Mapping[str, Any]
    diagnosis: Mapping[str, Any]
    drawn_with: Mapping[str, Any]
    with_gain: bool
    with_plan: bool

    @property
    def gains(self) -> bool:
        """True where the gain of the true effect is asked for and there is one."""
        return self.with_gain and self.label["family"] in GAINING_FAMILIES

    @property
    def plans(self) -> bool:
        """True where it is asked for whether proposed data separates look-alikes, and some are hidden."""
        return self.with_plan and self.label["family"] == "confounded"


def measure_all(
    measurements: Sequence[Measurement], jobs: int, told: Callable[[str, int, int], None] | None = None
) -> dict[str, dict[str, Any]]:
    """``gain_share`` and ``separated`` by name of the case, of those that either is measured at."""
    measurements = [one for one in measurements if one.gains or one.plans]
    for one in measurements:
        one.file.parent.mkdir(parents=True, exist_ok=True)
    missing = [one for one in measurements if not one.file.is_file()]
    done = len(measurements) - len(missing)
    for number in in_workers(_measure, [(one,) for one in missing], jobs):
        done += 1
        if told is not None:
            told(missing[number].case.name, done, len(measurements))
    return {one.case.name: json.loads(one.file.read_text(encoding="utf-8")) for one in measurements}


def _measure(one: Measurement) -> None:
    found: dict[str, Any] = {"gain_share": None, "separated": None}
    if one.gains:
        found["gain_share"] = gain_share(one.case, one.label, one.diagnosis)
    if one.plans:
        found["separated"] = separated_by_plan(one.planned, one.label, one.diagnosis, **one.drawn_with)
    write_whole(one.file, found)
