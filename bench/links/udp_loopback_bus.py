"""The link ``udp_loopback`` for python-can: ``can.Bus(interface="udp_loopback", channel="OWN_PORT:PEER_PORT")``."""

import select
import socket
import time
from typing import Any

import can
from can.interfaces.udp_multicast.utils import is_msgpack_installed, pack_message, unpack_message


class UdpLoopbackBus(can.BusABC):  # type: ignore[misc]
    """Unicast CAN bus between two ports of 127.0.0.1.

    Parameters
    ----------
    channel : str
        Own and peer's port, ``"20001:20002"``.
    **kwargs
        Passed to :class:`can.BusABC`.
    """

    def __init__(self, channel: str, **kwargs: Any) -> None:
        is_msgpack_installed()
        try:
            own, peer = (int(port) for port in str(channel).split(":"))
        except ValueError:
            raise can.CanInitializationError(f"channel {channel!r}: wanted OWN_PORT:PEER_PORT") from None
        self.channel_info = f"udp_loopback: 127.0.0.1 ports {own} and {peer}"
        self._peer = ("127.0.0.1", peer)
        self._socket = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
        try:
            self._socket.bind(("127.0.0.1", own))
        except OSError as error:
            self._socket.close()
            raise can.CanInitializationError(f"port {own}: {error.strerror}") from error
        super().__init__(channel=channel, **kwargs)

    def _recv_internal(self, timeout: float | None) -> tuple[can.Message | None, bool]:
        ready, _, _ = select.select([self._socket], [], [], timeout)
        if not ready:
            return None, False
        try:
            datagram = self._socket.recv(4096)
            return unpack_message(datagram, replace={"timestamp": time.time()}, check=True), False
        except Exception as error:
            raise can.CanOperationError("could not unpack a received message") from error

    def send(self, msg: can.Message, timeout: float | None = None) -> None:
        """Send one frame; loopback has room or drops it, so there is nothing to wait for."""
        try:
            self._socket.sendto(pack_message(msg), self._peer)
        except OSError as error:
            raise can.CanOperationError("failed to send") from error

    def fileno(self) -> int:
        """Descriptor of the socket."""
        return self._socket.fileno()

    def shutdown(self) -> None:
        """Close the socket."""
        super().shutdown()
        self._socket.close()
