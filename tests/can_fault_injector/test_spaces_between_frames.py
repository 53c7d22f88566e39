"""Overload frames, intermission, suspended sending and idle (rules OV, IM, SU, ID), and bit errors (BE) of a sender."""

import pytest
from bit_tester import BITS, FRAME, NAMES, PASSIVE, START, at, dominant, kinds, node, sending, started, stream

from can_fault_injector import Bus, Disturbance, Frame, Node


@pytest.mark.parametrize("bit", [1, 2])
@pytest.mark.parametrize("extra", [0, 3, 7])
def test_ov01_overload_frame_on_dominant_in_the_intermission(bit: int, extra: int) -> None:
    bus = node([*stream(), *[1] * (bit - 1), 0, *[0] * (6 + extra if extra else 0)])
    bus.run(200)
    flag = START + BITS + bit
    assert dominant(bus, at("eof.0")) == list(range(flag, flag + 6))
    assert bus.nodes["node"].receive_errors == 0
    assert bus.nodes["node"].received == [FRAME]


@pytest.mark.parametrize("bit", [1, 2])
def test_ov01_sender_starts_the_next_frame_after_the_overload_frame(bit: int) -> None:
    bus = node()
    sending(bus, frames=2)
    bus.disturb(Disturbance("dominant", f"intermission.{bit - 1}"))
    bus.run(600, until_idle=True)
    assert started(bus) == [START, START + BITS + bit + 6 + 8 + 3]


def test_ov01_endless_overload_freezes_the_bus() -> None:
    """Doom loop: dominant at the first intermission bit again and again; nobody counts an error."""
    bus = Bus(["sender", "receiver"])
    bus.send("sender", FRAME)
    bus.send("sender", FRAME)
    bus.disturb(Disturbance("dominant", "intermission.0", repeat=-1))
    bus.run(3000)
    assert len(started(bus, "sender")) == 1
    assert kinds(bus, "receiver").count("overload") > 150
    assert bus.nodes["sender"].errors == bus.nodes["receiver"].errors == []


@pytest.mark.parametrize("frame", ["error", "overload"])
def test_ov02_dominant_in_the_last_delimiter_bit_gives_an_overload_frame(frame: str) -> None:
    begin = [0] * 6 if frame == "error" else [*stream(), 0]
    bus = node([*begin, *[1] * 13, 0])
    bus.run(300)
    last = START + len(begin) + 13
    assert dominant(bus, last) == list(range(last + 1, last + 7))
    assert kinds(bus, "node")[-1] == "overload"


@pytest.mark.parametrize("errors", [0, PASSIVE])
def test_im01_dominant_third_intermission_bit_is_a_start_of_frame(errors: int) -> None:
    """A node with a waiting frame begins with its identifier, without a SOF of its own; a passive receiver too."""
    bus = node([*stream(acknowledged=True), 1, 1, 0], receive_errors=errors)
    bus.run(START + 30)
    bus.send("node", FRAME)
    bus.disturb(Disturbance("dominant", "ack_slot"))
    bus.run(400, until_idle=True)
    start = START + BITS + 2
    assert started(bus) == [start]
    expected = stream()
    expected[NAMES.index("ack_slot.0")] = 0
    assert bus.trace.bus[start : start + BITS].tolist() == expected
    assert bus.nodes["node"].errors == []


def test_im01_dominant_third_intermission_bit_begins_a_reception() -> None:
    bus = node([*stream(), 1, 1, *stream(acknowledged=False)])
    bus.run(400)
    assert bus.nodes["node"].received == [FRAME, FRAME]


def test_im01_node_with_a_waiting_frame_after_its_own() -> None:
    bus = node()
    sending(bus, frames=2)
    bus.disturb(Disturbance("dominant", "intermission.2"))
    bus.run(600, until_idle=True)
    assert started(bus) == [START, START + BITS + 2]


