"""Frames on the modelled bus: bench, ECU, a bystander and the injector, bit by bit, with what faults do to the bits."""

from collections import deque
from collections.abc import Callable
from dataclasses import dataclass, field
from typing import NamedTuple

from can_fault_injector.bus import Bus
from can_fault_injector.bus_records import Event, Node
from can_fault_injector.disturbance import Disturbance
from can_fault_injector.faults.bit_actions import SENDER, Marks
from can_fault_injector.faults.levels import NODES
from can_fault_injector.faults.running import NS_PER_S, WAYS, Way
from can_fault_injector.frame import Frame
from can_fault_injector.node import PASSIVE_LIMIT

INJECTOR = "injector"
MAILBOXES = 32
"""Frames of one sender that wait; the next one is lost, as in a controller whose mailboxes are full."""
_TABLE_FRAMES = 512
_WAY_TO: dict[str, Way] = {"ecu": "to_ecu", "bench": "to_bench"}
_SENDER_WAY: dict[str, Way] = {"bench": "to_ecu", "ecu": "to_bench"}


class Delivered(NamedTuple):
    """A frame that the receiver behind the injector accepted."""

    time_ns: int
    way: Way
    frame: Frame


class NodeEvent(NamedTuple):
    """An event of a node and its time."""

    time_ns: int
    event: Event


@dataclass
class _Entry:
    """A frame that waits for the bus, or is on it."""

    frame: Frame
    marks: Marks
    arrival_ns: int
    armed: list[int] = field(default_factory=list)


