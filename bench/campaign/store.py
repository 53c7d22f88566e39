"""The store of a campaign: Parquet files with one row per run, complete at any instant.

Rows are written in parts. A part is written beside its place and moved there in one step, so that a process that is
killed leaves whole parts only; what was not yet in one is run again. When a campaign is complete its parts become one
file. Every tool that reads Parquet reads the folder ``runs``.
"""

import fcntl
import json
import os
import time
from collections.abc import Iterator, Sequence
from pathlib import Path
from types import TracebackType
from typing import IO, Any

from signals.errors import InputError, RunError

ROWS_PER_PART = 200
SECONDS_PER_PART = 5.0
_WHOLE = "all.parquet"
_ABOUT = "campaign.json"

_TEXTS = (
    "key",
    "variant",
    "outcome",
    "noticed",
    "verdict",
    "run_outcome",
    "reason",
    "phase",
    "scenario_hash",
    "motion",
    "job",
    "details",
)
_NUMBERS = ("severity", "latency_s", "stopping_distance_m", "distance_ratio", "lock_time_s", "yaw_rad", "wall_s")
_COUNTS = ("seed", "refused_frames", "lost_frames", "accepted_frames", "error_frames", "batch")
_TEXT_LISTS = ("faults", "entries", "messages", "fields", "disturbances", "e2e", "levels", "hazards")
_LISTS = {"times_s": "double", "bits": "int64", "fault_codes": "int64"}
UNREAD = ("job", "details")
"""Large columns that tables and charts do not need."""


def schema() -> Any:
    """Arrow schema of the store; docs/campaigns.md tells what the columns hold."""
    import pyarrow as pa

    fields = [(name, pa.string()) for name in _TEXTS]
    fields += [(name, pa.float64()) for name in _NUMBERS]
    fields += [(name, pa.int64()) for name in _COUNTS]
    fields += [(name, pa.list_(pa.string())) for name in _TEXT_LISTS]
    fields += [(name, pa.list_(pa.type_for_alias(kind))) for name, kind in _LISTS.items()]
    fields += [("fault_free", pa.bool_()), ("values", pa.map_(pa.string(), pa.float64()))]
    return pa.schema(fields)


class Store:
    """Rows of one campaign in its folder; one process at a time may write.

    Parameters
    ----------
    folder : Path
        Of the campaign; made if it is not there.
    about : dict
        What the campaign is; a folder that holds another one is refused.

    Raises
    ------
    InputError
        If the folder holds another campaign.
    RunError
        If another process writes to it, or it cannot be written.
    """

    def __init__(self, folder: Path, about: dict[str, Any]) -> None:
        self.folder = folder
        self._rows = folder / "runs"
        try:
            self._rows.mkdir(parents=True, exist_ok=True)
            self._lock: IO[bytes] = (folder / "lock").open("wb")
        except OSError as error:
            raise RunError(f"{folder}: {(error.strerror or str(error)).lower()}") from None
        try:
            fcntl.flock(self._lock, fcntl.LOCK_EX | fcntl.LOCK_NB)
        except OSError:
            raise RunError(f"{folder}: another process is running this campaign") from None
        self._take(about)
        for leftover in self._rows.glob("*.partial"):
            leftover.unlink()
        self._waiting: list[dict[str, Any]] = []
        self._last_write = time.monotonic()
        self._next_part = 1 + max((int(path.stem[5:]) for path in self._rows.glob("part-*.parquet")), default=0)

    def _take(self, about: dict[str, Any]) -> None:
        path = self.folder / _ABOUT
        if path.exists():
            known = read_about(self.folder)
            if known["identity"] != about["identity"]:
                raise InputError(
                    f"{self.folder} holds another campaign, or an older state of this one",
                    mend="choose another folder: --out DIR; or remove it",
                )
            return
        _write_whole(path, json.dumps(about, indent=2, ensure_ascii=False).encode())

    def __enter__(self) -> "Store":
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        self.flush()
        self._lock.close()

    def add(self, row: dict[str, Any]) -> None:
        """Take a row; it is on the disk after `SECONDS_PER_PART` or `ROWS_PER_PART` rows at the latest."""
        self._waiting.append(row)
        if len(self._waiting) >= ROWS_PER_PART or time.monotonic() - self._last_write > SECONDS_PER_PART:
            self.flush()

    def flush(self) -> None:
        """Write what waits."""
        if self._waiting:
            _write_table(self._rows / f"part-{self._next_part:06d}.parquet", self._waiting)
            self._next_part += 1
            self._waiting = []
        self._last_write = time.monotonic()

    def drop(self, keys: set[str]) -> None:
        """Forget rows, so that their runs are made again."""
        if keys:
            self._replace([row for row in self.rows() if row["key"] not in keys])

    def join(self) -> None:
        """Make one file of all parts."""
        self.flush()
        self._replace(list(self.rows()))

    def rows(self) -> Iterator[dict[str, Any]]:
        """Every row on the disk, whole, each run once."""
        return read_rows(self.folder, columns=None)

    def _replace(self, rows: Sequence[dict[str, Any]]) -> None:
        # a kill between these two steps leaves parts beside the whole; each row is then read once all the same
        _write_table(self._rows / _WHOLE, rows)
        for part in self._rows.glob("part-*.parquet"):
            part.unlink()


