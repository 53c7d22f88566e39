"""Words of the SPI line between microcontroller and sensor block: 32 bits, most significant bit first.

The document names master, slave and duties, not the words. These are those of a common inertial sensor (Murata
SCL3300 data sheet, "SPI communication"): operation 6 bits (write flag, address), return status 2 bits, data 16 bits,
CRC-8 of the first three bytes with polynomial 0x1D, start value 0xFF and inverted result. The answer to a request
comes with the next transfer.
"""

import numpy as np
from numba import njit
from numpy.typing import NDArray

IntArray = NDArray[np.int64]

WORD_BYTES = 4
STARTING, NORMAL, SELF_TEST, FAILED = range(4)
"""Return status of an answer."""

ACCELERATION_RESOLUTION_M_S2 = 1e-3
RATE_RESOLUTION_RAD_S = 1e-4


@njit(cache=True)
def crc8(bits: int) -> int:
    """CRC-8 (SAE J1850) of 24 bits."""
    register = 0xFF
    for shift in (16, 8, 0):
        register ^= (bits >> shift) & 0xFF
        for _ in range(8):
            register = ((register << 1) ^ 0x1D) & 0xFF if register & 0x80 else register << 1
    return register ^ 0xFF


@njit(cache=True)
def read_request(address: int) -> int:
    """Word that asks for a register."""
    bits = address << 18
    return (bits << 8) | crc8(bits)


@njit(cache=True)
def answer(address: int, status: int, value: int) -> int:
    """Word of a sensor block that answers a request of register ``address``; ``value`` is a signed 16-bit number."""
    bits = (address << 18) | (status << 16) | (value & 0xFFFF)
    return (bits << 8) | crc8(bits)


@njit(cache=True)
def is_intact(word: int) -> bool:
    """Whether a word's CRC is right."""
    return crc8(word >> 8) == word & 0xFF


@njit(cache=True)
def address_of(word: int) -> int:
    """Register that a word asks for or answers."""
    return (word >> 26) & 0x1F


@njit(cache=True)
def status_of(word: int) -> int:
    """Return status of an answer."""
    return (word >> 24) & 3


@njit(cache=True)
def value_of(word: int) -> int:
    """Signed data of an answer."""
    value = (word >> 8) & 0xFFFF
    return value - 0x10000 if value & 0x8000 else value
