"""Compiled packing and unpacking of frames and AUTOSAR E2E Profile 2.

Profile 2 (AUTOSAR_SWS_E2ELibrary): byte 0 is a CRC-8 with polynomial 0x2F, start and final exclusive-or 0xFF, over
bytes 1 … length−1 and then the data id that belongs to the counter; the low half of byte 1 is the counter, 0 … 15.
"""

from typing import Any

import numba
import numpy as np
from numba import njit
from numpy.typing import NDArray

from bench.codec.tables import (
    ACCEPTED,
    BIG_ENDIAN,
    BITS,
    BY_CRC_AND_COUNTER,
    COUNTER,
    CRC_ERRORS,
    DATA_IDS,
    END,
    EXPECTED,
    FIRST,
    FLAGS,
    IDENTIFIER,
    LAST_COUNTER,
    LAST_TICK,
    LATENESS,
    LENGTH,
    LOST,
    MESSAGE_COLUMNS,
    NEXT_DUE,
    OFFSET,
    OUTER_SCALE,
    OUTER_SHIFT,
    PAYLOAD_COLUMNS,
    PERIOD,
    POSITION,
    PROTECTED,
    RAW_HIGH,
    RAW_LOW,
    RAW_START,
    REPEATED,
    SCALE,
    SHIFT,
    SIGNAL_COLUMNS,
    SIGNED,
    START,
    WRAPS,
    WRONG_LENGTH,
    WRONG_SEQUENCE,
)
from bench.links.frame import ERROR, EXTENDED, FD, FRAME_DTYPE, REMOTE, TICK_NS, TRANSMITTED
from signals.record_memory import addresses_at, pointer

AT_MESSAGES, AT_SIGNALS, AT_PAYLOADS, AT_VALUES, AT_GROUPS, AT_AGES = range(6)
"""Places in the list of addresses of a transmitter or receiver: arrays of ``bench.codec.tables`` and of values ..."""
MESSAGES, SIGNALS, VALUES, GROUPS, AGES, CHANNEL, SENDER = range(6, 13)
"""... then, in the same list, plain numbers: rows of those arrays, the channel and who sends."""
PLACES = 13

_POLYNOMIAL = 0x2F


def _crc_table() -> NDArray[np.uint8]:
    table = np.zeros(256, np.uint8)
    for value in range(256):
        register = value
        for _ in range(8):
            register = ((register << 1) ^ _POLYNOMIAL) & 0xFF if register & 0x80 else register << 1
        table[value] = register
    return table


_CRC_TABLE = _crc_table()

NEVER_TICKS = 1_000_000_000
"""Age of what was never received, in ticks: 1 000 000 s."""

_RESYNCHRONISE_CYCLES = 15

_DRIFT = 0.001
"""Share by which the clocks of sender and receiver may differ without a frame counting as late."""
_FORGOTTEN = 0.0002
"""Share of the lateness that is forgotten with each frame."""
_LONGEST_HOLD_TICKS = 500
"""Longest silence after which frames that go on where they were count as held up."""


@njit(cache=True)
def profile2_crc(data: NDArray[np.uint8], length: int, data_id: int) -> int:
    """CRC of a payload of ``length`` bytes whose byte 0 is left out."""
    register = 0xFF
    for i in range(1, length):
        register = int(_CRC_TABLE[register ^ int(data[i])])
    return int(_CRC_TABLE[register ^ data_id]) ^ 0xFF


@njit(cache=True)
def insert_bits(data: NDArray[np.uint8], start: int, bits: int, big_endian: int, raw: int) -> None:
    """Write the low ``bits`` bits of ``raw`` into zeroed bits of a payload."""
    byte = start >> 3
    low = start & 7
    left = bits
    if big_endian:
        while left > 0:
            take = min(low + 1, left)
            chunk = (raw >> (left - take)) & ((1 << take) - 1)
            data[byte] |= np.uint8(chunk << (low + 1 - take))
            left -= take
            byte += 1
            low = 7
        return
    while left > 0:
        take = min(8 - low, left)
        data[byte] |= np.uint8((raw & ((1 << take) - 1)) << low)
        raw >>= take
        left -= take
        byte += 1
        low = 0


@njit(cache=True)
def extract_bits(data: NDArray[np.uint8], start: int, bits: int, big_endian: int, signed: int) -> int:
    """Raw value of a signal in a payload."""
    byte = start >> 3
    low = start & 7
    left = bits
    raw = 0
    if big_endian:
        while left > 0:
            take = min(low + 1, left)
            chunk = (int(data[byte]) >> (low + 1 - take)) & ((1 << take) - 1)
            raw = (raw << take) | chunk
            left -= take
            byte += 1
            low = 7
    else:
        done = 0
        while left > 0:
            take = min(8 - low, left)
            chunk = (int(data[byte]) >> low) & ((1 << take) - 1)
            raw |= chunk << done
            done += take
            left -= take
            byte += 1
            low = 0
    if signed and raw >> (bits - 1):
        raw -= 1 << bits
    return raw


