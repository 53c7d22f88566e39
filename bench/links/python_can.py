"""Any other interface that python-can knows, by name: ``pcan:PCAN_USBBUS1@500000``, ``kvaser:0@500000``."""

import time
from typing import Any

import numpy as np
from numpy.typing import NDArray

from bench.links.frame import BIT_RATE_SWITCH, ERROR, EXTENDED, FD, REMOTE
from bench.links.interface import Link
from signals.errors import LinkError


class PythonCanLink(Link):
    """A bus of python-can.

    Parameters
    ----------
    interface, channel : str
        As for ``can.Bus``.
    bit_rate : int, optional
        Bit rate of the bus; None leaves the interface's own setting.
    role : str
        "bench", "ecu" or "injector".

    Raises
    ------
    LinkError
        If python-can cannot open it.
    """

    def __init__(self, interface: str, channel: str, bit_rate: int | None, role: str) -> None:
        from bench.links.python_can_library import can

        text = f"{interface}:{channel}" + (f"@{bit_rate}" if bit_rate else "")
        super().__init__(interface, text, (channel,), role, supports_lockstep=False)
        options: dict[str, Any] = {"bitrate": bit_rate} if bit_rate else {}
        self._message = can.Message
        self._errors = (can.CanError, OSError)
        try:
            self._bus: Any = can.Bus(interface=interface, channel=channel, **options)
        except Exception as error:  # vendors' libraries raise whatever they like
            raise LinkError(
                f"link {text}: python-can cannot open it: {' '.join(str(error).split())}",
                mend="look at the interface's page in python-can's manual\nor run without: --link udp",
            ) from error
        self._counts = dict.fromkeys(
            ("sent", "received", "own_echoes", "send_refused", "overflows", "malformed", "error_frames"), 0
        )

    def send(self, frames: NDArray[np.void], count: int) -> None:
        """Send each frame; a full queue drops it and counts."""
        for frame in frames[:count]:
            flags = int(frame["flags"])
            message = self._message(
                arbitration_id=int(frame["identifier"]),
                is_extended_id=bool(flags & EXTENDED),
                is_remote_frame=bool(flags & REMOTE),
                is_error_frame=bool(flags & ERROR),
                is_fd=bool(flags & FD),
                bitrate_switch=bool(flags & BIT_RATE_SWITCH),
                dlc=int(frame["length"]),
                data=None if flags & REMOTE else frame["data"][: frame["length"]].tobytes(),
            )
            try:
                self._bus.send(message, timeout=0)
                self._counts["sent"] += 1
            except self._errors:
                self._counts["send_refused"] += 1

    def receive(self, into: NDArray[np.void], start: int = 0) -> int:
        """Take all waiting messages that fit."""
        begin = start
        while start < len(into):
            try:
                message = self._bus.recv(timeout=0)
            except self._errors as error:
                raise LinkError(f"{self.text}: receiving failed: {error}") from error
            if message is None:
                break
            if not message.is_rx:
                self._counts["own_echoes"] += 1
                continue
            self._to_record(message, into[start])
            start += 1
        self._counts["received"] += start - begin
        return start - begin

    def _to_record(self, message: Any, record: np.void) -> None:
        flags = EXTENDED * message.is_extended_id | REMOTE * message.is_remote_frame | ERROR * message.is_error_frame
        flags |= FD * message.is_fd | BIT_RATE_SWITCH * message.bitrate_switch
        self._counts["error_frames"] += int(message.is_error_frame)
        stamp = message.timestamp or time.time()
        record["tick"], record["timestamp_ns"], record["identifier"] = 0, round(stamp * 1e9), message.arbitration_id
        record["channel"], record["flags"], record["sender"] = 0, flags, self.peer_sender
        record["length"] = message.dlc
        record["data"] = 0
        record["data"][: len(message.data)] = np.frombuffer(bytes(message.data), np.uint8)

    def wait(self, timeout_s: float) -> bool:
        """Let the tick sleep: python-can has no wait that leaves the message in its queue."""
        time.sleep(min(timeout_s, 0.5e-3))
        return True

    def statistics(self) -> dict[str, int | str]:
        """Counts since the link was opened; python-can does not tell overflows."""
        return {**self._counts, "timestamp_source": "python-can"}

    def close(self) -> None:
        """Shut the bus down."""
        self._bus.shutdown()
