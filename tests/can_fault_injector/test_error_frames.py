"""SocketCAN error frames of model conditions, byte for byte; what candump prints of them is in the same table.

The bytes follow from linux/can/error.h (classes, types, locations) and the SJA1000's segment codes; the table
``error_frames.json`` is checked against a real candump by ``tests/vcan/test_error_frames.py``.
"""

import json
from collections.abc import Callable
from pathlib import Path

import pytest

from can_fault_injector import Bus, Disturbance, Frame, Node
from can_fault_injector.error_frames import (
    CONTROLLER_CONDITIONS,
    COUNTERS,
    WIRES,
    ErrorFrame,
    arbitration_bit,
    controller_frame,
    error_frames,
    location,
    wire_frame,
)

TABLE = json.loads((Path(__file__).parent / "error_frames.json").read_text(encoding="utf-8"))
STANDARD, EXTENDED = Frame(0x2AA, b"\x55\x0f"), Frame(0x0AAA5555, b"\x55", extended=True)
FD = Frame(0x2AA, b"\x55", fd=True)
IDLE = 4

Case = Callable[[], ErrorFrame]
CASES: dict[str, Case] = {}


def case(name: str) -> Callable[[Case], Case]:
    def keep(function: Case) -> Case:
        CASES[name] = function
        return function

    return keep


def first(
    node: str,
    *disturbances: Disturbance,
    frame: Frame | None = STANDARD,
    number: int = 0,
    bits: int = 400,
    sender: dict[str, int] | None = None,
    receiver: dict[str, int] | None = None,
    others: tuple[str, ...] = ("witness",),
) -> ErrorFrame:
    """The error frame of that number which a node reports while a frame is sent under disturbances."""
    bus = Bus([Node("sender", **(sender or {})), Node("receiver", **(receiver or {})), *others])  # type: ignore[arg-type]
    bus.run(IDLE)
    if frame is not None:
        bus.send("sender", frame)
    for disturbance in disturbances:
        bus.disturb(disturbance)
    bus.run(bits)
    return error_frames(bus.events, node)[number][1]


def at(node: str, action: str, place: str | int, **settings: object) -> Disturbance:
    return Disturbance(action, place, tap="receive", node=node, **settings)  # type: ignore[arg-type]


@case("sender cannot send a dominant data bit")
def _() -> ErrorFrame:
    return first("sender", at("sender", "recessive", "data.0"))


@case("sender cannot send a recessive data bit")
def _() -> ErrorFrame:
    return first("sender", at("sender", "dominant", "data.1"))


@case("sender finds its CRC delimiter dominant")
def _() -> ErrorFrame:
    return first("sender", at("sender", "dominant", "crc_del"))


@case("nobody acknowledges")
def _() -> ErrorFrame:
    return first("sender", at("sender", "recessive", "ack_slot"))


@case("receiver: stuff error in bits 10 to 3 of the identifier")
def _() -> ErrorFrame:
    return first("receiver", at("receiver", "dominant", "id.0", length=6), frame=Frame(0x400, b""))


@case("receiver: stuff error in bits 17 to 13 of an extended identifier")
def _() -> ErrorFrame:
    return first("receiver", at("receiver", "recessive", "srr", length=7), frame=EXTENDED)


@case("receiver: stuff error in bits 12 to 5 of an extended identifier")
def _() -> ErrorFrame:
    return first("receiver", at("receiver", "dominant", "id_ext.2", length=6), frame=EXTENDED)


@case("receiver: stuff error in the data")
def _() -> ErrorFrame:
    return first("receiver", at("receiver", "recessive", "data.1", length=6))


@case("receiver: CRC error")
def _() -> ErrorFrame:
    return first("receiver", at("receiver", "flip", "data.3"))


@case("receiver: form error in the CRC delimiter")
def _() -> ErrorFrame:
    return first("receiver", at("receiver", "dominant", "crc_del"))


@case("receiver: form error in the ACK delimiter")
def _() -> ErrorFrame:
    return first("receiver", at("receiver", "dominant", "ack_del"))


@case("receiver: form error in EOF")
def _() -> ErrorFrame:
    return first("receiver", at("receiver", "dominant", "eof.3"))


@case("receiver: fixed stuff bit of CAN FD")
def _() -> ErrorFrame:
    return first("receiver", at("receiver", "flip", "fixed_stuff.2"), frame=FD)


@case("receiver cannot send its dominant acknowledge bit")
def _() -> ErrorFrame:
    return first("receiver", at("receiver", "recessive", "ack_slot"))


@case("receiver: bit error in its active error flag")
def _() -> ErrorFrame:
    return first("receiver", at("receiver", "flip", "data.3"), at("receiver", "recessive", "active_flag.2"), number=1)


@case("receiver: form error in the error delimiter")
def _() -> ErrorFrame:
    disturbed = at("receiver", "dominant", "error_delimiter.3", reference="receiver")
    return first("receiver", at("receiver", "flip", "data.3"), disturbed, number=1)


@case("receiver: dominant last bit of EOF, overload")
def _() -> ErrorFrame:
    return first("receiver", at("receiver", "dominant", "eof.6"))


@case("receiver: dominant first bit of the intermission, overload")
def _() -> ErrorFrame:
    return first("receiver", at("receiver", "dominant", "intermission.0"))


@case("receiver: bit error in its overload flag")
def _() -> ErrorFrame:
    return first(
        "receiver",
        at("receiver", "dominant", "intermission.0"),
        at("receiver", "recessive", "overload_flag.1", reference="receiver"),
        number=1,
    )


@case("arbitration lost at bit 5 of the identifier")
def _() -> ErrorFrame:
    return _lost(Frame(0x2A0 | 0x40), Frame(0x2A0))