@njit(cache=True)
def raw_value(value: float, signal: NDArray[np.float64]) -> int:
    """Raw value to send: rounded half to even, saturated or wrapped; the start value for what is no number."""
    inner = (value - signal[OUTER_SHIFT]) / signal[OUTER_SCALE]
    scaled = np.rint((inner - signal[SHIFT]) / signal[SCALE])
    if not np.isfinite(scaled):
        return int(signal[RAW_START])
    if signal[WRAPS] != 0.0:
        span = 2.0 ** signal[BITS]
        return int(scaled - np.floor(scaled / span) * span)
    return int(min(max(scaled, signal[RAW_LOW]), signal[RAW_HIGH]))


@njit(cache=True)
def pack(
    data: NDArray[np.uint8],
    message: NDArray[np.int64],
    signals: NDArray[np.float64],
    template: NDArray[np.uint8],
    values: NDArray[np.float64],
) -> None:
    """Fill a payload with the template and the message's signals; unprotected."""
    for i in range(message[LENGTH]):
        data[i] = template[i]
    for s in range(message[FIRST], message[END]):
        signal = signals[s]
        raw = raw_value(values[int(signal[POSITION])], signal)
        insert_bits(data, int(signal[START]), int(signal[BITS]), int(signal[BIG_ENDIAN]), raw)


@njit(cache=True)
def unpack(
    data: NDArray[np.uint8], message: NDArray[np.int64], signals: NDArray[np.float64], values: NDArray[np.float64]
) -> None:
    """Decode the message's signals into ``values``."""
    for s in range(message[FIRST], message[END]):
        signal = signals[s]
        start, bits = int(signal[START]), int(signal[BITS])
        raw = extract_bits(data, start, bits, int(signal[BIG_ENDIAN]), int(signal[SIGNED]))
        inner = raw * signal[SCALE] + signal[SHIFT]
        values[int(signal[POSITION])] = inner * signal[OUTER_SCALE] + signal[OUTER_SHIFT]


@njit(cache=True)
def _tables(places: Any) -> Any:
    """Messages, signals, payloads and values of a list of addresses."""
    rows = places[MESSAGES]
    return (
        numba.carray(pointer(places[AT_MESSAGES]), (rows, MESSAGE_COLUMNS), numba.int64),
        numba.carray(pointer(places[AT_SIGNALS]), (places[SIGNALS], SIGNAL_COLUMNS), numba.float64),
        numba.carray(pointer(places[AT_PAYLOADS]), (rows, PAYLOAD_COLUMNS), numba.uint8),
        numba.carray(pointer(places[AT_VALUES]), places[VALUES], numba.float64),
    )


@njit(cache=True)
def transmit(memory: int, frames_at: int, start: int, tick: int) -> int:
    """Pack the frames that are due into ``frames[start:]``; returns their number.

    Parameters
    ----------
    memory, frames_at
        Addresses of the list of addresses ``AT_...`` and of the frame records.
    """
    places = addresses_at(memory)
    messages, signals, payloads, values = _tables(places)
    sender, channel = places[SENDER], places[CHANNEL]
    frames = numba.carray(pointer(frames_at), start + messages.shape[0], FRAME_DTYPE)
    count = 0
    for m in range(messages.shape[0]):
        message = messages[m]
        if tick < message[NEXT_DUE]:
            continue
        message[NEXT_DUE] = tick + message[PERIOD] - (tick - message[OFFSET]) % message[PERIOD]
        frame = frames[start + count]
        data = frame["data"]
        pack(data, message, signals, payloads[m], values)
        if message[PROTECTED]:
            counter = message[COUNTER]
            data[1] |= np.uint8(counter)
            data[0] = np.uint8(profile2_crc(data, message[LENGTH], int(payloads[m, DATA_IDS + counter])))
            message[COUNTER] = (counter + 1) & 15
        frame["tick"] = tick
        frame["timestamp_ns"] = tick * TICK_NS
        frame["identifier"] = np.uint32(message[IDENTIFIER])
        frame["channel"] = np.uint8(channel)
        frame["flags"] = np.uint8(message[FLAGS] | TRANSMITTED)
        frame["sender"] = np.uint8(sender)
        frame["length"] = np.uint8(message[LENGTH])
        count += 1
    return count


@njit(cache=True)
def _find(messages: NDArray[np.int64], identifier: int, extended: int) -> int:
    """Row of a message, or −1; rows are sorted by (extended, identifier)."""
    low, high = 0, messages.shape[0]
    while low < high:
        middle = (low + high) >> 1
        row_extended = messages[middle, FLAGS] & EXTENDED
        if row_extended < extended or (row_extended == extended and messages[middle, IDENTIFIER] < identifier):
            low = middle + 1
        else:
            high = middle
    if low == messages.shape[0]:
        return -1
    return low if messages[low, IDENTIFIER] == identifier and (messages[low, FLAGS] & EXTENDED) == extended else -1


