"""CAN over UDP on this machine: multicast as python-can's ``udp_multicast``, or unicast where no multicast route is.

The multicast link sends with hop limit 0, so no frame leaves the machine, and every program that joins the group and
port (``can.Bus(interface="udp_multicast", channel=GROUP, port=PORT, hop_limit=0)``) is on the bus. The loopback link
joins two ports of 127.0.0.1; ``can.Bus(interface="udp_loopback", channel="OWN:PEER")`` is the same bus for python-can.
"""

import ipaddress
import socket
import time

import numpy as np
from numpy.typing import NDArray

from bench.links.available import MULTICAST_ROUTE, aim_at_group, join_group
from bench.links.frame import new_frames
from bench.links.interface import Link, Poller
from bench.links.kernel_receive import (
    ANCILLARY_BYTES,
    Ancillary,
    ask_for_overflow_counts,
    ask_for_timestamps,
    enlarge_receive_buffer,
)
from bench.links.message_pack import SLOT_BYTES, pack_frames, stamp_bytes, unpack_any, unpack_frames
from signals.errors import InputError, LinkError

BATCH = 64

Address = tuple[str, int]


class DatagramLink(Link):
    """Frames as datagrams: one socket to send from, one to receive at.

    Parameters
    ----------
    kind, text, channel, role : str
        As in :class:`~bench.links.interface.Link`.
    sender : socket
        Connected to where frames go.
    receiver : socket
        Bound to where frames come.
    """

    def __init__(
        self, kind: str, text: str, channel: str, role: str, sender: socket.socket, receiver: socket.socket
    ) -> None:
        super().__init__(kind, text, (channel,), role, supports_lockstep=True)
        self._sender, self._receiver = sender, receiver
        self._own_address: Address = sender.getsockname()[:2]
        self._poller = Poller([receiver.fileno()])
        self._ancillary = Ancillary()
        self._out = np.zeros((BATCH, SLOT_BYTES), np.uint8)
        self._out_sizes = np.zeros(BATCH, np.int64)
        self._out_views = [row.data for row in self._out]
        self._in = np.zeros((BATCH, SLOT_BYTES), np.uint8)
        self._in_heads = np.zeros((BATCH, 2), np.int64)
        self._in_views = [[row.data] for row in self._in]
        self._strange = np.zeros(BATCH, np.int64)
        self._counts = dict.fromkeys(("sent", "received", "own_echoes", "send_refused", "malformed", "error_frames"), 0)
        self._warm_up()

    def _warm_up(self) -> None:
        """Compile now: the first frame of a run must not wait for it."""
        frame = new_frames(1)
        pack_frames(frame, 1, stamp_bytes(0), self._out, self._out_sizes)
        unpack_frames(self._out, self._in_heads, 1, 0, frame, 0, self._strange)

    def send(self, frames: NDArray[np.void], count: int) -> None:
        """Send one datagram per frame."""
        stamp = stamp_bytes(time.time_ns())
        for first in range(0, count, BATCH):
            size = min(BATCH, count - first)
            pack_frames(frames[first : first + size], size, stamp, self._out, self._out_sizes)
            for number in range(size):
                self._send_one(self._out_views[number][: self._out_sizes[number]])

    def _send_one(self, datagram: memoryview) -> None:
        try:
            try:
                self._sender.send(datagram)
            except ConnectionRefusedError:  # the kernel's answer to an earlier datagram: nobody listened then
                self._sender.send(datagram)
            self._counts["sent"] += 1
        except (BlockingIOError, ConnectionRefusedError):
            self._counts["send_refused"] += 1
        except OSError as error:
            raise LinkError(f"{self.text}: sending failed: {error.strerror}") from error

    def receive(self, into: NDArray[np.void], start: int = 0) -> int:
        """Read all waiting datagrams that fit."""
        begin = start
        while start < len(into):
            wanted = min(BATCH, len(into) - start)
            read = self._read(wanted)
            if read:
                start += self._unpack(read, into, start)
            if read < wanted:
                break
        return start - begin

    def _read(self, wanted: int) -> int:
        """Fill the slots with datagrams of others; returns their number."""
        number = 0
        receiver, ancillary = self._receiver, self._ancillary
        while number < wanted:
            try:
                size, messages, _, address = receiver.recvmsg_into(self._in_views[number], ANCILLARY_BYTES)
            except BlockingIOError:
                break
            except OSError as error:
                raise LinkError(f"{self.text}: receiving failed: {error.strerror}") from error
            if address[:2] == self._own_address:
                self._counts["own_echoes"] += 1
                continue
            ancillary.read(messages)
            self._in_heads[number] = size, ancillary.software_ns
            number += 1
        return number

    def _unpack(self, read: int, into: NDArray[np.void], start: int) -> int:
        """Turn datagrams into records; returns the number of frames."""
        others = unpack_frames(self._in, self._in_heads, read, self.peer_sender, into, start, self._strange)
        if others:
            read = self._unpack_strange(read, others, into[start : start + read])
        self._counts["received"] += read
        return read

    def _unpack_strange(self, read: int, others: int, records: NDArray[np.void]) -> int:
        """Read what another program packed in its own way, close the gaps that rubbish leaves."""
        keep = np.ones(read, np.bool_)
        for number in self._strange[:others]:
            datagram = bytes(self._in[number, : self._in_heads[number, 0]])
            keep[number] = unpack_any(datagram, records[number])
        good = int(keep.sum())
        records[:good] = records[keep]
        self._counts["malformed"] += read - good
        return good

    def wait(self, timeout_s: float) -> bool:
        """Sleep until a datagram has arrived."""
        return self._poller.wait(timeout_s)

    def statistics(self) -> dict[str, int | str]:
        """Counts since the link was opened."""
        return {**self._counts, "overflows": self._ancillary.dropped, "timestamp_source": "kernel"}

    def close(self) -> None:
        """Close the sockets."""
        self._sender.close()
        self._receiver.close()


