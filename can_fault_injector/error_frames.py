"""Error frames of SocketCAN: what a controller's driver would tell of what happened to a node of the bit model.

The codes are those of ``linux/can/error.h``. That header has no code for a CRC error (its location is the CRC
sequence), for BRS, ESI and res (reserved bit 0, in whose place they stand), for the stuff count (CRC sequence), nor
for flags and delimiters: these have the segment codes of the SJA1000, which its driver passes on and candump prints.
Bytes 6 and 7 always hold the counters; the class bit that says so is left out, because candump refuses to decode a
frame with that bit up to can-utils 2020.11. ``docs/can_error_frames.md`` has the whole table.
"""

from collections.abc import Iterable
from typing import NamedTuple

from can_fault_injector.bus_records import Event
from can_fault_injector.node import PASSIVE_LIMIT, WARNING_LIMIT

ERROR_FLAG = 0x20000000
TX_TIMEOUT, LOST_ARBITRATION, CONTROLLER, PROTOCOL, TRANSCEIVER = 0x001, 0x002, 0x004, 0x008, 0x010
NO_ACKNOWLEDGE, BUS_OFF, BUS_ERROR, RESTARTED, COUNTERS = 0x020, 0x040, 0x080, 0x100, 0x200

RX_OVERFLOW, TX_OVERFLOW, RX_WARNING, TX_WARNING, RX_PASSIVE, TX_PASSIVE, ACTIVE = (1 << i for i in range(7))
FORM, STUFF, BIT0, BIT1, OVERLOAD, TRANSMISSION = 0x02, 0x04, 0x08, 0x10, 0x20, 0x80

_LOCATIONS = {
    "sof": 0x03,
    "ide": 0x05,
    "r0": 0x09,
    "res": 0x09,
    "brs": 0x09,
    "esi": 0x09,
    "r1": 0x0D,
    "dlc": 0x0B,
    "data": 0x0A,
    "stuff_count": 0x08,
    "crc": 0x08,
    "crc_del": 0x18,
    "ack_slot": 0x19,
    "ack_del": 0x1B,
    "eof": 0x1A,
    "intermission": 0x12,
    "active_flag": 0x11,
    "passive_flag": 0x16,
    "overload_flag": 0x1C,
    "error_delimiter": 0x17,
    "overload_delimiter": 0x17,
}
_STANDARD_PARTS = ((8, 0x02), (11, 0x06))
_EXTENSION_PARTS = ((5, 0x07), (13, 0x0F), (18, 0x0E))
"""Codes of the parts of the identifier, each up to before a bit."""
_ARBITRATION_STARTS = {"id": 1, "ide": 13, "id_ext": 14}

WIRES = {
    "can_h_open": 0x04,
    "can_h_to_battery": 0x05,
    "can_h_to_supply": 0x06,
    "can_h_to_ground": 0x07,
    "can_l_open": 0x40,
    "can_l_to_battery": 0x50,
    "can_l_to_supply": 0x60,
    "can_l_to_ground": 0x70,
    "can_h_to_can_l": 0x80,
    "both_open": 0x44,
}
"""Codes of a transceiver that reports the state of its wires."""
CONTROLLER_CONDITIONS = {
    "receive_overflow": (CONTROLLER, RX_OVERFLOW),
    "transmit_overflow": (CONTROLLER, TX_OVERFLOW),
    "transmit_timeout": (TX_TIMEOUT, 0),
}
"""What a driver reports without the bus: class and byte 1."""


class ErrorFrame(NamedTuple):
    """An error frame: classes in the identifier (without ``ERROR_FLAG``) and eight bytes, see linux/can/error.h."""

    classes: int
    data: bytes

    @property
    def can_id(self) -> int:
        """Identifier as a raw socket has it."""
        return self.classes | ERROR_FLAG

    def with_counter_class(self) -> "ErrorFrame":
        """The same with the class bit that declares bytes 6 and 7 (CAN_ERR_CNT), for readers that know it."""
        return self._replace(classes=self.classes | COUNTERS)


def _frame(classes: int, counts: tuple[int, int], **at: int) -> ErrorFrame:
    data = bytearray(8)
    for name, value in at.items():
        data[int(name[1:])] = value
    data[6], data[7] = (min(count, 255) for count in counts)
    return ErrorFrame(classes, bytes(data))


