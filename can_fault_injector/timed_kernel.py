"""Compiled loop of the bus in time: each node has a clock, time quanta, a sample point and delays (rules BT01, BT02).

Time is counted in femtoseconds. A node looks at its receive line at the beginning of each of its time quanta; it drives
at the beginning of its bits and samples between its two phase segments. ISO 11898-1:2015, clause 11.3.
"""

import numpy as np
from numba import njit
from numpy.typing import NDArray

from can_fault_injector import bus_kernel as kernel
from can_fault_injector import fields as f
from can_fault_injector import node_state as ns
from can_fault_injector.node import Rows, Table, drive
from can_fault_injector.receiver import Payload, State

(
    T_NEXT,
    T_QUANTUM,
    T_SEGMENT_1,
    T_SEGMENT_2,
    T_JUMP,
    T_DATA_QUANTUM,
    T_DATA_SEGMENT_1,
    T_DATA_SEGMENT_2,
    T_DATA_JUMP,
    T_DELAY,
    T_FAST,
    T_AT,
    T_LENGTH_1,
    T_LENGTH_2,
    T_SYNCHRONISED,
    T_SAMPLED,
    T_SEEN,
    T_LEVEL,
) = range(18)
TIMING_COLUMNS = 18
"""One row for each node. Segment 1 is propagation and first phase segment; segments and jump width are in quanta,
quanta and the delay (each way between controller and bus) in fs. From ``T_FAST`` on the state: data rate, quantum of
the present bit, lengths of its segments, whether it was synchronised since the last sample, the last sample, the level
seen in the last quantum, the level driven."""

HISTORY = 32
"""Level changes of a node that are kept: delays are shorter than that many bits."""
WINDOWS = 4
"""Begin and end of the present and of the last time in which a disturbance works, fs."""
SAMPLE_COLUMNS = 5
"""Instant in fs, node, level, transmit and receive error counter after it."""


@njit(cache=True)
def _level_at(times: Rows, levels: Table, changes: int, at: int) -> int:
    """Level that a node drove at an instant: that of its latest change before it, recessive before the first."""
    kept = times.size
    for back in range(1, min(changes, kept) + 1):
        i = (changes - back) % kept
        if times[i] <= at:
            return int(levels[i])
    return 1


@njit(cache=True)
def _disturbed(disturbances: Rows, windows: Rows, tap: int, node: int, level: int, at: int) -> int:
    for i in range(disturbances.shape[0]):
        d, w = disturbances[i], windows[i]
        if d[kernel.D_TAP] != tap or (d[kernel.D_NODE] >= 0 and d[kernel.D_NODE] != node):
            continue
        if w[0] <= at < w[1] or w[2] <= at < w[3]:
            action = d[kernel.D_ACTION]
            level = 1 - level if action == kernel.FLIP else (0 if action == kernel.DOMINANT else 1)
    return level


