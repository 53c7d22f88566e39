"""Runs made for estimators: a scenario in memory, without its own estimators and criteria."""

from collections.abc import Mapping
from pathlib import Path
from typing import Any

from bench.estimation.source import Source


def make_run(
    scenario: str, sets: Mapping[str, Any] | None = None, *, seed: int | None = None, plant: str | None = None,
    variant: str | None = None,
) -> Source:  # fmt: skip
    """Run a scenario in lock-step with the controller in this process.

    Raises
    ------
    InputError
        If there is no such scenario, or a change does not fit it.
    """
    from bench.api import run
    from bench.scenario.resolution import resolve

    changes: dict[str, Any] = {"estimators": {}, "criteria": [], "valid_if": [], **(sets or {})}
    if resolve(scenario, changes, variant=variant).ecu.kind not in ("none", "inprocess"):
        changes["ecu.kind"] = "inprocess"
    made = run(scenario, sets=changes, pacing="lockstep", variant=variant, seed=seed, plant=plant, record=False)
    name = made.scenario.id if seed is None else f"{made.scenario.id} seed {seed}"
    return Source(Path(name), made.data, None, made.scenario.vehicle)