def open_multicast(group: str, port: int, role: str) -> DatagramLink:
    """Join a multicast bus.

    Raises
    ------
    InputError
        If the group is no IPv4 multicast address or the port is none.
    LinkError
        If this machine has no route for multicast.
    """
    text = f"udp:{group}:{port}"
    try:
        usable = ipaddress.IPv4Address(group).is_multicast and 0 < port < 65536
    except ValueError:
        usable = False
    if not usable:
        raise InputError(f"link {text}: no multicast group and port", allowed="udp:239.192.0.1:20000 or just udp")
    sender, receiver = _two_sockets()
    try:
        aim_at_group(sender, group, port)
        join_group(receiver, group, port)
    except OSError as error:
        sender.close()
        receiver.close()
        raise LinkError(
            f"link {text}: no multicast on this machine: {error.strerror}",
            mend=f"add a route: {MULTICAST_ROUTE}\nor run without: --link udp_loopback",
        ) from error
    return DatagramLink("udp", text, f"{group}:{port}", role, sender, receiver)


def open_loopback(bench_port: int, ecu_port: int, role: str) -> DatagramLink:
    """Join a bus of two ports on 127.0.0.1; the ECU listens at the second.

    Raises
    ------
    LinkError
        If the port is taken.
    """
    text = f"udp_loopback:{bench_port}:{ecu_port}"
    own, peer = (ecu_port, bench_port) if role == "ecu" else (bench_port, ecu_port)
    sender, receiver = _two_sockets()
    try:
        receiver.bind(("127.0.0.1", own))
        sender.connect(("127.0.0.1", peer))
    except (OSError, OverflowError) as error:
        sender.close()
        receiver.close()
        reason = getattr(error, "strerror", None) or str(error)
        raise LinkError(f"link {text}: port {own}: {reason}", mend="use other ports, or just udp_loopback") from error
    return DatagramLink("udp_loopback", text, f"127.0.0.1:{bench_port}:{ecu_port}", role, sender, receiver)


def _two_sockets() -> tuple[socket.socket, socket.socket]:
    """Sending and receiving socket; two, so that own frames are known by the port they came from."""
    sender = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
    receiver = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
    sender.setblocking(False)
    receiver.setblocking(False)
    enlarge_receive_buffer(receiver)
    ask_for_overflow_counts(receiver)
    ask_for_timestamps(receiver)
    return sender, receiver
