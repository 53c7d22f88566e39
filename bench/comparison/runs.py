"""Run folders as a table: what ran, when, with which verdict and which key figures."""

from collections.abc import Mapping
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any

from rich.table import Table
from rich.text import Text

from bench.report.formatting import VERDICT_SYMBOLS, number
from bench.report.run_data import read_json, started_at
from bench.report.summary import VERDICT_STYLES
from signals.errors import InputError

UNFINISHED = "unfinished"
_SEARCH_DEPTH = 3


@dataclass(frozen=True)
class RunEntry:
    """One run folder.

    Attributes
    ----------
    verdict
        pass, inconclusive, fail or error; "unfinished" where the run goes on or was cut off.
    started
        Local time as ISO 8601, empty if it is not known.
    """

    path: str
    scenario: str
    verdict: str
    started: str
    seed: int | None
    mode: str | None
    stopping_distance_m: float | None
    mean_deceleration_m_s2: float | None
    longest_lock_s: float | None
    lateness_p99_us: float | None

    def as_json(self) -> dict[str, Any]:
        """The entry as plain data."""
        return asdict(self)


def list_runs(root: Path) -> list[RunEntry]:
    """Runs below a folder, the newest last.

    Raises
    ------
    InputError
        If there is no such folder.
    """
    if not root.is_dir():
        raise InputError(f"{root}: no such folder", mend="runs are written there by: bench run SCENARIO")
    folders = [path.parent for depth in range(_SEARCH_DEPTH) for name in ("verdict.json", "run.json")
               for path in root.glob("/".join(["*"] * depth + [name]))]  # fmt: skip
    entries = [_entry(folder) for folder in sorted(set(folders)) if not folder.name.startswith(".")]
    return sorted(entries, key=lambda entry: (entry.started, entry.path))


def _entry(folder: Path) -> RunEntry:
    try:
        verdict = read_json(folder / "verdict.json")
        state = read_json(folder / "run.json") if not verdict else {}
    except InputError:
        verdict, state = {}, {}
    started = started_at(folder)
    metrics, timing = _mapping(verdict, "metrics"), _mapping(verdict, "timing")
    return RunEntry(
        path=str(folder),
        scenario=str(verdict.get("scenario") or state.get("scenario") or ""),
        verdict=str(verdict.get("verdict") or UNFINISHED),
        started=started.isoformat(timespec="seconds") if started is not None else "",
        seed=verdict.get("seed"),
        mode=timing.get("mode"),
        stopping_distance_m=metrics.get("stopping_distance_m"),
        mean_deceleration_m_s2=metrics.get("mean_deceleration_m_s2"),
        longest_lock_s=_largest(metrics.get("lock_time_s")),
        lateness_p99_us=_mapping(timing, "lateness_us").get("p99") if timing.get("mode") == "realtime" else None,
    )


def _mapping(parent: Mapping[str, Any], key: str) -> Mapping[str, Any]:
    value = parent.get(key)
    return value if isinstance(value, Mapping) else {}


def _largest(values: Any) -> float | None:
    known = [value for value in values if isinstance(value, (int, float))] if isinstance(values, list) else []
    return max(known) if known else None


def runs_table(entries: list[RunEntry], root: Path) -> Table:
    """The runs for a terminal."""
    table = Table(box=None, pad_edge=False, padding=(0, 2, 0, 0), header_style="dim")
    table.add_column("verdict", no_wrap=True)
    table.add_column("run", overflow="fold")
    table.add_column("scenario", overflow="fold")
    table.add_column("started", no_wrap=True)
    for head in ("stop", "decel", "lock", "late p99"):
        table.add_column(head, justify="right", no_wrap=True)
    for entry in entries:
        style = VERDICT_STYLES.get(entry.verdict, "dim")
        symbol = VERDICT_SYMBOLS.get(entry.verdict, "·")
        table.add_row(
            Text(f"{symbol} {entry.verdict}", style=style),
            _relative(entry.path, root),
            entry.scenario,
            entry.started[:16].replace("T", " "),
            _with_unit(entry.stopping_distance_m, "m"),
            _with_unit(entry.mean_deceleration_m_s2, "m/s²"),
            _with_unit(entry.longest_lock_s, "s"),
            _with_unit(entry.lateness_p99_us, "µs"),
        )
    return table


def _relative(path: str, root: Path) -> str:
    folder = Path(path)
    return str(folder.relative_to(root)) if folder != root else str(folder)


def _with_unit(value: float | None, unit: str) -> str:
    return f"{number(value, 3)} {unit}" if value is not None else ""
