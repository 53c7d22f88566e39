"""Outcome of a run under faults, against the fault-free run with the same variant and seed."""

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

from bench.campaign.campaign_file import Hazard
from bench.campaign.observation import REFUSALS
from bench.campaign.outcome_names import (
    BENCH_ERROR,
    CORRECTED,
    DEGRADED,
    HAZARDOUS,
    NO_EFFECT,
    SILENT,
    Outcome,
)
from bench.execution.job import DONE, RunRow
from signals.quantities import to_si

NO_VALUE_SEVERITY = 2.0
"""Severity of a hazard that the run has no value for, such as a car that does not stop: twice the limit."""


@dataclass(frozen=True)
class Judgement:
    """What a run was.

    Attributes
    ----------
    hazards : tuple of str
        Ids of the hazards whose limit is broken.
    severity : float
        Largest share of its limit that a hazard's value reaches; above 1 the run is hazardous.
    noticed : str
        Who noticed first: "" nobody, "bus" the protocol, "frame check" the protection, "monitor" a fault code.
    latency_s : float or None
        From the first instant of a fault to the fault code.
    """

    outcome: Outcome
    hazards: tuple[str, ...]
    severity: float
    noticed: str
    latency_s: float | None


def classify(row: RunRow, fault_free: RunRow, hazards: Sequence[Hazard], same_within: float) -> Judgement:
    """Judge a run.

    The classes exclude each other, the first that fits counts: a bench error; hazardous; detected and degraded safely,
    if the ECU stored a fault that the fault-free run does not store; no effect, if nobody noticed and the car moved the
    same, bit for bit; corrected by the protocol, if bus or frame checks noticed and the hazard values are those of the
    fault-free run within ``same_within``; detected and degraded safely, if the frame checks noticed; else silent but
    harmless: an error on the bus that nobody above the bus knows of does not count as detected.
    """
    if row.outcome != DONE or fault_free.outcome != DONE:
        return Judgement(BENCH_ERROR, (), 0.0, "", None)
    found = {hazard.id: severity(hazard, row, fault_free) for hazard in hazards}
    broken = tuple(name for name, value in found.items() if value > 1.0)
    worst = max(found.values(), default=0.0)
    noticed, latency = _detection(row, fault_free)
    if broken:
        return Judgement(HAZARDOUS, broken, worst, noticed, latency)
    if noticed == "monitor":
        return Judgement(DEGRADED, (), worst, noticed, latency)
    same_motion = row.observations["motion"] == fault_free.observations["motion"]
    if not noticed and same_motion:
        return Judgement(NO_EFFECT, (), worst, "", None)
    unaffected = all(
        abs(value - severity(hazard, fault_free, fault_free)) <= same_within
        for hazard, value in zip(hazards, found.values(), strict=True)
    )
    outcome: Outcome = SILENT
    if noticed and unaffected:
        outcome = CORRECTED
    elif noticed == "frame check":
        outcome = DEGRADED
    return Judgement(outcome, (), worst, noticed, latency)


def severity(hazard: Hazard, row: RunRow, fault_free: RunRow) -> float:
    """Share of a hazard's limit that a run reaches; 1 is the limit itself, a limit of 0 counts as 1 in its unit."""
    criterion = row.criteria.get(hazard.id, {})
    value = criterion.get("value")
    if value is None:
        return NO_VALUE_SEVERITY if hazard.no_value == "hazardous" else 0.0
    reference = fault_free.criteria.get(hazard.id, {}).get("value")
    shares = []
    for limit, sign in ((hazard.at_most, 1.0), (hazard.at_least, -1.0)):
        if limit is None:
            continue
        if hazard.of_fault_free:
            if reference is None:
                return NO_VALUE_SEVERITY
            bound = to_si(limit, "1") * float(reference)
        else:
            bound = to_si(limit, str(criterion.get("unit") or "1"))
        shares.append(1.0 + sign * (float(value) - bound) / (abs(bound) or 1.0))
    return max(0.0, *shares) if all(math.isfinite(share) for share in shares) else NO_VALUE_SEVERITY


def _detection(row: RunRow, fault_free: RunRow) -> tuple[str, float | None]:
    seen, before = row.observations, fault_free.observations
    if set(seen["fault_codes"]) - set(before["fault_codes"]):
        began, told = seen["began_s"], seen["fault_code_s"]
        return "monitor", None if began is None or told is None else max(told - began, 0.0)
    if refused(seen) > refused(before):
        return "frame check", None
    if _bus_errors(seen) > _bus_errors(before):
        return "bus", None
    return "", None


def refused(observations: Mapping[str, Any]) -> int:
    """Frames that ECU and bench refused."""
    return sum(int(observations["frames"][name]) for name in REFUSALS)


def _bus_errors(observations: Mapping[str, Any]) -> int:
    return int(observations["bus"].get("error_frames", 0))
