"""A tester that puts any levels on the bus, without following the protocol, and what a node under test did."""

from collections.abc import Iterable

import numpy as np

from can_fault_injector import Bus, Disturbance, Frame, Node

FRAME = Frame(0x2AA, b"\x55\x0f")
NAMES = list(FRAME.bit_names())
BITS = len(NAMES)
START = 4
PASSIVE = 130


def stream(frame: Frame = FRAME, acknowledged: bool = True) -> list[int]:
    bits = [int(bit) for bit in frame.bits()]
    bits[list(frame.bit_names()).index("ack_slot.0")] = 0 if acknowledged else 1
    return bits


def at(name: str) -> int:
    return START + NAMES.index(name)


def node(levels: Iterable[int] = (), **settings: object) -> Bus:
    bus = Bus([Node("node", **settings)])  # type: ignore[arg-type]
    bus.drive(levels, START)
    return bus


def sending(bus: Bus, frames: int = 1) -> None:
    """The node sends from ``START`` on; every frame is acknowledged."""
    bus.run(START)
    for _ in range(frames):
        bus.send("node", FRAME)
    bus.disturb(Disturbance("dominant", "ack_slot", repeat=-1))


def started(bus: Bus, name: str = "node") -> list[int]:
    return [event.bit for event in bus.events if event.node == name and event.kind == "started"]


def dominant(bus: Bus, start: int, stop: int | None = None) -> list[int]:
    """Bits at which the first node drives dominant."""
    return [start + int(i) for i in np.flatnonzero(bus.trace.driven[start:stop, 0] == 0)]


def kinds(bus: Bus, name: str) -> list[str]:
    return [event.kind for event in bus.events if event.node == name]
