"""Plain records of the bus model: settings of a node, events, received frames, the trace."""

from dataclasses import dataclass
from typing import Literal, NamedTuple

import numpy as np
from numpy.typing import NDArray

from can_fault_injector.frame import Frame


@dataclass(frozen=True)
class Node:
    """Settings of a protocol node.

    Parameters
    ----------
    name : str
        Unique on the bus.
    fd : str
        "enabled", "tolerant" (waits without an error flag while others use CAN FD) or "classic" (reads FDF as r0).
    iso : bool
        CAN FD of ISO 11898-1:2015, else the older variant.
    silent : bool
        Listen only: neither acknowledges nor sends flags.
    recovers : bool
        Returns from bus-off by itself after 128 times 11 recessive bits.
    single_shot : bool
        Gives a frame up after an error instead of repeating it.
    transmit_errors, receive_errors : int
        Counters at the beginning.
    integrating : bool
        Waits for 11 recessive bits before it takes part, as after power-on; else idle at once.
    sample_point : float
        Instant of the bit at which it reads the level, 0 to 1; matters for pulses shorter than a bit.
    """

    name: str
    fd: Literal["enabled", "tolerant", "classic"] = "enabled"
    iso: bool = True
    silent: bool = False
    recovers: bool = True
    single_shot: bool = False
    transmit_errors: int = 0
    receive_errors: int = 0
    integrating: bool = False
    sample_point: float = 0.75

    def __post_init__(self) -> None:
        if not 0.0 < self.sample_point < 1.0:
            raise ValueError(f"sample_point: found {self.sample_point:g}, allowed: above 0, below 1")


class Event(NamedTuple):
    """What happened to a node at a bit, with its counters after that bit.

    Attributes
    ----------
    kind, error : str
        One of ``node_state.EVENT_NAMES``; of an error its kind.
    level : int
        What the node saw.
    transmitter : bool
        Whether it was the sender (of the frame before, in flags and delimiters).
    place : str
        The bit as a disturbance names it, ``crc.3``, ``stuff.1``, ``error_delimiter.2``.
    information : str
        Of a stuff bit the bit that comes after it, else the place.
    extended : bool
        Whether the identifier had proved to be extended.
    """

    bit: int
    node: str
    kind: str
    error: str
    transmit_errors: int
    receive_errors: int
    level: int
    transmitter: bool
    place: str
    information: str
    extended: bool


class Received(NamedTuple):
    """A frame that a node accepted at a bit (the last but one of EOF)."""

    bit: int
    node: str
    frame: Frame


class Trace:
    """Levels and counters of every bit of the runs of a bus.

    Attributes
    ----------
    bus : uint8 array (bits)
        At the sample point of the first node.
    driven, seen : uint8 arrays (bits, nodes)
        What each node put on its transmit line and found on its receive line, disturbances included, each at the
        node's sample point.
    durations_ns : int64 array (bits)
        Of each bit on the bus: shorter in the data phase of CAN FD.
    transmit_errors, receive_errors, phase : int16 arrays (bits, nodes)
        State after the bit; ``phase`` by the codes of ``node_state``.
    """

    def __init__(self, levels: NDArray[np.uint8], trace: NDArray[np.int16], bit_times_ns: NDArray[np.int64]) -> None:
        self.bus = levels[:, 0]
        self.driven, self.seen = levels[:, 1:-1:2], levels[:, 2::2]
        self.durations_ns = bit_times_ns[levels[:, -1]]
        self.transmit_errors, self.receive_errors, self.phase = trace[:, 0::3], trace[:, 1::3], trace[:, 2::3]
