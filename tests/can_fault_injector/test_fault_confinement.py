"""Fault confinement: the twelve rules of Bosch CAN 2.0 part B section 8, each with its counters bit by bit.

A node under test faces a tester that puts levels on the bus without following the protocol. All positions are bits of
the bus; ``START`` bits are idle first, so that every change of a counter is in the trace.
"""

import pytest
from bit_tester import FRAME, START, node
from fault_tester import BETWEEN, FLAG, OFFSETS, STUFF_VIOLATION, dominant_bits, levels, sending, steps

from can_fault_injector import Bus, Disturbance, Frame

RECEIVER_ERRORS = {
    "stuff": (STUFF_VIOLATION, 5),
    "crc": (levels(acknowledged=False, stop="ack_del.0", crc_14=1 - levels()[OFFSETS["crc.14"]]), OFFSETS["ack_del.0"]),
    "form_crc_delimiter": (levels(stop="crc_del.0", crc_del_0=0), OFFSETS["crc_del.0"]),
    "form_ack_delimiter": (levels(stop="ack_del.0", ack_del_0=0), OFFSETS["ack_del.0"]),
    **{f"form_eof_{i}": (levels(stop=f"eof.{i}", **{f"eof_{i}": 0}), OFFSETS[f"eof.{i}"]) for i in range(6)},
}


@pytest.mark.parametrize("case", RECEIVER_ERRORS)
def test_fc01_receiver_counts_one_for_an_error(case: str) -> None:
    stream, position = RECEIVER_ERRORS[case]
    bus = node(stream)
    bus.run(200)
    error = START + position
    assert steps(bus) == [(error, 0, 1)]
    assert bus.nodes["node"].errors == [case.partition("_")[0]]
    assert dominant_bits(bus, error + 1, 200) == list(range(error + 1, error + 7))
    assert bus.nodes["node"].received == []


def test_fc01a_acknowledge_bit_read_back_recessive_is_a_bit_error() -> None:
    bus = node(levels(acknowledged=False, stop="ack_slot.0"))
    bus.disturb(Disturbance("recessive", "ack_slot", tap="receive", node="node", reference="node"))
    bus.run(200)
    assert steps(bus) == [(START + OFFSETS["ack_slot.0"], 0, 1)]
    assert bus.nodes["node"].errors == ["bit"]


@pytest.mark.parametrize("bit", range(2, 8))
def test_fc01b_dominant_inside_the_error_delimiter(bit: int) -> None:
    error = START + 5
    bus = node([*STUFF_VIOLATION, *[1] * (FLAG + bit - 1), 0])
    bus.run(200)
    second = error + FLAG + bit
    assert steps(bus) == [(error, 0, 1), (second, 0, 2)]
    assert dominant_bits(bus, second + 1, 200) == list(range(second + 1, second + 7))


@pytest.mark.parametrize("bit", range(2, 8))
def test_fc01b_dominant_inside_the_overload_delimiter(bit: int) -> None:
    bus = node([*levels(), 0, *[1] * (FLAG + bit - 1), 0])
    bus.run(200)
    assert steps(bus) == [(START + len(levels()) + FLAG + bit, 0, 1)]
    assert bus.nodes["node"].errors == ["form"]


def test_fc02_dominant_after_the_error_flag_of_a_receiver() -> None:
    bus = node([*STUFF_VIOLATION, *[1] * FLAG, 0])
    bus.run(200)
    assert steps(bus) == [(START + 5, 0, 1), (START + 5 + FLAG + 1, 0, 9)]


def test_fc02_receiver_that_alone_saw_the_error() -> None:
    """With real nodes: the flags of the others begin at the end of its own (superposition), so it counts nine."""
    bus = Bus(["sender", "receiver", "other"])
    bus.send("sender", FRAME)
    bus.disturb(Disturbance("flip", "data.3", tap="receive", node="receiver"))
    bus.run(400, until_idle=True)
    assert bus.nodes["receiver"].counter_steps[-2][2] == 9
    assert [step[2] for step in bus.nodes["other"].counter_steps] == [1, 0]
    assert [step[1] for step in bus.nodes["sender"].counter_steps] == [8, 7]


