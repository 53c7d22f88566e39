"""Share of bus time in use: bits of the frames of the last 100 ms over the bits that fit."""

import numpy as np
from numba import njit
from numpy.typing import NDArray

WINDOW_TICKS = 100
BIT_RATE = 500_000.0
EXTENDED, REMOTE, ERROR = 1, 2, 4


@njit(cache=True)
def _nominal_bits(frames: NDArray[np.void], count: int) -> float:
    """Bits on the wire without stuff bits: 47 + 8 n for a standard and 67 + 8 n for an extended data frame."""
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
def _update(
    window: NDArray[np.float64],
    position: int,
    received: NDArray[np.void],
    received_count: int,
    sent: NDArray[np.void],
    sent_count: int,
) -> float:
    window[position] = _nominal_bits(received, received_count) + _nominal_bits(sent, sent_count)
    return float(np.sum(window))


class BusLoad:
    """Nominal load (stuff bits not counted, they add up to 20 %) of a 500 kbit/s bus over 100 ms."""

    def __init__(self, bit_rate: float = BIT_RATE) -> None:
        self._window = np.zeros(WINDOW_TICKS)
        self._position = 0
        self._capacity_bits = bit_rate * WINDOW_TICKS * 1e-3

    def update(self, received: NDArray[np.void], received_count: int, sent: NDArray[np.void], sent_count: int) -> float:
        """Load after a tick with these frames, 0 to 1."""
        bits = _update(self._window, self._position, received, received_count, sent, sent_count)
        self._position = (self._position + 1) % WINDOW_TICKS
        return bits / self._capacity_bits
