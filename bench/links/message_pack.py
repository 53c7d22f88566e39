"""Frames as the MessagePack maps that python-can's ``udp_multicast`` sends, so that its users can join our bus.

The map of a frame always has the same keys in the same order, so it is a template with holes: packing and unpacking is
compiled. A foreign sender may write numbers in fewer bytes; what does not match the template is read with ``msgpack``.
"""

import struct

import numpy as np
from numba import njit
from numpy.typing import NDArray

from bench.links.frame import BIT_RATE_SWITCH, ERROR, EXTENDED, FD, REMOTE

SLOT_BYTES = 320
"""Room for one datagram; the longest that we send has 246 bytes."""

_NIL, _FALSE, _TRUE, _BIN8, _UINT8, _UINT32, _FLOAT64 = 0xC0, 0xC2, 0xC3, 0xC4, 0xCC, 0xCE, 0xCB


def _key(name: str) -> bytes:
    return bytes([0xA0 | len(name)]) + name.encode()


def _template() -> tuple[bytes, bytes, dict[str, int]]:
    """Bytes before and after the payload, and where the holes are."""
    fields = (
        ("timestamp", bytes([_FLOAT64]) + bytes(8)),
        ("arbitration_id", bytes([_UINT32]) + bytes(4)),
        ("is_extended_id", bytes([_FALSE])),
        ("is_remote_frame", bytes([_FALSE])),
        ("is_error_frame", bytes([_FALSE])),
        ("channel", bytes([_NIL])),
        ("dlc", bytes([0])),
        ("data", bytes([_BIN8, 0])),
    )
    head, holes = bytes([0x80 | 11]), {}
    for name, value in fields:
        head += _key(name)
        holes[name] = len(head)
        head += value
    tail = b""
    for name in ("is_fd", "bitrate_switch", "error_state_indicator"):
        tail += _key(name)
        holes[name] = len(tail)
        tail += bytes([_FALSE])
    return head, tail, holes


_HEAD, _TAIL, _HOLES = _template()
_HEAD_BYTES = np.frombuffer(_HEAD, np.uint8)
_TAIL_BYTES = np.frombuffer(_TAIL, np.uint8)
_TIMESTAMP = _HOLES["timestamp"] + 1
_IDENTIFIER = _HOLES["arbitration_id"] + 1
_EXTENDED, _REMOTE, _ERROR = (_HOLES[f"is_{name}"] for name in ("extended_id", "remote_frame", "error_frame"))
_DLC, _LENGTH = _HOLES["dlc"], _HOLES["data"] + 1
_FD, _SWITCH, _STATE = (_HOLES[name] for name in ("is_fd", "bitrate_switch", "error_state_indicator"))


def _is_hole() -> tuple[NDArray[np.bool_], NDArray[np.bool_]]:
    """Which bytes of head and tail differ from frame to frame."""
    head, tail = np.zeros(len(_HEAD), np.bool_), np.zeros(len(_TAIL), np.bool_)
    head[_TIMESTAMP : _TIMESTAMP + 8] = True
    head[_IDENTIFIER : _IDENTIFIER + 4] = True
    head[[_EXTENDED, _REMOTE, _ERROR, _DLC, _LENGTH]] = True
    tail[[_FD, _SWITCH, _STATE]] = True
    return head, tail


_HEAD_HOLES, _TAIL_HOLES = _is_hole()


@njit(cache=True)
def _flag(is_set: int) -> np.uint8:
    return np.uint8(_TRUE if is_set else _FALSE)


@njit(cache=True)
def pack_frames(
    frames: NDArray[np.void], count: int, stamp: NDArray[np.uint8], slots: NDArray[np.uint8], sizes: NDArray[np.int64]
) -> None:
    """Write one datagram per frame.

    Parameters
    ----------
    stamp : uint8 array, shape (8,)
        Time of sending, s, as a big-endian double.
    slots : uint8 array, shape (n, SLOT_BYTES)
    sizes : int64 array, shape (n,)
        Receives the number of bytes of each datagram.
    """
    head = len(_HEAD_BYTES)
    for i in range(count):
        frame, slot = frames[i], slots[i]
        flags = int(frame["flags"])
        identifier = int(frame["identifier"])
        length = 0 if flags & REMOTE else int(frame["length"])
        slot[:head] = _HEAD_BYTES
        slot[_TIMESTAMP : _TIMESTAMP + 8] = stamp
        for b in range(4):
            slot[_IDENTIFIER + b] = np.uint8((identifier >> (24 - 8 * b)) & 0xFF)
        slot[_EXTENDED] = _flag(flags & EXTENDED)
        slot[_REMOTE] = _flag(flags & REMOTE)
        slot[_ERROR] = _flag(flags & ERROR)
        slot[_DLC] = frame["length"]
        slot[_LENGTH] = np.uint8(length)
        data = frame["data"]
        for b in range(length):
            slot[head + b] = data[b]
        tail = head + length
        slot[tail : tail + len(_TAIL_BYTES)] = _TAIL_BYTES
        slot[tail + _FD] = _flag(flags & FD)
        slot[tail + _SWITCH] = _flag(flags & BIT_RATE_SWITCH)
        sizes[i] = tail + len(_TAIL_BYTES)


