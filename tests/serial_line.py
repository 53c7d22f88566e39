"""A serial line between two processes, without wires."""

import contextlib
import mmap
import os
import pty
import select
import struct
import subprocess
import sys
import tty
from collections.abc import Sequence

COUNTS = struct.Struct("QQ")

DRAINED_S = 20.0
"""Longest wait for a full line: its 4 KiB take 40 ms at 1 Mbit/s, and a loaded machine some seconds."""


class NullModem:
    """Two pseudo-terminals joined by a process that copies bytes both ways.

    A process of its own: threads of the test would wait for the interpreter beside a loop that runs there.

    ``ends`` are their names, ``bytes_written`` what each end's process has written.
    """

    def __init__(self) -> None:
        self._pairs = [pty.openpty(), pty.openpty()]
        for _, device in self._pairs:
            tty.setraw(device)
        self.ends = [os.ttyname(device) for _, device in self._pairs]
        counted = os.memfd_create("bytes_written")
        os.truncate(counted, COUNTS.size)
        self._counts = mmap.mmap(counted, COUNTS.size)
        descriptors = [self._pairs[0][0], self._pairs[1][0], counted]
        command = [sys.executable, __file__, *map(str, descriptors)]
        self._process = subprocess.Popen(command, stdin=subprocess.PIPE, pass_fds=descriptors)
        os.close(counted)

    @property
    def bytes_written(self) -> tuple[int, int]:
        """By the processes at end 0 and end 1."""
        return COUNTS.unpack(self._counts[:])

    def disturb(self, end: int, stray: bytes) -> None:
        """Bytes that nobody has written arrive at an end, as soon as the line takes them; it is read all the time."""
        line, left = self._pairs[end][0], stray
        while left:
            if not select.select([], [line], [], DRAINED_S)[1]:
                raise TimeoutError(f"nobody reads end {end}")
            with contextlib.suppress(BlockingIOError):  # the other process has filled it meanwhile
                left = left[os.write(line, left) :]

    def close(self) -> None:
        """End both lines."""
        self._process.communicate()
        for descriptors in self._pairs:
            for descriptor in descriptors:
                os.close(descriptor)
        self._counts.close()


def copy(lines: Sequence[int], counted: int) -> None:
    """Bytes of each line to the other until standard input ends; what a full line does not take waits."""
    counts, sent = mmap.mmap(counted, COUNTS.size), [0, 0]
    waiting = [b"", b""]  # from line 0, from line 1
    for line in lines:
        os.set_blocking(line, False)
    while True:
        readable = [sys.stdin.fileno(), *(line for line, data in zip(lines, waiting, strict=True) if not data)]
        writable = [lines[1 - k] for k, data in enumerate(waiting) if data]
        ready, room, _ = select.select(readable, writable, [])
        if sys.stdin.fileno() in ready:  # by the test's end, however it ended
            return
        for k, line in enumerate(lines):
            if line in ready:
                waiting[k] = os.read(line, 4096)
                sent[k] += len(waiting[k])
            if waiting[k] and (lines[1 - k] in room or line in ready):
                waiting[k] = _write(lines[1 - k], waiting[k])
        counts[:] = COUNTS.pack(*sent)


def _write(line: int, data: bytes) -> bytes:
    """What the line did not take."""
    try:
        return data[os.write(line, data) :]
    except BlockingIOError:
        return data


if __name__ == "__main__":
    copy([int(text) for text in sys.argv[1:3]], int(sys.argv[3]))
