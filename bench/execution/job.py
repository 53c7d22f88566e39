"""What goes to a worker and what comes back."""

import hashlib
from dataclasses import asdict, dataclass, field
from typing import Any, Literal

from bench.scenario.schema import ScenarioFile

Outcome = Literal["done", "error", "lost"]
DONE: Outcome = "done"
ERROR: Outcome = "error"
LOST: Outcome = "lost"


@dataclass(frozen=True)
class Job:
    """One run to make.

    Attributes
    ----------
    key : str
        The caller's name of the job; its row carries it back.
    scenario : str
        Resolved scenario as JSON (see :func:`job_of`).
    seed : int, optional
        In place of the scenario's.
    """

    key: str
    scenario: str
    seed: int | None = None

    def scenario_file(self) -> ScenarioFile:
        """The scenario as it is run."""
        scenario = ScenarioFile.model_validate_json(self.scenario)
        return scenario if self.seed is None else scenario.model_copy(update={"seed": self.seed})


@dataclass(frozen=True)
class RunRow:
    """Result of one job: plain data, no signals.

    Attributes
    ----------
    outcome : {"done", "error", "lost"}
        done: there is a verdict; error: the run raised an error; lost: the worker died in it, twice.
    verdict : str
        pass, inconclusive, fail or error (also for "error" and "lost").
    scenario_hash : str
        Of the scenario as run (:func:`hash_of`).
    criteria : dict
        By id: value, unit, limits, margin and verdict of each criterion.
    metrics : dict
        As in ``verdict.json``.
    observations : dict
        What the pool's ``observe`` made of the run.
    reason : str
        Why there is no result.
    wall_s : float
        Time that the worker spent; not part of what a repetition reproduces.
    """

    key: str
    scenario: str
    seed: int
    scenario_hash: str
    outcome: Outcome
    verdict: str
    criteria: dict[str, dict[str, Any]] = field(default_factory=dict)
    metrics: dict[str, Any] = field(default_factory=dict)
    observations: dict[str, Any] = field(default_factory=dict)
    reason: str = ""
    wall_s: float = 0.0

    def as_json(self) -> dict[str, Any]:
        """The row as plain data."""
        return asdict(self)


def job_of(scenario: ScenarioFile, *, key: str = "", seed: int | None = None) -> Job:
    """Job of a resolved scenario: in virtual time, the controller in the worker's process, no files.

    Parameters
    ----------
    scenario : ScenarioFile
        As ``bench.scenario.resolve`` gives it.
    key : str
        By default the scenario's id.
    seed : int, optional
        In place of the scenario's.
    """
    ecu = scenario.ecu
    if ecu.kind != "none":
        ecu = ecu.model_copy(update={"kind": "inprocess", "link": None})
    as_run = scenario.model_copy(update={"ecu": ecu, "pacing": "lockstep"})
    return Job(key or scenario.id, as_run.model_dump_json(exclude_none=True), seed)


def hash_of(scenario: ScenarioFile) -> str:
    """Hash of a resolved scenario, its seed included: two runs with the same hash are the same run."""
    return hashlib.sha256(scenario.model_dump_json(exclude_none=True).encode()).hexdigest()[:16]