@njit(cache=True)
def _seen(
    node: int,
    at: int,
    timing: Rows,
    times: Rows,
    levels: Table,
    changes: Rows,
    driven: Table,
    driven_start: int,
    driven_unit: int,
    disturbances: Rows,
    windows: Rows,
    wiring: Table,
) -> int:
    """Level at the receive line of a node: what was on the bus one delay before, and sent one more delay before."""
    on_bus = at - timing[node, T_DELAY]
    level, dominant = 1, 0
    if on_bus >= driven_start and on_bus < driven_start + driven.size * driven_unit:
        level = int(driven[(on_bus - driven_start) // driven_unit])
    for i in range(timing.shape[0]):
        sent = on_bus - timing[i, T_DELAY]
        own = _level_at(times[i], levels[i], changes[i], sent)
        dominant |= (1 - _disturbed(disturbances, windows, kernel.TAP_TRANSMIT, i, own, sent)) << i
    if wiring.shape[0]:
        level &= wiring[dominant, node]
    elif dominant:
        level = 0
    level = _disturbed(disturbances, windows, kernel.TAP_BUS, -1, level, on_bus)
    return int(_disturbed(disturbances, windows, kernel.TAP_RECEIVE, node, level, at))


@njit(cache=True)
def _begins_bit(t: State) -> None:
    t[T_AT] = 0
    t[T_LENGTH_1] = t[T_DATA_SEGMENT_1] if t[T_FAST] else t[T_SEGMENT_1]
    t[T_LENGTH_2] = t[T_DATA_SEGMENT_2] if t[T_FAST] else t[T_SEGMENT_2]


@njit(cache=True)
def _hard_synchronises(s: State) -> bool:
    """Whether an edge restarts the bit: between frames, and for receivers from FDF to res of CAN FD."""
    phase = s[ns.PHASE]
    if phase == ns.FRAME:
        return bool(s[ns.FIELD] == f.RES and not s[ns.TRANSMITTER])
    if phase == ns.INTERMISSION:
        return bool(s[ns.COUNT] > 0)
    return bool(phase == ns.IDLE or phase == ns.SUSPEND or phase == ns.INTEGRATING or phase == ns.BUS_OFF)


@njit(cache=True)
def _synchronise(t: State, s: State) -> None:
    """An edge from recessive to dominant was seen in the present quantum."""
    if t[T_SYNCHRONISED] or t[T_SAMPLED] == 0:
        return
    at, first, second = t[T_AT], t[T_LENGTH_1], t[T_LENGTH_2]
    t[T_SYNCHRONISED] = 1
    if at == 0:
        return
    if _hard_synchronises(s):
        _begins_bit(t)
        return
    jump = t[T_DATA_JUMP] if t[T_FAST] else t[T_JUMP]
    if at <= first + 1:
        # what a node sees late of its own dominant bit is its own delay
        if t[T_LEVEL] == 0:
            t[T_SYNCHRONISED] = 0
        else:
            t[T_LENGTH_1] = first + min(at, jump)
        return
    early = 1 + first + second - at
    if early <= jump:
        _begins_bit(t)
    else:
        t[T_LENGTH_2] = second - jump


@njit(cache=True)
def _open_windows(
    node: int,
    now: int,
    bit_time: int,
    s: State,
    t: State,
    codes: Table,
    numbers: NDArray[np.int16],
    row_identifiers: Rows,
    disturbances: Rows,
    windows: Rows,
) -> None:
    """Begin the disturbances whose place is the bit that a node begins now."""
    for i in range(disturbances.shape[0]):
        d = disturbances[i]
        if d[kernel.D_TRIGGER] != kernel.AT_PLACE or d[kernel.D_REPEAT] == 0 or now < d[kernel.D_START] * bit_time:
            continue
        if not kernel.matches(d, s, node, codes, numbers, row_identifiers):
            continue
        if d[kernel.D_SKIP]:
            d[kernel.D_SKIP] -= 1
            continue
        quanta = 1 + t[T_LENGTH_1] + t[T_LENGTH_2]
        bit = quanta * (t[T_DATA_QUANTUM] if t[T_FAST] else t[T_QUANTUM])
        windows[i, 2], windows[i, 3] = windows[i, 0], windows[i, 1]
        begin, end = d[kernel.D_BEGIN], d[kernel.D_END] if d[kernel.D_END] else kernel.WHOLE_BIT
        windows[i, 0] = now + bit * begin // kernel.WHOLE_BIT
        windows[i, 1] = now + bit * (d[kernel.D_LENGTH] - 1) + bit * end // kernel.WHOLE_BIT
        d[kernel.D_HITS] += 1
        if d[kernel.D_REPEAT] > 0:
            d[kernel.D_REPEAT] -= 1


@njit(cache=True)
def _switch_rate(t: State, s: State) -> None:
    """After a sample: the data rate holds from BRS to the CRC delimiter, and ends with an error (FD06)."""
    fast = s[ns.PHASE] == ns.FRAME and s[ns.FD] and s[ns.BIT_RATE_SWITCH] and s[ns.FIELD] <= f.CRC_DELIMITER
    if fast != t[T_FAST]:
        t[T_FAST] = fast
        t[T_LENGTH_2] = t[T_DATA_SEGMENT_2] if fast else t[T_SEGMENT_2]


@njit(cache=True)
def run_quanta(
    until: int,
    bit_time: int,
    states: Rows,
    timing: Rows,
    times: Rows,
    levels: Table,
    changes: Rows,
    data: Payload,
    queues: Rows,
    passive_row: Rows,
    bits: Table,
    codes: Table,
    numbers: NDArray[np.int16],
    extended: Rows,
    row_identifiers: Rows,
    disturbances: Rows,
    windows: Rows,
    wiring: Table,
    driven: Table,
    driven_start: int,
    driven_unit: int,
    events: Rows,
    received: Rows,
    payloads: Payload,
    counters: Rows,
    samples: Rows,
) -> int:
    """Run to an instant (fs), or until a log is full; returns the number of samples logged.

    Parameters
    ----------
    timing : int64 array (nodes, TIMING_COLUMNS)
    times, levels, changes : arrays (nodes, HISTORY), (nodes, HISTORY), (nodes)
        Level changes of each node and how many there were.
    windows : int64 array (disturbances, WINDOWS)
    wiring : uint8 array (2 ** nodes, nodes)
        As in `bus_kernel`.
    driven, driven_start, driven_unit
        Levels of a tester, each for ``driven_unit`` fs.
    counters
        As in `bus_kernel`; the number of bits is the time over the nominal bit time.
    samples : int64 array (n, SAMPLE_COLUMNS)
    """
    logged = 0
    while True:
        j = int(np.argmin(timing[:, T_NEXT]))
        t, s = timing[j], states[j]
        now = t[T_NEXT]
        if now >= until or logged >= samples.shape[0]:
            return logged
        if counters[kernel.C_EVENTS] + 4 >= events.shape[0] or counters[kernel.C_RECEIVED] + 1 >= received.shape[0]:
            return logged
        counters[kernel.C_BITS] = now // bit_time
        level = _seen(
            j, now, timing, times, levels, changes, driven, driven_start, driven_unit, disturbances, windows, wiring
        )
        if t[T_SEEN] == 1 and level == 0:
            _synchronise(t, s)
        t[T_SEEN] = level
        if t[T_AT] == 0:
            own = drive(s, queues[j], passive_row, bits)
            _open_windows(j, now, bit_time, s, t, codes, numbers, row_identifiers, disturbances, windows)
            if own != t[T_LEVEL]:
                t[T_LEVEL] = own
                at = changes[j] % times.shape[1]
                times[j, at], levels[j, at] = now, own
                changes[j] += 1
        if t[T_AT] == 1 + t[T_LENGTH_1]:
            kernel.sample_node(
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
            t[T_SAMPLED], t[T_SYNCHRONISED] = level, 0
            _switch_rate(t, s)
            samples[logged, 0], samples[logged, 1], samples[logged, 2] = now, j, level
            samples[logged, 3], samples[logged, 4] = s[ns.TRANSMIT_ERRORS], s[ns.RECEIVE_ERRORS]
            logged += 1
        t[T_AT] += 1
        if t[T_AT] >= 1 + t[T_LENGTH_1] + t[T_LENGTH_2]:
            _begins_bit(t)
        t[T_NEXT] = now + (t[T_DATA_QUANTUM] if t[T_FAST] else t[T_QUANTUM])
