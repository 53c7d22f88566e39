"""What every link to an ECU does."""

import select
from abc import ABC, abstractmethod
from collections.abc import Sequence
from types import TracebackType
from typing import Self

import numpy as np
from numpy.typing import NDArray

from bench.links.frame import BENCH, ECU, ROLES


class Link(ABC):
    """A bus with the peer on the other end; nothing blocks, no threads, own frames never come back.

    Frames are records of :data:`bench.links.frame.FRAME_DTYPE`. On a link of several channels ``channel`` of a sent
    frame picks one. A received frame has ``tick`` 0, ``sender`` the peer's role (a bus does not tell who spoke; in
    lock-step the barrier marks strangers as FOREIGN) and in ``timestamp_ns`` the time of reception, CLOCK_REALTIME, of
    the best clock that the link has; ``timestamp_source`` in the statistics says which.

    Attributes
    ----------
    kind : str
        "virtual", "udp", "udp_loopback", "socketcan", "slcan", or the name of a python-can interface.
    text : str
        Text that opens the other end of the same bus, all random parts filled in.
    channels : tuple of str
        Names of the channels.
    supports_lockstep : bool
        True if frames pass in order and without the limits of a real wire, so that a barrier can keep two processes in
        virtual time.
    """

    kind: str
    text: str
    channels: tuple[str, ...]
    supports_lockstep: bool

    def __init__(self, kind: str, text: str, channels: Sequence[str], role: str, *, supports_lockstep: bool) -> None:
        self.kind = kind
        self.text = text
        self.channels = tuple(channels)
        self.supports_lockstep = supports_lockstep
        self.role = role
        self.own_sender = ROLES[role]
        self.peer_sender = BENCH if self.own_sender == ECU else ECU

    @abstractmethod
    def send(self, frames: NDArray[np.void], count: int) -> None:
        """Send the first ``count`` frames; one that the bus has no room for is dropped and counted.

        Raises
        ------
        LinkError
            If the link is lost.
        """

    @abstractmethod
    def receive(self, into: NDArray[np.void], start: int = 0) -> int:
        """Move what has arrived into ``into[start:]``; returns the number of frames.

        What does not fit stays for the next call.

        Raises
        ------
        LinkError
            If the link is lost.
        """

    @abstractmethod
    def wait(self, timeout_s: float) -> bool:
        """Sleep until a frame has arrived or the time is over; True if there may be one."""

    @property
    def descriptors(self) -> tuple[int, ...]:
        """File descriptors that are readable once a frame has arrived; none where a link has to be asked."""
        poller = getattr(self, "_poller", None)
        return poller.descriptors if isinstance(poller, Poller) else ()

    @abstractmethod
    def statistics(self) -> dict[str, int | str]:
        """Counts since the link was opened.

        At least ``sent``, ``received``, ``own_echoes``, ``send_refused`` (no buffer space), ``overflows`` (frames that
        the kernel dropped because nobody read them), ``malformed``, ``error_frames`` and ``timestamp_source``.
        """

    @abstractmethod
    def close(self) -> None:
        """Give the bus back; closing twice is harmless."""

    def __enter__(self) -> Self:
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        self.close()


class Poller:
    """Waits on file descriptors."""

    def __init__(self, descriptors: Sequence[int]) -> None:
        self.descriptors = tuple(descriptors)
        self._poll = select.poll()
        for descriptor in descriptors:
            self._poll.register(descriptor, select.POLLIN)

    def wait(self, timeout_s: float) -> bool:
        """True once a descriptor is readable, False after ``timeout_s``."""
        return bool(self._poll.poll(timeout_s * 1e3))
