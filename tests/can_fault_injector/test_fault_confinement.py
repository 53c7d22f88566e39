"""Fault confinement: the twelve rules of Bosch CAN 2.0 part B section 8, each with its counters bit by bit.

A node under test faces a tester that puts levels on the bus without following the protocol. All positions are bits of
the bus; ``START`` bits are idle first, so that every change of a counter is in the trace.
"""

from collections.abc import Iterable

import numpy as np
import pytest

from can_fault_injector import Bus, Disturbance, Frame, Node

START = 4
FRAME = Frame(0x2AA, b"\x55\x0f")
STUFF_VIOLATION = [0] * 6
FLAG, DELIMITER, INTERMISSION = 6, 8, 3
BETWEEN = FLAG + DELIMITER + INTERMISSION
OFFSETS = {name: i for i, name in enumerate(FRAME.bit_names())}


def levels(frame: Frame = FRAME, acknowledged: bool = True, stop: str | None = None, **changed: int) -> list[int]:
    """Levels of a frame as a tester drives them; ``crc_del_0=0`` changes a bit, ``stop`` is the last one."""
    names = list(frame.bit_names())
    bits = [int(bit) for bit in frame.bits()]
    bits[names.index("ack_slot.0")] = 0 if acknowledged else 1
    for name, level in changed.items():
        field, _, number = name.rpartition("_")
        bits[names.index(f"{field}.{number}")] = level
    return bits[: names.index(stop) + 1] if stop else bits


def node(stream: Iterable[int] = (), **settings: object) -> Bus:
    """Bus of one node that a tester drives from ``START`` on."""
    bus = Bus([Node("node", **settings)])  # type: ignore[arg-type]
    bus.drive(stream, START)
    return bus


def sending(bus: Bus, acknowledged: int = 1, frame: Frame = FRAME) -> int:
    """Have the node send from ``START`` on and acknowledge it so many times; returns the bit of SOF."""
    bus.run(START)
    bus.send("node", frame)
    if acknowledged:
        bus.disturb(Disturbance("dominant", "ack_slot", repeat=acknowledged))
    return START


def steps(bus: Bus) -> list[tuple[int, int, int]]:
    return bus.nodes["node"].counter_steps


def dominant_bits(bus: Bus, start: int, stop: int) -> list[int]:
    return [start + int(i) for i in np.flatnonzero(bus.trace.bus[start:stop] == 0)]


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


@pytest.mark.parametrize(("before", "after"), [(0, []), (1, [0]), (127, [126]), (128, [127]), (255, [254])])
def test_fc07_successful_transmission(before: int, after: list[int]) -> None:
    bus = node(transmit_errors=before)
    start = sending(bus)
    bus.run(300, until_idle=True)
    assert steps(bus) == [(start + OFFSETS["eof.6"], value, 0) for value in after]


@pytest.mark.parametrize(("before", "after"), [(0, []), (1, [0]), (127, [126]), (128, [119]), (255, [119])])
def test_fc08_successful_reception(before: int, after: list[int]) -> None:
    """Above 127 the standard allows 119 to 127."""
    bus = node(levels(acknowledged=False), receive_errors=before)
    bus.run(300)
    assert steps(bus) == [(START + OFFSETS["eof.5"], 0, value) for value in after]
    assert bus.nodes["node"].received == [FRAME]


def test_fc09_error_that_makes_a_sender_passive_still_sends_an_active_flag() -> None:
    bus = node(transmit_errors=120)
    start = sending(bus, acknowledged=2)
    bus.disturb(Disturbance("flip", "data.0", repeat=2))
    bus.run(400, until_idle=True)
    error = start + OFFSETS["data.0"]
    again = error + BETWEEN + 8 + 1  # now passive: it suspends eight bits
    assert dominant_bits(bus, error + 1, again) == list(range(error + 1, error + 7))
    second = again + OFFSETS["data.0"]
    assert dominant_bits(bus, second + 1, second + 8 + BETWEEN) == []
    assert steps(bus)[:2] == [(error, 128, 0), (second, 136, 0)]
    assert [event.bit for event in bus.events if event.kind == "error_passive"] == [error]


