"""CAN adapters on a serial line that speak slcan (Lawicel): CANable, USBtin, CANUSB and the like.

python-can's slcan reads the line byte by byte and waits until each frame has left the computer; a 1 ms tick has no time
for that. Here the line is read and written in one call per tick, and what it has no room for waits for the next. An
adapter tells neither the time of a frame nor what it lost, so frames are stamped when they are read.
"""

import contextlib
import errno
import os
import time

import numpy as np
from numpy.typing import NDArray

from bench.links.frame import BIT_RATE_SWITCH, ERROR, EXTENDED, FD, FD_LENGTHS, REMOTE
from bench.links.interface import Link, Poller
from signals.errors import InputError, LinkError

BIT_RATES = {
    10_000: "S0",
    20_000: "S1",
    50_000: "S2",
    100_000: "S3",
    125_000: "S4",
    250_000: "S5",
    500_000: "S6",
    750_000: "S7",
    1_000_000: "S8",
}

# first letter of a line: digits of the identifier, flags
_LETTERS = {
    "t": (3, 0),
    "T": (8, EXTENDED),
    "r": (3, REMOTE),
    "R": (8, EXTENDED | REMOTE),
    "d": (3, FD),
    "D": (8, FD | EXTENDED),
    "b": (3, FD | BIT_RATE_SWITCH),
    "B": (8, FD | BIT_RATE_SWITCH | EXTENDED),
}
_LETTER_OF_FLAGS = {flags: letter for letter, (_, flags) in _LETTERS.items()}
_FRAME_FLAGS = EXTENDED | REMOTE | ERROR | FD | BIT_RATE_SWITCH

_MOST_WAITING_BYTES = 64 * 1024


def frame_line(frame: np.void) -> bytes:
    """One frame as a line of slcan, carriage return included; empty for what slcan cannot say (error frames)."""
    flags, length = int(frame["flags"]) & _FRAME_FLAGS, int(frame["length"])
    if flags not in _LETTER_OF_FLAGS:
        return b""
    letter = _LETTER_OF_FLAGS[flags]
    digits = _LETTERS[letter][0]
    code = FD_LENGTHS.index(length)
    data = b"" if flags & REMOTE else frame["data"][:length].tobytes()
    return f"{letter}{int(frame['identifier']):0{digits}X}{code:X}{data.hex().upper()}\r".encode()


def read_line(line: bytes, frame: np.void) -> bool:
    """Read a line into one record; False if it is no frame (an answer, a setting, rubbish)."""
    try:
        text = line.decode("ascii")
        digits, flags = _LETTERS[text[:1]]
        identifier = int(text[1 : 1 + digits], 16)
        length = FD_LENGTHS[int(text[1 + digits], 16)]
        data = b"" if flags & REMOTE else bytes.fromhex(text[2 + digits : 2 + digits + 2 * length])
    except (KeyError, ValueError, IndexError):
        return False
    if not flags & REMOTE and len(data) != length:
        return False
    frame["identifier"], frame["flags"], frame["length"] = identifier, flags, length
    frame["data"] = 0
    frame["data"][: len(data)] = np.frombuffer(data, np.uint8)
    return True


