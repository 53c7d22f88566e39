"""``frames.blf`` and ``frames.asc``: every frame with time stamp, channel and direction.

Times in the files are relative to the start of the run, whose date stands in the header; in virtual time it is zero.
"""

import struct
import zlib
from collections.abc import Iterable, Iterator
from contextlib import suppress
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from bench.links.frame import BIT_RATE_SWITCH, ERROR, EXTENDED, FD, FRAME_DTYPE, REMOTE, TRANSMITTED
from bench.links.python_can_library import blf, can

CONTAINER_BYTES = 8192
_HEAD = struct.Struct("<qqIBBBB")
_MILLISECOND_NS = 1_000_000
_BROKEN = (blf.BLFParseError, struct.error, zlib.error, ValueError, TypeError, LookupError, ArithmeticError, EOFError)
"""What the reader raises where a killed writer left half an object."""


def to_messages(frames: NDArray[np.void], start_time_ns: int = 0) -> Iterator[can.Message]:
    """Frames as python-can messages, their time relative to the start of the run."""
    raw = np.ascontiguousarray(frames).tobytes()
    size = FRAME_DTYPE.itemsize
    for offset in range(0, len(raw), size):
        _, stamp_ns, identifier, channel, flags, _, length = _HEAD.unpack_from(raw, offset)
        data = b"" if flags & REMOTE else raw[offset + _HEAD.size : offset + _HEAD.size + length]
        yield can.Message(
            # half a nanosecond more, because the writers cut what is behind it
            timestamp=(stamp_ns - start_time_ns + 0.5) * 1e-9,
            arbitration_id=identifier,
            is_extended_id=bool(flags & EXTENDED),
            is_remote_frame=bool(flags & REMOTE),
            is_error_frame=bool(flags & ERROR),
            is_fd=bool(flags & FD),
            bitrate_switch=bool(flags & BIT_RATE_SWITCH),
            is_rx=not flags & TRANSMITTED,
            channel=channel,
            dlc=length,
            data=data,
        )


def from_messages(messages: Iterable[can.Message], start_time_ns: int = 0) -> NDArray[np.void]:
    """Frames of python-can messages; the sender is not known from a log."""
    records: list[NDArray[np.void]] = []
    for message in messages:
        record = np.zeros((), FRAME_DTYPE)
        relative_ns = round(message.timestamp * 1e9)
        record["timestamp_ns"] = start_time_ns + relative_ns
        record["tick"] = relative_ns // _MILLISECOND_NS
        record["identifier"] = message.arbitration_id
        record["channel"] = message.channel if isinstance(message.channel, int) else 0
        record["flags"] = _flags(message)
        record["length"] = message.dlc if message.is_remote_frame else len(message.data)
        record["data"][: len(message.data)] = np.frombuffer(bytes(message.data), np.uint8)
        records.append(record)
    return np.array(records, FRAME_DTYPE) if records else np.zeros(0, FRAME_DTYPE)


def _flags(message: can.Message) -> int:
    return (
        EXTENDED * message.is_extended_id
        | REMOTE * message.is_remote_frame
        | ERROR * message.is_error_frame
        | FD * message.is_fd
        | BIT_RATE_SWITCH * message.bitrate_switch
        | TRANSMITTED * (not message.is_rx)
    )


class BlfFile(blf.BLFWriter):  # type: ignore[misc]
    """BLF writer whose file can be read up to the last :meth:`checkpoint` if its process is killed."""

    start_timestamp: float | None
    stop_timestamp: float | None

    def __init__(self, path: Path, start_time_ns: int = 0) -> None:
        self._start_ns = start_time_ns - start_time_ns % _MILLISECOND_NS
        super().__init__(path, max_container_size=CONTAINER_BYTES)

    def _write_header(self, filesize: int) -> None:
        """Header with the date of the start; the messages' times are relative to it."""
        duration: float = self.stop_timestamp or 0.0
        self.start_timestamp = self._start_ns * 1e-9
        self.stop_timestamp = self.start_timestamp + duration
        super()._write_header(filesize)
        self.start_timestamp, self.stop_timestamp = 0.0, duration

    def write(self, frames: NDArray[np.void]) -> None:
        """Append frames."""
        for message in to_messages(frames, self._start_ns):
            self.on_message_received(message)

    def checkpoint(self) -> None:
        """Hand everything to the operating system, where it outlives this process."""
        self._flush()
        self.file.flush()

    def abandon(self) -> None:
        """Close after a write has failed."""
        with suppress(OSError):
            self.file.close()


class AscFile:
    """ASC writer, on request beside the BLF file."""

    def __init__(self, path: Path, start_time_ns: int = 0) -> None:
        self._start_ns = start_time_ns
        self._writer = can.ASCWriter(path)

    def write(self, frames: NDArray[np.void]) -> None:
        """Append frames."""
        for message in to_messages(frames, self._start_ns):
            self._writer.on_message_received(message)

    def checkpoint(self) -> None:
        """Hand everything to the operating system."""
        self._writer.file.flush()

    def abandon(self) -> None:
        """Close after a write has failed."""
        with suppress(OSError):
            self._writer.file.close()

    def stop(self) -> None:
        """Close the file."""
        self._writer.stop()


def read_blf(path: Path) -> NDArray[np.void]:
    """Frames of a BLF file, up to where it is whole: a killed writer leaves half a container at the end."""
    if path.stat().st_size < blf.FILE_HEADER_SIZE:
        return np.zeros(0, FRAME_DTYPE)
    with blf.BLFReader(path) as reader:
        start_ns = round(reader.start_timestamp * 1e3) * _MILLISECOND_NS
        reader.start_timestamp = 0.0
        return from_messages(_until_broken(reader), start_ns)


def _until_broken(reader: Any) -> Iterator[can.Message]:
    try:
        yield from reader
    except _BROKEN:
        return
