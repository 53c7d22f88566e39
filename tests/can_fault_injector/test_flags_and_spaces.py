"""Error and overload frames, intermission, suspend transmission, the end of a frame: bit positions on the bus.

Rules EF, EO, OV, IM, SU and BE of ISO 11898-1; a tester drives levels, or real nodes face each other.
"""

import numpy as np
import pytest
from bit_tester import BITS, FRAME, NAMES, PASSIVE, START, at, dominant, kinds, node, sending, started, stream

from can_fault_injector import Bus, Disturbance, Frame, Node, node_state


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
