"""Recorder that keeps a run in memory: campaigns, tests and benchmarks need no files."""

import numpy as np
from numpy.typing import NDArray

from bench.links.frame import FRAME_DTYPE


class MemoryRecorder:
    """Rows of the signal vector and, if wanted, frames of a run.

    Parameters
    ----------
    ticks, width : int
        Largest number of rows, and signals per row.
    keep_frames : bool
        Keep the frames too.
    """

    def __init__(self, ticks: int, width: int, keep_frames: bool = False) -> None:
        self._rows = np.empty((ticks, width))
        self._count = 0
        self._frames: list[NDArray[np.void]] | None = [] if keep_frames else None

    def write_row(self, values: NDArray[np.float64], tick: int) -> None:
        """Keep a row."""
        self._rows[self._count] = values
        self._count += 1

    def write_frames(self, frames: NDArray[np.void], count: int) -> None:
        """Keep copies of the frames of a tick."""
        if self._frames is not None:
            self._frames.append(frames[:count].copy())

    @property
    def rows(self) -> NDArray[np.float64]:
        """Rows so far, shape (ticks, signals)."""
        return self._rows[: self._count]

    @property
    def frames(self) -> NDArray[np.void]:
        """Frames so far."""
        # as bytes: numpy compares the fields of every piece that it joins, half a second for a minute of driving
        return np.frombuffer(bytearray().join(piece.data for piece in self._frames or ()), FRAME_DTYPE)
