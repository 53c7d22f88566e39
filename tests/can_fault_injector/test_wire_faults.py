"""Wire faults: voltages against Ohm's law and ISO 11898-2, and what nodes make of them against its bus failures.

The friction document asks that one open wire is an error or degraded, and that nothing passes with both open (item 35).
"""

from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

from can_fault_injector import Bus, Disturbance, Frame, Node
from can_fault_injector.error_frames import WIRES
from can_fault_injector.wire_faults import FAULTS, OUTPUT_OHM, SUPPLY_V, Line, levels, wiring
from can_fault_injector.wire_reactions import reactions

LINE = Line(("bystander", "bench", "ecu"))
STUB = Line(("bystander", "bench", "ecu"), terminated=("bystander", "bench"))
NODES = LINE.nodes
WITHOUT_COMMUNICATION = ("can_h_to_can_l", "can_h_to_ground", "can_l_to_battery", "can_l_to_supply")
DEGRADED = ("can_h_to_battery", "can_h_to_supply", "can_l_to_ground")
DOCUMENT = Path(__file__).parents[2] / "docs" / "can_wire_faults.md"


def words(line: Line, fault: str | None) -> list[str]:
    """One word for each node while bench and ECU send and the bystander listens."""
    return [reaction.word for reaction in reactions(line, fault, "ecu", ("bench", "ecu")).values()]


def test_names_are_those_of_the_error_frames() -> None:
    assert sorted(FAULTS) == sorted(WIRES)


def test_sound_line_has_the_levels_of_iso_11898_2() -> None:
    """60 ohm between two output stages: 5 V × 60 / (60 + 2 × 45) = 2 V; recessive 2.5 V on both."""
    for line in (LINE, STUB):
        sound = levels(line)
        assert sound.difference[0] == pytest.approx([0, 0, 0], abs=1e-9)
        assert sound.can_h[0] == pytest.approx([2.5] * 3, abs=1e-9)
        expected = SUPPLY_V * 60 / (60 + 2 * OUTPUT_OHM)
        for dominant in range(1, 8):
            if dominant.bit_count() == 1:
                assert sound.difference[dominant] == pytest.approx([expected] * 3, rel=0.02)
            assert np.all(sound.seen[dominant] == 0)
        assert np.all(sound.in_limits)


@pytest.mark.acceptance("F-35")
@pytest.mark.parametrize("conductor", ["can_h", "can_l"])
def test_one_open_conductor_is_an_error_or_degraded(conductor: str) -> None:
    """The ECU cannot be heard; behind a break it hears only where no resistor pulls its conductors together."""
    assert words(LINE, f"{conductor}_open") == ["degraded", "silent", "error"]
    assert words(STUB, f"{conductor}_open") == ["degraded", "silent", "error"]
    terminated = reactions(LINE, f"{conductor}_open", "ecu", ("bench", "ecu"))["ecu"]
    hanging = reactions(STUB, f"{conductor}_open", "ecu", ("bench", "ecu"))["ecu"]
    assert (terminated.received, terminated.delivered, terminated.state) == (0, 0, "error_passive")
    assert (hanging.received, hanging.delivered, hanging.state) == (3, 0, "error_passive")
    # the floating conductor stays at 2.5 V, the other one is pulled to 1.5 V
    assert levels(STUB, f"{conductor}_open").difference[2, 2] == pytest.approx(1.0, abs=0.01)


@pytest.mark.acceptance("F-35")
def test_with_both_open_no_frame_is_accepted_anywhere(record: Callable[..., None]) -> None:
    result = reactions(Line(("bench", "ecu")), "both_open")
    accepted = sum(reaction.received for reaction in result.values())
    record("frames accepted with both conductors open", accepted, "0")
    assert accepted == 0
    assert {reaction.word for reaction in result.values()} == {"error"}
    assert {reaction.transmit_errors for reaction in result.values()} == {128}  # FC15: passive, never bus-off


def test_with_both_open_no_frame_passes_the_break() -> None:
    for line in (LINE, STUB):
        result = reactions(line, "both_open", "ecu", ("bench", "ecu"))
        assert (result["ecu"].received, result["ecu"].delivered, result["bench"].received) == (0, 0, 0)


