"""Error and overload frames, intermission, suspend transmission, the end of a frame: bit positions on the bus.

Rules EF, EO, OV, IM, SU and BE of ISO 11898-1; a tester drives levels, or real nodes face each other.
"""

from collections.abc import Iterable

import numpy as np
import pytest

from can_fault_injector import Bus, Disturbance, Frame, Node, node_state

FRAME = Frame(0x2AA, b"\x55\x0f")
NAMES = list(FRAME.bit_names())
BITS = len(NAMES)
START = 4
PASSIVE = 130


def stream(frame: Frame = FRAME, acknowledged: bool = True) -> list[int]:
    bits = [int(bit) for bit in frame.bits()]
    bits[list(frame.bit_names()).index("ack_slot.0")] = 0 if acknowledged else 1
    return bits


def at(name: str) -> int:
    return START + NAMES.index(name)


def node(levels: Iterable[int] = (), **settings: object) -> Bus:
    bus = Bus([Node("node", **settings)])  # type: ignore[arg-type]
    bus.drive(levels, START)
    return bus


def sending(bus: Bus, frames: int = 1) -> None:
    """The node sends from ``START`` on; every frame is acknowledged."""
    bus.run(START)
    for _ in range(frames):
        bus.send("node", FRAME)
    bus.disturb(Disturbance("dominant", "ack_slot", repeat=-1))


def started(bus: Bus, name: str = "node") -> list[int]:
    return [event.bit for event in bus.events if event.node == name and event.kind == "started"]


def dominant(bus: Bus, start: int, stop: int | None = None) -> list[int]:
    """Bits at which the first node drives dominant."""
    return [start + int(i) for i in np.flatnonzero(bus.trace.driven[start:stop, 0] == 0)]


def kinds(bus: Bus, name: str) -> list[str]:
    return [event.kind for event in bus.events if event.node == name]


def test_ef01_flag_begins_at_the_next_bit_and_after_the_ack_delimiter_for_a_crc_error() -> None:
    levels = stream(acknowledged=False)
    levels[NAMES.index("crc.14")] ^= 1
    bus = node(levels[: NAMES.index("ack_del.0") + 1])
    bus.run(200)
    assert bus.nodes["node"].errors == ["crc"]
    assert dominant(bus, START) == list(range(at("eof.0"), at("eof.0") + 6))


def test_ef02_crc_and_form_error_give_one_flag() -> None:
    levels = stream(acknowledged=False)
    levels[NAMES.index("crc.14")] ^= 1
    levels[NAMES.index("crc_del.0")] = 0
    bus = node(levels[: NAMES.index("crc_del.0") + 1])
    bus.run(200)
    assert bus.nodes["node"].errors == ["form"]
    assert dominant(bus, START) == list(range(at("ack_slot.0"), at("ack_slot.0") + 6))


@pytest.mark.parametrize("extra", range(7))
def test_ef03_superposition_of_flags_and_delimiter(extra: int) -> None:
    """6 to 12 dominant bits, then eight recessive ones from the first recessive bit on, then three of intermission."""
    bus = node()
    sending(bus)
    bus.disturb(Disturbance("flip", "data.0"))
    error = at("data.0")
    bus.disturb(Disturbance("dominant", error + 1, length=6 + extra))
    bus.run(400, until_idle=True)
    assert started(bus) == [START, error + 6 + extra + 8 + 3 + 1]


@pytest.mark.parametrize("dominant_bits", range(6))
def test_ef04_up_to_five_dominant_bits_restart_the_passive_flag(dominant_bits: int) -> None:
    """Six equal bits complete it, so a disturbance of its first bits delays its end by its own length."""
    bus = node(transmit_errors=PASSIVE)
    sending(bus)
    bus.disturb(Disturbance("flip", "data.0"))
    error = at("data.0")
    if dominant_bits:
        bus.disturb(Disturbance("dominant", error + 1, length=dominant_bits))
    bus.run(400, until_idle=True)
    assert started(bus)[1] == error + dominant_bits + 6 + 8 + 3 + 8 + 1


