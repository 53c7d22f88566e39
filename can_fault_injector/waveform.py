"""Bus levels as a value change dump (IEEE 1364), which logic analysers and their decoders read."""

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from can_fault_injector.bus import Bus
from can_fault_injector.bus_records import Node
from can_fault_injector.disturbance import Disturbance
from can_fault_injector.frame import Frame

IDLE_BITS = 11
"""Recessive bits after which a node that has just joined takes part (ISO 11898-1, bus integration)."""
_FRAME_LIMIT = 10_000
"""Bits within which any frame and its repetition are over, by far."""
_TIMESCALES_NS = (100, 10, 1)
"""Those that the format knows; the coarsest that fits leaves a decoder the fewest samples."""
_HEADER = """$timescale {timescale} ns $end
$scope module bus $end
$var wire 1 ! {name} $end
$upscope $end
$enddefinitions $end
"""


class Wave(NamedTuple):
    """Levels of a line, one per bit, and how long each lasts."""

    levels: NDArray[np.uint8]
    durations_ns: NDArray[np.int64]


def receive_line(
    frame: Frame, flipped: Sequence[int] = (), *, bit_rate: float = 500e3, data_bit_rate: float | None = None
) -> Wave:
    """What a receiver sees of a frame, with what it does about inverted bits: error flag, and the sender's repetition.

    Parameters
    ----------
    flipped
        Bits inverted on the receiver's line, where the frame comes the first time, counted from SOF.
    bit_rate, data_bit_rate : float [bit/s]
        As of `Bus`.

    Returns
    -------
    Wave
        With a free bus before and after it.
    """
    bus = Bus([Node(name, iso=frame.iso) for name in ("sender", "receiver")], bit_rate, data_bit_rate=data_bit_rate)
    bus.run(IDLE_BITS)
    for position in flipped:
        bus.disturb(Disturbance("flip", IDLE_BITS + position, tap="receive", node="receiver"))
    bus.send("sender", frame)
    bus.run(_FRAME_LIMIT, until_idle=True)
    bus.run(IDLE_BITS)
    trace = bus.trace
    return Wave(trace.seen[:, bus.index("receiver")], trace.durations_ns)


def value_change_dump(wave: Wave, name: str = "can_rx") -> str:
    """Text of a dump of one wire."""
    timescale = next(scale for scale in _TIMESCALES_NS if not (wave.durations_ns % scale).any())
    starts = np.concatenate([[0], np.cumsum(wave.durations_ns // timescale)])
    changes = np.flatnonzero(np.diff(wave.levels.astype(int), prepend=-1))
    lines = [f"#{starts[i]}\n{wave.levels[i]}!" for i in changes]
    return _HEADER.format(timescale=timescale, name=name) + "\n".join([*lines, f"#{starts[-1]}"]) + "\n"
