"""Texts and tables of the page around the charts."""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

from bench.report.criteria_table import CriterionRow, criterion_rows
from bench.report.formatting import display, metric_label, number, size_text
from bench.report.instants import Instant, find_instant
from bench.report.run_data import RunData, started_at

_FILES = (
    ("signals.mf4", "all signals with units, MDF 4"),
    ("signals.mcap", "signals as they were streamed"),
    ("frames.blf", "every frame with direction and channel"),
    ("frames.asc", "every frame as text"),
    ("verdict.json", "verdict, metrics, timing"),
    ("junit.xml", "verdict for CI"),
    ("scenario.yaml", "scenario as run, all defaults resolved"),
    ("log.txt", "log of the run"),
)

_TILES = (
    "stopping_distance_m",
    "mean_deceleration_m_s2",
    "mfdd_m_s2",
    "lock_time_s",
    "max_abs_yaw_rate_rad_s",
    "lateral_offset_m",
)
_TILE_LABELS = {
    "lock_time_s": "longest wheel lock",
    "lateral_offset_m": "lateral offset",
}


@dataclass(frozen=True)
class Tile:
    """A key figure."""

    label: str
    value: str
    unit: str


def criteria(run: RunData) -> list[tuple[CriterionRow, Instant | None]]:
    """Verdict table with the instant to look at, the worst first."""
    by_id = {str(entry.get("id", "")): entry for entry in run.verdict.get("criteria", [])}
    return [(row, find_instant(run, by_id[row.id])) for row in criterion_rows(run.verdict)]


def tiles(run: RunData) -> list[Tile]:
    """Key figures of the run."""
    found = []
    metrics = run.verdict.get("metrics") or {}
    for name in _TILES:
        value = metrics.get(name)
        if isinstance(value, list):
            known = [item for item in value if isinstance(item, (int, float))]
            value = max(known) if known else None
        if value is None:
            continue
        label, unit = metric_label(name)
        shown, shown_unit = display(float(value), unit)
        found.append(Tile(_TILE_LABELS.get(name, label), number(shown, 3), shown_unit))
    return [*found, *_timing_tiles(run)]


def _timing_tiles(run: RunData) -> list[Tile]:
    timing = run.timing
    lateness = timing.get("lateness_us")
    found = []
    if run.real_time and isinstance(lateness, dict) and isinstance(lateness.get("p99"), (int, float)):
        found.append(Tile("lateness p99", number(lateness["p99"], 3), "µs"))
        found.append(Tile("overruns", number(timing.get("overruns")), "ticks"))
    elif isinstance(timing.get("real_time_factor"), (int, float)):
        found.append(Tile("speed of the run", number(timing["real_time_factor"], 3), "× real time"))
    return found


def facts(run: RunData) -> list[tuple[str, str]]:
    """How the run was made, in a few words."""
    modes = {"realtime": "real time", "lockstep": "lock-step"}
    started = started_at(run.folder)
    entries: list[tuple[str, Any]] = [
        ("ECU", _nested(run.scenario, "ecu", "kind")),
        ("link", _nested(run.timing, "link", "text") or _nested(run.scenario, "ecu", "link")),
        ("paced by", modes.get(str(run.timing.get("mode")), run.timing.get("mode"))),
        ("vehicle", run.scenario.get("vehicle")),
        ("plant", run.scenario.get("plant")),
        ("seed", run.verdict.get("seed")),
        ("started", f"{started:%Y-%m-%d %H:%M}" if started is not None else None),
    ]
    if len(run.time):
        entries.append(("simulated", f"{number(float(run.time[-1] - run.time[0]), 3)} s"))
    return [(label, str(value)) for label, value in entries if isinstance(value, (str, int, float))]


def _nested(mapping: Mapping[str, Any], *keys: str) -> Any:
    value: Any = mapping
    for key in keys:
        value = value.get(key) if isinstance(value, Mapping) else None
    return value


def files(run: RunData) -> list[tuple[str, str, str]]:
    """Name, purpose and size of what stands in the run's folder."""
    finished = (run.folder / "signals.mf4").exists()
    kept = [entry for entry in _FILES if not (finished and entry[0] == "signals.mcap")]
    present = [(name, purpose, run.folder / name) for name, purpose in kept]
    return [(name, purpose, size_text(path.stat().st_size)) for name, purpose, path in present if path.exists()]