@pytest.mark.parametrize("bit", [1, 3, 6])
def test_ef04_five_dominant_bits_inside_the_passive_flag(bit: int) -> None:
    bus = node(transmit_errors=PASSIVE)
    sending(bus)
    bus.disturb(Disturbance("flip", "data.0"))
    error = at("data.0")
    bus.disturb(Disturbance("dominant", error + bit, length=5))
    bus.run(400, until_idle=True)
    assert started(bus)[1] == error + (bit - 1) + 5 + 6 + 8 + 3 + 8 + 1


@pytest.mark.parametrize("bit", range(1, 7))
def test_ef05_dominant_in_the_passive_flag_is_no_bit_error(bit: int) -> None:
    bus = node(transmit_errors=PASSIVE)
    sending(bus)
    bus.disturb(Disturbance("flip", "data.0"))
    bus.disturb(Disturbance("dominant", at("data.0") + bit))
    bus.run(400, until_idle=True)
    assert bus.nodes["node"].errors == ["bit"]
    assert bus.nodes["node"].transmit_errors == PASSIVE + 8 - 1


def test_ef06_passive_receiver_does_not_disturb_others() -> None:
    """No active flag covers its own: the frame of the others goes on and is received by them."""
    bus = Bus(["sender", "other", Node("passive", receive_errors=PASSIVE)])
    bus.send("sender", FRAME)
    bus.send("sender", Frame(0x100, b"\x01"))
    bus.disturb(Disturbance("flip", "data.0", tap="receive", node="passive"))
    bus.run(600, until_idle=True)
    assert bus.nodes["other"].received == [FRAME, Frame(0x100, b"\x01")]
    assert bus.nodes["sender"].errors == bus.nodes["other"].errors == []
    assert bus.nodes["passive"].errors[0] in ("stuff", "crc")
    assert not np.any(bus.trace.driven[: len(stream()) + 3, 2] == 0)


def test_ef06_passive_receiver_counts_equal_bits_of_running_traffic() -> None:
    """Its flag ends with six equal bits, which only the end of the frame has: ACK delimiter to the fifth EOF bit."""
    bus = Bus([Node("passive", receive_errors=PASSIVE), "sender", "other"])
    bus.send("sender", FRAME)
    bus.disturb(Disturbance("dominant", "bit.1", tap="receive", node="passive", length=5))
    bus.run(400, until_idle=True)
    assert bus.nodes["passive"].errors == ["stuff"]
    phases = [node_state.PHASE_NAMES[code] for code in bus.trace.phase[:BITS, 0]]
    end = NAMES.index("eof.4")
    assert phases[5:end] == ["passive_flag"] * (end - 5)
    assert phases[end:] == ["after_flag", "delimiter", "delimiter"]


def test_ef07_passive_sender_whose_flag_is_followed_by_an_active_flag_repeats_after_31_bits() -> None:
    bus = node(transmit_errors=PASSIVE)
    sending(bus)
    bus.disturb(Disturbance("flip", "data.0"))
    error = at("data.0")
    bus.disturb(Disturbance("dominant", error + 7, length=6))
    bus.run(400, until_idle=True)
    assert started(bus) == [START, error + 31 + 1]


def test_ef07_node_turned_passive_by_the_error() -> None:
    bus = node(transmit_errors=127)
    sending(bus)
    bus.disturb(Disturbance("flip", "data.0"))
    bus.run(400, until_idle=True)
    assert started(bus) == [START, at("data.0") + 6 + 8 + 3 + 8 + 1]


@pytest.mark.parametrize("bit", range(6))
def test_eo01_dominant_in_eof_1_to_6_is_a_form_error_of_the_receiver(bit: int) -> None:
    levels = stream()
    levels[NAMES.index(f"eof.{bit}")] = 0
    bus = node(levels[: NAMES.index(f"eof.{bit}") + 1])
    bus.run(200)
    error = at(f"eof.{bit}")
    assert bus.nodes["node"].received == []
    assert dominant(bus, error) == list(range(error + 1, error + 7))


def test_eo01_dominant_in_eof_7_gives_an_overload_frame_and_the_frame_is_accepted() -> None:
    levels = stream()
    levels[NAMES.index("eof.6")] = 0
    bus = node(levels)
    bus.run(200)
    last = at("eof.6")
    assert bus.nodes["node"].received == [FRAME]
    assert bus.nodes["node"].errors == []
    assert dominant(bus, last) == list(range(last + 1, last + 7))


