"""Compiled loop of the bus: one pass per bit over all nodes, with disturbances on the bus and on single taps.

The bus is the wired AND of what all nodes drive. Each node has a transmit tap (between its controller and the bus) and
a receive tap (between the bus and its controller), so a disturbance may reach one node only.
"""

import numpy as np
from numba import njit
from numpy.typing import NDArray

from can_fault_injector import fields as f
from can_fault_injector import node_state as ns
from can_fault_injector.node import Rows, Table, drive, is_passive, is_warned, sample
from can_fault_injector.receiver import Payload, State

TAP_BUS, TAP_TRANSMIT, TAP_RECEIVE = range(3)
FLIP, DOMINANT, RECESSIVE = range(3)
AT_BIT, AT_PLACE = range(2)

(
    D_TAP,
    D_NODE,
    D_ACTION,
    D_TRIGGER,
    D_START,
    D_PLACE,
    D_NUMBER,
    D_REFERENCE,
    D_IDENTIFIER,
    D_MASK,
    D_SKIP,
    D_REPEAT,
    D_LENGTH,
    D_BEGIN,
    D_END,
    D_REMAINING,
    D_HITS,
) = range(17)
DISTURBANCE_COLUMNS = 17
"""Columns of a disturbance. ``D_BEGIN`` and ``D_END`` bound a pulse shorter than a bit in thousandths of the bit, and
are 0 for whole bits. The last two are its state: bits that it still lasts, and how often it began."""
WHOLE_BIT = 1000

(
    E_BIT,
    E_NODE,
    E_EVENT,
    E_ERROR,
    E_TRANSMIT_ERRORS,
    E_RECEIVE_ERRORS,
    E_LEVEL,
    E_TRANSMITTER,
    E_EXTENDED,
    E_PLACE,
    E_NUMBER,
    E_FIELD,
    E_INDEX,
) = range(13)
EVENT_COLUMNS = 13
"""Columns of an event. From ``E_LEVEL`` on the bit itself: level seen, and as they were before it the node's role,
extended format so far, place as a disturbance names it, and the place of the next information bit: that differs from
the former at a stuff bit."""
RECEIVED_COLUMNS = 11
"""Bit, node, identifier, extended, remote, FD, BRS, ESI, length code, length, ISO."""

C_BITS, C_EVENTS, C_RECEIVED, C_TIME_NS = range(4)
"""Counters of the bus: bits so far, filled rows of events and received frames, time in nanoseconds."""


@njit(cache=True)
def place_of(s: State, codes: Table, numbers: NDArray[np.int16]) -> tuple[int, int]:
    """Field and number of the coming bit as the node counts it."""
    phase = s[ns.PHASE]
    if phase == ns.AFTER_FLAG or phase == ns.DELIMITER:
        return (ns.ERROR_DELIMITER if s[ns.IN_ERROR_FRAME] else ns.OVERLOAD_DELIMITER), s[ns.COUNT]
    if phase != ns.FRAME:
        return ns.PHASE_PLACE + phase, s[ns.COUNT]
    field, index = s[ns.FIELD], s[ns.INDEX]
    if s[ns.TRANSMITTER] and field < f.CRC_DELIMITER:
        return codes[s[ns.ROW], s[ns.POSITION]], numbers[s[ns.ROW], s[ns.POSITION]]
    if s[ns.FD] and (field == f.STUFF_COUNT or field == f.CRC):
        if s[ns.FIXED_STUFF_DUE]:
            before = 1 if field == f.CRC and s[ns.ISO] else 0
            return f.FIXED_STUFF, index // 4 + before
        return field, index
    if s[ns.RUN] == 5 and (field < f.CRC_DELIMITER or (field == f.CRC_DELIMITER and not s[ns.FD])):
        return f.STUFF, s[ns.STUFF_BITS]
    return field, index


@njit(cache=True)
def matches(d: Rows, s: State, reference: int, codes: Table, numbers: NDArray[np.int16], row_identifiers: Rows) -> bool:
    """Whether the place of a disturbance is the coming bit of this node."""
    if d[D_REFERENCE] >= 0 and d[D_REFERENCE] != reference:
        return False
    if d[D_REFERENCE] < 0 and not s[ns.TRANSMITTER]:
        return False
    if d[D_MASK]:
        identifier = row_identifiers[s[ns.ROW]] if s[ns.TRANSMITTER] else s[ns.IDENTIFIER]
        if (identifier ^ d[D_IDENTIFIER]) & d[D_MASK]:
            return False
    if d[D_PLACE] == ns.FRAME_POSITION:
        return bool(s[ns.PHASE] == ns.FRAME and s[ns.FRAME_BITS] == d[D_NUMBER])
    place, number = place_of(s, codes, numbers)
    return bool(place == d[D_PLACE] and number == d[D_NUMBER])