@pytest.mark.parametrize("gap", [2, 3, 9])
def test_im02_passive_former_sender_receives_and_acknowledges(gap: int) -> None:
    """A frame from the third intermission bit, or the first or seventh bit of suspend transmission, on."""
    bus = node(transmit_errors=PASSIVE)
    sending(bus, frames=2)
    other = Frame(0x700, b"\x12")
    bus.drive([*[1] * gap, *stream(other, acknowledged=False)], START + BITS)
    slot = START + BITS + gap + list(other.bit_names()).index("ack_slot.0")
    bus.run(600, until_idle=True)
    assert bus.nodes["node"].received == [other]
    assert bus.trace.driven[slot, 0] == 0
    assert started(bus)[1] == START + BITS + gap + len(stream(other)) + 3


def test_su01_passive_sender_suspends_eight_bits() -> None:
    bus = node(transmit_errors=PASSIVE)
    sending(bus, frames=2)
    bus.run(600, until_idle=True)
    assert started(bus) == [START, START + BITS + 3 + 8]


def test_su01_active_sender_does_not_suspend() -> None:
    bus = node(transmit_errors=127)
    sending(bus, frames=2)
    bus.run(600, until_idle=True)
    assert started(bus) == [START, START + BITS + 3]


def test_su01_suspend_after_an_overload_frame() -> None:
    bus = node(transmit_errors=PASSIVE)
    sending(bus, frames=2)
    bus.disturb(Disturbance("dominant", "intermission.0"))
    bus.run(600, until_idle=True)
    assert started(bus) == [START, START + BITS + 1 + 6 + 8 + 3 + 8]


def test_su02_no_suspend_after_lost_arbitration() -> None:
    winner = Frame(0x0AA, b"\x55")
    bus = node(transmit_errors=PASSIVE)
    sending(bus)
    bus.drive(stream(winner, acknowledged=True), START)
    bus.run(600, until_idle=True)
    assert started(bus) == [START, START + len(stream(winner)) + 3]
    assert bus.nodes["node"].received == [winner]


def test_su02_error_passive_node_that_only_received_sends_at_once() -> None:
    bus = node(stream(), receive_errors=PASSIVE)
    bus.run(START + 20)
    bus.send("node", FRAME)
    bus.disturb(Disturbance("dominant", "ack_slot"))
    bus.run(400, until_idle=True)
    assert started(bus) == [START + BITS + 3]


def test_id01_node_joins_after_eleven_recessive_bits() -> None:
    bus = Bus([Node("node", integrating=True)])
    bus.drive([*[1] * 5, 0, *[1] * 10, 0, *[1] * 11, *stream(acknowledged=False)], 0)
    bus.run(300)
    assert bus.nodes["node"].received == [FRAME]
    assert bus.nodes["node"].errors == []


def test_id01_frames_without_idle_between_them() -> None:
    bus = node([*stream(), 1, 1, 1, *stream(), 1, 1, 1, *stream()])
    bus.run(600)
    assert bus.nodes["node"].received == [FRAME] * 3


def test_be01_recessive_in_the_ack_slot_and_arbitration_is_no_bit_error() -> None:
    bus = Bus(["a", "b", "c"])
    bus.send("a", Frame(0x155))
    bus.send("b", Frame(0x154))
    bus.run(600, until_idle=True)
    assert [bus.nodes[name].errors for name in "abc"] == [[], [], []]
    assert bus.nodes["c"].received == [Frame(0x154), Frame(0x155)]


@pytest.mark.parametrize("name", [name for name in NAMES if not name.startswith(("ack_slot", "eof", "ack_del"))])
def test_be01_every_other_mismatch_of_a_sender_is_an_error(name: str) -> None:
    recessive = FRAME.bits()[NAMES.index(name)] == 1
    arbitration = name.startswith(("id.", "rtr"))
    bus = Bus(["sender", "receiver"])
    bus.send("sender", FRAME)
    bus.disturb(Disturbance("flip", name, tap="receive", node="sender"))
    bus.run(START + BITS)
    if arbitration and recessive:
        assert kinds(bus, "sender")[1] == "arbitration_lost"
    else:
        first = next(event for event in bus.events if event.node == "sender" and event.kind == "error")
        assert (first.bit, first.error) == (NAMES.index(name), "form" if name == "crc_del.0" else "bit")
