"""Compiled conversion of frames to the bits on the wire and back (ISO 11898-1; Bosch CAN 2.0 part B).

A bit is 0 (dominant) or 1 (recessive). Every bit carries the code of its field and its number inside the field; a
dynamic stuff bit is a field of its own, numbered through the frame.
"""

import numpy as np
from numba import njit
from numpy.typing import NDArray

from can_fault_injector import fields as f

Bits = NDArray[np.uint8]
Numbers = NDArray[np.int16]

CRC15_POLYNOMIAL = 0x4599
CRC17_POLYNOMIAL = 0x1685B
CRC21_POLYNOMIAL = 0x102899
LENGTHS = np.array(f.FD_LENGTHS, np.int64)


@njit(cache=True)
def crc_update(crc: int, bit: int, width: int, polynomial: int) -> int:
    """CRC register after one more bit, most significant bit first."""
    top = (crc >> (width - 1)) & 1
    crc = (crc << 1) & ((1 << width) - 1)
    return crc ^ polynomial if top ^ bit else crc


@njit(cache=True)
def crc_parameters(fd: bool, length: int, iso: bool) -> tuple[int, int, int]:
    """Width, polynomial and initial value of the CRC of a frame with ``length`` data bytes.

    CAN FD of ISO 11898-1:2015 starts with a one in the top bit, the older non-ISO variant with zero.
    """
    if not fd:
        return 15, CRC15_POLYNOMIAL, 0
    if length <= 16:
        return 17, CRC17_POLYNOMIAL, (1 << 16) if iso else 0
    return 21, CRC21_POLYNOMIAL, (1 << 20) if iso else 0


@njit(cache=True)
def stuff_count_bits(count: int) -> int:
    """Four bits of the stuff bit count: number of dynamic stuff bits modulo 8 in Gray code, then even parity."""
    remainder = count & 7
    gray = remainder ^ (remainder >> 1)
    parity = (gray ^ (gray >> 1) ^ (gray >> 2)) & 1
    return (gray << 1) | parity


@njit(cache=True)
def _put_bit(field: int, number: int, level: int, bits: Bits, codes: Bits, numbers: Numbers, at: int) -> int:
    """Write bit ``number`` of a field at a position; returns the next position."""
    bits[at], codes[at], numbers[at] = level, field, number
    return at + 1


@njit(cache=True)
def _put(field: int, value: int, width: int, bits: Bits, codes: Bits, numbers: Numbers, at: int, first: int = 0) -> int:
    """Write the bits of a value, most significant first, as bits ``first`` and up of a field."""
    for i in range(width):
        at = _put_bit(field, first + i, (value >> (width - 1 - i)) & 1, bits, codes, numbers, at)
    return at


@njit(cache=True)
def header_and_data(
    identifier: int,
    extended: bool,
    remote: bool,
    fd: bool,
    bit_rate_switch: bool,
    error_state: bool,
    dlc: int,
    data: Bits,
    length: int,
    bits: Bits,
    codes: Bits,
    numbers: Numbers,
) -> int:
    """Unstuffed bits from SOF to the end of the data field; returns their number."""
    at = _put(f.SOF, 0, 1, bits, codes, numbers, 0)
    if extended:
        at = _put(f.IDENTIFIER, identifier >> 18, 11, bits, codes, numbers, at)
        at = _put(f.SRR, 1, 1, bits, codes, numbers, at)
        at = _put(f.IDE, 1, 1, bits, codes, numbers, at)
        at = _put(f.IDENTIFIER_EXTENSION, identifier & 0x3FFFF, 18, bits, codes, numbers, at)
    else:
        at = _put(f.IDENTIFIER, identifier, 11, bits, codes, numbers, at)
    at = _put(f.RRS if fd else f.RTR, 1 if remote else 0, 1, bits, codes, numbers, at)
    if not extended:
        at = _put(f.IDE, 0, 1, bits, codes, numbers, at)
    if fd:
        at = _put(f.FDF, 1, 1, bits, codes, numbers, at)
        at = _put(f.RES, 0, 1, bits, codes, numbers, at)
        at = _put(f.BRS, 1 if bit_rate_switch else 0, 1, bits, codes, numbers, at)
        at = _put(f.ESI, 1 if error_state else 0, 1, bits, codes, numbers, at)
    else:
        if extended:
            at = _put(f.R1, 0, 1, bits, codes, numbers, at)
        at = _put(f.R0, 0, 1, bits, codes, numbers, at)
    at = _put(f.DLC, dlc, 4, bits, codes, numbers, at)
    for i in range(length):
        at = _put(f.DATA, data[i], 8, bits, codes, numbers, at, 8 * i)
    return at