@njit(cache=True)
def _fits_template(slot: NDArray[np.uint8], size: int) -> bool:
    head, tail = len(_HEAD_BYTES), len(_TAIL_BYTES)
    if size < head + tail:
        return False
    length = int(slot[_LENGTH])
    if size != head + length + tail or length > 64 or slot[_DLC] > 64:
        return False
    differs = False
    for i in range(head):
        differs |= not _HEAD_HOLES[i] and slot[i] != _HEAD_BYTES[i]
    for i in range(tail):
        differs |= not _TAIL_HOLES[i] and slot[head + length + i] != _TAIL_BYTES[i]
    return not differs


@njit(cache=True)
def unpack_frames(
    slots: NDArray[np.uint8],
    heads: NDArray[np.int64],
    count: int,
    sender: int,
    frames: NDArray[np.void],
    start: int,
    strange: NDArray[np.int64],
) -> int:
    """Read datagrams into ``frames[start:]``; returns how many do not match the template.

    Parameters
    ----------
    slots : uint8 array, shape (n, SLOT_BYTES)
    heads : int64 array, shape (n, 2)
        Bytes of each datagram and the time of its reception, ns.
    sender : int
        Written to all records.
    strange : int64 array, shape (n,)
        Receives the numbers of the datagrams that do not match; the rest of their records stays as it is.
    """
    head = len(_HEAD_BYTES)
    others = 0
    for i in range(count):
        frame = frames[start + i]
        frame["tick"] = 0
        frame["timestamp_ns"] = heads[i, 1]
        frame["sender"] = np.uint8(sender)
        slot = slots[i]
        if not _fits_template(slot, heads[i, 0]):
            strange[others] = i
            others += 1
            continue
        length = int(slot[_LENGTH])
        tail = head + length
        identifier = 0
        for b in range(4):
            identifier = (identifier << 8) | int(slot[_IDENTIFIER + b])
        flags = 0
        for position, bit in ((_EXTENDED, EXTENDED), (_REMOTE, REMOTE), (_ERROR, ERROR)):
            flags |= bit if slot[position] == _TRUE else 0
        for position, bit in ((_FD, FD), (_SWITCH, BIT_RATE_SWITCH)):
            flags |= bit if slot[tail + position] == _TRUE else 0
        frame["identifier"] = np.uint32(identifier)
        frame["flags"] = np.uint8(flags)
        frame["channel"] = np.uint8(0)
        frame["length"] = slot[_DLC]
        data = frame["data"]
        for b in range(length):
            data[b] = slot[head + b]
        for b in range(length, 64):
            data[b] = 0
    return others


def unpack_any(datagram: bytes, frame: np.void) -> bool:
    """Read any map of python-can into one record; False if it is none."""
    import msgpack  # type: ignore[import-untyped]

    try:
        fields = msgpack.unpackb(datagram, raw=False)
        data = bytes(fields["data"] or b"")
        identifier, length = int(fields["arbitration_id"]), int(fields["dlc"])
        if len(data) > 64 or not 0 <= length <= 64 or not 0 <= identifier < 1 << 32:
            return False
        flags = EXTENDED * bool(fields["is_extended_id"]) | REMOTE * bool(fields["is_remote_frame"])
        flags |= ERROR * bool(fields["is_error_frame"]) | FD * bool(fields["is_fd"])
        flags |= BIT_RATE_SWITCH * bool(fields["bitrate_switch"])
    except Exception:  # anything can arrive at an open port, and msgpack raises many kinds
        return False
    frame["identifier"], frame["flags"], frame["channel"], frame["length"] = identifier, flags, 0, length
    frame["data"] = 0
    frame["data"][: len(data)] = np.frombuffer(data, np.uint8)
    return True


def stamp_bytes(time_ns: int) -> NDArray[np.uint8]:
    """Time as the eight bytes that :func:`pack_frames` wants."""
    return np.frombuffer(struct.pack(">d", time_ns * 1e-9), np.uint8)
