"""A bus in memory, for nodes of one process."""

from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray

from bench.links.frame import OPAQUE_DTYPE, TRANSMITTED, new_frames
from bench.links.interface import Link

CAPACITY_FRAMES = 8192
_NOT_TRANSMITTED = 255 - TRANSMITTED

_buses: dict[str, list["VirtualLink"]] = {}


class VirtualLink(Link):
    """One node on a bus of this process; all nodes opened with the same name hear each other.

    Frames keep the ``tick``, ``timestamp_ns`` and ``sender`` that their sender wrote: nothing on this bus takes time.

    Parameters
    ----------
    name : str
        Name of the bus.
    role : str
        "bench", "ecu" or "injector".
    """

    def __init__(self, name: str, role: str) -> None:
        super().__init__("virtual", f"virtual:{name}", (name,), role, supports_lockstep=True)
        self._queue = new_frames(CAPACITY_FRAMES)
        self._opaque = self._queue.view(OPAQUE_DTYPE)
        self._waiting = 0
        self._sent = self._received = self._overflows = 0
        self._view = _cached_view()
        self._members = _buses.setdefault(name, [])
        self._members.append(self)

    def send(self, frames: NDArray[np.void], count: int) -> None:
        """Put frames into the queue of every other node."""
        view = self._view(frames)
        for member in self._members:
            if member is not self:
                member._take(view, count)
        self._sent += count

    def _take(self, frames: NDArray[np.void], count: int) -> None:
        fits = min(count, CAPACITY_FRAMES - self._waiting)
        self._opaque[self._waiting : self._waiting + fits] = frames[:fits]
        self._waiting += fits
        self._overflows += count - fits

    def receive(self, into: NDArray[np.void], start: int = 0) -> int:
        """Move waiting frames into ``into[start:]``."""
        waiting = self._waiting
        if waiting == 0:
            return 0
        count = min(waiting, len(into) - start)
        self._view(into)[start : start + count] = self._opaque[:count]
        self._opaque[: waiting - count] = self._opaque[count:waiting]
        self._waiting = waiting - count
        self._received += count
        into["flags"][start : start + count] &= _NOT_TRANSMITTED
        return count

    def wait(self, timeout_s: float) -> bool:
        """Nobody else runs meanwhile in this process, so it never sleeps."""
        return self._waiting > 0

    def statistics(self) -> dict[str, int | str]:
        """Counts since the link was opened."""
        counts: dict[str, int | str] = dict.fromkeys(("own_echoes", "send_refused", "malformed", "error_frames"), 0)
        return counts | {
            "sent": self._sent,
            "received": self._received,
            "overflows": self._overflows,
            "timestamp_source": "virtual time",
        }

    def close(self) -> None:
        """Leave the bus."""
        if self in self._members:
            self._members.remove(self)


def _cached_view() -> Callable[[NDArray[np.void]], NDArray[np.void]]:
    """``frames.view(OPAQUE_DTYPE)`` that is made once for an array used again and again."""
    known: dict[int, tuple[NDArray[np.void], NDArray[np.void]]] = {}

    def view(frames: NDArray[np.void]) -> NDArray[np.void]:
        entry = known.get(id(frames))
        if entry is None:
            if len(known) > 16:
                known.clear()
            entry = known[id(frames)] = (frames, frames.view(OPAQUE_DTYPE))
        return entry[1]

    return view