@pytest.mark.parametrize("bit", range(7))
def test_eo02_dominant_in_eof_makes_the_sender_repeat(bit: int) -> None:
    bus = Bus(["sender", "receiver"])
    bus.send("sender", FRAME)
    bus.disturb(Disturbance("dominant", f"eof.{bit}"))
    bus.run(600, until_idle=True)
    assert bus.nodes["sender"].errors == ["form"]
    assert len(started(bus, "sender")) == 2
    # the last bit: receivers have the frame already, so they get a duplicate
    assert bus.nodes["receiver"].received == [FRAME] * (2 if bit == 6 else 1)


def test_eo02_dominant_in_the_first_intermission_bit_repeats_nothing() -> None:
    bus = Bus(["sender", "receiver"])
    bus.send("sender", FRAME)
    bus.disturb(Disturbance("dominant", "intermission.0"))
    bus.run(600, until_idle=True)
    assert bus.nodes["receiver"].received == [FRAME]
    assert len(started(bus, "sender")) == 1
    assert "overload" in kinds(bus, "sender")
    assert "overload" in kinds(bus, "receiver")


def test_eo03_error_in_the_last_but_one_eof_bit_of_a_subset_duplicates() -> None:
    """Rufino 1998: one receiver rejects, its flag reaches the others in the last bit, which accept; both get more."""
    bus = Bus(["sender", "victim", "other"])
    bus.send("sender", FRAME)
    bus.disturb(Disturbance("dominant", "eof.5", tap="receive", node="victim"))
    bus.run(600, until_idle=True)
    assert bus.nodes["victim"].received == [FRAME]
    assert bus.nodes["other"].received == [FRAME, FRAME]


def test_eo03_sender_that_does_not_repeat_makes_an_omission() -> None:
    bus = Bus([Node("sender", single_shot=True), "victim", "other"])
    bus.send("sender", FRAME)
    bus.disturb(Disturbance("dominant", "eof.5", tap="receive", node="victim"))
    bus.run(600, until_idle=True)
    assert bus.nodes["victim"].received == []
    assert bus.nodes["other"].received == [FRAME]


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


def test_bus_off_attack_on_one_identifier() -> None:
    """Bit errors in one identifier only: 32 errors of eight make its sender bus-off (Cho and Shin 2016).

    The attacked node is passive after 16; a frame of a third node goes through meanwhile.
    """
    victim, other = Frame(0x120, b"\x55"), Frame(0x130, b"\x0f")
    bus = Bus([Node("victim", recovers=False), "other", "receiver"])
    bus.send("victim", victim)
    bus.send("other", other)
    bus.disturb(Disturbance("flip", "data.0", identifier=0x120, repeat=-1))
    bus.run(5000)
    assert bus.nodes["victim"].state == "bus_off"
    assert [step[1] for step in bus.nodes["victim"].counter_steps] == [8 * i for i in range(1, 33)]
    assert bus.nodes["receiver"].received == [other]
    assert bus.nodes["other"].transmit_errors == 0


@pytest.mark.parametrize("place", ["id.4", "dlc.0", "data.3", "data.12", "crc.3"])
def test_ef03_flags_of_real_nodes_superpose_to_6_to_12_bits(place: str) -> None:
    """One receiver sees an error first, the others at the latest by the sixth bit of its flag."""
    bus = Bus(["sender", "receiver", "other"])
    bus.send("sender", FRAME)
    bus.disturb(Disturbance("flip", place, tap="receive", node="receiver"))
    bus.run(600, until_idle=True)
    first = next(event.bit for event in bus.events if event.kind == "error")
    last_dominant = first + int(np.flatnonzero(bus.trace.bus[first + 1 :] == 1)[0])
    repeated = started(bus, "sender")[1]
    assert 6 <= last_dominant - first <= 12
    # eight recessive bits of delimiter and three of intermission
    assert repeated - last_dominant == 8 + 3 + 1
    assert bus.nodes["receiver"].received == bus.nodes["other"].received == [FRAME]
