"""Reading a socket without waiting, with what the kernel knows of each datagram: its time and what was dropped."""

import errno
import socket
import struct

SO_TIMESTAMPNS = 35
SO_TIMESTAMPING = 37
SO_RXQ_OVFL = 40
SO_RCVBUFFORCE = 33

RX_HARDWARE, RX_SOFTWARE, SOFTWARE, RAW_HARDWARE = 1 << 2, 1 << 3, 1 << 4, 1 << 6
"""Flags SOF_TIMESTAMPING_* of SO_TIMESTAMPING."""

RECEIVE_BUFFER_BYTES = 4 << 20
ANCILLARY_BYTES = socket.CMSG_SPACE(48) + socket.CMSG_SPACE(4)

_TIMESPEC = struct.Struct("@ll")
_THREE_TIMESPECS = struct.Struct("@llllll")
_COUNT = struct.Struct("@I")


def enlarge_receive_buffer(sock: socket.socket) -> int:
    """Ask for :data:`RECEIVE_BUFFER_BYTES` (a burst of 3 000 frames must fit); returns what the kernel granted."""
    try:
        sock.setsockopt(socket.SOL_SOCKET, SO_RCVBUFFORCE, RECEIVE_BUFFER_BYTES)
    except OSError:  # needs CAP_NET_ADMIN; without, the limit of net.core.rmem_max holds
        sock.setsockopt(socket.SOL_SOCKET, socket.SO_RCVBUF, RECEIVE_BUFFER_BYTES)
    return sock.getsockopt(socket.SOL_SOCKET, socket.SO_RCVBUF)


def ask_for_overflow_counts(sock: socket.socket) -> None:
    """Have every received datagram carry the number of those dropped so far."""
    sock.setsockopt(socket.SOL_SOCKET, SO_RXQ_OVFL, 1)


def ask_for_timestamps(sock: socket.socket, *, hardware: bool = False) -> None:
    """Have every received datagram carry the kernel's, and where the driver can, the hardware's time."""
    if hardware:
        flags = RX_HARDWARE | RAW_HARDWARE | RX_SOFTWARE | SOFTWARE
        try:
            sock.setsockopt(socket.SOL_SOCKET, SO_TIMESTAMPING, flags)
            return
        except OSError as error:
            if error.errno not in (errno.EINVAL, errno.ENOPROTOOPT):
                raise
    sock.setsockopt(socket.SOL_SOCKET, SO_TIMESTAMPNS, 1)


class Ancillary:
    """What the control messages of one received datagram say.

    Attributes
    ----------
    software_ns, hardware_ns : int
        Time of reception by the kernel's and by the hardware's clock, 0 if there is none.
    dropped : int
        Datagrams that the kernel has dropped on this socket so far, for want of buffer space.
    """

    def __init__(self) -> None:
        self.software_ns = self.hardware_ns = self.dropped = 0

    def read(self, messages: list[tuple[int, int, bytes]]) -> None:
        """Take in the control messages that came with a datagram."""
        self.software_ns = self.hardware_ns = 0
        for level, kind, data in messages:
            if level != socket.SOL_SOCKET:
                continue
            if kind == SO_TIMESTAMPNS:
                seconds, nanoseconds = _TIMESPEC.unpack(data)
                self.software_ns = seconds * 1_000_000_000 + nanoseconds
            elif kind == SO_TIMESTAMPING:
                software_s, software_ns, _, _, hardware_s, hardware_ns = _THREE_TIMESPECS.unpack(data)
                self.software_ns = software_s * 1_000_000_000 + software_ns
                self.hardware_ns = hardware_s * 1_000_000_000 + hardware_ns
            elif kind == SO_RXQ_OVFL:
                (self.dropped,) = _COUNT.unpack(data)


class HardwareClock:
    """Maps the clock of a CAN controller to CLOCK_REALTIME.

    The kernel's stamp of a frame is never earlier than its true time, so the smallest difference between the two clocks
    is the best one; it may grow by ``DRIFT`` per second, the worst of a crystal, to follow a slower hardware clock.

    Attributes
    ----------
    offset_ns : int or None
        CLOCK_REALTIME minus hardware clock, None before the first stamp.
    """

    DRIFT = 100e-6

    def __init__(self) -> None:
        self.offset_ns: int | None = None
        self._last_ns = 0

    def realtime_ns(self, hardware_ns: int, software_ns: int) -> int:
        """CLOCK_REALTIME of a frame that has both stamps."""
        difference = software_ns - hardware_ns
        if self.offset_ns is None:
            self.offset_ns = difference
        else:
            grown = self.offset_ns + int((software_ns - self._last_ns) * self.DRIFT)
            self.offset_ns = min(grown, difference)
        self._last_ns = software_ns
        return hardware_ns + self.offset_ns
