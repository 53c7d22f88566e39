"""A run's folder as the report reads it: verdict, resolved scenario, signals, frames, steps of the manoeuvre."""

import json
from collections.abc import Mapping
from dataclasses import dataclass, field
from datetime import datetime
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from bench.recording.arrays import RunArrays
from bench.report.thinning import segments
from signals.errors import InputError
from signals.wheels import WHEELS

FloatArray = NDArray[np.float64]
BEFORE_BRAKE_S = 0.5


@dataclass(frozen=True)
class Step:
    """One visit to a step of the manoeuvre."""

    name: str
    start_s: float
    end_s: float

    def inline(self) -> dict[str, Any]:
        """Form for the page's script."""
        return {"name": self.name, "start": self.start_s, "end": self.end_s}


@dataclass
class RunData:
    """What is known of a run.

    Attributes
    ----------
    folder
        The run's folder.
    verdict, scenario
        ``verdict.json`` and the resolved scenario as plain mappings; empty where the run ended before they were there.
    scenario_text
        The scenario file as it stands in the folder.
    signals
        Signals on the time base of the run; None where nothing was recorded.
    frames
        Records of ``bench.links.frame.FRAME_DTYPE``; empty where no frame was recorded.
    remarks
        What could not be read, for the reader of the report.
    """

    folder: Path
    verdict: dict[str, Any]
    scenario: dict[str, Any] = field(default_factory=dict)
    scenario_text: str = ""
    signals: RunArrays | None = None
    frames: NDArray[np.void] | None = None
    remarks: list[str] = field(default_factory=list)

    @property
    def name(self) -> str:
        """Id of the scenario."""
        return str(self.verdict.get("scenario") or self.folder.name)

    @property
    def title(self) -> str:
        """One line on what the scenario is, with a capital letter; its id where it has none."""
        title = str(self.scenario.get("title") or "")
        return title[:1].upper() + title[1:] if title else self.name

    @property
    def outcome(self) -> str:
        """Verdict of the run; a run without one has not ended properly: error."""
        return str(self.verdict.get("verdict") or "error")

    @property
    def timing(self) -> Mapping[str, Any]:
        """Timing block of the verdict."""
        timing = self.verdict.get("timing")
        return timing if isinstance(timing, dict) else {}

    @property
    def real_time(self) -> bool:
        """Whether the run was paced by the clock."""
        return bool(self.timing.get("mode") == "realtime")

    def has(self, *names: str) -> bool:
        """Whether all these signals were recorded."""
        return self.signals is not None and all(name in self.signals for name in names)

    def has_wheels(self, name: str) -> bool:
        """Whether a signal was recorded for all four wheels."""
        return self.has(*(f"{name}_{wheel}" for wheel in WHEELS))

    def array(self, name: str) -> FloatArray:
        """Values of a signal in SI units; KeyError where it was not recorded."""
        if self.signals is None:
            raise KeyError(name)
        return self.signals.array(name)

    @property
    def time(self) -> FloatArray:
        """Time of the rows, in s."""
        return self.signals.time if self.signals is not None else np.zeros(0)

    def steps(self) -> list[Step]:
        """Steps of the manoeuvre in the order in which they were visited."""
        if self.signals is None or not self.has("manoeuvre_phase"):
            return []
        names = self.signals.phase_names
        return [
            Step(names[state] if 0 <= state < len(names) else f"step {state + 1}", start, end)
            for start, end, state in segments(self.time, self.array("manoeuvre_phase"))
        ]

    def brake_start_s(self) -> float | None:
        """Instant at which the driver begins to brake, None if nobody did."""
        pressed = np.zeros(len(self.time), np.bool_)
        for name in ("driver_pedal_force", "driver_master_pressure"):
            if self.has(name):
                pressed |= self.array(name) > 0.0
        return float(self.time[int(np.argmax(pressed))]) if pressed.any() else None

    def focus(self) -> tuple[float, float] | None:
        """The stop, where much happened before it; None where the whole run is as well shown at once."""
        start = self.brake_start_s()
        if start is None or self.time[-1] - start > 0.6 * (self.time[-1] - self.time[0]):
            return None
        return max(float(self.time[0]), start - BEFORE_BRAKE_S), float(self.time[-1])


def started_at(folder: Path) -> datetime | None:
    """Start of a run: the first word of its log, else the date of its first file."""
    try:
        with (folder / "log.txt").open(encoding="utf-8") as log:
            return datetime.fromisoformat(log.readline().split(" ", 1)[0]).astimezone()
    except (OSError, ValueError):
        pass
    dates = [path.stat().st_mtime for name in ("scenario.yaml", "verdict.json") if (path := folder / name).exists()]
    return datetime.fromtimestamp(min(dates)).astimezone() if dates else None


def find_run(run: str | Path) -> Path:
    """Folder of a run given by its path or by its name under ``runs/``.

    Raises
    ------
    InputError
        If there is no such folder.
    """
    for candidate in (Path(run), Path("runs") / run):
        folder = candidate.parent if candidate.name == "verdict.json" else candidate
        if folder.is_dir():
            return folder
    raise InputError(f"{run}: no such run folder", mend="see what there is: bench runs")


def read_json(path: Path) -> dict[str, Any]:
    """A JSON object, or an empty one where the file is missing.

    Raises
    ------
    InputError
        If the file is no JSON object.
    """
    if not path.exists():
        return {}
    try:
        content = json.loads(path.read_text(encoding="utf-8"))
    except (ValueError, OSError) as error:
        raise InputError(f"{path}: not readable: {error}", mend=f"try: bench recover {path.parent}") from None
    if not isinstance(content, dict):
        raise InputError(f"{path}: not a JSON object", mend=f"try: bench recover {path.parent}")
    return content