@njit(cache=True)
def _append_crc(
    fd: bool,
    iso: bool,
    crc: int,
    width: int,
    stuffed: bool,
    count: int,
    bits: Bits,
    codes: Bits,
    numbers: Numbers,
    at: int,
) -> int:
    """CRC sequence of CAN FD: stuff count (ISO only) and CRC with a fixed stuff bit before every fourth bit."""
    total = width + (4 if iso else 0)
    sequence = (stuff_count_bits(count) << width) | crc if iso else crc
    for i in range(total):
        if stuffed and i % 4 == 0:
            at = _put_bit(f.FIXED_STUFF, i // 4, 1 - bits[at - 1], bits, codes, numbers, at)
        in_count = iso and i < 4
        field, number = (f.STUFF_COUNT, i) if in_count else (f.CRC, i - (total - width))
        at = _put_bit(field, number, (sequence >> (total - 1 - i)) & 1, bits, codes, numbers, at)
    return at


@njit(cache=True)
def encode(
    identifier: int,
    extended: bool,
    remote: bool,
    fd: bool,
    bit_rate_switch: bool,
    error_state: bool,
    dlc: int,
    data: Bits,
    length: int,
    iso: bool,
    stuffed: bool,
    bits: Bits,
    codes: Bits,
    numbers: Numbers,
) -> int:
    """Bits of a frame from SOF to the last bit of EOF, as the sender drives them; returns their number.

    Parameters
    ----------
    data, length
        Payload and the bytes of it that go on the wire (0 for a remote frame, at most 8 for classic CAN).
    iso
        CAN FD of ISO 11898-1:2015, else the older variant without stuff count.
    stuffed
        False leaves out dynamic and fixed stuff bits; the CRC is the same.
    bits, codes, numbers : arrays of at least MAX_BITS
        Receive level, field code and number inside the field of each bit.
    """
    plain = np.empty(600, np.uint8)
    plain_codes = np.empty(600, np.uint8)
    plain_numbers = np.empty(600, np.int16)
    n = header_and_data(
        identifier,
        extended,
        remote,
        fd,
        bit_rate_switch,
        error_state,
        dlc,
        data,
        length,
        plain,
        plain_codes,
        plain_numbers,
    )
    width, polynomial, crc = crc_parameters(fd, length, iso)
    if not fd:
        for i in range(n):
            crc = crc_update(crc, plain[i], width, polynomial)
        n = _put(f.CRC, crc, width, plain, plain_codes, plain_numbers, n)
    at, run, last, stuff_bits = 0, 0, 2, 0
    for i in range(n):
        bit = plain[i]
        at = _put_bit(plain_codes[i], plain_numbers[i], bit, bits, codes, numbers, at)
        run = run + 1 if bit == last else 1
        last = bit
        if fd:
            crc = crc_update(crc, bit, width, polynomial)
        # in CAN FD the fixed stuff bit follows the data field at once, so none is inserted after its last bit
        if run == 5 and not (fd and i == n - 1):
            last = 1 - bit
            run = 1
            if fd:
                crc = crc_update(crc, last, width, polynomial)
            if stuffed:
                at = _put_bit(f.STUFF, stuff_bits, last, bits, codes, numbers, at)
            stuff_bits += 1
    if fd:
        if iso:
            count = stuff_count_bits(stuff_bits)
            for i in range(4):
                crc = crc_update(crc, (count >> (3 - i)) & 1, width, polynomial)
        at = _append_crc(fd, iso, crc, width, stuffed, stuff_bits, bits, codes, numbers, at)
    at = _put(f.CRC_DELIMITER, 1, 1, bits, codes, numbers, at)
    at = _put(f.ACK_SLOT, 1, 1, bits, codes, numbers, at)
    at = _put(f.ACK_DELIMITER, 1, 1, bits, codes, numbers, at)
    return _put(f.EOF, 0x7F, 7, bits, codes, numbers, at)
