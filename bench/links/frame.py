"""The record of one CAN frame that every part of the bench hands on.

A frame that a part sends carries the tick in which it was sent. A frame that a link hands on carries the tick in which
the other side sent it (lock-step) or zero, which the receiver replaces by its own (real time). ``timestamp_ns`` is
``tick`` in nanoseconds in virtual time and CLOCK_REALTIME of the best clock that the link has in real time.
"""

import numpy as np
from numpy.typing import NDArray

FRAME_DTYPE = np.dtype(
    [
        ("tick", "i8"),
        ("timestamp_ns", "i8"),
        ("identifier", "u4"),
        ("channel", "u1"),
        ("flags", "u1"),
        ("sender", "u1"),
        ("length", "u1"),
        ("data", "u1", (64,)),
    ]
)

OPAQUE_DTYPE = np.dtype(f"V{FRAME_DTYPE.itemsize}")
"""``frames.view(OPAQUE_DTYPE)`` copies seven times as fast: numpy then copies bytes and not field by field."""

TICK_NS = 1_000_000

EXTENDED, REMOTE, ERROR, FD, BIT_RATE_SWITCH, TRANSMITTED = 1, 2, 4, 8, 16, 32
"""Bits of ``flags``; TRANSMITTED marks a frame that the recording side itself has sent."""

BENCH, ECU, FOREIGN, INJECTOR = range(4)
"""Values of ``sender``."""

ROLES = {"bench": BENCH, "ecu": ECU, "injector": INJECTOR}
"""Roles in which a link can be opened."""

FD_LENGTHS = (0, 1, 2, 3, 4, 5, 6, 7, 8, 12, 16, 20, 24, 32, 48, 64)
"""Payload lengths of CAN FD by data length code."""


def new_frames(count: int) -> NDArray[np.void]:
    """Zeroed array of ``count`` frame records."""
    return np.zeros(count, FRAME_DTYPE)


def frames_address(frames: NDArray[np.void]) -> int:
    """Address of frame records for compiled code; whoever uses it keeps the array.

    Raises
    ------
    ValueError
        If they are not consecutive records of ``FRAME_DTYPE``.
    """
    if frames.dtype != FRAME_DTYPE or not frames.flags.c_contiguous:
        raise ValueError(f"found {frames.dtype}, allowed: consecutive frame records, as new_frames gives")
    return int(frames.ctypes.data)


def make_frame(
    identifier: int, data: bytes = b"", *, flags: int = 0, channel: int = 0, tick: int = 0
) -> NDArray[np.void]:
    """Array with one frame, for tools and tests.

    Parameters
    ----------
    identifier : int
        11 bits, or 29 bits with EXTENDED in ``flags``.
    data : bytes
        Payload, at most 8 bytes, or a length of :data:`FD_LENGTHS` with FD in ``flags``.
    """
    frame = new_frames(1)
    frame["identifier"] = identifier
    frame["flags"] = flags
    frame["channel"] = channel
    frame["tick"] = tick
    frame["length"] = len(data)
    frame["data"][0, : len(data)] = np.frombuffer(data, np.uint8)
    return frame


def payload(frame: np.void) -> bytes:
    """Payload of one record."""
    return bytes(frame["data"][: frame["length"]])
