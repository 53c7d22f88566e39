"""The ring between the loop and its helper processes: a plain memory-mapped file with one writer.

Layout: header (magic, size, schema as JSON), control words, ticks, rows, frames; each part begins on a page. The writer
stores a row and then raises its counter, so a row behind the counter is whole even if the writer was killed in the
middle of the next. The file outlives kill -9 of everybody; ``bench recover`` reads it.

In lock-step the writer waits for the recorder when the ring is full. In real time it never waits: it overwrites the
oldest rows, and the recorder counts what it lost.
"""

import mmap
import os
import struct
import time
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from bench.links.frame import FRAME_DTYPE
from bench.recording.schema import RunSchema
from signals.errors import InputError, RunError

MAGIC = b"BENCHRG1"
ROWS = 1 << 14
FRAMES = 1 << 15
PAGE = 4096
CHECK_EVERY = 256
ROOM_TIMEOUT_S = 10.0
ERROR_BYTES = 512

# positions in the control words; each in a cache line of its own, because writer and recorder are on different cores
ROWS_WRITTEN, ROWS_TAKEN, FRAMES_WRITTEN, FRAMES_TAKEN = 0, 8, 16, 24
FRAMES_BEGUN, ROWS_LOST, FRAMES_LOST, CLOSED, STATE = 32, 40, 48, 56, 64
CONTROL_WORDS = PAGE // 8

STARTING, RECORDING, FINISHED, FAILED = range(4)
"""States of the recorder."""

_PREFIX = struct.Struct("<8sQQQQ")
_FRAME = np.dtype(f"V{FRAME_DTYPE.itemsize}")