def location(place: str, extended: bool) -> int:
    """Code of the location of a bit (byte 3); 0 for places that have none."""
    field, _, number = place.partition(".")
    if field == "id":
        return next(code for end, code in _STANDARD_PARTS if int(number) < end)
    if field == "id_ext":
        return next(code for end, code in _EXTENSION_PARTS if int(number) < end)
    if field == "rtr":
        return 0x0C if extended else 0x04
    if field == "error_delimiter" and number == "0":
        return 0x13  # dominant bits after a flag are tolerated, and counted
    return _LOCATIONS.get(field, 0)


def arbitration_bit(place: str, extended: bool) -> int:
    """Number of a bit of the arbitration field without stuff bits, SOF is 0 (byte 0)."""
    field, _, number = place.partition(".")
    if field == "rtr":
        return 32 if extended else 12
    return _ARBITRATION_STARTS[field] + int(number)


def _level_of(count: int) -> int:
    """0 below the warning level, 1 from it on, 2 error passive."""
    return (count >= WARNING_LIMIT) + (count >= PASSIVE_LIMIT)


def _state(counts: tuple[int, int]) -> ErrorFrame:
    """New state of the controller; as in the kernel's ``can_change_state`` the worse counter is named, or both."""
    transmit, receive = (_level_of(count) for count in counts)
    worse = max(transmit, receive)
    if worse == 0:
        return _frame(CONTROLLER, counts, _1=ACTIVE)
    of_transmitter, of_receiver = ((TX_WARNING, RX_WARNING), (TX_PASSIVE, RX_PASSIVE))[worse - 1]
    flags = (of_transmitter if transmit >= receive else 0) | (of_receiver if receive >= transmit else 0)
    return _frame(CONTROLLER, counts, _1=flags)


def _error(event: Event, counts: tuple[int, int]) -> ErrorFrame:
    classes = PROTOCOL | BUS_ERROR
    role = TRANSMISSION if event.transmitter else 0
    where = location(event.information, event.extended)
    if event.error == "ack":
        return _frame(classes | NO_ACKNOWLEDGE, counts, _2=role, _3=_LOCATIONS["ack_slot"])
    if event.error == "crc":
        return _frame(classes, counts, _2=role, _3=_LOCATIONS["crc"])
    if event.error == "bit":
        return _frame(classes, counts, _2=role | (BIT0 if event.level else BIT1), _3=where)
    return _frame(classes, counts, _2=role | {"stuff": STUFF, "form": FORM}[event.error], _3=where)


def error_frame(event: Event) -> ErrorFrame | None:
    """Error frame that tells of an event of a node, or None for one that a driver keeps for itself.

    Receptions, transmissions, beginnings and protocol exceptions are none. A node that leaves the passive state or the
    warning level reports its new state.
    """
    counts = event.transmit_errors, event.receive_errors
    if event.kind == "error":
        return _error(event, counts)
    if event.kind == "overload":
        return _frame(PROTOCOL, counts, _2=OVERLOAD, _3=location(event.information, event.extended))
    if event.kind == "arbitration_lost":
        return _frame(LOST_ARBITRATION, counts, _0=arbitration_bit(event.information, event.extended))
    if event.kind in ("warning", "warning_over", "error_passive", "error_active"):
        return _state(counts)
    if event.kind == "bus_off":
        return _frame(BUS_OFF, counts)
    if event.kind == "recovered":
        return _frame(RESTARTED, counts)
    return None


def error_frames(events: Iterable[Event], node: str) -> list[tuple[int, ErrorFrame]]:
    """Bit and error frame of everything that the driver of one node would report."""
    told = ((event.bit, error_frame(event)) for event in events if event.node == node)
    return [(bit, frame) for bit, frame in told if frame is not None]


def controller_frame(condition: str, transmit_errors: int = 0, receive_errors: int = 0) -> ErrorFrame:
    """Error frame of a condition of ``CONTROLLER_CONDITIONS``, which no bit shows."""
    classes, flags = CONTROLLER_CONDITIONS[condition]
    return _frame(classes | (CONTROLLER if flags else 0), (transmit_errors, receive_errors), _1=flags)


def wire_frame(fault: str, transmit_errors: int = 0, receive_errors: int = 0) -> ErrorFrame:
    """Error frame of a transceiver that found a wire fault of ``WIRES``."""
    return _frame(TRANSCEIVER, (transmit_errors, receive_errors), _4=WIRES[fault])
