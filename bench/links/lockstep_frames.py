"""Which of the frames on a bus are the peer's in a tick: announcements by signature, and the frames that match them."""

import struct
import time

import numpy as np
from numba import njit
from numpy.typing import NDArray

from bench.links.frame import BIT_RATE_SWITCH, ERROR, EXTENDED, FD, FOREIGN, REMOTE, TICK_NS, new_frames
from bench.links.interface import Link
from signals.errors import LinkError, RunError

CHANNELS = 2
MOST_FRAMES = 4096

HEADER = struct.Struct("<qqqI")
MESSAGE_BYTES = HEADER.size + 8 * MOST_FRAMES
"""A message: tick, frames sent on channel 0 and 1 since the start, number of signatures, signatures of 64 bits."""

_IDENTITY_FLAGS = EXTENDED | REMOTE | ERROR | FD | BIT_RATE_SWITCH


@njit(cache=True)
def sign(frames: NDArray[np.void], start: int, end: int, signatures: NDArray[np.uint64]) -> None:
    """64-bit FNV-1a hash of identifier, kind, length and payload of ``frames[start:end]``."""
    prime = np.uint64(0x100000001B3)
    for i in range(start, end):
        frame = frames[i]
        value = np.uint64(0xCBF29CE484222325)
        word = np.uint64(frame["identifier"]) | np.uint64(frame["flags"] & _IDENTITY_FLAGS) << np.uint64(32)
        word |= np.uint64(frame["length"]) << np.uint64(40)
        for b in range(6):
            value = (value ^ ((word >> np.uint64(8 * b)) & np.uint64(0xFF))) * prime
        data = frame["data"]
        for b in range(frame["length"]):
            value = (value ^ np.uint64(data[b])) * prime
        signatures[i] = value


@njit(cache=True)
def match(
    announced: NDArray[np.uint64],
    announced_count: int,
    signatures: NDArray[np.uint64],
    start: int,
    end: int,
    places: NDArray[np.int64],
    taken: NDArray[np.bool_],
) -> int:
    """Find announced frames among those received in ``start … end − 1``; returns how many are still missing.

    ``places[i]`` receives the place of announced frame i (the first unused one that fits), −1 if it is missing;
    ``taken`` marks those places. Entries that are found already stay.
    """
    missing = 0
    for i in range(announced_count):
        if places[i] >= 0:
            continue
        for k in range(start, end):
            if not taken[k] and signatures[k] == announced[i]:
                places[i] = k
                taken[k] = True
                break
        else:
            missing += 1
    return missing


@njit(cache=True)
def hand_on(
    held: NDArray[np.void],
    early: int,
    announced_count: int,
    places: NDArray[np.int64],
    taken: NDArray[np.bool_],
    tick: int,
    peer: int,
    into: NDArray[np.void],
) -> int:
    """Copy the announced frames by channel and order of sending, then strangers that came before this round.

    Returns
    -------
    int
        Number of frames in ``into``; strangers that it has no room for are left out.
    """
    total = 0
    for channel in range(CHANNELS):
        for i in range(announced_count):
            if held[places[i]]["channel"] == channel:
                into[total] = held[places[i]]
                into[total]["sender"] = np.uint8(peer)
                total += 1
    for k in range(early):
        if not taken[k] and total < len(into):
            into[total] = held[k]
            into[total]["sender"] = np.uint8(FOREIGN)
            total += 1
    for k in range(total):
        into[k]["tick"] = tick
        into[k]["timestamp_ns"] = tick * TICK_NS
    return total


@njit(cache=True)
def keep_early(
    held: NDArray[np.void], signatures: NDArray[np.uint64], early: int, held_count: int, taken: NDArray[np.bool_]
) -> int:
    """Move what came in this round and was not announced yet to the front; returns its number."""
    kept = 0
    for k in range(early, held_count):
        if not taken[k]:
            held[kept] = held[k]
            signatures[kept] = signatures[k]
            kept += 1
    return kept