def _pages(size: int) -> int:
    return -(-size // PAGE) * PAGE


class _Layout:
    """Offsets of the parts of a ring file."""

    def __init__(self, header: int, columns: int, rows: int, frames: int) -> None:
        self.columns, self.rows, self.frames = columns, rows, frames
        self.control = header
        self.error = self.control + PAGE - ERROR_BYTES
        self.ticks = self.control + PAGE
        self.values = self.ticks + _pages(8 * rows)
        self.frame_records = self.values + _pages(8 * columns * rows)
        self.size = self.frame_records + _pages(FRAME_DTYPE.itemsize * frames)


class _Ring:
    """Parts of a mapped ring as arrays."""

    def __init__(self, memory: mmap.mmap, layout: _Layout) -> None:
        self.memory = memory
        self.layout = layout
        words = CONTROL_WORDS - ERROR_BYTES // 8
        self.control: NDArray[np.int64] = np.frombuffer(memory, np.int64, words, layout.control)
        self.ticks: NDArray[np.int64] = np.frombuffer(memory, np.int64, layout.rows, layout.ticks)
        values = np.frombuffer(memory, np.float64, layout.rows * layout.columns, layout.values)
        self.values: NDArray[np.float64] = values.reshape(layout.rows, layout.columns)
        self.frames: NDArray[np.void] = np.frombuffer(memory, _FRAME, layout.frames, layout.frame_records)


def ring_size(columns: int, rows: int = ROWS, frames: int = FRAMES) -> int:
    """Size of a ring file in bytes, without its header."""
    return _Layout(0, columns, rows, frames).size


def place_for_ring(run_dir: Path, size: int) -> Path:
    """Path for a run's ring: /dev/shm if it has room, where no disk can make the loop wait, else the run's folder."""
    shared = Path("/dev/shm")
    try:
        space = os.statvfs(shared)
        if os.access(shared, os.W_OK) and space.f_bavail * space.f_frsize > 2 * size:
            return shared / f"bench-{os.getpid()}-{time.time_ns():x}.ring"
    except OSError:
        pass
    return run_dir / "signals.ring"


class RingWriter:
    """The loop's end of a ring.

    Parameters
    ----------
    path : Path
        File to create.
    schema : RunSchema
        Layout of a row.
    flow_control : bool
        Wait for the recorder when the ring is full (lock-step) instead of overwriting (real time).
    rows, frames : int
        Capacity, powers of two.
    recorder_alive : callable, optional
        Asked every 256 rows and while waiting, so that a dead recorder ends the run.

    Raises
    ------
    RunError
        If there is no room for the file.
    """

    def __init__(
        self,
        path: Path,
        schema: RunSchema,
        *,
        flow_control: bool = False,
        rows: int = ROWS,
        frames: int = FRAMES,
        recorder_alive: Callable[[], bool] | None = None,
    ) -> None:
        self.path = path
        self.schema = schema
        self.recorder_alive = recorder_alive
        self._flow_control = flow_control
        self._ring = _create(path, schema, rows, frames)
        self._values, self._ticks, self._control = self._ring.values, self._ring.ticks, self._ring.control
        self._frames = self._ring.frames
        self._row_mask, self._frame_mask = rows - 1, frames - 1
        self._row_count = self._frame_count = 0
        self._next_row_check = 0
        self._frame_limit = frames

    def write_row(self, values: NDArray[np.float64], tick: int) -> None:
        """Store the signal vector of a tick.

        Raises
        ------
        RunError
            If the recorder has failed or ended (asked every 256 rows and whenever the ring is full).
        """
        count = self._row_count
        if count >= self._next_row_check:
            self._check_rows(count)
        slot = count & self._row_mask
        self._values[slot] = values
        self._ticks[slot] = tick
        self._row_count = count = count + 1
        self._control[ROWS_WRITTEN] = count

    def write_frames(self, frames: NDArray[np.void], count: int) -> None:
        """Store the first ``count`` frame records."""
        total = self._frame_count
        if total + count > self._frame_limit:
            self._make_room_for_frames(total + count)
        self._control[FRAMES_BEGUN] = total + count
        slot = total & self._frame_mask
        source = frames.view(_FRAME)
        fits = min(count, self._frame_mask + 1 - slot)
        self._frames[slot : slot + fits] = source[:fits]
        if fits < count:
            self._frames[: count - fits] = source[fits:count]
        self._frame_count = total = total + count
        self._control[FRAMES_WRITTEN] = total

    def _check_rows(self, count: int) -> None:
        self._raise_if_failed()
        self._next_row_check = count + CHECK_EVERY
        if self._flow_control:
            # one slot stays free: readers count the slot after the counter as being written
            capacity = self._row_mask
            self._wait_until(lambda: int(self._control[ROWS_TAKEN]) + capacity > count)
            self._next_row_check = min(self._next_row_check, int(self._control[ROWS_TAKEN]) + capacity)

    def _make_room_for_frames(self, wanted: int) -> None:
        capacity = self._frame_mask + 1
        if self._flow_control:
            self._wait_until(lambda: int(self._control[FRAMES_TAKEN]) + capacity >= wanted)
            self._frame_limit = int(self._control[FRAMES_TAKEN]) + capacity
        else:
            self._frame_limit = wanted + capacity

    def _wait_until(self, room: Callable[[], bool]) -> None:
        deadline = time.monotonic() + ROOM_TIMEOUT_S
        while not room():
            self._raise_if_failed()
            if time.monotonic() > deadline:
                raise RunError(f"the recorder has taken nothing for {ROOM_TIMEOUT_S:.0f} s")
            time.sleep(2e-4)

    def _raise_if_failed(self) -> None:
        if self._control[STATE] == FAILED:
            raise RunError(f"recording failed: {recorder_error(self._ring)}", mend="what was recorded is kept")
        if self.recorder_alive is not None and not self.recorder_alive():
            raise RunError("the recorder ended before the run did", mend="the rows so far are kept: bench recover RUN")

    @property
    def recorder_state(self) -> int:
        """STARTING, RECORDING, FINISHED or FAILED."""
        return int(self._control[STATE])

    @property
    def error(self) -> str:
        """What the recorder said when it failed."""
        return recorder_error(self._ring)

    def statistics(self) -> dict[str, int]:
        """Rows and frames written, and how many of them the recorder could not take in time."""
        control = self._control
        return {
            "rows": int(control[ROWS_WRITTEN]),
            "rows_lost": int(control[ROWS_LOST]),
            "frames": int(control[FRAMES_WRITTEN]),
            "frames_lost": int(control[FRAMES_LOST]),
        }

    def close(self) -> None:
        """Tell the readers that nothing more will come."""
        self._control[CLOSED] = 1


class RingReader:
    """A reader of a ring; any number of them may read.

    Parameters
    ----------
    path : Path
        File of a ring, its writer alive or not.
    recorder : bool
        This reader is the recorder: it may write the control words.

    Raises
    ------
    InputError
        If the file is no ring.
    """

    def __init__(self, path: Path, *, recorder: bool = False) -> None:
        self.path = path
        self._ring, self.schema = _open(path, writable=recorder)
        self.control = self._ring.control
        self._row_next = int(self.control[ROWS_TAKEN]) if recorder else 0
        self._frame_next = int(self.control[FRAMES_TAKEN]) if recorder else 0

    @property
    def rows_written(self) -> int:
        """Rows that the writer has stored since the start."""
        return int(self.control[ROWS_WRITTEN])

    @property
    def frames_written(self) -> int:
        """Frames that the writer has stored since the start."""
        return int(self.control[FRAMES_WRITTEN])

    @property
    def closed(self) -> bool:
        """True once the writer has said that nothing more will come."""
        return bool(self.control[CLOSED])

    @property
    def error(self) -> str:
        """What the recorder said when it failed."""
        return recorder_error(self._ring)

    def latest(self) -> NDArray[np.float64] | None:
        """Copy of the newest row, shape (signals,); None before the first."""
        layout = self._ring.layout
        while True:
            count = self.rows_written
            if count == 0:
                return None
            row = self._ring.values[(count - 1) % layout.rows].copy()
            if self.rows_written - count < layout.rows - 1:
                return row

    def take_rows(self, limit: int = ROWS) -> tuple[int, NDArray[np.int64], NDArray[np.float64]]:
        """Rows that this reader has not had yet, at most ``limit``.

        Returns
        -------
        first : int
            Number of the first of them, counted from the start of the run; what is missing before it was overwritten.
        ticks, values : ndarray, shapes (n,) and (n, signals)
            Copies.
        """
        layout = self._ring.layout
        first = max(self._row_next, self._oldest_row())
        last = min(self.rows_written, first + limit)
        slots = np.arange(first, last) % layout.rows
        ticks, values = self._ring.ticks[slots], self._ring.values[slots]
        overtaken = max(0, min(self._oldest_row() - first, last - first))
        self._row_next = last
        return first + overtaken, ticks[overtaken:], values[overtaken:]

    def take_frames(self, limit: int = FRAMES) -> tuple[int, NDArray[np.void]]:
        """Frames that this reader has not had yet: number of the first, and copies of the records."""
        layout = self._ring.layout
        first = max(self._frame_next, self._oldest_frame())
        last = max(first, min(self.frames_written, first + limit))
        slots = np.arange(first, last) % layout.frames
        records = self._ring.frames[slots].view(FRAME_DTYPE)
        overtaken = max(0, min(self._oldest_frame() - first, last - first))
        self._frame_next = last
        return first + overtaken, records[overtaken:]

    def _oldest_row(self) -> int:
        """Number of the oldest row that the writer is not overwriting."""
        return self.rows_written - self._ring.layout.rows + (0 if self.closed else 1)

    def _oldest_frame(self) -> int:
        return int(self.control[FRAMES_BEGUN]) - self._ring.layout.frames

    def skip_to_newest(self) -> None:
        """Leave out everything written so far."""
        self._row_next, self._frame_next = self.rows_written, self.frames_written

    @property
    def unreleased_rows(self) -> int:
        """Rows that this reader has taken and the writer may not yet overwrite."""
        return self._row_next - int(self.control[ROWS_TAKEN])

    def release(self) -> None:
        """Make room for the writer: everything taken so far is safe in files."""
        self.control[ROWS_TAKEN] = self._row_next
        self.control[FRAMES_TAKEN] = self._frame_next

    def count_lost(self, rows: int, frames: int) -> None:
        """Note rows and frames that the recorder was too late for."""
        self.control[ROWS_LOST] += rows
        self.control[FRAMES_LOST] += frames

    def set_state(self, state: int, error: str = "") -> None:
        """State of the recorder, read by the writer."""
        if error:
            text = error.encode()[: ERROR_BYTES - 1].ljust(ERROR_BYTES, b"\0")
            offset = self._ring.layout.error
            self._ring.memory[offset : offset + ERROR_BYTES] = text
        self.control[STATE] = state


def recorder_error(ring: Any) -> str:
    """Text that a failed recorder left in the ring."""
    offset = ring.layout.error
    text: bytes = ring.memory[offset : offset + ERROR_BYTES]
    return text.split(b"\0", 1)[0].decode(errors="replace")


def _create(path: Path, schema: RunSchema, rows: int, frames: int) -> _Ring:
    text = schema.to_json().encode()
    layout = _Layout(_pages(_PREFIX.size + len(text)), len(schema.signals), rows, frames)
    try:
        with path.open("xb+") as file:
            # every block is allocated now: a full disk is an error here, not a signal in the middle of a tick
            os.posix_fallocate(file.fileno(), 0, layout.size)
            flags = mmap.MAP_SHARED | getattr(mmap, "MAP_POPULATE", 0)
            memory = mmap.mmap(file.fileno(), layout.size, flags=flags)
    except OSError as error:
        path.unlink(missing_ok=True)
        raise RunError(f"{path}: no room for the recording ring ({error.strerror}, {layout.size >> 20} MiB)") from error
    memory[_PREFIX.size : _PREFIX.size + len(text)] = text
    memory[: _PREFIX.size] = _PREFIX.pack(MAGIC, layout.control, len(text), rows, frames)
    return _Ring(memory, layout)


def _open(path: Path, *, writable: bool) -> tuple[_Ring, RunSchema]:
    try:
        with path.open("rb+" if writable else "rb") as file:
            access = mmap.ACCESS_WRITE if writable else mmap.ACCESS_READ
            memory = mmap.mmap(file.fileno(), 0, access=access)
        magic, header, length, rows, frames = _PREFIX.unpack(memory[: _PREFIX.size])
        if magic != MAGIC:
            raise InputError(f"{path}: no recording ring")
        schema = RunSchema.from_json(memory[_PREFIX.size : _PREFIX.size + length])
    except (OSError, ValueError, struct.error) as error:
        raise InputError(f"{path}: no recording ring ({error})") from error
    return _Ring(memory, _Layout(header, len(schema.signals), rows, frames)), schema
