"""Signals that a run with faults on its bus records beside those of the catalogue."""

from collections.abc import Sequence

from can_fault_injector.faults.fault_file import Fault
from can_fault_injector.faults.levels import NODES
from signals.catalogue import Signal

BLOCK = "injector"
_COUNTS = {
    "injector.frames_disturbed": "frames that a fault acted on, so far",
    "injector.frames_lost": "frames that entered the injector and never left it, so far",
    "injector.error_frames": "error frames that the modelled nodes gave rise to, so far",
}


def counter_name(node: str, which: str) -> str:
    """Signal of a node's error counter; ``which`` is "transmit" or "receive"."""
    return f"injector.{which}_errors_{node}"


def figure_name(fault: Fault, figure: str) -> str:
    """Signal of what a fault measures on its frames."""
    return f"injector.{fault.name}_{figure}"


def injector_signals(faults: Sequence[Fault]) -> tuple[Signal, ...]:
    """The signals; none without faults."""
    if not faults:
        return ()
    named = {f"injector.{fault.name}": f"1 while the fault {fault.name} acts" for fault in faults}
    counters = {
        counter_name(node, which): f"{which} error counter of node {node} in the model of the bus"
        for node in NODES
        for which in ("transmit", "receive")
    }
    texts = named | _COUNTS | counters
    measured = [
        Signal(figure_name(fault, figure), unit, f"{text}, of the last frame of fault {fault.name}", BLOCK, unit, 1.0)
        for fault in faults
        for figure, (unit, text) in fault.disturbance.model.figures.items()
    ]
    return (*(Signal(name, "1", text, BLOCK, "1", 1.0) for name, text in texts.items()), *measured)