def test_fc09_error_that_makes_a_receiver_passive_still_sends_an_active_flag() -> None:
    bus = node([*STUFF_VIOLATION, *[1] * 40, *STUFF_VIOLATION], receive_errors=127)
    bus.run(200)
    error, second = START + 5, START + 46 + 5
    assert steps(bus) == [(error, 0, 128), (second, 0, 129)]
    assert dominant_bits(bus, error + 1, error + 30) == list(range(error + 1, error + 7))
    assert dominant_bits(bus, second + 1, 200) == []
    assert bus.nodes["node"].state == "error_passive"


def test_fc10_bus_off_has_no_influence_on_the_bus() -> None:
    bus = node(transmit_errors=248)
    start = sending(bus, acknowledged=0)
    bus.disturb(Disturbance("flip", "data.0"))
    error = start + OFFSETS["data.0"]
    bus.drive([1] * 30 + levels(acknowledged=False), error + 1)
    bus.run(400)
    assert steps(bus) == [(error, 256, 0)]
    assert bus.nodes["node"].state == "bus_off"
    assert not np.any(bus.trace.driven[error + 1 :, 0] == 0)
    assert bus.nodes["node"].received == []
    assert [event.bit for event in bus.events if event.kind == "bus_off"] == [error]


def test_fc11_active_again_only_when_both_counters_allow_it() -> None:
    bus = node([*levels(acknowledged=False)], transmit_errors=128, receive_errors=130)
    bus.run(START + len(levels()) + 20)
    assert bus.nodes["node"].state == "error_passive"
    assert bus.nodes["node"].receive_errors == 119
    bus.disturb(Disturbance("dominant", "ack_slot"))
    bus.send("node", FRAME)
    bus.run(300, until_idle=True)
    assert (bus.nodes["node"].transmit_errors, bus.nodes["node"].state) == (127, "error_active")


def test_fc11_a_detected_error_never_makes_a_node_active() -> None:
    bus = node([*STUFF_VIOLATION, *[1] * 30], transmit_errors=128)
    bus.run(200)
    assert bus.nodes["node"].state == "error_passive"
    assert dominant_bits(bus, START + 6, 200) == []


def _bus_off(bus: Bus) -> int:
    """Drive a node into bus-off; returns the first bit of its recovery."""
    start = sending(bus, acknowledged=0)
    bus.disturb(Disturbance("flip", "data.0"))
    return start + OFFSETS["data.0"] + 1


def test_fc12_recovery_after_128_times_11_recessive_bits() -> None:
    bus = node(transmit_errors=248, receive_errors=7)
    first = _bus_off(bus)
    bus.run(first + 128 * 11 - 1 - START)
    assert bus.nodes["node"].state == "bus_off"
    bus.run(1)
    assert bus.nodes["node"].state == "error_active"
    assert steps(bus) == [(first - 1, 256, 7), (first + 128 * 11 - 1, 0, 0)]
    bus.run(1)
    assert bus.trace.bus[-1] == 0, "the waiting frame begins at once"


@pytest.mark.parametrize("bit", [0, 5, 10])
def test_fc12_a_dominant_bit_restarts_only_the_present_sequence(bit: int) -> None:
    bus = node(transmit_errors=248)
    first = _bus_off(bus)
    bus.disturb(Disturbance("dominant", first + 20 * 11 + bit))
    bus.run(2000)
    assert steps(bus)[1] == (first + 128 * 11 + bit, 0, 0)


def test_fc12_without_automatic_recovery() -> None:
    bus = node(transmit_errors=248, recovers=False)
    _bus_off(bus)
    bus.run(3000)
    assert bus.nodes["node"].state == "bus_off"


UNCHANGED = {
    "last_bit_of_eof": levels(eof_6=0),
    "last_bit_of_overload_delimiter": [*levels(), 0, *[1] * 13, 0],
    "first_bit_of_intermission": [*levels(), 0],
    "overload_flag_of_13_bits": [*levels(), 0, *[0] * 13],
}


@pytest.mark.parametrize("case", UNCHANGED)
def test_fc13_receiver_counts_nothing(case: str) -> None:
    bus = node(UNCHANGED[case], transmit_errors=3)
    bus.run(300)
    assert steps(bus) == []
    assert bus.nodes["node"].received == [FRAME]
    assert "overload" in [event.kind for event in bus.events]


def test_fc13_dominant_last_bit_of_the_error_delimiter() -> None:
    bus = node([*STUFF_VIOLATION, *[1] * 13, 0])
    bus.run(200)
    assert steps(bus) == [(START + 5, 0, 1)]
    assert [event.kind for event in bus.events][-1] == "overload"


