"""A node under test that faces a tester which puts levels on the bus without following the protocol."""

import numpy as np
from bit_tester import FRAME, START

from can_fault_injector import Bus, Disturbance, Frame

STUFF_VIOLATION = [0] * 6
FLAG, DELIMITER, INTERMISSION = 6, 8, 3
BETWEEN = FLAG + DELIMITER + INTERMISSION
OFFSETS = {name: i for i, name in enumerate(FRAME.bit_names())}


def levels(frame: Frame = FRAME, acknowledged: bool = True, stop: str | None = None, **changed: int) -> list[int]:
    """Levels of a frame as a tester drives them; ``crc_del_0=0`` changes a bit, ``stop`` is the last one."""
    names = list(frame.bit_names())
    bits = [int(bit) for bit in frame.bits()]
    bits[names.index("ack_slot.0")] = 0 if acknowledged else 1
    for name, level in changed.items():
        field, _, number = name.rpartition("_")
        bits[names.index(f"{field}.{number}")] = level
    return bits[: names.index(stop) + 1] if stop else bits


def sending(bus: Bus, acknowledged: int = 1, frame: Frame = FRAME) -> int:
    """Have the node send from ``START`` on and acknowledge it so many times; returns the bit of SOF."""
    bus.run(START)
    bus.send("node", frame)
    if acknowledged:
        bus.disturb(Disturbance("dominant", "ack_slot", repeat=acknowledged))
    return START


def steps(bus: Bus) -> list[tuple[int, int, int]]:
    return bus.nodes["node"].counter_steps


def dominant_bits(bus: Bus, start: int, stop: int) -> list[int]:
    return [start + int(i) for i in np.flatnonzero(bus.trace.bus[start:stop] == 0)]