SENDER_ERRORS = {
    "bit": ("recessive", "data.0"),
    "bit_dominant": ("dominant", "data.1"),
    "form_crc_delimiter": ("dominant", "crc_del.0"),
    "form_ack_delimiter": ("dominant", "ack_del.0"),
    **{f"form_eof_{i}": ("dominant", f"eof.{i}") for i in range(7)},
}


@pytest.mark.parametrize("case", SENDER_ERRORS)
def test_fc03_sender_counts_eight_and_repeats(case: str) -> None:
    action, place = SENDER_ERRORS[case]
    bus = node()
    start = sending(bus, acknowledged=2)
    bus.disturb(Disturbance(action, place))  # type: ignore[arg-type]
    bus.run(400, until_idle=True)
    error = start + OFFSETS[place]
    repeated = error + BETWEEN + 1
    assert steps(bus) == [(error, 8, 0), (repeated + OFFSETS["eof.6"], 7, 0)]
    assert bus.nodes["node"].errors == [case.partition("_")[0]]
    assert [event.bit for event in bus.events if event.kind == "started"] == [start, repeated]
    assert dominant_bits(bus, error + 1, repeated) == list(range(error + 1, error + 7))


def test_fc03_missing_acknowledgement() -> None:
    bus = node()
    start = sending(bus, acknowledged=0)
    bus.disturb(Disturbance("dominant", "ack_slot", skip=1))
    bus.run(400, until_idle=True)
    error = start + OFFSETS["ack_slot.0"]
    assert steps(bus) == [(error, 8, 0), (error + BETWEEN + 1 + OFFSETS["eof.6"], 7, 0)]
    assert bus.nodes["node"].errors == ["ack"]


def test_fc03x1_passive_sender_without_acknowledgement() -> None:
    bus = node(transmit_errors=128)
    sending(bus, acknowledged=0)
    bus.run(600)
    assert steps(bus) == []
    assert bus.nodes["node"].errors.count("ack") >= 5


@pytest.mark.parametrize("bit", [0, 1, 4])
def test_fc03x1n_dominant_bit_in_the_passive_flag_cancels_the_exception(bit: int) -> None:
    bus = node(transmit_errors=128)
    start = sending(bus, acknowledged=0)
    bus.disturb(Disturbance("dominant", start + OFFSETS["ack_slot.0"] + 1 + bit))
    bus.run(start + 100)
    assert steps(bus) == [(start + OFFSETS["ack_slot.0"] + 1 + bit, 136, 0)]


@pytest.mark.parametrize("frame", [Frame(0x008), Frame(0x00000F, b"\x01", extended=True)])
def test_fc03x2_stuff_error_in_arbitration(frame: Frame) -> None:
    """The recessive stuff bit after SOF and four dominant identifier bits is overwritten."""
    bus = node()
    sending(bus, frame=frame)
    bus.disturb(Disturbance("dominant", "stuff.0"))
    bus.run(400, until_idle=True)
    assert bus.nodes["node"].errors == ["stuff"]
    assert steps(bus) == []


def test_fc03x2_needs_a_recessive_stuff_bit() -> None:
    bus = node()
    sending(bus, frame=Frame(0x7C0))
    bus.disturb(Disturbance("recessive", "stuff.0"))
    bus.run(400, until_idle=True)
    assert bus.nodes["node"].errors == ["bit"]
    assert [step[1] for step in steps(bus)] == [8, 7]


def test_fc03x2_does_not_hold_after_rtr() -> None:
    """Identifier ...0000 and RTR are five dominant bits: the stuff bit comes after RTR."""
    frame = Frame(0x7F0)
    assert list(frame.bit_names())[-100:].index("rtr.0") + 1 == list(frame.bit_names()).index("stuff.1")
    bus = node()
    sending(bus, frame=frame)
    bus.disturb(Disturbance("dominant", "stuff.1"))
    bus.run(400, until_idle=True)
    assert [step[1] for step in steps(bus)] == [8, 7]


@pytest.mark.parametrize("bit", range(6))
def test_fc04_bit_error_in_the_active_error_flag_of_a_sender(bit: int) -> None:
    bus = node()
    start = sending(bus, acknowledged=2)
    error = start + OFFSETS["data.0"]
    bus.disturb(Disturbance("flip", "data.0"))
    bus.disturb(Disturbance("recessive", error + 1 + bit))
    bus.run(400, until_idle=True)
    second = error + 1 + bit
    assert steps(bus)[:2] == [(error, 8, 0), (second, 16, 0)]
    assert dominant_bits(bus, second + 1, second + 15) == list(range(second + 1, second + 7))


