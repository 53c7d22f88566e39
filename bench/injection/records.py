"""Frames of the links (records of an array) as frames of the injector, and back."""

import numpy as np
from numpy.typing import NDArray

from bench.links.frame import BENCH, BIT_RATE_SWITCH, ECU, ERROR, EXTENDED, FD, REMOTE, TRANSMITTED
from can_fault_injector.error_frames import ErrorFrame
from can_fault_injector.faults.running import Way
from can_fault_injector.frame import Frame

_SENDERS = {"to_ecu": BENCH, "to_bench": ECU}
_FLAGS = {"to_ecu": TRANSMITTED, "to_bench": 0}
_CLASSIC_BYTES = 8


def frame_of(record: np.void) -> Frame:
    """Frame of one record; not for error frames."""
    flags = int(record["flags"])
    remote = bool(flags & REMOTE)
    length = int(record["length"])
    return Frame(
        int(record["identifier"]),
        b"" if remote else record["data"][:length].tobytes(),
        extended=bool(flags & EXTENDED),
        remote=remote,
        fd=bool(flags & FD),
        bit_rate_switch=bool(flags & BIT_RATE_SWITCH),
        dlc=length if remote else None,
    )


def write_frame(record: np.void, frame: Frame, way: Way, tick: int, time_ns: int) -> None:
    """Fill a record with a frame that leaves the injector."""
    flags = EXTENDED * frame.extended | REMOTE * frame.remote | FD * frame.fd | BIT_RATE_SWITCH * frame.bit_rate_switch
    length = min(frame.length_code, _CLASSIC_BYTES) if frame.remote else len(frame.data)
    _write(record, frame.identifier, flags | _FLAGS[way], way, tick, time_ns, length)
    record["data"][:] = 0
    record["data"][: len(frame.data)] = np.frombuffer(frame.data, np.uint8)


def write_error_frame(record: np.void, error: ErrorFrame, way: Way, tick: int, time_ns: int) -> None:
    """Fill a record with an error frame; ``way`` is that of the frames of whoever reads it."""
    _write(record, error.classes, ERROR, way, tick, time_ns, len(error.data))
    record["data"][:] = 0
    record["data"][: len(error.data)] = np.frombuffer(error.data, np.uint8)


def _write(record: np.void, identifier: int, flags: int, way: Way, tick: int, time_ns: int, length: int) -> None:
    record["tick"], record["timestamp_ns"] = tick, time_ns
    record["identifier"], record["flags"], record["length"] = identifier, flags, length
    record["sender"], record["channel"] = _SENDERS[way], 0


def is_error(frames: NDArray[np.void], number: int) -> bool:
    """Whether a record is an error frame: those pass by the injector."""
    return bool(frames["flags"][number] & ERROR)