@njit(cache=True)
def _update_disturbances(
    disturbances: Rows, states: Rows, codes: Table, numbers: NDArray[np.int16], row_identifiers: Rows, bit: int
) -> None:
    """Begin the disturbances whose trigger is the coming bit."""
    for i in range(disturbances.shape[0]):
        d = disturbances[i]
        if d[D_REMAINING] or d[D_REPEAT] == 0:
            continue
        begins = d[D_TRIGGER] == AT_BIT and bit == d[D_START]
        if d[D_TRIGGER] == AT_PLACE and bit >= d[D_START]:
            for j in range(states.shape[0]):
                if matches(d, states[j], j, codes, numbers, row_identifiers):
                    begins = True
        if not begins:
            continue
        if d[D_SKIP]:
            d[D_SKIP] -= 1
            continue
        d[D_REMAINING] = d[D_LENGTH]
        d[D_HITS] += 1
        if d[D_REPEAT] > 0:
            d[D_REPEAT] -= 1


@njit(cache=True)
def _apply(disturbances: Rows, tap: int, node: int, level: int, instant: int) -> int:
    """Level of a line at an instant of the bit, thousandths."""
    for i in range(disturbances.shape[0]):
        d = disturbances[i]
        if d[D_REMAINING] and d[D_TAP] == tap and (d[D_NODE] < 0 or d[D_NODE] == node):
            if d[D_END] and not d[D_BEGIN] <= instant < d[D_END]:
                continue
            flipped = 1 - level
            level = flipped if d[D_ACTION] == FLIP else (0 if d[D_ACTION] == DOMINANT else 1)
    return level


@njit(cache=True)
def _pulses(disturbances: Rows) -> bool:
    """Whether a pulse shorter than a bit is on the bus now, so that nodes may see different levels."""
    for i in range(disturbances.shape[0]):
        if disturbances[i, D_REMAINING] and disturbances[i, D_END] and disturbances[i, D_TAP] != TAP_RECEIVE:
            return True
    return False


@njit(cache=True)
def _bus_level(disturbances: Rows, driven: Rows, tester: int, instant: int, wiring: Table, node: int) -> int:
    """Level of the bus at a node and an instant of the bit: wired AND, or what the wires let through."""
    bus, dominant = tester, 0
    for j in range(driven.size):
        level = _apply(disturbances, TAP_TRANSMIT, j, driven[j], instant)
        dominant |= (1 - level) << j
    if wiring.shape[0]:
        bus &= wiring[dominant, node]
    elif dominant:
        bus = 0
    return int(_apply(disturbances, TAP_BUS, -1, bus, instant))


@njit(cache=True)
def _at_data_rate(states: Rows) -> bool:
    """Whether a sender is in the fast part of a CAN FD frame: ESI to the last bit of the CRC (FD06)."""
    for j in range(states.shape[0]):
        s = states[j]
        if s[ns.PHASE] == ns.FRAME and s[ns.TRANSMITTER] and s[ns.BIT_RATE_SWITCH] and s[ns.FIELD] < f.CRC_DELIMITER:
            return True
    return False


@njit(cache=True)
def _log(events: Rows, counters: Rows, event: int, kind: int, s: State) -> None:
    """Complete the prepared row; the next one begins as its copy, for further events of the same bit."""
    at = counters[C_EVENTS]
    events[at, E_EVENT], events[at, E_ERROR] = event, kind
    events[at, E_TRANSMIT_ERRORS], events[at, E_RECEIVE_ERRORS] = s[ns.TRANSMIT_ERRORS], s[ns.RECEIVE_ERRORS]
    events[at + 1] = events[at]
    counters[C_EVENTS] += 1


@njit(cache=True)
def _store(received: Rows, payloads: Payload, counters: Rows, node: int, s: State, data: Payload) -> None:
    at = counters[C_RECEIVED]
    row = received[at]
    row[0], row[1], row[2], row[3] = counters[C_BITS], node, s[ns.IDENTIFIER], s[ns.EXTENDED]
    row[4], row[5], row[6], row[7] = s[ns.REMOTE], s[ns.FD], s[ns.BIT_RATE_SWITCH], s[ns.ERROR_STATE]
    row[8], row[9], row[10] = s[ns.LENGTH_CODE], s[ns.LENGTH], s[ns.ISO]
    payloads[at] = data
    counters[C_RECEIVED] += 1