@pytest.mark.parametrize("place", ["error_delimiter.7", "overload_delimiter.7"])
def test_fc13_sender_counts_nothing_at_the_last_bit_of_a_delimiter(place: str) -> None:
    bus = node()
    start = sending(bus, acknowledged=2)
    first = Disturbance("flip", "data.0") if place.startswith("error") else Disturbance("dominant", "intermission.0")
    bus.disturb(first)
    bus.disturb(Disturbance("dominant", place))
    bus.run(500, until_idle=True)
    expected = [(start + OFFSETS["data.0"], 8, 0)] if place.startswith("error") else []
    assert steps(bus)[:1] == expected
    assert [event.kind for event in bus.events].count("overload") == (1 if expected else 2)


def test_fc13_lost_arbitration_and_then_an_error() -> None:
    bus = node()
    sending(bus, acknowledged=1)
    winner = levels(Frame(0x2A0, b"\x55"), stop="data.2")
    bus.drive([*winner, *STUFF_VIOLATION], START)
    bus.run(400, until_idle=True)
    assert "arbitration_lost" in [event.kind for event in bus.events]
    assert {step[1] for step in steps(bus)} == {0}
    assert steps(bus)[0][2] == 1


def test_fc13_transmission_leaves_rec_and_reception_leaves_tec() -> None:
    bus = Bus([Node("a", transmit_errors=9, receive_errors=9), Node("b", transmit_errors=9, receive_errors=9)])
    bus.send("a", FRAME)
    bus.run(300, until_idle=True)
    assert [(n.transmit_errors, n.receive_errors) for n in bus.nodes.values()] == [(8, 9), (9, 8)]


def test_fc13_protocol_exception() -> None:
    frame = Frame(0x123, bytes(20), fd=True)
    bus = node(levels(frame), fd="tolerant")
    bus.run(400)
    assert steps(bus) == []
    assert bus.nodes["node"].errors == []
    assert not np.any(bus.trace.driven[:, 0] == 0)


def test_fc14_counters_are_independent() -> None:
    """A node sends with errors and receives with errors in turn; each counter only follows its own role."""
    bus = Bus(["a", "b"])
    bus.run(1)
    bus.send("a", FRAME)
    bus.disturb(Disturbance("flip", "data.0", repeat=3))
    bus.run(900, until_idle=True)
    assert (bus.nodes["a"].transmit_errors, bus.nodes["a"].receive_errors) == (23, 0)
    assert (bus.nodes["b"].transmit_errors, bus.nodes["b"].receive_errors) == (0, 2)
    bus.send("b", FRAME)
    bus.disturb(Disturbance("flip", "data.0"))
    bus.run(900, until_idle=True)
    assert (bus.nodes["a"].transmit_errors, bus.nodes["a"].receive_errors) == (23, 0)
    assert (bus.nodes["b"].transmit_errors, bus.nodes["b"].receive_errors) == (7, 2)
    assert [step[2] for step in bus.nodes["a"].counter_steps][-2:] == [1, 0]


def test_fc15_lone_node_stays_passive_and_never_goes_off() -> None:
    bus = node()
    start = sending(bus, acknowledged=0)
    bus.run(20_000)
    tries = [start + i * (OFFSETS["ack_slot.0"] + BETWEEN + 1) for i in range(16)]
    assert steps(bus) == [(bit + OFFSETS["ack_slot.0"], 8 * (i + 1), 0) for i, bit in enumerate(tries)]
    assert bus.nodes["node"].state == "error_passive"
    assert bus.nodes["node"].errors.count("ack") > 100


@pytest.mark.parametrize(
    ("transmit", "receive", "warning", "state"),
    [
        (95, 95, False, "error_active"),
        (96, 0, True, "error_active"),
        (0, 96, True, "error_active"),
        (127, 127, True, "error_active"),
        (128, 0, True, "error_passive"),
        (0, 128, True, "error_passive"),
        (256, 0, True, "bus_off"),
    ],
)
def test_fc16_levels_of_the_counters(transmit: int, receive: int, warning: bool, state: str) -> None:
    """The thresholds of linux/can/error.h: 96, 128, 256."""
    view = node(transmit_errors=transmit, receive_errors=receive).nodes["node"]
    assert (view.warning, view.state) == (warning, state)
