"""One run of a campaign again, with everything that a run leaves behind."""

from dataclasses import dataclass
from pathlib import Path
from typing import Any

from bench.campaign.folders import find_run
from bench.campaign.observation import motion_hash
from bench.campaign.outcome_names import OUTCOME_TEXTS
from bench.execution.job import Job


@dataclass(frozen=True)
class Repeated:
    """A run that was repeated.

    Attributes
    ----------
    row : dict
        Of the campaign's store.
    folder : Path
        Of the repetition.
    motion : str
        Hash of the car's motion, now.
    verdict : str
        Of the repetition, by the hazards with absolute limits.
    """

    row: dict[str, Any]
    folder: Path
    motion: str
    verdict: str

    @property
    def same(self) -> bool:
        """Whether the car moved as in the campaign, bit for bit."""
        return bool(self.motion == self.row["motion"])

    def as_json(self) -> dict[str, Any]:
        """Plain data."""
        return {
            "key": self.row["key"],
            "outcome": self.row["outcome"],
            "faults": self.row["faults"],
            "times_s": self.row["times_s"],
            "same_motion": self.same,
            "verdict": self.verdict,
            "folder": str(self.folder),
        }

    def lines(self) -> list[str]:
        """Text for people."""
        row = self.row
        faults = [
            fault if time is None else f"{fault} at {time:g} s"
            for fault, time in zip(row["faults"], row["times_s"], strict=True)
        ]
        same = "the car moved the same, bit for bit" if self.same else "the car did NOT move as in the campaign"
        return [
            f"run       {row['key']}: {'; '.join(faults) or 'no fault'}",
            f"campaign  {OUTCOME_TEXTS[row['outcome']]}{': ' if row['hazards'] else ''}{', '.join(row['hazards'])}",
            f"again     {same}",
            f"report: {self.folder / 'report.html'}",
        ]


def repeat(key: str, campaign: str | None, out: Path | None) -> Repeated:
    """Make a run of a campaign again, alone, with recording and report.

    Raises
    ------
    InputError
        If there is no such run.
    """
    from bench.loop.runs import run_recorded

    folder, row = find_run(key, campaign)
    scenario = Job(str(row["key"]), str(row["job"]), int(str(row["seed"]))).scenario_file()
    run = run_recorded(scenario, out or folder / "show" / str(row["key"]))
    return Repeated(row, run.folder or folder, motion_hash(run.data), run.verdict.verdict)
