"""A serial line between two processes, without wires."""

import os
import pty
import threading
import tty


class NullModem:
    """Two pseudo-terminals joined by a thread that copies bytes both ways."""

    def __init__(self) -> None:
        self._pairs = [pty.openpty(), pty.openpty()]
        for _, device in self._pairs:
            tty.setraw(device)
        self.ends = [os.ttyname(device) for _, device in self._pairs]
        for here, there in ((0, 1), (1, 0)):
            copying = threading.Thread(
                target=self._copy, args=(self._pairs[here][0], self._pairs[there][0]), daemon=True
            )
            copying.start()

    @staticmethod
    def _copy(source: int, target: int) -> None:
        try:
            while data := os.read(source, 4096):
                os.write(target, data)
        except OSError:  # closed at the end of the test
            return

    def close(self) -> None:
        """End both lines."""
        for descriptors in self._pairs:
            for descriptor in descriptors:
                os.close(descriptor)