@pytest.mark.parametrize("line", [LINE, STUB])
@pytest.mark.parametrize("fault", WITHOUT_COMMUNICATION)
def test_shorts_that_leave_no_difference_stop_the_bus(fault: str, line: Line) -> None:
    """Senders never see their own dominant bits and go bus-off; who only listens notices nothing."""
    result = reactions(line, fault, "ecu", ("bench", "ecu"))
    assert [reaction.word for reaction in result.values()] == ["silent", "error", "error"]
    assert [result[name].state for name in ("bench", "ecu")] == ["bus_off", "bus_off"]
    assert levels(line, fault, "ecu").difference.max() < 0.5


@pytest.mark.parametrize("line", [LINE, STUB])
@pytest.mark.parametrize("fault", DEGRADED)
def test_shorts_that_leave_a_difference_only_degrade(fault: str, line: Line) -> None:
    """Every frame passes, but the recessive bus lies at a supply: no reserve against ground shift."""
    assert words(line, fault) == ["degraded"] * 3
    assert not np.any(levels(line, fault, "ecu").in_limits)


def test_short_to_the_battery_carries_the_current_of_one_output_stage() -> None:
    """CAN_H at 13.5 V: current through 60 ohm and one output stage of 45 ohm, the diode of the other one blocks."""
    difference = levels(LINE, "can_h_to_battery", "ecu").difference[4, 2]
    assert difference == pytest.approx(13.5 * 60 / 105, rel=0.01)


def test_sound_wires_change_nothing() -> None:
    """The table of a sound line is the wired AND: the run with an error in it is the same bit for bit."""
    traces = []
    for table in (None, wiring(LINE, NODES)):
        bus = Bus(NODES)
        bus.connect(table)
        for name in ("bench", "ecu"):
            bus.send(name, Frame(0x100 + len(name), b"\x12\x34"))
        bus.disturb(Disturbance("flip", "data.3", tap="receive", node="ecu"))
        bus.run(400)
        traces.append(np.hstack([bus.trace.bus[:, None], bus.trace.seen, bus.trace.phase, bus.trace.transmit_errors]))
    assert np.array_equal(*traces)


def test_order_of_the_nodes_is_of_no_account() -> None:
    for names in (("ecu", "bystander", "bench"), ("bench", "ecu", "bystander")):
        bus = Bus(names)
        bus.connect(wiring(LINE, names, "can_h_open", "ecu"))
        bus.send("ecu", Frame(0x100))
        bus.run(60)
        assert bus.nodes["ecu"].errors[:1] == ["ack"]
        assert bus.nodes["bench"].errors == []


def test_a_break_that_heals_lets_the_bus_go_on() -> None:
    bus = Bus(("bench", "ecu"))
    line = Line(("bench", "ecu"))
    bus.connect(wiring(line, line.nodes, "both_open"))
    bus.send("bench", Frame(0x100, b"\x01"))
    bus.run(2000)
    assert bus.nodes["bench"].state == "error_passive"
    bus.connect(None)
    for _ in range(20):
        bus.send("bench", Frame(0x101))
    bus.run(5000, until_idle=True)
    assert bus.nodes["ecu"].received == [Frame(0x100, b"\x01"), *[Frame(0x101)] * 20]
    assert bus.nodes["bench"].state == "error_active"


def test_a_break_in_the_middle_splits_the_line() -> None:
    line = Line(("a", "b", "c", "d"))
    result = reactions(line, "both_open", "c", ("a", "d"))
    assert [result[name].received for name in "abcd"] == [0, 3, 3, 0]


def test_documented_table_is_what_the_model_says() -> None:
    rows = {}
    for text in DOCUMENT.read_text(encoding="utf-8").splitlines():
        cells = [cell.strip() for cell in text.strip("|").split("|")]
        if len(cells) == 7 and cells[0].strip("`") in FAULTS:
            rows[cells[0].strip("`")] = cells[1:]
    assert rows == {fault: [*words(LINE, fault), *words(STUB, fault)] for fault in FAULTS}


@pytest.mark.parametrize(
    ("arguments", "word"),
    [
        (("can_h_gone", "ecu"), "wire fault"),
        (("can_h_open", "nobody"), "node"),
        (("can_h_open", "bystander"), "first node"),
    ],
)
def test_impossible_faults_are_refused(arguments: tuple[str, str], word: str) -> None:
    with pytest.raises(ValueError, match=word):
        levels(LINE, *arguments)


def test_wrong_wirings_are_refused() -> None:
    with pytest.raises(ValueError, match="shape"):
        Bus([Node("a"), Node("b")]).connect(np.zeros((2, 2), np.uint8))
    with pytest.raises(ValueError, match="nodes of the line"):
        wiring(LINE, ("bench", "ecu"))
