"""Sensor block of the cluster: an SPI slave that answers requests with the values that were set."""

import mmap
import os
from pathlib import Path

import numpy as np
from numba import njit
from numpy.typing import NDArray

from bench.sensor_cluster.words import (
    ACCELERATION_RESOLUTION_M_S2,
    FAILED,
    NORMAL,
    RATE_RESOLUTION_RAD_S,
    STARTING,
    IntArray,
    address_of,
    answer,
    is_intact,
    value_of,
)

FloatArray = NDArray[np.float64]

CHANNELS = (
    "longitudinal_acceleration",
    "lateral_acceleration",
    "vertical_acceleration",
    "yaw_rate",
    "roll_rate",
    "pitch_rate",
)
"""Signals in the order of the registers; the register of the first has address 1."""
IN_ORDER = np.arange(len(CHANNELS))
RESOLUTIONS = np.array([ACCELERATION_RESOLUTION_M_S2] * 3 + [RATE_RESOLUTION_RAD_S] * 3)
FIRST_ADDRESS = 1

# memory of a sensor block: registers by address, then
REGISTERS = 8
PENDING, POWERED, STARTUP_LEFT, ANSWERED, REFUSED, SERVED = range(REGISTERS, REGISTERS + 6)
MEMORY_SIZE = REGISTERS + 6
STARTUP_TRANSFERS = 70
"""Answers that say "starting" after the supply came: ten cycles of seven transfers."""
SILENT_LINE = 0xFFFFFFFF
"""What a master reads from a line that nobody drives."""


@njit(cache=True)
def set_registers(memory: IntArray, values: FloatArray, positions: IntArray) -> None:
    """Put sensor values in SI units into the registers, rounded and saturated to 16 bits.

    Parameters
    ----------
    memory : int64 array, shape (MEMORY_SIZE,)
    values : float64 array
        Where the values stand, among others.
    positions : int64 array, shape (6,)
        Place of each of ``CHANNELS`` in ``values``.
    """
    for k in range(positions.shape[0]):
        value = values[positions[k]]
        raw = np.rint(value / RESOLUTIONS[k]) if np.isfinite(value) else 32767.0
        memory[FIRST_ADDRESS + k] = int(min(max(raw, -32768.0), 32767.0))


@njit(cache=True)
def switch_supply(memory: IntArray, on: bool) -> None:
    """The relay in the supply: off forgets everything, on begins with the start-up."""
    if on and memory[POWERED] == 0:
        memory[STARTUP_LEFT] = STARTUP_TRANSFERS
        memory[PENDING] = answer(0, STARTING, 0)
    memory[POWERED] = 1 if on else 0


@njit(cache=True)
def transfer(memory: IntArray, request: int) -> int:
    """One transfer: take a request, give the answer to the one before."""
    if memory[POWERED] == 0:
        return SILENT_LINE
    given = memory[PENDING]
    status = NORMAL
    if memory[STARTUP_LEFT] > 0:
        memory[STARTUP_LEFT] -= 1
        status = STARTING
    address = address_of(request)
    if not is_intact(request) or address >= REGISTERS or value_of(request) != 0:
        memory[REFUSED] += 1
        memory[PENDING] = answer(address, FAILED, 0)
    else:
        memory[ANSWERED] += 1
        memory[PENDING] = answer(address, status, memory[address])
    return given


class SensorBlock:
    """Registers and state of the slave, in memory of this process or in a file that several processes map.

    Parameters
    ----------
    path : Path, optional
        File to map; it is made if it is not there.
    """

    def __init__(self, path: Path | None = None) -> None:
        self._map: mmap.mmap | None = None
        if path is None:
            self.memory: IntArray = np.zeros(MEMORY_SIZE, np.int64)
        else:
            with path.open("r+b" if path.exists() else "w+b") as file:
                os.ftruncate(file.fileno(), 8 * MEMORY_SIZE)
                self._map = mmap.mmap(file.fileno(), 8 * MEMORY_SIZE)
            self.memory = np.frombuffer(self._map, np.int64)

    def set(self, values: FloatArray, positions: IntArray = IN_ORDER) -> None:
        """Take sensor values in SI units; ``positions`` of ``CHANNELS`` in them, by default just these in order."""
        set_registers(self.memory, values, positions)

    def supply(self, on: bool) -> None:
        """Switch the relay."""
        switch_supply(self.memory, on)

    def transfer(self, request: int) -> int:
        """One transfer of 32 bits."""
        return int(transfer(self.memory, request))

    def counts(self) -> dict[str, int]:
        """Transfers answered and refused since the start."""
        return {"answered": int(self.memory[ANSWERED]), "refused": int(self.memory[REFUSED])}
