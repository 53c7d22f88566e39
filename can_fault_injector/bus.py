"""A CAN bus at bit level: protocol nodes, disturbances on each node's lines, counters after every bit."""

from collections.abc import Iterable, Sequence

import numpy as np
from numpy.typing import NDArray

from can_fault_injector import bus_kernel as kernel
from can_fault_injector import node_state as ns
from can_fault_injector.bus_records import Event, Node, Received, Trace
from can_fault_injector.disturbance import Disturbance
from can_fault_injector.frame import Frame
from can_fault_injector.frame_table import FrameTable
from can_fault_injector.node import BUS_OFF_LIMIT, PASSIVE_LIMIT, WARNING_LIMIT

QUEUE_SIZE = 1024
_EVENT_ROWS, _RECEIVED_ROWS = 4096, 1024
_NS_PER_S = 1e9


class NodeView:
    """State of one node of a bus."""

    def __init__(self, bus: "Bus", index: int) -> None:
        self._bus, self._index = bus, index

    def _column(self, column: int) -> int:
        return int(self._bus._states[self._index, column])

    @property
    def transmit_errors(self) -> int:
        """Transmit error counter (TEC)."""
        return self._column(ns.TRANSMIT_ERRORS)

    @property
    def receive_errors(self) -> int:
        """Receive error counter (REC), 255 at most."""
        return self._column(ns.RECEIVE_ERRORS)

    @property
    def state(self) -> str:
        """ "error_active", "error_passive" or "bus_off"."""
        if self._column(ns.PHASE) == ns.BUS_OFF:
            return "bus_off"
        passive = max(self.transmit_errors, self.receive_errors) >= PASSIVE_LIMIT
        return "error_passive" if passive else "error_active"

    @property
    def warning(self) -> bool:
        """Whether a counter reached the warning level (FC16)."""
        return max(self.transmit_errors, self.receive_errors) >= WARNING_LIMIT

    @property
    def counter_steps(self) -> list[tuple[int, int, int]]:
        """Bit, TEC and REC for every bit of the trace that changed one of them."""
        trace = self._bus.trace
        counters = np.stack([trace.transmit_errors, trace.receive_errors], axis=2)[:, self._index].astype(int)
        changed = np.flatnonzero(np.any(np.diff(counters, axis=0), axis=1)) + 1
        return [(int(bit), int(counters[bit, 0]), int(counters[bit, 1])) for bit in changed]

    @property
    def phase(self) -> str:
        """What the node does now: one of ``node_state.PHASE_NAMES``."""
        return ns.PHASE_NAMES[self._column(ns.PHASE)]

    @property
    def waiting(self) -> int:
        """Frames that are queued or under way."""
        return self._column(ns.QUEUE_TAIL) - self._column(ns.QUEUE_HEAD)

    @property
    def received(self) -> list[Frame]:
        """Frames accepted so far."""
        name = self._bus.names[self._index]
        return [item.frame for item in self._bus.received if item.node == name]

    @property
    def errors(self) -> list[str]:
        """Kinds of the errors that it detected so far, in order."""
        name = self._bus.names[self._index]
        return [event.error for event in self._bus.events if event.node == name and event.kind == "error"]


