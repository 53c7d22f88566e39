"""Compiled bit-by-bit reading of a frame by a protocol node (ISO 11898-1:2015; rules ST, EO, FD of the tests)."""

import numpy as np
from numba import njit
from numpy.typing import NDArray

from can_fault_injector import fields as f
from can_fault_injector import node_state as ns
from can_fault_injector.bits import (
    CRC15_POLYNOMIAL,
    CRC17_POLYNOMIAL,
    CRC21_POLYNOMIAL,
    LENGTHS,
    crc_update,
    stuff_count_bits,
)

State = NDArray[np.int64]
Payload = NDArray[np.uint8]


@njit(cache=True)
def begin(s: State) -> None:
    """Make ready for the first bit (SOF) of a frame."""
    s[ns.PHASE], s[ns.COUNT] = ns.FRAME, 0
    s[ns.FRAME_BITS] = 0
    s[ns.FIELD], s[ns.INDEX] = f.SOF, 0
    s[ns.RUN], s[ns.LAST], s[ns.STUFF_BITS], s[ns.FIXED_STUFF_DUE] = 0, 2, 0, 0
    s[ns.CRC_15] = 0
    s[ns.CRC_17] = (1 << 16) if s[ns.ISO] else 0
    s[ns.CRC_21] = (1 << 20) if s[ns.ISO] else 0
    s[ns.SEQUENCE], s[ns.CRC_WRONG], s[ns.ACKNOWLEDGED] = 0, 0, 0
    s[ns.IDENTIFIER], s[ns.EXTENDED], s[ns.REMOTE], s[ns.FD] = 0, 0, 0, 0
    s[ns.BIT_RATE_SWITCH], s[ns.ERROR_STATE], s[ns.LENGTH_CODE], s[ns.LENGTH] = 0, 0, 0, 0


@njit(cache=True)
def _go_to(s: State, field: int) -> None:
    s[ns.FIELD], s[ns.INDEX] = field, 0


@njit(cache=True)
def _fd_crc(s: State, bit: int) -> None:
    s[ns.CRC_17] = crc_update(s[ns.CRC_17], bit, 17, CRC17_POLYNOMIAL)
    s[ns.CRC_21] = crc_update(s[ns.CRC_21], bit, 21, CRC21_POLYNOMIAL)


@njit(cache=True)
def _start_crc(s: State) -> None:
    s[ns.SEQUENCE] = 0
    if s[ns.FD]:
        s[ns.FIXED_STUFF_DUE] = 1
        _go_to(s, f.STUFF_COUNT if s[ns.ISO] else f.CRC)
    else:
        _go_to(s, f.CRC)


@njit(cache=True)
def _format_bit(s: State, bit: int) -> int:
    """FDF of CAN FD, r0 or r1 of classic CAN."""
    if bit == 1 and s[ns.FD_MODE] == ns.FD_TOLERANT:
        return ns.PROTOCOL_EXCEPTION
    if bit == 1 and s[ns.FD_MODE] == ns.FD_ENABLED:
        s[ns.FD], s[ns.REMOTE] = 1, 0
        _go_to(s, f.RES)
    else:
        _go_to(s, f.R0 if s[ns.FIELD] == f.R1 else f.DLC)
    return f.NO_ERROR


@njit(cache=True)
def _header_bit(s: State, bit: int) -> int:
    """An information bit from SOF to the bit before DLC."""
    field = s[ns.FIELD]
    if field == f.SOF:
        _go_to(s, f.IDENTIFIER)
    elif field == f.IDENTIFIER or field == f.IDENTIFIER_EXTENSION:
        s[ns.IDENTIFIER] = (s[ns.IDENTIFIER] << 1) | bit
        s[ns.INDEX] += 1
        if s[ns.INDEX] == (11 if field == f.IDENTIFIER else 18):
            _go_to(s, f.RTR)
    elif field == f.RTR:
        # before IDE this is RTR of a standard or SRR of an extended frame: nobody knows yet
        s[ns.REMOTE] = bit
        _go_to(s, f.R1 if s[ns.EXTENDED] else f.IDE)
    elif field == f.IDE:
        s[ns.EXTENDED] = bit
        _go_to(s, f.IDENTIFIER_EXTENSION if bit else f.R0)
    elif field == f.R1 or (field == f.R0 and not s[ns.EXTENDED]):
        return int(_format_bit(s, bit))
    elif field == f.R0:
        _go_to(s, f.DLC)
    elif field == f.RES:
        if bit:
            return ns.PROTOCOL_EXCEPTION
        _go_to(s, f.BRS)
    elif field == f.BRS:
        s[ns.BIT_RATE_SWITCH] = bit
        _go_to(s, f.ESI)
    else:
        s[ns.ERROR_STATE] = bit
        _go_to(s, f.DLC)
    return f.NO_ERROR


@njit(cache=True)
def _body_bit(s: State, data: Payload, bit: int) -> int:
    """An information bit of DLC, data or the CRC of classic CAN."""
    field = s[ns.FIELD]
    s[ns.INDEX] += 1
    if field == f.DLC:
        s[ns.LENGTH_CODE] = (s[ns.LENGTH_CODE] << 1) | bit
        if s[ns.INDEX] == 4:
            code = s[ns.LENGTH_CODE]
            s[ns.LENGTH] = LENGTHS[code] if s[ns.FD] else (0 if s[ns.REMOTE] else min(code, 8))
            if s[ns.LENGTH]:
                _go_to(s, f.DATA)
            else:
                _start_crc(s)
    elif field == f.DATA:
        at = (s[ns.INDEX] - 1) >> 3
        data[at] = ((data[at] << 1) | bit) & 0xFF
        if s[ns.INDEX] == 8 * s[ns.LENGTH]:
            _start_crc(s)
    else:
        s[ns.SEQUENCE] = (s[ns.SEQUENCE] << 1) | bit
        if s[ns.INDEX] == 15:
            s[ns.CRC_WRONG] = 1 if s[ns.SEQUENCE] != s[ns.CRC_15] else 0
            _go_to(s, f.CRC_DELIMITER)
    return f.NO_ERROR