@njit(cache=True)
def sample_node(
    node: int,
    level: int,
    states: Rows,
    data: Payload,
    queues: Rows,
    passive_row: Rows,
    bits: Table,
    codes: Table,
    numbers: NDArray[np.int16],
    extended: Rows,
    events: Rows,
    received: Rows,
    payloads: Payload,
    counters: Rows,
) -> None:
    """Sample one node and log what happened to it."""
    s = states[node]
    # the state may change by this bit only, so the old one is told from the new by what was true before
    passive, warned, off = is_passive(s), is_warned(s), s[ns.PHASE] == ns.BUS_OFF
    place, number = place_of(s, codes, numbers)
    transmitter, is_extended = s[ns.TRANSMITTER], s[ns.EXTENDED]
    field, index = (s[ns.FIELD], s[ns.INDEX]) if s[ns.PHASE] == ns.FRAME else (place, number)
    sample(s, data[node], queues[node], passive_row, bits, codes, extended, level)
    event = s[ns.EVENT]
    went_off = s[ns.PHASE] == ns.BUS_OFF
    if event == ns.NO_EVENT and went_off == off and is_warned(s) == warned and is_passive(s) == passive:
        return
    row = events[counters[C_EVENTS]]
    row[E_BIT], row[E_NODE], row[E_LEVEL] = counters[C_BITS], node, level
    row[E_TRANSMITTER], row[E_EXTENDED], row[E_PLACE], row[E_NUMBER] = transmitter, is_extended, place, number
    row[E_FIELD], row[E_INDEX] = field, index
    if event != ns.NO_EVENT:
        _log(events, counters, event, s[ns.ERROR_KIND] if event == ns.ERROR else 0, s)
    if event == ns.RECEIVED:
        _store(received, payloads, counters, node, s, data[node])
    if went_off or off:
        if not off:
            _log(events, counters, ns.WENT_BUS_OFF, 0, s)
        return
    if is_warned(s) != warned:
        _log(events, counters, ns.WARNING_OVER if warned else ns.WENT_WARNING, 0, s)
    if is_passive(s) != passive:
        _log(events, counters, ns.WENT_ACTIVE if passive else ns.WENT_PASSIVE, 0, s)


@njit(cache=True)
def run_bits(
    count: int,
    states: Rows,
    data: Payload,
    queues: Rows,
    passive_row: Rows,
    bits: Table,
    codes: Table,
    numbers: NDArray[np.int16],
    extended: Rows,
    row_identifiers: Rows,
    disturbances: Rows,
    wiring: Table,
    driven: Table,
    driven_start: int,
    bit_times_ns: Rows,
    until_idle: bool,
    events: Rows,
    received: Rows,
    payloads: Payload,
    counters: Rows,
    levels: Table,
    trace: NDArray[np.int16],
) -> int:
    """Run up to ``count`` bits; returns how many were run.

    Parameters
    ----------
    disturbances : int64 array (n, DISTURBANCE_COLUMNS)
    wiring : uint8 array (2 ** nodes, nodes)
        Level at each node by the set of nodes that drive dominant; no rows: a sound bus.
    driven, driven_start
        Levels that a tester puts on the bus from a bit on, without being a node.
    bit_times_ns : int64 array of 2
        Bit time of the arbitration and of the data phase.
    until_idle
        End when all nodes are idle and nothing waits.
    events, received, payloads
        Filled from the rows given in ``counters``; the run ends early when they are full.
    levels : uint8 array (count, 2 + 2 nodes), trace : int16 array (count, 3 nodes)
        Bus, transmit and receive level of each node, whether the bit has the rate of the data phase; each node's TEC,
        REC and phase after the bit. Empty: nothing is kept.
    """
    nodes = states.shape[0]
    sent = np.empty(nodes, np.int64)
    keep = levels.shape[0] > 0
    for step in range(count):
        if counters[C_EVENTS] + 3 * nodes >= events.shape[0] or counters[C_RECEIVED] + nodes > received.shape[0]:
            return step
        now = counters[C_BITS]
        for j in range(nodes):
            sent[j] = drive(states[j], queues[j], passive_row, bits)
        _update_disturbances(disturbances, states, codes, numbers, row_identifiers, now)
        tester = 1
        if now >= driven_start and now < driven_start + driven.size:
            tester = driven[now - driven_start]
        bus = _bus_level(disturbances, sent, tester, states[0, ns.SAMPLE_POINT], wiring, 0)
        differ = wiring.shape[0] > 0 or _pulses(disturbances)
        fast = 1 if _at_data_rate(states) else 0
        counters[C_TIME_NS] += bit_times_ns[fast]
        idle = True
        for j in range(nodes):
            instant = states[j, ns.SAMPLE_POINT]
            level = _bus_level(disturbances, sent, tester, instant, wiring, j) if differ else bus
            level = _apply(disturbances, TAP_RECEIVE, j, level, instant)
            sample_node(
                j,
                level,
                states,
                data,
                queues,
                passive_row,
                bits,
                codes,
                numbers,
                extended,
                events,
                received,
                payloads,
                counters,
            )
            s = states[j]
            idle = idle and s[ns.PHASE] == ns.IDLE and s[ns.QUEUE_HEAD] == s[ns.QUEUE_TAIL]
            if keep:
                levels[step, 1 + 2 * j] = _apply(disturbances, TAP_TRANSMIT, j, sent[j], instant)
                levels[step, 2 + 2 * j] = level
                trace[step, 3 * j], trace[step, 3 * j + 1] = s[ns.TRANSMIT_ERRORS], s[ns.RECEIVE_ERRORS]
                trace[step, 3 * j + 2] = s[ns.PHASE]
        if keep:
            levels[step, 0], levels[step, 1 + 2 * nodes] = bus, fast
        for i in range(disturbances.shape[0]):
            if disturbances[i, D_REMAINING]:
                disturbances[i, D_REMAINING] -= 1
        counters[C_BITS] += 1
        if until_idle and idle and now + 1 >= driven_start + driven.size:
            return step + 1
    return count
