"""Fault confinement (Bosch CAN 2.0 part B section 8): counting down, passive, bus-off, what counts nothing."""

import numpy as np
import pytest
from bit_tester import FRAME, START, node
from fault_tester import BETWEEN, OFFSETS, STUFF_VIOLATION, dominant_bits, levels, sending, steps

from can_fault_injector import Bus, Disturbance, Frame, Node


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
