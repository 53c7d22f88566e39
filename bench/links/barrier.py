"""Lock-step of two processes: who may run which tick, and which frames belong to it.

A socket of packets (AF_UNIX, SOCK_SEQPACKET) beside the bus; nothing of it shows on the bus. In each tick the bench
says "run tick n; by the end of my tick n − 1 I had sent so many frames on each channel, and those of that tick have
these signatures". The peer reads its link until it has them all, runs its tick n while the bench runs its own, sends
its frames and answers in the same form. So a frame of tick n is seen by the other side in tick n + 1 on every kind of
link, and a stranger's frame is never taken for one of the pair's, whatever it looks like and whenever it comes.
``docs/bus.md`` describes the messages for peers in other languages.
"""

import socket
import struct
import time
from collections.abc import Callable
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from bench.links.interface import Link
from bench.links.lockstep_frames import HEADER, MESSAGE_BYTES, Announcer, Collector, warm_up
from signals.errors import RunError

TIMEOUT_S = 5.0
"""Time that the ECU has for a tick."""
PATIENCE_S = 60.0
"""Time that the ECU gives the bench to begin a tick; a bench that died is noticed at once."""


class PeerSilent(RunError):
    """The other process did not answer in time."""


class PeerLost(RunError):
    """The other process closed its end of the barrier, or died."""


class _End:
    """What both ends of a barrier do."""

    def __init__(self, timeout_s: float) -> None:
        self.timeout_s = timeout_s
        self._socket: socket.socket | None = None
        self._announcer = Announcer()
        self._collector = Collector()
        self._buffer = memoryview(bytearray(MESSAGE_BYTES))
        warm_up()

    def _use(self, sock: socket.socket) -> None:
        seconds = int(self.timeout_s)
        limit = struct.pack("@ll", seconds, int((self.timeout_s - seconds) * 1e6))
        sock.setblocking(True)
        sock.setsockopt(socket.SOL_SOCKET, socket.SO_RCVTIMEO, limit)
        self._socket = sock

    def _send(self, message: bytes) -> None:
        if self._socket is None:
            raise PeerLost("the barrier has no peer")
        try:
            self._socket.send(message)
        except OSError as error:
            raise PeerLost(f"the other side of the barrier is gone: {error.strerror}") from error

    def _receive(self) -> memoryview:
        """Next message; empty once the other side has closed its end."""
        if self._socket is None:
            raise PeerLost("the barrier has no peer")
        try:
            return self._buffer[: self._socket.recv_into(self._buffer)]
        except BlockingIOError:
            raise PeerSilent(f"no answer within {self.timeout_s:g} s") from None
        except ConnectionResetError:
            return self._buffer[:0]

    def close(self) -> None:
        """Close this end: the other one sees it at once."""
        if self._socket is not None:
            self._socket.close()
            self._socket = None


class BarrierServer(_End):
    """The bench's end.

    Parameters
    ----------
    path : str or Path
        Where the socket is made; the peer gets it as ``--barrier PATH``.
    timeout_s : float
        Time within which the peer has to answer.
    """

    def __init__(self, path: str | Path, timeout_s: float = TIMEOUT_S) -> None:
        super().__init__(timeout_s)
        self.path = Path(path)
        self._tick = -1
        self._listener = socket.socket(socket.AF_UNIX, socket.SOCK_SEQPACKET)
        self.path.unlink(missing_ok=True)
        try:
            self._listener.bind(str(self.path))
        except OSError as error:
            self._listener.close()
            raise RunError(f"{self.path}: cannot make the barrier's socket: {error}") from error
        self._listener.listen(1)

    def wait_for_peer(self, timeout_s: float | None = None, is_alive: Callable[[], bool] = lambda: True) -> None:
        """Wait until the peer has joined.

        Parameters
        ----------
        timeout_s : float, optional
            Longest wait; the timeout of the barrier by default.
        is_alive : callable
            False once the peer's process has ended, which ends the wait.

        Raises
        ------
        PeerSilent, PeerLost
            If nobody joined in time, or its process has ended.
        """
        limit = self.timeout_s if timeout_s is None else timeout_s
        deadline = time.monotonic() + limit
        self._listener.settimeout(0.05)
        while True:
            try:
                sock, _ = self._listener.accept()
            except TimeoutError:
                if not is_alive():
                    raise PeerLost("the ECU's process ended before it joined the barrier") from None
                if time.monotonic() > deadline:
                    raise PeerSilent(
                        f"the ECU did not join the barrier within {limit:g} s",
                        mend=f"start it:  bench ecu --link … --barrier {self.path}",
                    ) from None
            else:
                self._use(sock)
                return

    def begin(self, tick: int, sent: NDArray[np.void], count: int) -> None:
        """Let the peer run a tick; ``sent[:count]`` is what the bench has sent since the last call.

        Raises
        ------
        PeerLost
            If the peer is gone.
        """
        self._tick = tick
        self._send(self._announcer.message(tick, sent, count))

    def finish(self, link: Link, into: NDArray[np.void]) -> int:
        """Wait for the peer's answer to the tick begun last; its frames and strangers' go into ``into``.

        Returns
        -------
        int
            Number of frames: the peer's by channel and order of sending, then strangers' (``sender`` FOREIGN).

        Raises
        ------
        PeerSilent, PeerLost
            If the peer does not answer in time, or is gone.
        LinkError
            If a frame that it has sent does not arrive.
        """
        try:
            message = self._receive()
        except PeerSilent as error:
            raise PeerSilent(f"the ECU never answered tick {self._tick}: {error.message}") from None
        if not message:
            raise PeerLost(f"the ECU ended in tick {self._tick}")
        return self._collector.collect(message, self._tick, link, into, self.timeout_s)

    def close(self) -> None:
        """End the barrier and remove its socket."""
        super().close()
        self._listener.close()
        self.path.unlink(missing_ok=True)


class BarrierClient(_End):
    """The ECU's end.

    Parameters
    ----------
    path : str or Path
        The server's socket.
    timeout_s : float
        Time within which the bench has to begin each tick.

    Raises
    ------
    RunError
        If nobody listens there.
    """

    def __init__(self, path: str | Path, timeout_s: float = PATIENCE_S) -> None:
        super().__init__(timeout_s)
        self._tick = -1
        sock = socket.socket(socket.AF_UNIX, socket.SOCK_SEQPACKET)
        try:
            sock.connect(str(path))
        except OSError as error:
            sock.close()
            raise RunError(f"{path}: no bench listens at this barrier: {error.strerror}") from error
        self._use(sock)

    def begin(self, link: Link, into: NDArray[np.void]) -> tuple[int, int] | None:
        """Wait for the next tick.

        Returns
        -------
        tuple of int or None
            Tick and number of frames in ``into`` that the bench (then strangers) sent in the tick before; None once the
            bench has ended the run.

        Raises
        ------
        PeerSilent
            If the bench does not begin a tick in time.
        LinkError
            If a frame that it has sent does not arrive.
        """
        message = self._receive()
        if not message:
            return None
        self._tick = HEADER.unpack_from(message)[0]
        return self._tick, self._collector.collect(message, self._tick - 1, link, into, self.timeout_s)

    def finish(self, sent: NDArray[np.void], count: int) -> None:
        """Answer the tick; ``sent[:count]`` is what was sent in it, already on the link."""
        self._send(self._announcer.message(self._tick, sent, count))