def read_about(folder: Path) -> dict[str, Any]:
    """What a campaign's folder says of itself.

    Raises
    ------
    InputError
        If it is no such folder.
    """
    try:
        about: dict[str, Any] = json.loads((folder / _ABOUT).read_text(encoding="utf-8"))
    except (OSError, ValueError):
        raise InputError(f"{folder}: no folder of a campaign", mend="bench campaign run FILE makes one") from None
    return about


def read_rows(folder: Path, columns: Sequence[str] | None = ()) -> Iterator[dict[str, Any]]:
    """Rows of a campaign, each run once, in the order in which they were stored.

    Parameters
    ----------
    columns : sequence of str, optional
        Columns to read; None for all of them, nothing for all but the large ones.
    """
    import pyarrow.parquet as pq

    wanted = [name for name in schema().names if name not in UNREAD] if columns == () else columns
    seen: set[str] = set()
    for path in sorted((folder / "runs").glob("*.parquet")):
        for row in pq.read_table(path, columns=list(wanted) if wanted is not None else None).to_pylist():
            if row["key"] not in seen:
                seen.add(row["key"])
                row["values"] = dict(row.get("values") or [])
                yield row


def find_row(folder: Path, key: str) -> dict[str, Any] | None:
    """The whole row of a run, by its key or the beginning of it; None if there is none, or more than one."""
    import pyarrow.parquet as pq

    found: dict[str, dict[str, Any]] = {}
    for path in sorted((folder / "runs").glob("*.parquet")):
        keys = pq.read_table(path, columns=["key"])["key"].to_pylist()
        rows = [number for number, other in enumerate(keys) if other.startswith(key)]
        if rows:
            found |= {row["key"]: row for row in pq.read_table(path).take(rows).to_pylist()}
    return next(iter(found.values())) if len(found) == 1 else None


def _write_table(path: Path, rows: Sequence[dict[str, Any]]) -> None:
    import pyarrow as pa
    import pyarrow.parquet as pq

    partial = path.with_name(f".{path.name}.partial")
    try:
        pq.write_table(pa.Table.from_pylist(list(rows), schema=schema()), partial, compression="zstd")
        _move_durably(partial, path)
    except OSError as error:
        raise RunError(f"{path}: {(error.strerror or str(error)).lower()}") from None


def _write_whole(path: Path, content: bytes) -> None:
    partial = path.with_name(f".{path.name}.partial")
    partial.write_bytes(content)
    _move_durably(partial, path)


def _move_durably(partial: Path, path: Path) -> None:
    with partial.open("rb") as stream:
        os.fsync(stream.fileno())
    os.replace(partial, path)
