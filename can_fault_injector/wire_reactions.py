"""What protocol nodes make of a wire fault: run on the bit model, each in one word."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Literal

from can_fault_injector.bus import Bus
from can_fault_injector.bus_records import Node
from can_fault_injector.frame import Frame
from can_fault_injector.wire_faults import Line, levels

Word = Literal["ok", "degraded", "error", "silent"]
_FRAMES_EACH = 3
_BITS = 20_000


@dataclass(frozen=True)
class Reaction:
    """How a node fared.

    Attributes
    ----------
    word : str
        "error": it detected errors. "silent": it noticed nothing and received nothing. "degraded": without an error it
        missed frames that were sent, or its voltages are outside ISO 11898-2. "ok".
    received, delivered : int
        Frames that it accepted, and how often its own were accepted by others.
    transmit_errors, receive_errors, state
        At the end; nodes stay bus-off.
    """

    word: Word
    received: int
    delivered: int
    transmit_errors: int
    receive_errors: int
    state: str


def reactions(
    line: Line, fault: str | None, before: str | None = None, senders: Sequence[str] | None = None
) -> dict[str, Reaction]:
    """Reaction of each node of a line while ``senders`` (by default all) send three frames each.

    Parameters
    ----------
    fault, before
        As in `wire_faults.levels`.
    """
    electrical = levels(line, fault, before)
    bus = Bus([Node(name, recovers=False) for name in line.nodes], trace=False)
    bus.connect(electrical.seen)
    sending = tuple(line.nodes if senders is None else senders)
    for number in range(_FRAMES_EACH):
        for i, name in enumerate(sending):
            bus.send(name, Frame(0x100 + 16 * i + number, bytes([i, number])))
    bus.run(_BITS, until_idle=True)
    result = {}
    for i, (name, node) in enumerate(bus.nodes.items()):
        own = (
            {0x100 + 16 * sending.index(name) + number for number in range(_FRAMES_EACH)} if name in sending else set()
        )
        expected = _FRAMES_EACH * sum(other != name for other in sending)
        received = len(node.received)
        delivered = sum(item.frame.identifier in own for item in bus.received)
        sound = bool(electrical.in_limits[i]) and received == expected
        word: Word = "ok" if sound else "degraded"
        if node.errors:
            word = "error"
        elif received == 0 and expected:
            word = "silent"
        result[name] = Reaction(word, received, delivered, node.transmit_errors, node.receive_errors, node.state)
    return result
