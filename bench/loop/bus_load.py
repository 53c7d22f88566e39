"""Share of bus time in use: bits of the frames of the last 100 ms over the bits that fit."""

from typing import Any

import numba
import numpy as np
from numba import njit
from numpy.typing import NDArray

from bench.links.frame import ERROR, EXTENDED, FRAME_DTYPE, REMOTE, frames_address
from signals.record_memory import pointer, record_at

WINDOW_TICKS = 100
BIT_RATE = 500_000.0

LOAD_RECORD = np.dtype([("capacity", "f8"), ("total", "f8"), ("position", "i8"), ("window", "f8", (WINDOW_TICKS,))])


@njit(cache=True)
def _nominal_bits(frames_at: int, count: int) -> float:
    """Bits on the wire without stuff bits: 47 + 8 n for a standard and 67 + 8 n for an extended data frame."""
    frames = numba.carray(pointer(frames_at), count, FRAME_DTYPE)
    bits = 0.0
    for i in range(count):
        flags = frames[i]["flags"]
        if flags & ERROR:
            continue
        bits += 67.0 if flags & EXTENDED else 47.0
        if not flags & REMOTE:
            bits += 8.0 * frames[i]["length"]
    return bits


@njit(cache=True)
def bus_load(memory: int, received_at: int, received_count: int, sent_at: int, sent_count: int) -> float:
    """Load after a tick with these frames, 0 to 1; all by address, ``memory`` a record of ``LOAD_RECORD``."""
    s: Any = record_at(memory, LOAD_RECORD)
    bits = _nominal_bits(received_at, received_count) + _nominal_bits(sent_at, sent_count)
    # whole numbers: the sum stays exact however long it runs
    s.total += bits - s.window[s.position]
    s.window[s.position] = bits
    s.position = (s.position + 1) % WINDOW_TICKS
    return float(s.total / s.capacity)


class BusLoad:
    """Nominal load (stuff bits not counted, they add up to 20 %) of a 500 kbit/s bus over 100 ms.

    Attributes
    ----------
    address : int
        Of the memory that `bus_load` works on, for compiled callers.
    """

    def __init__(self, bit_rate: float = BIT_RATE) -> None:
        self._record: NDArray[np.void] = np.zeros(1, LOAD_RECORD)
        self._record["capacity"] = bit_rate * WINDOW_TICKS * 1e-3
        self.address = int(self._record.ctypes.data)

    def update(self, received: NDArray[np.void], received_count: int, sent: NDArray[np.void], sent_count: int) -> float:
        """Load after a tick with these frames, 0 to 1."""
        load: float = bus_load(self.address, frames_address(received), received_count, frames_address(sent), sent_count)
        return load
