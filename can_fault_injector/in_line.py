"""The device in series that forwards a frame and changes nothing (F1 of the friction document, 5.2.2 and 5.2.5)."""

from typing import NamedTuple

import numpy as np

from can_fault_injector.bus_records import Node
from can_fault_injector.delay_model import DelayModel
from can_fault_injector.frame import Frame
from can_fault_injector.timed_bus import BitTiming, TimedBus, TimedNode

_NS_PER_S = 1e9
_LATE, _EARLY = BitTiming(11, 4, 4, 4), BitTiming(5, 4, 10, 4)
"""Nodes that sample at 80 % and at 50 % of a bit: both ends of the source's window (5.2.5)."""
_FRAMES = 3
"""Longest run in frames: one that is not acknowledged is sent again."""


class Forwarded(NamedTuple):
    """A frame that went through the device.

    Attributes
    ----------
    delay_ns : float
        From an edge of one side to the same edge of the other.
    share : float
        The delay in bit times.
    passed_late, passed_early : bool
        With nodes that sample late, or early: the far node has the frame, and the sender saw the acknowledgement, which
        comes back after twice the delay, before its sample point.
    frame_ns : float
        Duration of the frame on the wire.
    """

    delay_ns: float
    share: float
    passed_late: bool
    passed_early: bool
    frame_ns: float


def forward(frame: Frame, bit_rate: float, generator: np.random.Generator) -> Forwarded:
    """Send a frame through the device at a bit rate.

    Parameters
    ----------
    bit_rate : float [bit/s]
        10 kbit/s to 1 Mbit/s (Table 7).
    generator : numpy.random.Generator
        Source of the scatter, see `DelayModel`.
    """
    delay_ns = float(DelayModel(generator).delays_ns(bit_rate)[0])
    late, early = (_passes(frame, bit_rate, delay_ns, timing) for timing in (_LATE, _EARLY))
    frame_ns = frame.bits().size / bit_rate * _NS_PER_S
    return Forwarded(delay_ns, delay_ns * bit_rate / _NS_PER_S, late, early, frame_ns)


def _passes(frame: Frame, bit_rate: float, delay_ns: float, timing: BitTiming) -> bool:
    """Whether a frame arrives and its sender has the acknowledgement in time, between two nodes of one timing."""
    bus = TimedBus([TimedNode(Node("near"), timing), TimedNode(Node("far"), timing, delay_ns=delay_ns)], bit_rate)
    bus.send("near", frame)
    bus.run(_FRAMES * frame.bits().size, until_idle=True)
    near, far = bus.nodes["near"], bus.nodes["far"]
    return far.received == [frame] and not near.errors and not far.errors
