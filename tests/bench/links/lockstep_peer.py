"""A stand-in for an ECU in lock-step: answers each tick with frames computed from all that it has seen so far.

Run as ``python lockstep_peer.py LINK BARRIER [STOP_AT [HANG]]``; prints the digest of what it saw.
"""

import hashlib
import sys
import time

from bench.links.barrier import BarrierClient
from bench.links.frame import EXTENDED, FOREIGN, new_frames
from bench.links.registry import open_link


class Node:
    """Deterministic state machine over frames; used by the peer's process and, as the reference, in the test's."""

    def __init__(self) -> None:
        self._digest = hashlib.sha256()

    def tick(self, tick, frames, count, out) -> int:
        for frame in frames[:count]:
            if frame["sender"] == FOREIGN:
                continue
            self._digest.update(frame["tick"].tobytes() + frame["identifier"].tobytes())
            self._digest.update(bytes([frame["channel"], frame["flags"] & 31, frame["length"], frame["sender"]]))
            self._digest.update(frame["data"].tobytes())
        state = self._digest.digest()
        number = tick % 4
        for i in range(number):
            out[i]["identifier"] = 0x1ABCDE00 + i if state[i] & 1 else 0x300 + i
            out[i]["flags"] = EXTENDED if state[i] & 1 else 0
            out[i]["length"] = 8 if i else 0
            out[i]["data"] = 0
            if i:
                out[i]["data"][:8] = bytearray(state[8 * i : 8 * i + 8])
            out[i]["tick"] = tick
            out[i]["sender"] = 1
        return number

    def digest(self) -> str:
        return self._digest.hexdigest()


def main(link_text: str, barrier_path: str, stop_at: int = -1, hang: int = 0) -> None:
    link = open_link(link_text, role="ecu")
    barrier = BarrierClient(barrier_path)
    node = Node()
    received, out = new_frames(4096), new_frames(64)
    while (begun := barrier.begin(link, received)) is not None:
        tick, count = begun
        if tick == stop_at:
            time.sleep(hang)
            return
        number = node.tick(tick, received, count, out)
        link.send(out, number)
        barrier.finish(out, number)
    print(node.digest())


if __name__ == "__main__":
    main(sys.argv[1], sys.argv[2], *(int(argument) for argument in sys.argv[3:]))
