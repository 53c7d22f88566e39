"""Runs of shipped scenarios, each made once: lock-step, ECU in the test's process, nothing written."""

import json
import sys
from collections.abc import Callable, Mapping
from functools import cache
from pathlib import Path
from typing import Any

import pytest

import bench
from bench.scenario.resolution import resolve
from bench.verdict.result import CriterionResult

sys.path.insert(0, str(Path(__file__).parent))


class JudgedRun:
    """A run and its criteria by id."""

    def __init__(self, run: bench.Run) -> None:
        self.run = run
        self.verdict = run.verdict
        self.criteria = {criterion.id: criterion for criterion in run.verdict.criteria}

    def __getitem__(self, identifier: str) -> CriterionResult:
        criterion: CriterionResult = self.criteria[identifier]
        return criterion

    def value(self, identifier: str) -> float:
        """Value of a criterion, in its SI unit."""
        value: float | None = self.criteria[identifier].value
        assert value is not None, f"{identifier}: {self.criteria[identifier].reason}"
        return value


Judge = Callable[..., JudgedRun]


@cache
def _judged(scenario: str, variant: str | None, sets: str, seed: int | None) -> JudgedRun:
    changes = json.loads(sets)
    # the ECU of a scenario without one stays away; any other runs in this process
    if resolve(scenario, changes, variant=variant).ecu.kind != "none":
        changes["ecu.kind"] = "inprocess"
    run = bench.run(scenario, pacing="lockstep", variant=variant, sets=changes, seed=seed, record=False)
    assert not run.verdict.errors, run.verdict.errors
    return JudgedRun(run)


@pytest.fixture(scope="session")
def judged() -> Judge:
    """``judged("friction/e10_abs_grip_jump", variant=None, sets={...})`` runs a scenario once per session."""

    def run(
        scenario: str, variant: str | None = None, sets: Mapping[str, Any] | None = None, seed: int | None = None
    ) -> JudgedRun:
        return _judged(scenario, variant, json.dumps(sets or {}, sort_keys=True), seed)

    return run


def limits_of(criterion: CriterionResult) -> str:
    """Limits of a criterion as the traceability table shows them."""
    low, high = criterion.limits
    if low is None and high is None:
        return "reported"
    if low is None:
        return f"at most {high:.4g} {criterion.unit}"
    if high is None:
        return f"at least {low:.4g} {criterion.unit}"
    return f"{low:.4g} ... {high:.4g} {criterion.unit}"


@pytest.fixture
def assert_passed(record: Callable[..., None]) -> Callable[..., None]:
    """``assert_passed(run, "A5_speed_plus", id="F-A5")``: records the value with its limit, and it has to pass."""

    def check(run: JudgedRun, identifier: str, *, id: str, quantity: str = "") -> None:
        criterion = run[identifier]
        name = " ".join(
            part for part in (quantity or criterion.id, "" if criterion.unit == "1" else criterion.unit) if part
        )
        record(name, run.value(identifier), limits_of(criterion), id=id)
        assert any(limit is not None for limit in criterion.limits), f"{identifier} has no limits"
        assert criterion.verdict == "pass", f"{identifier} = {criterion.value}, {criterion.limits}: {criterion.reason}"

    return check
