"""From a worker's row to the row of the store: what was injected, what it did, what the run would need again."""

import json
from collections.abc import Mapping
from typing import Any

from bench.campaign.classification import Judgement, refused
from bench.campaign.fault_space import FaultSpace, Injection, Point
from bench.execution.job import Job, RunRow


def stored_row(
    space: FaultSpace, point: Point, job: Job, row: RunRow, judgement: Judgement, fault_free: RunRow, batch: int
) -> dict[str, Any]:
    """A row of the store."""
    injections = space.injections_of(point)
    seen = row.observations
    metrics = row.metrics
    return {
        "key": job.key,
        "fault_free": not injections,
        "variant": space.variants[point[0]].name,
        "seed": row.seed,
        "batch": batch,
        **_injected(injections),
        "phase": _phase(injections, fault_free.observations.get("phases", {})),
        "outcome": judgement.outcome,
        "severity": judgement.severity,
        "hazards": list(judgement.hazards),
        "noticed": judgement.noticed,
        "latency_s": judgement.latency_s,
        "fault_codes": seen.get("fault_codes", []),
        "refused_frames": refused(seen) if seen else 0,
        "lost_frames": seen["frames"]["lost"] if seen else 0,
        "accepted_frames": seen["frames"]["accepted"] if seen else 0,
        "error_frames": int(seen.get("bus", {}).get("error_frames", 0)),
        "stopping_distance_m": metrics.get("stopping_distance_m"),
        "distance_ratio": _ratio(metrics, fault_free.metrics),
        "lock_time_s": max((value for value in metrics.get("lock_time_s") or [] if value is not None), default=None),
        "yaw_rad": metrics.get("yaw_rad"),
        "values": {name: entry.get("value") for name, entry in row.criteria.items()},
        "verdict": row.verdict,
        "run_outcome": row.outcome,
        "reason": row.reason,
        "scenario_hash": row.scenario_hash,
        "motion": seen.get("motion", ""),
        "wall_s": row.wall_s,
        "job": job.scenario,
        "details": json.dumps(row.as_json(), separators=(",", ":")),
    }


def run_row(stored: Mapping[str, Any]) -> RunRow:
    """The worker's row out of a row of the store."""
    return RunRow(**json.loads(stored["details"]))


def _injected(injections: list[Injection]) -> dict[str, Any]:
    places = [item.place for item in injections]
    return {
        "faults": [item.label for item in injections],
        "entries": [item.name for item in injections],
        "times_s": [item.time_s for item in injections],
        "messages": [place.message for place in places],
        "fields": [place.field for place in places],
        "bits": [place.bit for place in places],
        "disturbances": [place.disturbance for place in places],
        "e2e": [place.e2e for place in places],
        "levels": [place.level for place in places],
    }


def _phase(injections: list[Injection], phases: Mapping[str, float]) -> str:
    """Step of the fault-free manoeuvre in which the first fault begins."""
    times = [item.time_s for item in injections if item.time_s is not None]
    if not times:
        return ""
    return max((start, name) for name, start in [("", -1.0), *phases.items()] if start <= min(times))[1]


def _ratio(metrics: Mapping[str, Any], reference: Mapping[str, Any]) -> float | None:
    distance, usual = metrics.get("stopping_distance_m"), reference.get("stopping_distance_m")
    return None if distance is None or not usual else distance / usual
