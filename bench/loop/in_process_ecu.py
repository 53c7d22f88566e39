"""The emulated ECU in the bench's own process: the other side of the bus without a bus, compiled."""

from typing import Any

import numba
import numpy as np
from numba import njit
from numpy.typing import NDArray

from bench.ecu.node import EcuNode, node_tick
from bench.links.frame import FRAME_DTYPE, TRANSMITTED, frames_address, new_frames
from signals.record_memory import addresses_at, pointer

AT_NODE, AT_SENT, SENT, AT_ANSWERS, ANSWERS, AT_RECEIVED = range(6)
"""Places in the list of an exchange: addresses, and the numbers of frames that the bench sent and the ECU answered."""
PLACES = 6

MOST_ANSWERS = 64


@njit(cache=True)
def exchange(memory: int, tick: int) -> int:
    """Hand over the ECU's answers of its previous tick, then run its tick on what the bench sent one tick ago."""
    places: Any = addresses_at(memory)
    count = places[ANSWERS]
    answers = numba.carray(pointer(places[AT_ANSWERS]), count, FRAME_DTYPE)
    received = numba.carray(pointer(places[AT_RECEIVED]), count, FRAME_DTYPE)
    for k in range(count):
        # sent by the other side: here they are received
        answers[k].flags &= 255 - TRANSMITTED
        received[k] = answers[k]
    places[ANSWERS] = node_tick(places[AT_NODE], places[AT_SENT], places[SENT], places[AT_ANSWERS], 0, tick)
    places[SENT] = 0
    return int(count)


class InProcessEcu:
    """The emulated ECU called by the tick, behind the same frames as on a bus."""

    origin_ns = 0

    def __init__(self, node: EcuNode) -> None:
        self._node = node
        self._answers = new_frames(MOST_ANSWERS)
        self._sent = self._received = new_frames(1)
        self._places = np.zeros(PLACES, np.int64)
        self._places[[AT_NODE, AT_ANSWERS]] = node.address, frames_address(self._answers)
        self._memory = int(self._places.ctypes.data)
        self._silent = False

    def prepare(self) -> None:
        """Nothing to prepare."""

    def receive(self, tick: int, frames: NDArray[np.void]) -> int:
        """Frames of the controller's previous tick; runs its tick on what the bench sent one tick ago."""
        if self._silent:
            return 0
        if frames is not self._received:
            # the same come tick by tick, so their address is kept
            self._places[AT_RECEIVED], self._received = frames_address(frames), frames
        count: int = exchange(self._memory, tick)
        if count and self.origin_ns:
            frames["timestamp_ns"][:count] += self.origin_ns
        return count

    def send(self, tick: int, frames: NDArray[np.void], count: int) -> None:
        """Keep the frames for the controller's next tick, which runs before the bench fills this array again."""
        if frames is not self._sent:
            self._places[AT_SENT], self._sent = frames_address(frames), frames
        self._places[SENT] = count
        if self.origin_ns:
            frames["timestamp_ns"][:count] += self.origin_ns

    def silence(self) -> None:
        """The controller is lost: it runs no more."""
        self._silent = True

    def close(self) -> None:
        """Nothing to close."""
