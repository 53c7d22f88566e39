"""Exhaustive sweeps: every bit of a frame disturbed in every way, as reading alone or with whole protocol nodes."""

from dataclasses import dataclass

import numpy as np
from numba import njit
from numpy.typing import NDArray

from can_fault_injector import bus_kernel as kernel
from can_fault_injector import decoding
from can_fault_injector import fields as f
from can_fault_injector import node_state as ns
from can_fault_injector.bits import Bits
from can_fault_injector.bus import QUEUE_SIZE
from can_fault_injector.decoding import decode
from can_fault_injector.frame import Frame
from can_fault_injector.frame_table import FrameTable

ACTIONS = 3
NODES = 4
"""One sender and three receivers."""
_FRAME_GAP = 3
_LONGEST_FRAME_TIMES = 6
_LOGGED = 64

REJECTED, SAME, ESCAPED = range(3)

Counts = NDArray[np.int64]


@njit(cache=True)
def _judge(bits: Bits, iso: bool, sent: Bits, sent_result: Counts, data: Bits, result: Counts) -> int:
    """What a receiver of the bus makes of disturbed bits: rejected, read as sent, or accepted with other content."""
    if decode(bits, iso, data, result) != f.NO_ERROR:
        return REJECTED
    # a frame that ends elsewhere than the sender's is acknowledged at a wrong place: the sender's error flag ends it
    if result[decoding.RESULT_BITS] != sent_result[decoding.RESULT_BITS]:
        return REJECTED
    for column in range(decoding.RESULT_IDENTIFIER, decoding.RESULT_LENGTH + 1):
        if result[column] != sent_result[column]:
            return ESCAPED
    for i in range(result[decoding.RESULT_LENGTH]):
        if data[i] != sent[i]:
            return ESCAPED
    return SAME


@njit(cache=True)
def _single_bits(bits: Bits, iso: bool, outcomes: NDArray[np.uint8]) -> None:
    sent, data = np.zeros(64, np.uint8), np.zeros(64, np.uint8)
    sent_result, result = np.zeros(decoding.RESULT_SIZE, np.int64), np.zeros(decoding.RESULT_SIZE, np.int64)
    decode(bits, iso, sent, sent_result)
    for i in range(bits.size):
        level = bits[i]
        for action in range(ACTIONS):
            bits[i] = 1 - level if action == kernel.FLIP else (0 if action == kernel.DOMINANT else 1)
            outcomes[i, action] = _judge(bits, iso, sent, sent_result, data, result)
        bits[i] = level


@njit(cache=True)
def _flip_pairs(bits: Bits, iso: bool, escapes: Counts) -> tuple[int, int]:
    """All pairs of flips; the positions of escapes go to ``escapes`` as far as it is long. Pairs and escapes."""
    sent, data = np.zeros(64, np.uint8), np.zeros(64, np.uint8)
    sent_result, result = np.zeros(decoding.RESULT_SIZE, np.int64), np.zeros(decoding.RESULT_SIZE, np.int64)
    decode(bits, iso, sent, sent_result)
    pairs, found = 0, 0
    for i in range(bits.size):
        bits[i] ^= 1
        for j in range(i + 1, bits.size):
            bits[j] ^= 1
            pairs += 1
            if _judge(bits, iso, sent, sent_result, data, result) == ESCAPED:
                if found < escapes.shape[0]:
                    escapes[found, 0], escapes[found, 1] = i, j
                found += 1
            bits[j] ^= 1
        bits[i] ^= 1
    return pairs, found


def _on_the_bus(frame: Frame) -> Bits:
    """Levels of an acknowledged frame; a recessive slot would let a reading that is one bit short look complete."""
    bits, codes, _ = frame.encoded()
    bits[codes == f.ACK_SLOT] = 0
    return bits


def single_bit_outcomes(frame: Frame) -> NDArray[np.uint8]:
    """What a receiver makes of the frame with each bit flipped, forced dominant, forced recessive.

    Returns
    -------
    uint8 array (bits, 3)
        REJECTED, SAME or ESCAPED (accepted with other content).
    """
    bits = _on_the_bus(frame)
    outcomes = np.zeros((bits.size, ACTIONS), np.uint8)
    _single_bits(bits, frame.iso, outcomes)
    return outcomes


def flip_pair_escapes(frame: Frame) -> tuple[int, list[tuple[int, int]]]:
    """Number of pairs of flipped bits of a frame, and the pairs that a receiver accepts with other content."""
    escapes = np.zeros((256, 2), np.int64)
    pairs, found = _flip_pairs(_on_the_bus(frame), frame.iso, escapes)
    return int(pairs), [(int(i), int(j)) for i, j in escapes[:found]]


