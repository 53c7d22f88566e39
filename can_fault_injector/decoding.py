"""Compiled reading of the bits of a frame, as a receiver does that synchronised at SOF (ISO 11898-1)."""

import numpy as np
from numba import njit
from numpy.typing import NDArray

from can_fault_injector import fields as f
from can_fault_injector.bits import LENGTHS, Bits, crc_parameters, crc_update, stuff_count_bits

(
    RESULT_ERROR,
    RESULT_POSITION,
    RESULT_IDENTIFIER,
    RESULT_EXTENDED,
    RESULT_REMOTE,
    RESULT_FD,
    RESULT_BRS,
    RESULT_ESI,
    RESULT_DLC,
    RESULT_LENGTH,
    RESULT_CRC,
    RESULT_BITS,
) = range(12)
RESULT_SIZE = 12


@njit(cache=True)
def _fail(result: NDArray[np.int64], error: int, position: int) -> int:
    result[RESULT_ERROR] = error
    result[RESULT_POSITION] = position
    return error


@njit(cache=True)
def destuff(
    bits: Bits, wanted: int, at: int, run: int, last: int, plain: Bits, n: int
) -> tuple[int, int, int, int, int]:
    """Read ``wanted`` information bits; returns position, run length, last level, stuff bits seen, error position.

    The error position is -1, that of a stuff error (the sixth equal bit), or minus two at the end of the bits.
    """
    stuff_bits = 0
    for i in range(wanted):
        if run == 5:
            if at >= bits.size:
                return at, run, last, stuff_bits, -2
            if bits[at] == last:
                return at, run, last, stuff_bits, at
            last = bits[at]
            run = 1
            at += 1
            stuff_bits += 1
        if at >= bits.size:
            return at, run, last, stuff_bits, -2
        bit = bits[at]
        at += 1
        run = run + 1 if bit == last else 1
        last = bit
        plain[n + i] = bit
    return at, run, last, stuff_bits, -1


@njit(cache=True)
def number(plain: Bits, start: int, width: int) -> int:
    """Unsigned value of ``width`` bits, most significant first."""
    value = 0
    for i in range(width):
        value = (value << 1) | plain[start + i]
    return value


@njit(cache=True)
def _tail(bits: Bits, at: int, result: NDArray[np.int64]) -> int:
    """CRC delimiter, acknowledge slot (either level), acknowledge delimiter, EOF; its last bit is free (EO01)."""
    end = at + 10
    if end > bits.size:
        return _fail(result, f.TRUNCATED, bits.size)
    for position in range(at, end - 1):
        if position != at + 1 and bits[position] == 0:
            return _fail(result, f.FORM_ERROR, position)
    result[RESULT_BITS] = end
    return f.NO_ERROR


@njit(cache=True)
def _classic_crc(bits: Bits, at: int, run: int, last: int, plain: Bits, n: int, result: NDArray[np.int64]) -> int:
    at, run, last, _, error = destuff(bits, 15, at, run, last, plain, n)
    if error == -2:
        return _fail(result, f.TRUNCATED, bits.size)
    if error >= 0:
        return _fail(result, f.STUFF_ERROR, error)
    # stuffing goes on to the bit after the last bit of the CRC sequence (ST01)
    if run == 5:
        if at >= bits.size:
            return _fail(result, f.TRUNCATED, bits.size)
        if bits[at] == last:
            return _fail(result, f.STUFF_ERROR, at)
        at += 1
    width, polynomial, crc = crc_parameters(False, 0, True)
    for i in range(n):
        crc = crc_update(crc, plain[i], width, polynomial)
    result[RESULT_CRC] = number(plain, n, 15)
    tail = _tail(bits, at, result)
    if tail == f.TRUNCATED:
        return tail
    if crc != result[RESULT_CRC]:
        return _fail(result, f.CRC_ERROR, at)
    return tail


