"""Janus frames: one waveform that nodes with an early and with a late sample point read as two different frames."""

import numpy as np

from can_fault_injector.disturbance import Disturbance
from can_fault_injector.frame import Frame

SPLIT = 0.5
"""Instant of the bit, 0 to 1, up to which the early frame is on the bus and from which on the late one is."""


def differing_bits(late: Frame, early: Frame) -> list[int]:
    """Bits in which two frames of equal length on the wire differ, SOF is 0.

    Raises
    ------
    ValueError
        If their lengths differ: then the end of one is in the middle of the other.
    """
    late_bits, early_bits = late.bits(), early.bits()
    if late_bits.size != early_bits.size:
        raise ValueError(
            f"Janus frame: found {late_bits.size} and {early_bits.size} bits on the wire, "
            "allowed: two frames of equal length, stuff bits included"
        )
    return [int(position) for position in np.flatnonzero(late_bits != early_bits)]


def split_edges(late: Frame, early: Frame) -> int:
    """Edges from recessive to dominant in the middle of bits, early 1 and late 0, which nodes may follow.

    Each moves the nodes by up to their jump width, the early ones back, the late ones forth. Nodes with a jump width of
    one quantum stay in step over a few of them, seldom over more than five.
    """
    return sum(late.bits()[position] == 0 for position in differing_bits(late, early))


def janus(late: Frame, early: Frame, sender: str, split: float = SPLIT) -> list[Disturbance]:
    """Disturbances that make the transmit line of ``sender``, which sends ``late``, show ``early`` up to the split.

    Raises
    ------
    ValueError
        If the frames are not of equal length on the wire.
    """
    levels = early.bits()
    return [
        Disturbance(
            "recessive" if levels[position] else "dominant",
            f"bit.{position}",
            tap="transmit",
            node=sender,
            reference=sender,
            identifier=late.identifier,
            width=split,
        )
        for position in differing_bits(late, early)
    ]