class SlcanLink(Link):
    """An slcan adapter.

    Parameters
    ----------
    port : str
        Serial device, ``/dev/ttyUSB0``.
    bit_rate : int
        Bit rate of the CAN bus, one of :data:`BIT_RATES`.
    baud_rate : int
        Speed of the serial line; USB adapters do not care.
    role : str
        "bench", "ecu" or "injector".

    Raises
    ------
    LinkError
        If the device does not exist, is not permitted or in use.
    """

    def __init__(self, port: str, bit_rate: int, baud_rate: int, role: str) -> None:
        super().__init__("slcan", f"slcan:{port}@{bit_rate}", (port,), role, supports_lockstep=False)
        if bit_rate not in BIT_RATES:
            allowed = ", ".join(str(rate) for rate in BIT_RATES)
            raise InputError(f"link {self.text}: no bit rate of slcan", found=str(bit_rate), allowed=allowed)
        self._serial = _open_port(port, baud_rate)
        self._descriptor: int = self._serial.fileno()
        self._poller = Poller([self._descriptor])
        self._to_send = bytearray()
        self._line = bytearray()
        self._counts = dict.fromkeys(
            ("sent", "received", "own_echoes", "send_refused", "overflows", "malformed", "error_frames"), 0
        )
        self._write(b"C\r" + BIT_RATES[bit_rate].encode() + b"\rO\r")

    def _write(self, lines: bytes) -> None:
        self._to_send += lines
        try:
            written = os.write(self._descriptor, self._to_send)
        except BlockingIOError:
            written = 0
        except OSError as error:
            raise LinkError(f"{self.text}: sending failed: {error.strerror}") from error
        del self._to_send[:written]

    def send(self, frames: NDArray[np.void], count: int) -> None:
        """Write all frames at once; with 64 KiB waiting, more are dropped and counted."""
        if len(self._to_send) > _MOST_WAITING_BYTES:
            self._counts["send_refused"] += count
            count = 0
        self._write(b"".join(frame_line(frame) for frame in frames[:count]))
        self._counts["sent"] += count

    def receive(self, into: NDArray[np.void], start: int = 0) -> int:
        """Read what has arrived; lines that do not fit stay for the next call."""
        if self._to_send:
            self._write(b"")
        try:
            self._line += os.read(self._descriptor, 65536)
        except BlockingIOError:
            pass
        except OSError as error:
            raise LinkError(f"{self.text}: the device is gone: {error.strerror}") from error
        now_ns = time.time_ns()
        begin = start
        while start < len(into):
            end = self._line.find(b"\r")
            if end < 0:
                break
            line = bytes(self._line[:end])
            del self._line[: end + 1]
            self._counts["malformed"] += line.count(b"\a")
            record = into[start]
            if read_line(line.lstrip(b"\a"), record):
                record["tick"], record["timestamp_ns"] = 0, now_ns
                record["channel"], record["sender"] = 0, self.peer_sender
                start += 1
        self._counts["received"] += start - begin
        return start - begin

    def wait(self, timeout_s: float) -> bool:
        """Sleep until the line has something to read."""
        return self._poller.wait(timeout_s)

    def statistics(self) -> dict[str, int | str]:
        """Counts since the link was opened; an adapter does not tell its overflows."""
        return {**self._counts, "timestamp_source": "user space"}

    def close(self) -> None:
        """Close the CAN channel and the serial device."""
        if self._serial.is_open:
            with contextlib.suppress(OSError):  # unplugged: there is no channel to close
                os.write(self._descriptor, b"C\r")
            self._serial.close()


def _open_port(port: str, baud_rate: int):  # type: ignore[no-untyped-def] # pyserial has no types
    import serial

    try:
        return serial.Serial(port, baudrate=baud_rate, timeout=0, write_timeout=0, exclusive=True)
    except (serial.SerialException, OSError, ValueError) as error:
        raise _port_error(port, error) from error


def _port_error(port: str, error: Exception) -> LinkError:
    number = getattr(error, "errno", None)
    without = "or run without: --link udp"
    if number in (errno.EACCES, errno.EPERM):
        mend = f"join the group that owns it: sudo usermod -aG $(stat -c %G {port}) $USER; log in again\n{without}"
        return LinkError(f"{port}: no permission to open the serial device", mend=mend)
    if number in (errno.ENOENT, errno.ENXIO, errno.ENODEV):
        mend = f"plug it in and look: ls -l /dev/serial/by-id/ /dev/ttyUSB* /dev/ttyACM*\n{without}"
        return LinkError(f"{port}: no such serial device", mend=mend)
    if number in (errno.EBUSY, errno.EAGAIN):
        return LinkError(f"{port}: in use by another program", mend=f"find it: fuser -v {port}\n{without}")
    return LinkError(f"{port}: not usable as a serial device: {error}", mend=without)
