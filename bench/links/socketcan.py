"""SocketCAN: one raw socket per channel, read without waiting, with the kernel's or the adapter's time stamps.

python-can's own receive sets only the kernel's stamp, knows no overflow count and makes an object of each frame; here a
frame is 16 (CAN FD: 72) bytes that compiled code moves into the records. Frames that this process sends do not come
back (CAN_RAW_RECV_OWN_MSGS stays off), those of other processes of this machine do.
"""

import errno
import re
import socket

import numpy as np
from numba import njit
from numpy.typing import NDArray

from bench.links.available import interface_is_up, is_virtual
from bench.links.frame import BIT_RATE_SWITCH, ERROR, EXTENDED, FD, FD_LENGTHS, REMOTE, new_frames
from bench.links.interface import Link, Poller
from bench.links.kernel_receive import (
    ANCILLARY_BYTES,
    Ancillary,
    HardwareClock,
    ask_for_overflow_counts,
    ask_for_timestamps,
    enlarge_receive_buffer,
)
from signals.errors import LinkError

BATCH = 64
CAN_MTU, CANFD_MTU = 16, 72

# linux/can.h
_EFF_FLAG, _RTR_FLAG, _ERR_FLAG = 1 << 31, 1 << 30, 1 << 29
_EFF_MASK, _SFF_MASK = (1 << 29) - 1, (1 << 11) - 1
_FD_BRS, _FD_FDF = 1, 4
_CAN_RAW_ERR_FILTER = 2

_LENGTHS = np.array(FD_LENGTHS, np.int64)


@njit(cache=True)
def pack_socket_frames(
    frames: NDArray[np.void], count: int, slots: NDArray[np.uint8], sizes: NDArray[np.int64]
) -> None:
    """Write ``struct can_frame`` or ``struct canfd_frame`` for each frame into ``slots`` of 72 bytes."""
    for i in range(count):
        frame, slot = frames[i], slots[i]
        flags = int(frame["flags"])
        word = int(frame["identifier"])
        word |= _EFF_FLAG if flags & EXTENDED else 0
        word |= _RTR_FLAG if flags & REMOTE else 0
        word |= _ERR_FLAG if flags & ERROR else 0
        for b in range(4):
            slot[b] = np.uint8((word >> (8 * b)) & 0xFF)
        slot[4:] = 0
        slot[4] = frame["length"]
        if flags & FD:
            slot[5] = np.uint8(_FD_FDF | (_FD_BRS if flags & BIT_RATE_SWITCH else 0))
        data = frame["data"]
        if not flags & REMOTE:
            for b in range(int(frame["length"])):
                slot[8 + b] = data[b]
        sizes[i] = CANFD_MTU if flags & FD else CAN_MTU


@njit(cache=True)
def unpack_socket_frames(
    slots: NDArray[np.uint8],
    heads: NDArray[np.int64],
    count: int,
    sender: int,
    channel: int,
    frames: NDArray[np.void],
    start: int,
) -> int:
    """Read structs into ``frames[start:]``; returns the number of error frames among them.

    ``heads`` has the size of each struct and the time of its reception, ns.
    """
    errors = 0
    for i in range(count):
        frame, slot = frames[start + i], slots[i]
        word = int(slot[0]) | int(slot[1]) << 8 | int(slot[2]) << 16 | int(slot[3]) << 24
        flags = FD if heads[i, 0] == CANFD_MTU else 0
        if flags and slot[5] & _FD_BRS:
            flags |= BIT_RATE_SWITCH
        flags |= EXTENDED if word & _EFF_FLAG else 0
        flags |= REMOTE if word & _RTR_FLAG else 0
        if word & _ERR_FLAG:
            flags |= ERROR
            errors += 1
        frame["tick"] = 0
        frame["timestamp_ns"] = heads[i, 1]
        frame["identifier"] = np.uint32(word & (_EFF_MASK if word & (_EFF_FLAG | _ERR_FLAG) else _SFF_MASK))
        frame["channel"] = np.uint8(channel)
        frame["flags"] = np.uint8(flags)
        frame["sender"] = np.uint8(sender)
        frame["length"] = slot[4]
        data = frame["data"]
        size = heads[i, 0] - 8
        for b in range(64):
            data[b] = slot[8 + b] if b < size else np.uint8(0)
    return errors


class _Channel:
    """One interface: its socket, stamps and counts."""

    def __init__(self, name: str) -> None:
        self.name = name
        self.socket = _open_socket(name)
        self.ancillary = Ancillary()
        self.clock = HardwareClock()
        self.hardware = False

    def stamp_ns(self) -> int:
        """Time of the frame whose control messages were read last."""
        ancillary = self.ancillary
        if ancillary.hardware_ns == 0:
            return ancillary.software_ns
        self.hardware = True
        return self.clock.realtime_ns(ancillary.hardware_ns, ancillary.software_ns)


