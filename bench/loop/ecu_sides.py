"""The other side of the bus as the tick sees it: nobody, a link, a link in lock-step.

The emulated ECU in the bench's own process is in :mod:`bench.loop.in_process_ecu`.

In virtual time a frame sent in tick n is seen by the other side at tick n + 1, on every kind of side, and time stamps
are ticks. A recording in real time has an origin in CLOCK_REALTIME: ``origin_ns`` of a side, which tick 0 stands for.
"""

import time
from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray

from bench.codec.codec import Receiver
from bench.links.barrier import BarrierServer, PeerLost
from bench.links.frame import FRAME_DTYPE, OPAQUE_DTYPE
from bench.links.interface import Link
from signals.errors import RunError

MAX_FRAMES = 4096


class NoEcu:
    """Nobody answers: the frames go to the recording only."""

    origin_ns = 0

    def prepare(self) -> None:
        """Nothing to prepare."""

    def receive(self, tick: int, frames: NDArray[np.void]) -> int:
        """Nothing ever arrives."""
        return 0

    def send(self, tick: int, frames: NDArray[np.void], count: int) -> None:
        """Frames go nowhere."""
        frames["timestamp_ns"][:count] += self.origin_ns

    def close(self) -> None:
        """Nothing to close."""


class LinkedEcu:
    """An ECU behind a link, in real time: what has arrived is seen, nothing is waited for.

    Parameters
    ----------
    link : Link
        An open link.
    first_answer_s : float
        Wall-clock time within which :meth:`wait_until_heard` expects a frame.
    """

    origin_ns = 0

    def __init__(self, link: Link, first_answer_s: float) -> None:
        self._link = link
        self._first_answer_s = first_answer_s
        self._shift_ns = 0
        self._before_the_clock = np.zeros(MAX_FRAMES, FRAME_DTYPE)

    def wait_until_heard(self, ecu_frames: Receiver, is_alive: Callable[[], bool] = lambda: True) -> None:
        """Wait for the ECU's first good frame, so that a run begins with an ECU that is there.

        Parameters
        ----------
        ecu_frames : Receiver
            Tells the ECU's frames from those of others on the bus.
        is_alive : callable
            False once the ECU's process has ended, which ends the wait.

        Raises
        ------
        RunError
            If no frame comes in time.
        """
        deadline = time.monotonic() + self._first_answer_s
        heard = self._before_the_clock
        while not ecu_frames.accept(heard, self._link.receive(heard), 0):
            if not is_alive():
                raise RunError("the emulated ECU ended before it answered", mend="see log.txt in the run's folder")
            if time.monotonic() > deadline:
                raise RunError(
                    f"the ECU on {self._link.text} sent no frame within {self._first_answer_s:g} s",
                    mend="start it (bench ecu --link …), check the link, or declare ecu.expect: silent in the scenario",
                )
            self._link.wait(0.01)

    def prepare(self) -> None:
        """Drop what has arrived since the ECU was first heard: the frames of a run begin with its clock.

        Preparations that take long overflow the receive buffer, which keeps the oldest frames. A receiver that began
        with those would refuse the first frames of the run by their counters.
        """
        while self._link.receive(self._before_the_clock) == MAX_FRAMES:
            pass

    def receive(self, tick: int, frames: NDArray[np.void]) -> int:
        """Everything that arrived since the last tick."""
        if tick == 0 and self.origin_ns:
            # the recording began when its processes were started; its time is counted from this tick on
            self._shift_ns = self.origin_ns - time.time_ns()
        count = self._link.receive(frames)
        frames["tick"][:count] = tick
        frames["timestamp_ns"][:count] += self._shift_ns
        return count

    def send(self, tick: int, frames: NDArray[np.void], count: int) -> None:
        """Put the frames on the link."""
        self._link.send(frames, count)
        frames["timestamp_ns"][:count] = time.time_ns() + self._shift_ns

    def close(self) -> None:
        """Close the link."""
        self._link.close()


class BarrierEcu:
    """An ECU in another process in virtual time: both run tick n at the same time on the frames of tick n − 1.

    Parameters
    ----------
    link, barrier
        Open; the peer has joined the barrier.
    may_be_lost : bool
        The scenario expects that the ECU may end: from then on nobody answers. Otherwise its end is an error.
    """

    origin_ns = 0

    def __init__(self, link: Link, barrier: BarrierServer, may_be_lost: bool) -> None:
        self._link = link
        self._barrier = barrier
        self._may_be_lost = may_be_lost
        self._sent = np.zeros(MAX_FRAMES, FRAME_DTYPE)
        self._sent_bytes = self._sent.view(OPAQUE_DTYPE)
        self._sent_count = 0
        self._running = False
        self._lost = False

    def prepare(self) -> None:
        """Nothing to prepare."""

    def receive(self, tick: int, frames: NDArray[np.void]) -> int:
        """Frames that the peer sent in its previous tick; then lets it run this one."""
        if self._lost:
            return 0
        try:
            return self._exchange(tick, frames)
        except PeerLost:
            if not self._may_be_lost:
                raise
            self._lost = True
            return 0

    def _exchange(self, tick: int, frames: NDArray[np.void]) -> int:
        count = self._barrier.finish(self._link, frames) if self._running else 0
        self._barrier.begin(tick, self._sent, self._sent_count)
        self._sent_count = 0
        self._running = True
        return count

    def send(self, tick: int, frames: NDArray[np.void], count: int) -> None:
        """Put the frames on the link; the peer is told of them at the next tick."""
        self._link.send(frames, count)
        self._sent_bytes[:count] = frames.view(OPAQUE_DTYPE)[:count]
        self._sent_count = count
        if self.origin_ns:
            frames["timestamp_ns"][:count] += self.origin_ns

    def silence(self) -> None:
        """The peer has been killed: what it may have sent in this tick is lost, so that its last frame is definite."""
        self._lost = True

    def close(self) -> None:
        """End the barrier and close the link."""
        self._barrier.close()
        self._link.close()
