"""What is left of the conformance clauses: corrupted delimiters of senders and passive nodes, starts after an error."""

import pytest

from can_fault_injector import Bus, Disturbance, Frame, Node

FRAME = Frame(0x2AA, b"\x55\x0f")
NAMES = list(FRAME.bit_names())
START = 4
ERROR = START + NAMES.index("data.0")
PASSIVE = 130


def stream(frame: Frame, acknowledged: bool) -> list[int]:
    bits = [int(bit) for bit in frame.bits()]
    bits[list(frame.bit_names()).index("ack_slot.0")] = 0 if acknowledged else 1
    return bits


def sending(**settings: object) -> Bus:
    bus = Bus([Node("node", **settings)])  # type: ignore[arg-type]
    bus.run(START)
    bus.send("node", FRAME)
    bus.disturb(Disturbance("dominant", "ack_slot", repeat=-1))
    return bus


@pytest.mark.parametrize("errors", [0, PASSIVE])
@pytest.mark.parametrize("bit", range(2, 8))
def test_fc03_sender_finds_its_error_delimiter_corrupted(errors: int, bit: int) -> None:
    bus = sending(transmit_errors=errors)
    bus.disturb(Disturbance("flip", "data.0"))
    bus.disturb(Disturbance("dominant", f"error_delimiter.{bit - 1}"))
    bus.run(600, until_idle=True)
    assert bus.nodes["node"].errors == ["bit", "form"]
    assert bus.nodes["node"].counter_steps[:2] == [(ERROR, errors + 8, 0), (ERROR + 6 + bit, errors + 16, 0)]


@pytest.mark.parametrize("bit", range(2, 8))
def test_fc03_sender_finds_its_overload_delimiter_corrupted(bit: int) -> None:
    bus = sending(transmit_errors=1)
    bus.disturb(Disturbance("dominant", "intermission.0"))
    bus.disturb(Disturbance("dominant", f"overload_delimiter.{bit - 1}"))
    bus.run(600, until_idle=True)
    end = START + len(NAMES)
    assert bus.nodes["node"].counter_steps == [(end - 1, 0, 0), (end + 6 + bit, 8, 0)]


@pytest.mark.parametrize("bit", range(2, 8))
def test_fc01b_passive_receiver_finds_its_error_delimiter_corrupted(bit: int) -> None:
    bus = Bus([Node("node", receive_errors=PASSIVE)])
    bus.drive([*[0] * 6, *[1] * (6 + bit - 1), 0], START)
    bus.run(200)
    first = START + 5
    assert bus.nodes["node"].counter_steps == [(first, 0, PASSIVE + 1), (first + 6 + bit, 0, PASSIVE + 2)]


@pytest.mark.parametrize("errors", [0, PASSIVE])
def test_im01_receiver_takes_a_frame_from_the_third_intermission_bit_after_an_error(errors: int) -> None:
    bus = Bus([Node("node", receive_errors=errors)])
    bus.drive([*[0] * 6, *[1] * (6 + 8 + 2), *stream(FRAME, acknowledged=False)], START)
    bus.run(300)
    assert bus.nodes["node"].received == [FRAME]


def test_im01_sender_starts_from_the_third_intermission_bit_after_an_error() -> None:
    bus = sending()
    bus.disturb(Disturbance("flip", "data.0"))
    bus.disturb(Disturbance("dominant", "intermission.2"))
    bus.run(600, until_idle=True)
    assert [event.bit for event in bus.events if event.kind == "started"] == [START, ERROR + 6 + 8 + 3]
    assert bus.nodes["node"].transmit_errors == 7


def test_im02_passive_sender_takes_a_frame_from_the_third_intermission_bit_after_an_error() -> None:
    other = Frame(0x700, b"\x12")
    bus = sending(transmit_errors=PASSIVE)
    bus.disturb(Disturbance("flip", "data.0"))
    bus.drive(stream(other, acknowledged=False), ERROR + 6 + 8 + 3)
    bus.run(600, until_idle=True)
    assert bus.nodes["node"].received == [other]


@pytest.mark.parametrize("length", range(9))
@pytest.mark.parametrize("extended", [False, True])
def test_every_identifier_bit_and_length_is_sent_and_received(extended: bool, length: int) -> None:
    width = 29 if extended else 11
    identifiers = [0, (1 << width) - 1, *(1 << bit for bit in range(width))]
    frames = [Frame(identifier, bytes(range(length)), extended=extended) for identifier in identifiers]
    bus = Bus(["a", "b"], trace=False)
    for frame in frames:
        bus.send("a", frame)
    bus.run(20_000, until_idle=True)
    assert bus.nodes["b"].received == frames
    assert bus.nodes["a"].errors == bus.nodes["b"].errors == []


EXTENDED = Frame(0x0AAA5555, b"\x55\x0f", extended=True)


@pytest.mark.parametrize("name", [n for n in EXTENDED.bit_names() if n.startswith(("id_ext", "dlc", "data", "crc."))])
def test_be01_mismatch_in_an_extended_frame(name: str) -> None:
    position = list(EXTENDED.bit_names()).index(name)
    bus = Bus(["sender", "receiver"])
    bus.send("sender", EXTENDED)
    bus.disturb(Disturbance("flip", name, tap="receive", node="sender"))
    bus.run(position + 1)
    kind = bus.events[-1].kind
    lost = name.startswith("id_ext") and EXTENDED.bits()[position] == 1
    assert (kind, bus.events[-1].error) == (("arbitration_lost", "") if lost else ("error", "bit"))


def test_fd09_frame_after_a_protocol_exception_needs_enough_idle() -> None:
    """Eleven recessive bits end the exception: a frame after ten is not acknowledged, one after eleven is."""
    fd, classic = Frame(0x123, b"\x01", fd=True), Frame(0x123, b"\x01")
    for idle, accepted in [(10, []), (11, [classic])]:
        levels = stream(fd, acknowledged=True)
        before = len(levels) - 8  # the acknowledge slot is the last dominant bit, eight recessive bits follow it
        bus = Bus([Node("node", fd="tolerant")])
        bus.drive([*levels, *[1] * (idle - 8), *stream(classic, acknowledged=False)], START)
        bus.run(400)
        assert levels[before - 1] == 0
        assert bus.nodes["node"].received == accepted


@pytest.mark.parametrize("extra", range(20))
def test_fc06_and_fc06a_dominant_bits_after_the_overload_flag_of_a_sender(extra: int) -> None:
    bus = sending()
    end = START + len(NAMES)
    bus.disturb(Disturbance("dominant", end, length=1 + 6 + extra))
    bus.run(600, until_idle=True)
    assert bus.nodes["node"].counter_steps == [(end + 6 + 8 * i, 8 * i, 0) for i in range(1, extra // 8 + 1)]