class SocketCanLink(Link):
    """One or two SocketCAN interfaces.

    Parameters
    ----------
    interfaces : tuple of str
        Names such as ``("vcan0",)``; a frame's ``channel`` is the place in it.
    role : str
        "bench", "ecu" or "injector".

    Raises
    ------
    LinkError
        If the kernel has no CAN, an interface does not exist, is down or not permitted.
    """

    def __init__(self, interfaces: tuple[str, ...], role: str) -> None:
        text = f"socketcan:{','.join(interfaces)}"
        virtual = all(is_virtual(name) for name in interfaces)
        super().__init__("socketcan", text, interfaces, role, supports_lockstep=virtual)
        self._channels: list[_Channel] = []
        try:
            for name in interfaces:
                self._channels.append(_Channel(name))
        except LinkError:
            self.close()
            raise
        self._poller = Poller([channel.socket.fileno() for channel in self._channels])
        self._out = np.zeros((BATCH, CANFD_MTU), np.uint8)
        self._out_sizes = np.zeros(BATCH, np.int64)
        self._out_views = [row.data for row in self._out]
        self._in = np.zeros((BATCH, CANFD_MTU), np.uint8)
        self._in_heads = np.zeros((BATCH, 2), np.int64)
        self._in_views = [[row.data] for row in self._in]
        self._counts = dict.fromkeys(("sent", "received", "own_echoes", "send_refused", "malformed", "error_frames"), 0)
        self._warm_up()

    def _warm_up(self) -> None:
        """Compile now: the first frame of a run must not wait for it."""
        frame = new_frames(1)
        pack_socket_frames(frame, 1, self._out, self._out_sizes)
        unpack_socket_frames(self._out, self._in_heads, 1, 0, 0, frame, 0)

    def send(self, frames: NDArray[np.void], count: int) -> None:
        """Give each frame to the kernel; where the queue is full it is dropped and counted (ENOBUFS)."""
        for first in range(0, count, BATCH):
            size = min(BATCH, count - first)
            batch = frames[first : first + size]
            pack_socket_frames(batch, size, self._out, self._out_sizes)
            channels = batch["channel"]
            for number in range(size):
                self._send_one(self._channels[channels[number]], self._out_views[number][: self._out_sizes[number]])

    def _send_one(self, channel: _Channel, struct: memoryview) -> None:
        try:
            channel.socket.send(struct)
            self._counts["sent"] += 1
        except OSError as error:
            if error.errno not in (errno.ENOBUFS, errno.EAGAIN):
                raise _link_error(channel.name, error) from error
            self._counts["send_refused"] += 1

    def receive(self, into: NDArray[np.void], start: int = 0) -> int:
        """Read all waiting frames that fit, channel by channel."""
        begin = start
        for number, channel in enumerate(self._channels):
            while start < len(into):
                wanted = min(BATCH, len(into) - start)
                read = self._read(channel, wanted)
                if read:
                    self._counts["error_frames"] += unpack_socket_frames(
                        self._in, self._in_heads, read, self.peer_sender, number, into, start
                    )
                    start += read
                if read < wanted:
                    break
        self._counts["received"] += start - begin
        return start - begin

    def _read(self, channel: _Channel, wanted: int) -> int:
        number = 0
        while number < wanted:
            try:
                size, messages, _, _ = channel.socket.recvmsg_into(self._in_views[number], ANCILLARY_BYTES)
            except BlockingIOError:
                break
            except OSError as error:
                raise _link_error(channel.name, error) from error
            channel.ancillary.read(messages)
            self._in_heads[number] = size, channel.stamp_ns()
            number += 1
        return number

    def wait(self, timeout_s: float) -> bool:
        """Sleep until a frame has arrived on any channel."""
        return self._poller.wait(timeout_s)

    def statistics(self) -> dict[str, int | str]:
        """Counts since the link was opened."""
        hardware = bool(self._channels) and all(channel.hardware for channel in self._channels)
        return {
            **self._counts,
            "overflows": sum(channel.ancillary.dropped for channel in self._channels),
            "timestamp_source": "hardware" if hardware else "kernel",
        }

    def close(self) -> None:
        """Close the sockets."""
        for channel in self._channels:
            channel.socket.close()


def _open_socket(name: str) -> socket.socket:
    try:
        sock = socket.socket(socket.AF_CAN, socket.SOCK_RAW, socket.CAN_RAW)
    except OSError as error:
        raise _link_error(name, error) from error
    try:
        sock.setblocking(False)
        sock.setsockopt(socket.SOL_CAN_RAW, _CAN_RAW_ERR_FILTER, _EFF_MASK)
        sock.setsockopt(socket.SOL_CAN_RAW, socket.CAN_RAW_FD_FRAMES, 1)
        enlarge_receive_buffer(sock)
        ask_for_overflow_counts(sock)
        ask_for_timestamps(sock, hardware=True)
        sock.bind((name,))
        if not interface_is_up(name):
            raise OSError(errno.ENETDOWN, "the interface is down")
    except OSError as error:
        sock.close()
        raise _link_error(name, error) from error
    return sock


def _link_error(name: str, error: OSError) -> LinkError:
    up = f"sudo ip link set {name} up" + ("" if name.startswith("v") else " type can bitrate 500000")
    make = f"sudo ip link add {name} type vcan && {up}" if re.match(r"vx?can", name) else up
    without = "or run without: --link udp"
    if error.errno == errno.EAFNOSUPPORT:
        return LinkError(
            f"{name}: this kernel has no CAN (AF_CAN)",
            mend=f"sudo modprobe can-raw vcan, or in a CAN kernel: ci/can_kernel bench run …\n{without}",
        )
    if error.errno in (errno.ENODEV, errno.ENXIO):
        return LinkError(f"{name}: no such interface (AF_CAN is there)", mend=f"make it: {make}\n{without}")
    if error.errno == errno.ENETDOWN:
        return LinkError(f"{name}: the interface is down", mend=f"bring it up: {up}\n{without}")
    if error.errno in (errno.EPERM, errno.EACCES):
        return LinkError(f"{name}: not permitted", mend=f"run with CAP_NET_RAW, or outside the sandbox\n{without}")
    return LinkError(f"{name}: {error.strerror}", mend=f"look at: ip -details -statistics link show {name}")
