"""A serial line between two processes, without wires."""

import os
import pty
import threading
import tty


class NullModem:
    """Two pseudo-terminals joined by threads that copy bytes both ways.

    ``ends`` are their names, ``bytes_written`` what each end's process has written.
    """

    def __init__(self) -> None:
        self._pairs = [pty.openpty(), pty.openpty()]
        self.bytes_written = [0, 0]
        for _, device in self._pairs:
            tty.setraw(device)
        self.ends = [os.ttyname(device) for _, device in self._pairs]
        for here, there in ((0, 1), (1, 0)):
            threading.Thread(target=self._copy, args=(here, there), daemon=True).start()

    def _copy(self, here: int, there: int) -> None:
        try:
            while data := os.read(self._pairs[here][0], 4096):
                os.write(self._pairs[there][0], data)
                self.bytes_written[here] += len(data)
        except OSError:  # closed at the end of the test
            return

    def disturb(self, end: int, stray: bytes) -> None:
        """Bytes that nobody has written arrive at an end."""
        os.write(self._pairs[end][0], stray)

    def close(self) -> None:
        """End both lines."""
        for descriptors in self._pairs:
            for descriptor in descriptors:
                os.close(descriptor)