class Announcer:
    """Counts and signs what one side sends."""

    def __init__(self) -> None:
        self._sent = [0] * CHANNELS
        self._signatures = np.zeros(MOST_FRAMES, np.uint64)

    def message(self, tick: int, frames: NDArray[np.void], count: int) -> bytes:
        """Message that announces ``frames[:count]``."""
        if count == 0:
            return HEADER.pack(tick, *self._sent, 0)
        sign(frames, 0, count, self._signatures)
        for channel in frames["channel"][:count].tolist():
            self._sent[channel] += 1
        return HEADER.pack(tick, *self._sent, count) + self._signatures[:count].tobytes()


class Collector:
    """Tells frames of the peer, which the barrier announced, from those of strangers.

    A frame that nobody has announced yet may be an early one of the peer's next tick; it is a stranger's if the next
    announcement does not name it either.
    """

    def __init__(self) -> None:
        self._held = new_frames(MOST_FRAMES)
        self._signatures = np.zeros(MOST_FRAMES, np.uint64)
        self._held_count = 0
        self._announced = np.zeros(MOST_FRAMES, np.uint64)
        self._places = np.zeros(MOST_FRAMES, np.int64)
        self._taken = np.zeros(MOST_FRAMES, np.bool_)
        self._received = 0

    def collect(self, message: memoryview, frames_tick: int, link: Link, into: NDArray[np.void], wait_s: float) -> int:
        """Read the link until every announced frame is there, then hand on what belongs to the tick."""
        _, *sent, count = HEADER.unpack_from(message)
        self._received += count
        if count > len(into):
            raise RunError(f"{count} frames in tick {frames_tick} are more than the {len(into)} that there is room for")
        if self._received != sum(sent) or len(message) != HEADER.size + 8 * count:
            raise RunError(
                f"the barrier's peer speaks another protocol: {sum(sent)} frames, {self._received} signatures"
            )
        self._announced[:count] = np.frombuffer(message, np.uint64, count, HEADER.size)
        self._places[:count] = -1
        early = self._held_count
        self._taken[:early] = False
        self._read(link)
        missing: int = match(self._announced, count, self._signatures, 0, self._held_count, self._places, self._taken)
        if missing:
            self._wait_for(count, missing, frames_tick, link, wait_s)
        held_count, places, taken = self._held_count, self._places, self._taken
        total: int = hand_on(self._held, early, count, places, taken, frames_tick, link.peer_sender, into)
        self._held_count = keep_early(self._held, self._signatures, early, held_count, taken)
        return total

    def _wait_for(self, count: int, missing: int, frames_tick: int, link: Link, wait_s: float) -> None:
        deadline = time.monotonic() + wait_s
        while missing:
            left = deadline - time.monotonic()
            if left <= 0.0:
                raise LinkError(
                    f"{link.text}: {missing} of {count} frames that the peer sent in tick {frames_tick} never came",
                    mend="see the link's overflows; does another program flood the bus?",
                )
            link.wait(min(left, 0.1))
            searched = self._held_count
            self._read(link)
            missing = match(
                self._announced, count, self._signatures, searched, self._held_count, self._places, self._taken
            )

    def _read(self, link: Link) -> None:
        if self._held_count == len(self._held):
            self._grow()
        number = link.receive(self._held, self._held_count)
        if number:
            end = self._held_count + number
            sign(self._held, self._held_count, end, self._signatures)
            self._taken[self._held_count : end] = False
            self._held_count = end

    def _grow(self) -> None:
        """Make room for twice as many: strangers' frames stand before those that are waited for."""
        self._held = np.concatenate([self._held, new_frames(len(self._held))])
        self._signatures = np.concatenate([self._signatures, np.zeros_like(self._signatures)])
        self._taken = np.concatenate([self._taken, np.zeros_like(self._taken)])


def warm_up() -> None:
    """Compile now: the peer must not time out meanwhile."""
    frames, one, taken = new_frames(1), np.zeros(1, np.uint64), np.zeros(1, np.bool_)
    places = np.full(1, -1, np.int64)
    sign(frames, 0, 1, one)
    match(one, 1, one, 0, 1, places, taken)
    hand_on(frames, 0, 1, places, taken, 0, 0, new_frames(1))
    keep_early(frames, one, 0, 1, taken)