@pytest.mark.parametrize("bit", range(6))
def test_fc04_bit_error_in_the_overload_flag_of_a_sender(bit: int) -> None:
    bus = node(transmit_errors=5)
    start = sending(bus)
    end = start + len(levels())
    bus.disturb(Disturbance("dominant", end))
    bus.disturb(Disturbance("recessive", end + 1 + bit))
    bus.run(400, until_idle=True)
    assert steps(bus) == [(end - 1, 4, 0), (end + 1 + bit, 12, 0)]


@pytest.mark.parametrize("bit", range(6))
def test_fc05_bit_error_in_the_active_error_flag_of_a_receiver(bit: int) -> None:
    bus = node(STUFF_VIOLATION)
    error = START + 5
    bus.disturb(Disturbance("recessive", error + 1 + bit))
    bus.run(200)
    assert steps(bus) == [(error, 0, 1), (error + 1 + bit, 0, 9)]
    assert bus.nodes["node"].errors == ["stuff", "bit"]


@pytest.mark.parametrize("bit", range(6))
def test_fc05_bit_error_in_the_overload_flag_of_a_receiver(bit: int) -> None:
    bus = node([*levels(), 0])
    position = START + len(levels()) + 1 + bit
    bus.disturb(Disturbance("recessive", position))
    bus.run(200)
    assert steps(bus) == [(position, 0, 8)]


@pytest.mark.parametrize("extra", range(1, 25))
def test_fc06_and_fc06a_dominant_bits_after_the_active_flag_of_a_sender(extra: int) -> None:
    """Seven are free; the eighth after the flag (the 14th in a row) and each further eighth count eight."""
    bus = node()
    start = sending(bus, acknowledged=2)
    error = start + OFFSETS["data.0"]
    bus.disturb(Disturbance("flip", "data.0"))
    bus.disturb(Disturbance("dominant", error + 1, length=FLAG + extra))
    bus.run(500, until_idle=True)
    counted = [(error + FLAG + 8 * i, 8 + 8 * i, 0) for i in range(1, extra // 8 + 1)]
    assert steps(bus)[:-1] == [(error, 8, 0), *counted]


@pytest.mark.parametrize("extra", range(1, 25))
def test_fc06_and_fc06a_dominant_bits_after_the_active_flag_of_a_receiver(extra: int) -> None:
    bus = node([*STUFF_VIOLATION, *[0] * (FLAG + extra)])
    error = START + 5
    bus.run(200)
    counted = [(error + FLAG + 8 * i, 0, 9 + 8 * i) for i in range(1, extra // 8 + 1)]
    assert steps(bus) == [(error, 0, 1), (error + FLAG + 1, 0, 9), *counted]


@pytest.mark.parametrize("extra", range(25))
def test_fc06_and_fc06a_dominant_bits_after_the_overload_flag(extra: int) -> None:
    bus = node([*levels(), 0, *[0] * (FLAG + extra)])
    bus.run(300)
    flag_end = START + len(levels()) + FLAG
    assert steps(bus) == [(flag_end + 8 * i, 0, 8 * i) for i in range(1, extra // 8 + 1)]


@pytest.mark.parametrize("extra", range(25))
def test_fc06_and_fc06a_dominant_bits_after_the_passive_flag_of_a_sender(extra: int) -> None:
    """The flag is over after six recessive bits."""
    bus = node(transmit_errors=130)
    start = sending(bus, acknowledged=2)
    error = start + OFFSETS["data.0"]
    bus.disturb(Disturbance("flip", "data.0"))
    if extra:
        bus.disturb(Disturbance("dominant", error + FLAG + 1, length=extra))
    bus.run(error + FLAG + extra + 10)
    assert steps(bus) == [(error + FLAG * (i > 0) + 8 * i, 138 + 8 * i, 0) for i in range(extra // 8 + 1)]


def test_fc06a_dominant_bits_after_the_passive_flag_of_a_receiver() -> None:
    bus = node([*STUFF_VIOLATION, *[1] * FLAG, *[0] * 17], receive_errors=130)
    bus.run(200)
    error = START + 5
    first = error + FLAG + 1
    assert steps(bus) == [(error, 0, 131), (first, 0, 139), (first + 7, 0, 147), (first + 15, 0, 155)]