@njit(cache=True)
def _frames_lost(counter: int, tick: int, message: NDArray[np.int64]) -> int:
    """Frames lost before this one (0 … 15), −1 if it repeats the last one, −2 if it is out of sequence.

    The allowed step grows by one with each cycle of silence, as MaxDeltaCounter of Profile 2 does; after 15 silent
    cycles any counter is taken. The state moves in the caller, and only on an accepted frame.
    """
    if message[LAST_COUNTER] < 0:
        return 0
    period = message[PERIOD]
    silent_cycles = _RESYNCHRONISE_CYCLES if period < 1 else (tick - message[LAST_TICK]) // period
    step = int(counter - message[LAST_COUNTER]) & 15
    if silent_cycles >= _RESYNCHRONISE_CYCLES:
        return (step - 1) & 15
    if step == 0:
        return -1
    return step - 1 if step <= silent_cycles + 1 else -2


@njit(cache=True)
def _note_lateness(counter: int, tick: int, message: NDArray[np.int64]) -> None:
    """How much later than its counter says a frame came; the earliest frames so far are on time.

    Frames that are held up on their way keep their counters in order, and each is new: only its time tells. After long
    silence the counter tells that much only if it goes on where it was; else the sender may have begun anew. What stays
    late becomes the normal case within thousands of frames. A negative ``EXPECTED`` switches this off.
    """
    if message[EXPECTED] < 0:
        return
    period, now = message[PERIOD], 1000 * tick
    step = int(counter - message[LAST_COUNTER]) & 15
    silence = tick - message[LAST_TICK]
    known = message[LAST_COUNTER] >= 0 and (
        silence < _RESYNCHRONISE_CYCLES * period or (step == 1 and silence < _LONGEST_HOLD_TICKS)
    )
    expected = now
    if known:
        forgotten = step * period * _DRIFT + message[LATENESS] * _FORGOTTEN
        expected = min(now, message[EXPECTED] + int(1000 * (step * period + forgotten)))
    message[EXPECTED] = expected
    message[LATENESS] = (now - expected) // 1000


@njit(cache=True)
def _accept_frame(
    data: NDArray[np.uint8],
    tick: int,
    message: NDArray[np.int64],
    payload: NDArray[np.uint8],
) -> bool:
    """Check the protection of a frame of right length and take note of it."""
    if message[PROTECTED]:
        counter = int(data[1]) & 15
        if profile2_crc(data, message[LENGTH], int(payload[DATA_IDS + counter])) != int(data[0]):
            message[CRC_ERRORS] += 1
            return False
        if message[PROTECTED] == BY_CRC_AND_COUNTER:
            lost = _frames_lost(counter, tick, message)
            if lost < 0:
                message[REPEATED if lost == -1 else WRONG_SEQUENCE] += 1
                return False
            message[LOST] += lost
            _note_lateness(counter, tick, message)
            message[LAST_COUNTER] = counter
    message[LAST_TICK] = tick
    message[ACCEPTED] += 1
    return True


@njit(cache=True)
def receive(memory: int, frames_at: int, count: int, tick: int) -> int:
    """Decode what is accepted of the first ``count`` frames into the values and update the ages.

    Parameters
    ----------
    memory, frames_at
        Addresses of the list of addresses ``AT_...`` and of the frame records. In the list, ``CHANNEL`` is the channel
        listened to, -1 for all. The groups have shape (g + 1, m + 1): row 0, entry 0 counts frames of unknown
        identifier; then for each group of signals its position in the ages and a 1 for each message that belongs to it.
        The age of a group is that of its oldest message, in s: time since it came, and what it came late by its
        counter.

    Returns
    -------
    int
        Number of frames accepted.
    """
    places = addresses_at(memory)
    messages, signals, payloads, values = _tables(places)
    channel = places[CHANNEL]
    frames = numba.carray(pointer(frames_at), count, FRAME_DTYPE)
    groups = numba.carray(pointer(places[AT_GROUPS]), (places[GROUPS], messages.shape[0] + 1), numba.int64)
    ages = numba.carray(pointer(places[AT_AGES]), places[AGES], numba.float64)
    accepted = 0
    for i in range(count):
        frame = frames[i]
        flags = frame["flags"]
        if flags & (ERROR | REMOTE) or (channel >= 0 and frame["channel"] != channel):
            continue
        m = _find(messages, int(frame["identifier"]), int(flags & EXTENDED))
        if m < 0:
            groups[0, 0] += 1
            continue
        message = messages[m]
        if frame["length"] != message[LENGTH] or (flags & FD) != (message[FLAGS] & FD):
            message[WRONG_LENGTH] += 1
            continue
        data = frame["data"]
        if _accept_frame(data, tick, message, payloads[m]):
            unpack(data, message, signals, values)
            accepted += 1
    for g in range(1, groups.shape[0]):
        oldest = 0
        for m in range(messages.shape[0]):
            if groups[g, m + 1]:
                oldest = max(oldest, min(tick - messages[m, LAST_TICK] + messages[m, LATENESS], NEVER_TICKS))
        ages[groups[g, 0]] = oldest * 1e-3
    return accepted
