"""Messages and signals as three plain arrays, which the compiled codec walks through.

Few arrays because each one costs a compiled call some 60 ns; integers of a signal stand in a float64 table for the same
reason (all are far below 2**53).
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from bench.codec.database import bit_positions
from bench.codec.layout import Carried, Carrier
from bench.codec.mapping_file import BUS_NAMES
from bench.links.frame import BIT_RATE_SWITCH, EXTENDED, FD

# columns of `messages`: what the database says ...
IDENTIFIER, FLAGS, LENGTH, PERIOD, OFFSET, PROTECTED, FIRST, END = range(8)
# ... the state of a sender, or of a receiver ...
COUNTER, NEXT_DUE = 8, 9
LAST_COUNTER, LAST_TICK = 8, 9
# ... and a receiver's counts
ACCEPTED, CRC_ERRORS, REPEATED, LOST, WRONG_SEQUENCE, WRONG_LENGTH = range(10, 16)
# when a receiver expects the frame it took last, in thousandths of a tick, and by how many ticks that one came later
EXPECTED, LATENESS = 16, 17
MESSAGE_COLUMNS = 18
# values of PROTECTED
UNPROTECTED, BY_CRC, BY_CRC_AND_COUNTER = range(3)
STATISTICS = ("accepted", "crc_errors", "repeated", "lost", "wrong_sequence", "wrong_length")

# columns of `signals`; the position is that in the array of values
START, BITS, BIG_ENDIAN, SIGNED, WRAPS, RAW_LOW, RAW_HIGH, RAW_START, POSITION = range(9)
SCALE, SHIFT, OUTER_SCALE, OUTER_SHIFT = range(9, 13)
SIGNAL_COLUMNS = 13

# columns of `payloads`: template, then data ids
DATA_IDS = 64
PAYLOAD_COLUMNS = 80


@dataclass(frozen=True)
class Tables:
    """Arrays of the compiled codec, one row per message or signal.

    Attributes
    ----------
    messages : int64 array, shape (m, 18)
        Sorted by (extended, identifier).
    signals : float64 array, shape (s, 13)
        ours = (raw × SCALE + SHIFT) × OUTER_SCALE + OUTER_SHIFT; those of a message are rows FIRST … END − 1.
    payloads : uint8 array, shape (m, 80)
        Start values of the bits that are not ours, then the 16 data ids of Profile 2.
    """

    messages: NDArray[np.int64]
    signals: NDArray[np.float64]
    payloads: NDArray[np.uint8]


def by_identifier(carriers: Sequence[Carrier]) -> list[Carrier]:
    """Messages in the order of the tables' rows."""
    return sorted(carriers, key=lambda carrier: (carrier.message.extended, carrier.message.identifier))


def build_tables(carriers: Sequence[Carrier], names: Sequence[str] = BUS_NAMES) -> Tables:
    """Tables of some messages, for arrays of values in the order of ``names``."""
    position = {name: number for number, name in enumerate(names)}
    ordered = by_identifier(carriers)
    tables = Tables(
        np.zeros((len(ordered), MESSAGE_COLUMNS), np.int64),
        np.zeros((sum(len(carrier.carried) for carrier in ordered), SIGNAL_COLUMNS)),
        np.zeros((len(ordered), PAYLOAD_COLUMNS), np.uint8),
    )
    row = 0
    for number, carrier in enumerate(ordered):
        tables.messages[number, : END + 1] = _message_row(carrier, row)
        tables.payloads[number] = _payload_row(carrier)
        for carried in carrier.carried:
            tables.signals[row] = _signal_row(carried, position[carried.name])
            row += 1
    return tables


def _message_row(carrier: Carrier, first: int) -> tuple[int, ...]:
    message = carrier.message
    flags = EXTENDED * message.extended | FD * message.fd | BIT_RATE_SWITCH * message.bit_rate_switch
    schedule = (carrier.cycle_ms, carrier.offset_ms)
    return (
        message.identifier,
        flags,
        message.length,
        *schedule,
        BY_CRC_AND_COUNTER if carrier.data_ids else UNPROTECTED,
        first,
        first + len(carrier.carried),
    )


def _signal_row(carried: Carried, position: int) -> tuple[float, ...]:
    signal = carried.signal
    place = (signal.start, signal.length, signal.big_endian, signal.signed, signal.wraps)
    limits = (signal.raw_low, signal.raw_high, signal.raw_start)
    return (*place, *limits, position, signal.scale, signal.offset, carried.scale, carried.offset)


def _payload_row(carrier: Carrier) -> NDArray[np.uint8]:
    row = np.zeros(PAYLOAD_COLUMNS, np.uint8)
    row[: carrier.message.length] = np.frombuffer(carrier.message.start_payload, np.uint8)
    for carried in carrier.carried:
        for bit in bit_positions(carried.signal.start, carried.signal.length, carried.signal.big_endian):
            row[bit >> 3] &= 255 - (1 << (bit & 7))
    if carrier.data_ids:
        row[0] = 0
        row[1] &= 0xF0
        row[DATA_IDS:] = carrier.data_ids
    return row