@njit(cache=True)
def _fd_sequence_bit(s: State, bit: int) -> int:
    """A bit of stuff count, CRC or fixed stuffing of CAN FD."""
    if s[ns.FIXED_STUFF_DUE]:
        if bit == s[ns.LAST]:
            return f.FORM_ERROR
        s[ns.FIXED_STUFF_DUE], s[ns.LAST] = 0, bit
        return f.NO_ERROR
    s[ns.LAST] = bit
    s[ns.SEQUENCE] = (s[ns.SEQUENCE] << 1) | bit
    s[ns.INDEX] += 1
    if s[ns.FIELD] == f.STUFF_COUNT:
        _fd_crc(s, bit)
        if s[ns.INDEX] == 4:
            s[ns.CRC_WRONG] = 1 if s[ns.SEQUENCE] != stuff_count_bits(s[ns.STUFF_BITS]) else 0
            s[ns.SEQUENCE], s[ns.FIXED_STUFF_DUE] = 0, 1
            _go_to(s, f.CRC)
        return f.NO_ERROR
    width = 17 if s[ns.LENGTH] <= 16 else 21
    if s[ns.INDEX] == width:
        if s[ns.SEQUENCE] != (s[ns.CRC_17] if width == 17 else s[ns.CRC_21]):
            s[ns.CRC_WRONG] = 1
        _go_to(s, f.CRC_DELIMITER)
    elif s[ns.INDEX] % 4 == 0:
        s[ns.FIXED_STUFF_DUE] = 1
    return f.NO_ERROR


@njit(cache=True)
def _trailer_bit(s: State, bit: int) -> int:
    """CRC delimiter, acknowledge slot and delimiter, EOF: a CRC error shows after the acknowledge delimiter (EF01)."""
    field = s[ns.FIELD]
    if field == f.CRC_DELIMITER:
        if bit == 0:
            return f.FORM_ERROR
        _go_to(s, f.ACK_SLOT)
        return f.NO_ERROR
    if field == f.ACK_SLOT:
        s[ns.ACKNOWLEDGED] = 1 - bit
        _go_to(s, f.ACK_DELIMITER)
        # the sender of a CAN FD frame waits one bit more, as delays may make the CRC delimiter two bits long (FD10)
        if bit == 1 and s[ns.TRANSMITTER] and not s[ns.FD]:
            return ns.ACKNOWLEDGE_ERROR
        return f.NO_ERROR
    if field == f.ACK_DELIMITER:
        if bit == 0:
            if not s[ns.FD] or s[ns.INDEX]:
                return f.FORM_ERROR
            s[ns.ACKNOWLEDGED], s[ns.INDEX] = 1, 1
            return f.NO_ERROR
        if s[ns.TRANSMITTER] and not s[ns.ACKNOWLEDGED]:
            return ns.ACKNOWLEDGE_ERROR
        if s[ns.CRC_WRONG] and (not s[ns.FD] or s[ns.INDEX]):
            return f.CRC_ERROR
        _go_to(s, f.EOF)
        return f.NO_ERROR
    at = s[ns.INDEX]
    s[ns.INDEX] += 1
    if s[ns.CRC_WRONG]:
        return f.CRC_ERROR
    if bit == 0:
        return ns.OVERLOAD_CONDITION if at == 6 and not s[ns.TRANSMITTER] else f.FORM_ERROR
    if at == 6:
        return ns.FRAME_END
    # a frame is valid for its receivers at the last but one bit of EOF, for its sender only at the last (EO01, EO02)
    return ns.ACCEPTED if at == 5 and not s[ns.TRANSMITTER] else f.NO_ERROR


@njit(cache=True)
def read_bit(s: State, data: Payload, bit: int) -> int:
    """Take one bus level of a frame; returns an error kind, or what the bit means to the node (``node_state``)."""
    field = s[ns.FIELD]
    s[ns.FRAME_BITS] += 1
    if s[ns.FD] and (field == f.STUFF_COUNT or field == f.CRC):
        return int(_fd_sequence_bit(s, bit))
    # in classic CAN a stuff bit may follow the last bit of the CRC (ST01, ST02)
    if s[ns.RUN] == 5 and (field < f.CRC_DELIMITER or (field == f.CRC_DELIMITER and not s[ns.FD])):
        if bit == s[ns.LAST]:
            return f.STUFF_ERROR
        s[ns.RUN], s[ns.LAST] = 1, bit
        s[ns.STUFF_BITS] += 1
        _fd_crc(s, bit)
        return f.NO_ERROR
    if field >= f.CRC_DELIMITER:
        return int(_trailer_bit(s, bit))
    s[ns.RUN] = s[ns.RUN] + 1 if bit == s[ns.LAST] else 1
    s[ns.LAST] = bit
    if field != f.CRC:
        s[ns.CRC_15] = crc_update(s[ns.CRC_15], bit, 15, CRC15_POLYNOMIAL)
        _fd_crc(s, bit)
    if field < f.DLC:
        return int(_header_bit(s, bit))
    return int(_body_bit(s, data, bit))