@case("arbitration lost at RTR")
def _() -> ErrorFrame:
    return _lost(Frame(0x123, remote=True), Frame(0x123))


@case("arbitration lost at IDE")
def _() -> ErrorFrame:
    return _lost(Frame(0x123 << 18, extended=True), Frame(0x123, remote=True))


@case("arbitration lost at the last bit of an extended identifier")
def _() -> ErrorFrame:
    return _lost(Frame(0x0AAA5555, extended=True), Frame(0x0AAA5554, extended=True))


def _lost(loser: Frame, winner: Frame) -> ErrorFrame:
    bus = Bus(["loser", "winner"])
    bus.send("loser", loser)
    bus.send("winner", winner)
    bus.run(100)
    return error_frames(bus.events, "loser")[0][1]


@case("warning level of the sender")
def _() -> ErrorFrame:
    return first("sender", at("sender", "recessive", "data.0"), sender={"transmit_errors": 90}, number=1)


@case("warning level of the receiver")
def _() -> ErrorFrame:
    return first("receiver", at("receiver", "flip", "data.3"), receiver={"receive_errors": 95}, number=1)


@case("sender turns error passive")
def _() -> ErrorFrame:
    return first("sender", at("sender", "recessive", "data.0"), sender={"transmit_errors": 125}, number=1)


@case("receiver turns error passive")
def _() -> ErrorFrame:
    return first("receiver", at("receiver", "flip", "data.3"), receiver={"receive_errors": 127}, number=1)


@case("sender becomes error active again, still warned")
def _() -> ErrorFrame:
    return first("sender", sender={"transmit_errors": 128})


@case("sender leaves the warning level")
def _() -> ErrorFrame:
    return first("sender", sender={"transmit_errors": 96})


@case("sender goes bus-off")
def _() -> ErrorFrame:
    return first("sender", at("sender", "recessive", "data.0"), sender={"transmit_errors": 250}, number=1)


@case("sender returns from bus-off")
def _() -> ErrorFrame:
    return first("sender", frame=None, sender={"transmit_errors": 256}, bits=1500)


for _condition in CONTROLLER_CONDITIONS:
    CASES[_condition.replace("_", " ")] = lambda condition=_condition: controller_frame(condition)  # type: ignore[misc]
for _wire in WIRES:
    CASES[_wire.replace("_", " ")] = lambda fault=_wire: wire_frame(fault, 8, 1)  # type: ignore[misc]


@pytest.mark.parametrize("name", CASES)
def test_condition_gives_these_bytes(name: str) -> None:
    frame = CASES[name]()
    assert f"{frame.can_id:08X}#{frame.data.hex().upper()}" == TABLE[name]["frame"]


def test_table_has_every_case_and_nothing_else() -> None:
    assert list(TABLE) == list(CASES)
    assert len({row["frame"] for row in TABLE.values()}) >= 20


def test_document_shows_the_same_bytes() -> None:
    text = (Path(__file__).parents[2] / "docs" / "can_error_frames.md").read_text(encoding="utf-8")
    for name, row in TABLE.items():
        identifier, _, data = row["frame"].partition("#")
        shown = " ".join(data[i : i + 2] for i in range(0, 16, 2))
        assert f"| {name} | `{identifier}` | `{shown}` |" in text


@pytest.mark.parametrize(
    ("place", "extended", "code"),
    [
        ("id.0", False, 0x02),
        ("id.7", False, 0x02),
        ("id.8", False, 0x06),
        ("id.10", True, 0x06),
        ("id_ext.0", True, 0x07),
        ("id_ext.4", True, 0x07),
        ("id_ext.5", True, 0x0F),
        ("id_ext.12", True, 0x0F),
        ("id_ext.13", True, 0x0E),
        ("id_ext.17", True, 0x0E),
        ("rtr.0", False, 0x04),
        ("rtr.0", True, 0x0C),
        ("r1.0", True, 0x0D),
        ("r0.0", False, 0x09),
        ("brs.0", False, 0x09),
        ("stuff_count.2", False, 0x08),
        ("passive_flag.0", False, 0x16),
        ("error_delimiter.0", False, 0x13),
        ("error_delimiter.1", False, 0x17),
        ("suspend.3", False, 0x00),
    ],
)
def test_locations_of_linux_can_error_h(place: str, extended: bool, code: int) -> None:
    assert location(place, extended) == code


def test_arbitration_bits_count_from_sof_without_stuff_bits() -> None:
    assert [arbitration_bit(place, True) for place in ("id.0", "rtr.0", "ide.0", "id_ext.0", "id_ext.17")] == [
        1,
        32,
        13,
        14,
        31,
    ]
    assert arbitration_bit("rtr.0", False) == 12


def test_counters_above_a_byte_show_as_255_and_may_be_declared() -> None:
    frame = wire_frame("can_h_open", 256, 300)
    assert frame.data[6:] == b"\xff\xff"
    assert frame.with_counter_class().can_id == frame.can_id | COUNTERS


def test_every_crossing_of_the_warning_level_and_the_passive_limit_is_reported_once() -> None:
    """A receiver that sees dominant bits without end counts 8 for every 8 of them (FC06a): 80, 81, 89, 97, …, 129."""
    bus = Bus([Node("receiver", receive_errors=80)])
    bus.drive([0] * 80, IDLE)
    bus.run(100)
    states = [(frame.data[1], frame.data[7]) for _, frame in error_frames(bus.events, "receiver") if frame.classes == 4]
    assert states == [(0x04, 97), (0x10, 129)]
    assert error_frames(bus.events, "nobody") == []