class BitStage:
    """The bus of the model, run in pieces of time.

    Parameters
    ----------
    bit_rate, data_bit_rate : float [bit/s]
    on_lost : callable
        Called with way, frame and reason for a frame that never gets to its receiver.
    """

    def __init__(
        self,
        bit_rate: float,
        data_bit_rate: float | None,
        on_lost: Callable[[Way, Frame, str], None],
    ) -> None:
        nodes = [Node(name) for name in (*NODES, INJECTOR)]
        self.bus = Bus(nodes, bit_rate, data_bit_rate=data_bit_rate, trace=False)
        self.bit_ns = NS_PER_S / bit_rate
        self._offset_ns = 0.0
        self._on_lost = on_lost
        self._waiting: dict[Way, deque[_Entry]] = {way: deque() for way in WAYS}
        self._on_bus: dict[Way, deque[_Entry]] = {way: deque() for way in WAYS}
        self._frames_sent = 0
        self._lasting: set[int] = set()
        self.muted: set[str] = set()
        """Nodes that are off: what they would send is lost, and they hear nothing."""
        self.delivered: list[Delivered] = []
        self.events: list[NodeEvent] = []

    @property
    def now_ns(self) -> float:
        """Time up to which the bus has run."""
        return self.bus.time_s * NS_PER_S + self._offset_ns

    @property
    def idle(self) -> bool:
        """Nothing on the bus, nothing waiting, and every node fit to send."""
        return not any(self._waiting.values()) and not any(self._on_bus.values()) and self.bus.idle

    @property
    def settled(self) -> bool:
        """Idle, and no node counts errors: frames may pass without it, nothing would be different."""
        nodes = (self.bus.nodes[name] for name in NODES)
        return self.idle and not any(node.transmit_errors or node.receive_errors for node in nodes)

    def put(self, way: Way, frame: Frame, marks: Marks, now_ns: int) -> None:
        """A sender wants to send a frame."""
        if SENDER[way] in self.muted:
            self._on_lost(way, frame, "its sender is off")
        elif len(self._waiting[way]) + len(self._on_bus[way]) >= MAILBOXES:
            self._on_lost(way, frame, "its sender's mailboxes are full")
        elif self.bus.nodes[SENDER[way]].state == "bus_off":
            self._on_lost(way, frame, "its sender is bus-off")
        else:
            self._waiting[way].append(_Entry(frame, marks, now_ns))

    def put_as_injector(self, frame: Frame) -> None:
        """A frame that the injector's own node sends as soon as it gets the bus."""
        if self.bus.nodes[INJECTOR].waiting < MAILBOXES:
            self.bus.send(INJECTOR, frame)
            self._frames_sent += 1

    @property
    def injector_waiting(self) -> int:
        """Frames that the injector's node has still to send."""
        return self.bus.nodes[INJECTOR].waiting

    def silence_injector(self) -> None:
        """The injector's node sends no more."""
        self.bus.reset(INJECTOR)

    def begin_lasting(self, disturbance: Disturbance) -> int:
        """Arm a disturbance that belongs to no frame; returns its number for :meth:`end_lasting`."""
        number = self.bus.disturb(disturbance)
        self._lasting.add(number)
        return number

    def end_lasting(self, number: int) -> None:
        """End a disturbance that belongs to no frame."""
        self.bus.withdraw(number)
        self._lasting.discard(number)

    def drop_waiting(self, way: Way, reason: str) -> None:
        """What a sender has not yet sent is lost."""
        for entry in (*self._on_bus[way], *self._waiting[way]):
            self._on_lost(way, entry.frame, reason)
            self._disarm(entry)
        self._on_bus[way].clear()
        self._waiting[way].clear()

    def catch_up(self, now_ns: int) -> None:
        """Bring the bus to a time: what is on it goes on, and if it is idle it was so up to then."""
        if not self.idle:
            self.run(now_ns)
        if self.idle:
            self._offset_ns += max(0.0, now_ns - self.now_ns)

    def run(self, until_ns: int) -> None:
        """Let the bus run up to a time, or until it is idle with nothing to send, into ``delivered`` and ``events``."""
        while True:
            self._feed()
            bits = int((until_ns - self.now_ns) / self.bit_ns)
            if bits <= 0:
                return
            self.bus.run(bits, until_idle=True)
            self._collect()
            if self.bus.idle and not any(self._waiting.values()):
                return

    def _feed(self) -> None:
        """Hand waiting frames to their nodes, the earliest first; a frame with marks is alone with its identifier."""
        if self.bus.idle:
            self._tidy()
            arrivals = [queue[0].arrival_ns for queue in self._waiting.values() if queue]
            if arrivals:
                self._offset_ns += max(0.0, min(arrivals) - self.now_ns)
        for way in WAYS:
            waiting, under_way = self._waiting[way], self._on_bus[way]
            while waiting:
                entry = waiting[0]
                same = [other for other in under_way if other.frame.identifier == entry.frame.identifier]
                if same and (entry.marks or any(other.marks for other in same)):
                    break
                if entry.marks.overwritten_by is not None and not self.bus.idle:
                    break
                if any(other.marks.single_shot for other in under_way):
                    break
                self._start(way, waiting.popleft())

    def _start(self, way: Way, entry: _Entry) -> None:
        sender = SENDER[way]
        entry.armed = [self.bus.disturb(disturbance) for disturbance in entry.marks.disturbances]
        if entry.marks.overwritten_by is not None:
            self.bus.set_transmit_errors(sender, max(self.bus.nodes[sender].transmit_errors, PASSIVE_LIMIT))
            self.bus.drive(entry.marks.overwritten_by.bits())
        self.bus.configure(sender, single_shot=entry.marks.single_shot)
        self.bus.send(sender, entry.frame)
        self._frames_sent += 1
        self._on_bus[way].append(entry)

    def _disarm(self, entry: _Entry) -> None:
        for number in entry.armed:
            self.bus.withdraw(number)
        entry.armed = []

    def _tidy(self) -> None:
        """A bus that is idle forgets the frames and disturbances of the past."""
        armed = any(entry.armed for queue in self._on_bus.values() for entry in queue)
        if self._frames_sent > _TABLE_FRAMES and not (armed or self._lasting):
            self.bus.forget()
            self._frames_sent = 0

    def _time_of(self, bit: int) -> int:
        return round(self.now_ns - (self.bus.bit - bit) * self.bit_ns)

    def _collect(self) -> None:
        for event in self.bus.events:
            self.events.append(NodeEvent(self._time_of(event.bit), event))
            self._follow(event)
        self.bus.events.clear()
        for bit, node, frame in self.bus.received:
            way = _WAY_TO.get(node)
            if way is not None and node not in self.muted:
                self.delivered.append(Delivered(self._time_of(bit), way, frame))
        self.bus.received.clear()
        for way, queue in self._on_bus.items():
            while len(queue) > self.bus.nodes[SENDER[way]].waiting:
                entry = queue.popleft()
                self._disarm(entry)
                self._on_lost(way, entry.frame, "its sender gave it up after an error")

    def _follow(self, event: Event) -> None:
        way = _SENDER_WAY.get(event.node)
        if way is None:
            return
        if event.kind == "transmitted" and self._on_bus[way]:
            self._disarm(self._on_bus[way].popleft())
        elif event.kind == "bus_off":
            self.bus.drop_waiting(event.node)
            if not self.bus.nodes[event.node].waiting:
                self.drop_waiting(way, "its sender is bus-off")