@njit(cache=True)
def _sweep_nodes(
    positions: int,
    start: Counts,
    passive_row: Counts,
    bits: Bits,
    codes: Bits,
    numbers: NDArray[np.int16],
    extended: Counts,
    identifiers: Counts,
    limit: int,
    outcomes: Counts,
) -> None:
    nodes = start.shape[0]
    disturbances = np.zeros((1, kernel.DISTURBANCE_COLUMNS), np.int64)
    d = disturbances[0]
    states = np.empty_like(start)
    data, payloads = np.zeros((nodes, 64), np.uint8), np.zeros((_LOGGED, 64), np.uint8)
    queues = np.zeros((nodes, QUEUE_SIZE), np.int64)
    events = np.zeros((_LOGGED, kernel.EVENT_COLUMNS), np.int64)
    received = np.zeros((_LOGGED, kernel.RECEIVED_COLUMNS), np.int64)
    wiring = np.zeros((0, nodes), np.uint8)
    levels, trace, driven = np.zeros((0, 1), np.uint8), np.zeros((0, 1), np.int16), np.zeros(0, np.uint8)
    bit_times, counters = np.ones(2, np.int64), np.zeros(4, np.int64)
    # up to the disturbed bit all cases of a position are one: run once, bit by bit, and gone on from there
    before, before_data = np.empty((positions, *start.shape), np.int64), np.zeros((positions, nodes, 64), np.uint8)
    before_counters, undisturbed = np.zeros((positions, 4), np.int64), np.zeros_like(received)
    states[:] = start
    for position in range(positions):
        before[position], before_data[position], before_counters[position] = states, data, counters
        kernel.run_bits(
            1, states, data, queues, passive_row, bits, codes, numbers, extended, identifiers, disturbances, wiring,
            driven, 0, bit_times, False, events, undisturbed, payloads, counters, levels, trace,
        )  # fmt: skip
    for position in range(positions):
        for action in range(ACTIONS):
            for receiver in range(1, nodes):
                states[:], data[:], counters[:] = before[position], before_data[position], before_counters[position]
                received[:] = undisturbed
                d[:] = 0
                d[kernel.D_TAP], d[kernel.D_NODE], d[kernel.D_ACTION] = kernel.TAP_RECEIVE, receiver, action
                d[kernel.D_TRIGGER], d[kernel.D_START] = kernel.AT_BIT, position
                d[kernel.D_REPEAT], d[kernel.D_LENGTH] = 1, 1
                row = outcomes[position, action, receiver - 1]
                row[nodes] = position + kernel.run_bits(
                    limit - position, states, data, queues, passive_row, bits, codes, numbers, extended, identifiers,
                    disturbances, wiring, driven, 0, bit_times, True, events, received, payloads, counters, levels,
                    trace,
                )  # fmt: skip
                for i in range(counters[kernel.C_RECEIVED]):
                    row[received[i, 1]] += 1
                row[0] = states[0, ns.TRANSMIT_ERRORS]


@dataclass(frozen=True)
class NodeSweep:
    """Result of :func:`sweep_receivers`, each array (bits, 3 actions, 3 receivers).

    Attributes
    ----------
    copies : int64 array (bits, 3, 3, 3)
        How often each of the three receivers (last axis) got the frame.
    transmit_errors : int64 array
        TEC of the sender at the end.
    bits_run : int64 array
        Bits until all nodes were idle again.
    """

    copies: Counts
    transmit_errors: Counts
    bits_run: Counts


def sweep_receivers(frame: Frame) -> NodeSweep:
    """Disturb each bit of a frame at one of three receivers, with error flags, counters and retransmission.

    One sender and three receivers run for every bit, action (flip, dominant, recessive) and disturbed receiver until
    the bus is idle again.
    """
    table = FrameTable()
    table.add(frame)  # the only one, row 0: what the queues hold
    start = np.zeros((NODES, ns.COLUMNS), np.int64)
    start[:, ns.ISO], start[:, ns.RECOVERS], start[:, ns.PHASE] = frame.iso, 1, ns.IDLE
    start[0, ns.QUEUE_TAIL] = 1
    positions = frame.bits().size + _FRAME_GAP
    outcomes = np.zeros((positions, ACTIONS, NODES - 1, NODES + 1), np.int64)
    _sweep_nodes(
        positions,
        start,
        table.passive_rows,
        table.bits,
        table.codes,
        table.numbers,
        table.extended,
        table.identifiers,
        _LONGEST_FRAME_TIMES * positions,
        outcomes,
    )
    return NodeSweep(outcomes[..., 1:NODES], outcomes[..., 0], outcomes[..., NODES])
