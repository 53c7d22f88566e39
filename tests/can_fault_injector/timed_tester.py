"""A tester with a resolution of one quantum, 1/20 of a bit, and a node in time that listens to it."""

from collections.abc import Sequence

from bit_tester import START

from can_fault_injector import Node
from can_fault_injector.timed_bus import TimedBus, TimedNode

QUANTA, TO_SAMPLE, JUMP = 20, 15, 4
BIT_RATE = 500e3
QUANTUM_NS = 1e9 / BIT_RATE / QUANTA


def receiver(levels: Sequence[int], **settings: object) -> TimedBus:
    """One node that listens to a tester, whose levels last a quantum each and begin at bit ``START``."""
    bus = TimedBus([TimedNode(Node("node", silent=True), **settings)], BIT_RATE)  # type: ignore[arg-type]
    bus.drive(levels, START, 1 / QUANTA)
    bus.run(START + len(levels) // QUANTA + 20)
    return bus


def samples_after(bus: TimedBus, quantum: int) -> list[float]:
    """Instants of the node's samples in quanta since the tester began, from an instant on."""
    begin = START * QUANTA
    times = [sample.time_ns / QUANTUM_NS - begin for sample in bus.samples if sample.node == "node"]
    return [time for time in times if time >= quantum]


def timed_counter_steps(bus: TimedBus, node: str = "node") -> list[tuple[int, int, int]]:
    """Nominal bit, TEC and REC of every sample of a node that changed one of them."""
    samples = [sample for sample in bus.samples if sample.node == node]
    counters = [(sample.transmit_errors, sample.receive_errors) for sample in samples]
    times = [int(sample.time_ns / QUANTUM_NS / QUANTA) for sample in samples]
    return [(times[i], *counters[i]) for i in range(1, len(samples)) if counters[i] != counters[i - 1]]
