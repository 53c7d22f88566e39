"""Rows and frames of a run that is not finished: what the files hold, and after it what only the ring holds."""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from fnmatch import fnmatchcase
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from bench.links.frame import FRAME_DTYPE
from bench.recording.arrays import RunArrays
from bench.recording.frame_file import read_blf
from bench.recording.ring import FRAMES_LOST, RingReader
from bench.recording.run_folder import FRAME_FILE, STREAM_FILE
from bench.recording.schema import RunSchema
from bench.recording.signal_file import Rows, read_signal_file
from signals.errors import InputError

MATCHED_FRAMES = 8


@dataclass
class StoredRun:
    """Everything that is left of a run.

    Attributes
    ----------
    schema : RunSchema or None
        None if the run was killed before anything was written.
    rows : list of (first, ticks, values)
        Consecutive rows; a gap between two entries was lost.
    frames : ndarray of FRAME_DTYPE
    """

    schema: RunSchema | None
    rows: list[Rows] = field(default_factory=list)
    frames: NDArray[np.void] = field(default_factory=lambda: np.zeros(0, FRAME_DTYPE))

    @property
    def row_count(self) -> int:
        """Rows that are there."""
        return sum(len(ticks) for _, ticks, _ in self.rows)

    def arrays(self, timing: Mapping[str, Any] | None = None) -> RunArrays:
        """The rows as signals.

        Raises
        ------
        InputError
            If nothing was recorded, not even what a row holds.
        """
        if self.schema is None:
            raise InputError("nothing was recorded")
        values = [block for _, _, block in self.rows]
        matrix = np.concatenate(values) if values else np.zeros((0, len(self.schema.signals)))
        information = self.schema.information | {"start_time_ns": self.schema.start_time_ns}
        return RunArrays.from_matrix(
            matrix,
            self.schema.signals,
            phase_names=self.schema.phase_names,
            timing=timing,
            information=information,
        )

    def chosen(self, patterns: Sequence[str]) -> tuple[RunSchema, Iterator[Rows]]:
        """Schema and rows with only the signals that a pattern fits, and the time."""
        schema = self.schema or RunSchema(())
        columns = [
            position
            for position, name in enumerate(schema.names)
            if name == "time" or any(fnmatchcase(name, pattern) for pattern in patterns)
        ]
        if len(columns) == len(schema.signals):
            return schema, iter(self.rows)
        chosen = replace(schema, signals=tuple(schema.signals[position] for position in columns))
        return chosen, ((first, ticks, values[:, columns]) for first, ticks, values in self.rows)

    @property
    def last_time_s(self) -> float:
        """Time of the last row, 0 without any."""
        if self.schema is None or not self.rows:
            return 0.0
        return float(self.rows[-1][2][-1, self.schema.names.index("time")])


def read_stored(folder: Path, ring_path: Path | None = None) -> StoredRun:
    """Read what a run has left in its folder and in its ring."""
    stream = folder / STREAM_FILE
    schema, blocks = read_signal_file(stream) if stream.is_file() else (None, iter(()))
    rows = list(blocks)
    frame_file = folder / FRAME_FILE
    frames = read_blf(frame_file) if frame_file.is_file() else np.zeros(0, FRAME_DTYPE)
    ring = _open_ring(ring_path)
    if ring is None:
        return StoredRun(schema, rows, frames)
    rows += _rows_after(ring, rows)
    return StoredRun(schema or ring.schema, rows, _with_ring_frames(frames, ring))


def _open_ring(path: Path | None) -> RingReader | None:
    if path is None or not path.is_file():
        return None
    try:
        return RingReader(path)
    except InputError:
        # killed while the ring was being made: nothing was in it yet
        return None


def _rows_after(ring: RingReader, rows: list[Rows]) -> Iterator[Rows]:
    """Rows of the ring that the file does not hold."""
    due = rows[-1][0] + len(rows[-1][1]) if rows else 0
    first, ticks, values = ring.take_rows()
    skip = min(max(due - first, 0), len(ticks))
    if len(ticks) > skip:
        yield first + skip, ticks[skip:], values[skip:]


def _with_ring_frames(frames: NDArray[np.void], ring: RingReader) -> NDArray[np.void]:
    """Frames of the file, then those that only the ring holds.

    The file holds the first frames of the run without numbers, so their count is the number of the next, unless the
    recorder was late and lost some; the last frames of the file tell which of the two holds.
    """
    first, records = ring.take_frames()
    lost = int(ring.control[FRAMES_LOST])
    for due in dict.fromkeys((len(frames), len(frames) + lost)):
        skip = due - first
        if skip <= 0:
            return np.concatenate([frames, records])
        if skip <= len(records) and _same_tail(frames, records[:skip]):
            return np.concatenate([frames, records[skip:]])
    newer = records["timestamp_ns"] > (frames["timestamp_ns"].max() if len(frames) else -1)
    return np.concatenate([frames, records[newer]])


def _same_tail(frames: NDArray[np.void], records: NDArray[np.void]) -> bool:
    count = min(len(frames), len(records), MATCHED_FRAMES)
    ours, theirs = frames[len(frames) - count :], records[len(records) - count :]
    return all(np.array_equal(ours[name], theirs[name]) for name in ("identifier", "length", "data"))