@njit(cache=True)
def _fd_crc(bits: Bits, at: int, stuff_bits: int, length: int, iso: bool, result: NDArray[np.int64]) -> int:
    """Stuff count and CRC of CAN FD; ``at`` is the first fixed stuff bit, so ``bits[:at]`` is what the CRC covers."""
    width, polynomial, crc = crc_parameters(True, length, iso)
    for i in range(at):
        crc = crc_update(crc, bits[i], width, polynomial)
    total = width + (4 if iso else 0)
    sequence = 0
    for i in range(total):
        if i % 4 == 0:
            if at >= bits.size:
                return _fail(result, f.TRUNCATED, bits.size)
            if bits[at] == bits[at - 1]:
                return _fail(result, f.FORM_ERROR, at)
            at += 1
        if at >= bits.size:
            return _fail(result, f.TRUNCATED, bits.size)
        sequence = (sequence << 1) | bits[at]
        at += 1
    result[RESULT_CRC] = sequence & ((1 << width) - 1)
    wrong = False
    if iso:
        count = sequence >> width
        wrong = count != stuff_count_bits(stuff_bits)
        for i in range(4):
            crc = crc_update(crc, (count >> (3 - i)) & 1, width, polynomial)
    tail = _tail(bits, at, result)
    if tail == f.TRUNCATED:
        return tail
    if wrong or crc != result[RESULT_CRC]:
        return _fail(result, f.CRC_ERROR, at)
    return tail


@njit(cache=True)
def decode(bits: Bits, iso: bool, data: Bits, result: NDArray[np.int64]) -> int:
    """Read one stuffed frame that begins with SOF; returns the error code (0 for an accepted frame).

    Parameters
    ----------
    bits : uint8 array
        Bus levels from SOF on; what follows the frame is ignored.
    data : uint8 array of 64
        Receives the payload.
    result : int64 array of RESULT_SIZE
        Receives the fields; with an error, its position.
    """
    plain = np.empty(640, np.uint8)
    result[:] = 0
    if bits.size == 0 or bits[0] != 0:
        return _fail(result, f.FORM_ERROR, 0)
    at, run, last, stuff_bits, error = destuff(bits, 14, 0, 0, 2, plain, 0)
    n = 14
    if error == -1:
        extended = plain[13] == 1
        result[RESULT_EXTENDED] = extended
        more = 20 if extended else 1
        at, run, last, extra, error = destuff(bits, more, at, run, last, plain, n)
        stuff_bits += extra
        n += more
    if error != -1:
        return _fail(result, f.TRUNCATED if error == -2 else f.STUFF_ERROR, bits.size if error == -2 else error)
    # bits so far: SOF id RTR IDE r0/FDF, or SOF id SRR IDE id_ext RTR r1/FDF
    identifier = number(plain, 1, 11)
    if extended:
        identifier = (identifier << 18) | number(plain, 14, 18)
    fd = plain[n - 1] == 1
    remote_bit = plain[32] if extended else plain[12]
    result[RESULT_IDENTIFIER], result[RESULT_FD] = identifier, fd
    result[RESULT_REMOTE] = 0 if fd else remote_bit
    # FD: res, BRS, ESI; extended classic: r0; then DLC
    between = 3 if fd else (1 if extended else 0)
    at, run, last, extra, error = destuff(bits, between + 4, at, run, last, plain, n)
    stuff_bits += extra
    if error != -1:
        return _fail(result, f.TRUNCATED if error == -2 else f.STUFF_ERROR, bits.size if error == -2 else error)
    if fd:
        if plain[n] == 1:
            return _fail(result, f.FORM_ERROR, at)
        result[RESULT_BRS], result[RESULT_ESI] = plain[n + 1], plain[n + 2]
    dlc = number(plain, n + between, 4)
    n += between + 4
    length = LENGTHS[dlc] if fd else (0 if remote_bit else min(dlc, 8))
    result[RESULT_DLC], result[RESULT_LENGTH] = dlc, length
    at, run, last, extra, error = destuff(bits, 8 * length, at, run, last, plain, n)
    stuff_bits += extra
    if error != -1:
        return _fail(result, f.TRUNCATED if error == -2 else f.STUFF_ERROR, bits.size if error == -2 else error)
    for i in range(length):
        data[i] = number(plain, n + 8 * i, 8)
    n += 8 * length
    if fd:
        return int(_fd_crc(bits, at, stuff_bits, length, iso, result))
    return int(_classic_crc(bits, at, run, last, plain, n, result))