class Bus:
    """Protocol nodes on one pair of wires, simulated bit by bit.

    Parameters
    ----------
    nodes : sequence of Node or str
        A string is a node of that name with default settings.
    bit_rate, data_bit_rate : float [bit/s]
        Rates of the arbitration phase and of the data phase of CAN FD frames with BRS; equal by default.
    trace : bool
        Keep levels and counters of every bit.

    Notes
    -----
    The unit of time is one bit: the bits of all nodes begin at the same instant, each samples at its own point of the
    bit. `timed_bus.TimedBus` has delays and resynchronisation. A rate switch changes the duration of the bits between
    BRS and the CRC delimiter, nothing else.
    """

    def __init__(
        self,
        nodes: Sequence[Node | str],
        bit_rate: float = 500e3,
        *,
        data_bit_rate: float | None = None,
        trace: bool = True,
    ) -> None:
        settings = [Node(node) if isinstance(node, str) else node for node in nodes]
        self.names = tuple(node.name for node in settings)
        if len(set(self.names)) != len(self.names) or not self.names:
            raise ValueError(f"nodes: found {', '.join(self.names) or 'none'}, allowed: at least one, unique names")
        rates = np.array([bit_rate, data_bit_rate or bit_rate])
        if rates.min() <= 0:
            raise ValueError(f"bit rates: found {rates[0]:g} and {rates[1]:g}, allowed: above 0 bit/s")
        self._bit_times_ns = np.rint(_NS_PER_S / rates).astype(np.int64)
        self._states = np.zeros((len(settings), ns.COLUMNS), np.int64)
        for row, node in zip(self._states, settings, strict=True):
            self._set_up(row, node)
        self.nodes = {name: NodeView(self, i) for i, name in enumerate(self.names)}
        self.events: list[Event] = []
        self.received: list[Received] = []
        self._data = np.zeros((len(settings), 64), np.uint8)
        self._queues = np.zeros((len(settings), QUEUE_SIZE), np.int64)
        self._table = FrameTable()
        self._disturbances = np.zeros((0, kernel.DISTURBANCE_COLUMNS), np.int64)
        self._driven, self._driven_start = np.zeros(0, np.uint8), 0
        self._counters = np.zeros(4, np.int64)
        self._events = np.zeros((_EVENT_ROWS, kernel.EVENT_COLUMNS), np.int64)
        self._received = np.zeros((_RECEIVED_ROWS, kernel.RECEIVED_COLUMNS), np.int64)
        self._payloads = np.zeros((_RECEIVED_ROWS, 64), np.uint8)
        self._wiring = np.zeros((0, len(settings)), np.uint8)
        self._keep = trace
        self._levels: list[NDArray[np.uint8]] = []
        self._traces: list[NDArray[np.int16]] = []

    @staticmethod
    def _set_up(row: NDArray[np.int64], node: Node) -> None:
        row[ns.FD_MODE] = ns.FD_MODES.index(node.fd)
        row[ns.ISO], row[ns.SILENT], row[ns.RECOVERS] = node.iso, node.silent, node.recovers
        row[ns.SINGLE_SHOT] = node.single_shot
        row[ns.SAMPLE_POINT] = round(node.sample_point * kernel.WHOLE_BIT)
        row[ns.TRANSMIT_ERRORS], row[ns.RECEIVE_ERRORS] = node.transmit_errors, node.receive_errors
        row[ns.PHASE] = ns.INTEGRATING if node.integrating else ns.IDLE
        if node.transmit_errors >= BUS_OFF_LIMIT:
            row[ns.PHASE] = ns.BUS_OFF

    def index(self, node: str) -> int:
        """Number of a node; ValueError with the names that exist."""
        if node not in self.names:
            raise ValueError(f"node: found {node!r}, allowed: {', '.join(self.names)}")
        return self.names.index(node)

    def send(self, node: str, frame: Frame) -> None:
        """Queue a frame; it begins when the bus is free and is repeated until somebody acknowledges it."""
        state = self._states[self.index(node)]
        if frame.fd and state[ns.FD_MODE] != ns.FD_ENABLED:
            raise ValueError(f"frame: found CAN FD, node {node} sends classic CAN only")
        if frame.fd and bool(state[ns.ISO]) != frame.iso:
            raise ValueError(f"frame: found iso = {frame.iso}, node {node} has iso = {bool(state[ns.ISO])}")
        if state[ns.QUEUE_TAIL] - state[ns.QUEUE_HEAD] >= QUEUE_SIZE:
            raise ValueError(f"node {node}: {QUEUE_SIZE} frames wait already")
        self._queues[self.index(node), state[ns.QUEUE_TAIL] % QUEUE_SIZE] = self._table.add(frame)
        state[ns.QUEUE_TAIL] += 1

    def disturb(self, disturbance: Disturbance) -> int:
        """Arm a disturbance; returns its number for :meth:`hits`."""
        row = disturbance.row(self.index)
        if disturbance.trigger_bit is not None:
            row[kernel.D_START] = disturbance.trigger_bit
        elif disturbance.from_time_s:
            row[kernel.D_START] = self.bit + round(disturbance.from_time_s * _NS_PER_S / self._bit_times_ns[0])
        self._disturbances = np.vstack([self._disturbances, row])
        return self._disturbances.shape[0] - 1

    def hits(self, number: int) -> int:
        """How often a disturbance began."""
        return int(self._disturbances[number, kernel.D_HITS])

    def drive(self, levels: Iterable[int], start: int | None = None) -> None:
        """Put levels on the bus from a bit on (default: now), like a tester that follows no protocol."""
        self._driven = np.array(list(levels), np.uint8)
        self._driven_start = self.bit if start is None else start

    def connect(self, wiring: NDArray[np.uint8] | None) -> None:
        """Change the wires between the nodes, while the bus runs or before.

        Parameters
        ----------
        wiring : uint8 array (2 ** nodes, nodes), optional
            Level that each node sees, by the set of nodes that drive dominant (bit i of the row: node i); see
            `wire_faults`. None is a sound bus: dominant if anybody drives dominant.

        Raises
        ------
        ValueError
            If the shape does not fit the nodes.
        """
        count = len(self.names)
        if wiring is not None and wiring.shape != (2**count, count):
            raise ValueError(f"wiring: found shape {wiring.shape}, allowed: {(2**count, count)}")
        self._wiring = np.zeros((0, count), np.uint8) if wiring is None else np.ascontiguousarray(wiring, np.uint8)

    def reset(self, node: str) -> None:
        """Restart a node: counters zero, integrating, waiting frames dropped."""
        state = self._states[self.index(node)]
        state[ns.TRANSMIT_ERRORS], state[ns.RECEIVE_ERRORS], state[ns.TRANSMITTER] = 0, 0, 0
        state[ns.PHASE], state[ns.COUNT] = ns.INTEGRATING, 0
        state[ns.QUEUE_HEAD] = state[ns.QUEUE_TAIL]

    def withdraw(self, number: int) -> None:
        """End a disturbance that :meth:`disturb` armed, now and for good."""
        self._disturbances[number, kernel.D_REPEAT] = self._disturbances[number, kernel.D_REMAINING] = 0

    def configure(
        self, node: str, *, silent: bool | None = None, recovers: bool | None = None, single_shot: bool | None = None
    ) -> None:
        """Change settings of a node while the bus runs; what is None stays."""
        state = self._states[self.index(node)]
        for column, value in ((ns.SILENT, silent), (ns.RECOVERS, recovers), (ns.SINGLE_SHOT, single_shot)):
            if value is not None:
                state[column] = value

    def set_transmit_errors(self, node: str, count: int) -> None:
        """Set a node's transmit error counter; at 256 and above it is bus-off."""
        state = self._states[self.index(node)]
        state[ns.TRANSMIT_ERRORS] = count
        if count >= BUS_OFF_LIMIT and state[ns.PHASE] != ns.BUS_OFF:
            state[ns.PHASE], state[ns.COUNT], state[ns.IDLE_SEQUENCES] = ns.BUS_OFF, 0, 0

    def drop_waiting(self, node: str) -> None:
        """What a bus-off node wanted to send is lost."""
        state = self._states[self.index(node)]
        if state[ns.PHASE] == ns.BUS_OFF:
            state[ns.QUEUE_HEAD] = state[ns.QUEUE_TAIL]

    @property
    def idle(self) -> bool:
        """True if every node is idle and nothing waits."""
        return self._idle()

    def forget(self) -> None:
        """Drop what has piled up: events, received frames, disturbances, and the table of frames if nothing waits."""
        self.events.clear()
        self.received.clear()
        self._disturbances = self._disturbances[:0]
        if (self._states[:, ns.QUEUE_TAIL] == self._states[:, ns.QUEUE_HEAD]).all():
            self._table = FrameTable()
            self._states[:, ns.ROW] = 0

    @property
    def bit(self) -> int:
        """Bits run so far."""
        return int(self._counters[kernel.C_BITS])

    @property
    def time_s(self) -> float:
        """Time that those bits took."""
        return float(self._counters[kernel.C_TIME_NS]) / _NS_PER_S

    @property
    def trace(self) -> Trace:
        """Every bit so far; empty if the bus was made with ``trace=False``."""
        count = len(self.names)
        levels = np.concatenate([np.zeros((0, 2 + 2 * count), np.uint8), *self._levels])
        trace = np.concatenate([np.zeros((0, 3 * count), np.int16), *self._traces])
        return Trace(levels, trace, self._bit_times_ns)

    def run(self, bits: int = 100_000, *, until_idle: bool = False) -> int:
        """Run a number of bits, or until all nodes are idle with nothing to send; returns the bits run."""
        done = 0
        while done < bits:
            count = self._run(bits - done, until_idle)
            done += count
            if until_idle and self._idle():
                break
        return done

    def _idle(self) -> bool:
        waiting = self._states[:, ns.QUEUE_TAIL] != self._states[:, ns.QUEUE_HEAD]
        driving = self.bit < self._driven_start + self._driven.size
        return not (driving or waiting.any() or (self._states[:, ns.PHASE] != ns.IDLE).any())

    def _run(self, bits: int, until_idle: bool) -> int:
        kept = bits if self._keep else 0
        levels = np.zeros((kept, 2 + 2 * len(self.names)), np.uint8)
        trace = np.zeros((kept, 3 * len(self.names)), np.int16)
        count: int = kernel.run_bits(
            bits,
            self._states,
            self._data,
            self._queues,
            self._table.passive_rows,
            self._table.bits,
            self._table.codes,
            self._table.numbers,
            self._table.extended,
            self._table.identifiers,
            self._disturbances,
            self._wiring,
            self._driven,
            self._driven_start,
            self._bit_times_ns,
            until_idle,
            self._events,
            self._received,
            self._payloads,
            self._counters,
            levels,
            trace,
        )
        if self._keep:
            self._levels.append(levels[:count].copy())
            self._traces.append(trace[:count].copy())
        self._drain()
        return count

    def _drain(self) -> None:
        """Take over what the compiled loop logged."""
        for row in self._events[: self._counters[kernel.C_EVENTS]].tolist():
            self.events.append(self._event(row))
        for i in range(int(self._counters[kernel.C_RECEIVED])):
            self.received.append(self._received_frame(self._received[i].tolist(), self._payloads[i]))
        self._counters[kernel.C_EVENTS] = self._counters[kernel.C_RECEIVED] = 0

    def _event(self, row: list[int]) -> Event:
        error = row[kernel.E_ERROR]
        return Event(
            row[kernel.E_BIT],
            self.names[row[kernel.E_NODE]],
            ns.EVENT_NAMES[row[kernel.E_EVENT]],
            ns.ERROR_KINDS[error] if error else "",
            row[kernel.E_TRANSMIT_ERRORS],
            row[kernel.E_RECEIVE_ERRORS],
            row[kernel.E_LEVEL],
            bool(row[kernel.E_TRANSMITTER]),
            f"{ns.PLACE_NAMES[row[kernel.E_PLACE]]}.{row[kernel.E_NUMBER]}",
            f"{ns.PLACE_NAMES[row[kernel.E_FIELD]]}.{row[kernel.E_INDEX]}",
            bool(row[kernel.E_EXTENDED]),
        )

    def _received_frame(self, row: list[int], payload: NDArray[np.uint8]) -> Received:
        bit, node, identifier, extended, remote, fd, rate, error_state, code, length, iso = row
        frame = Frame(
            identifier,
            payload[:length].tobytes(),
            extended=bool(extended),
            remote=bool(remote),
            fd=bool(fd),
            bit_rate_switch=bool(rate),
            error_state_indicator=bool(error_state),
            dlc=code if remote or (not fd and code > 8) else None,
            iso=bool(iso) if fd else True,
        )
        return Received(bit, self.names[node], frame)
