"""``signals.mcap``: the rows of a run while it runs, in chunks that are whole or absent when somebody is killed.

Each message holds consecutive rows: number of the first, their count, their ticks, their values. Every message is a
chunk of its own of at most 64 KiB, so what was flushed can be read whatever happens after it.
"""

import struct
from collections.abc import Iterator
from contextlib import suppress
from pathlib import Path
from typing import IO, Any

import numpy as np
from mcap.exceptions import McapError
from mcap.records import Message, Schema
from mcap.stream_reader import StreamReader
from mcap.writer import CompressionType, IndexType, Writer
from numpy.typing import NDArray

from bench.recording.schema import RunSchema

CHUNK_BYTES = 64 * 1024
_HEAD = struct.Struct("<qq")
_BROKEN = (McapError, struct.error, ValueError, LookupError, ArithmeticError, EOFError, RuntimeError)
"""What the reader raises where a killed writer left half a chunk; RuntimeError is LZ4's."""

Rows = tuple[int, NDArray[np.int64], NDArray[np.float64]]


class SignalFile:
    """Writer of ``signals.mcap``."""

    def __init__(self, path: Path, schema: RunSchema, tick_ns: int = 1_000_000) -> None:
        self._file: IO[bytes] = path.open("wb")
        # chunk size 1: a message is a chunk, because the writer has no other way to end one
        self._writer = Writer(self._file, chunk_size=1, compression=CompressionType.LZ4, index_types=IndexType.CHUNK)
        self._writer.start(profile="", library="brake-control-bench")
        layout = self._writer.register_schema("bench.SignalRows", "bench-signal-rows", schema.to_json().encode())
        self._channel = self._writer.register_channel("signals", "bench-signal-rows", layout)
        self._tick_ns = tick_ns
        self._rows_per_chunk = max(1, (CHUNK_BYTES - 256) // (8 * (len(schema.signals) + 1)))
        # the schema stands in the first chunk: written with no row, it is on its way before the first
        self._add(0, np.zeros(0, np.int64), np.zeros((0, len(schema.signals))))
        self._file.flush()

    def write(self, first: int, ticks: NDArray[np.int64], values: NDArray[np.float64]) -> None:
        """Write consecutive rows, the first of which has number ``first``."""
        for begin in range(0, len(ticks), self._rows_per_chunk):
            end = min(begin + self._rows_per_chunk, len(ticks))
            self._add(first + begin, ticks[begin:end], values[begin:end])

    def _add(self, first: int, ticks: NDArray[np.int64], values: NDArray[np.float64]) -> None:
        data = b"".join((_HEAD.pack(first, len(ticks)), ticks.tobytes(), values.tobytes()))
        time_ns = int(ticks[0]) * self._tick_ns if len(ticks) else 0
        self._writer.add_message(self._channel, time_ns, data, time_ns)

    def flush(self) -> None:
        """Hand everything to the operating system, where it outlives this process."""
        self._file.flush()

    def close(self) -> None:
        """Write the index and close."""
        self._writer.finish()
        self._file.close()

    def abandon(self) -> None:
        """Close without an index, after a write has failed."""
        with suppress(OSError):
            self._file.close()


def read_signal_file(path: Path) -> tuple[RunSchema | None, Iterator[Rows]]:
    """Schema and rows of a ``signals.mcap``, however it ends.

    Returns
    -------
    schema : RunSchema or None
        None if the file was cut before it.
    rows : iterator of (first, ticks, values)
        Consecutive rows of each chunk that is whole.
    """
    records = _records(path)
    for record in records:
        if isinstance(record, Schema):
            schema = RunSchema.from_json(record.data)
            blocks = (_rows(r.data, len(schema.signals)) for r in records if isinstance(r, Message))
            return schema, (block for block in blocks if len(block[1]))
    return None, iter(())


def _records(path: Path) -> Iterator[Any]:
    """Records up to the first that is broken: a killed writer leaves half a chunk at the end, and no index."""
    with path.open("rb") as file:
        try:
            yield from StreamReader(file, validate_crcs=True, record_size_limit=1 << 26).records
        except _BROKEN:
            return


def _rows(data: bytes, columns: int) -> Rows:
    first, count = _HEAD.unpack_from(data)
    ticks = np.frombuffer(data, np.int64, count, _HEAD.size)
    values = np.frombuffer(data, np.float64, count * columns, _HEAD.size + 8 * count)
    return first, ticks, values.reshape(count, columns)
