"""Nodes with clocks and lines of their own (rule BT01 and BT02): oscillators, delays, fast data phases, split edges."""

import numpy as np
import pytest
from bit_tester import FRAME, NAMES, START
from timed_tester import BIT_RATE, QUANTA, TO_SAMPLE, receiver, samples_after

from can_fault_injector import Bus, Disturbance, Frame, Node
from can_fault_injector.delay_model import mean_delay_ns
from can_fault_injector.janus import janus, split_edges
from can_fault_injector.timed_bus import BitTiming, TimedBus, TimedNode
from can_fault_injector.wire_faults import Line, wiring


def pair(first: float, second: float, delay_ns: float = 0.0, frames: int = 20, **timing: int) -> TimedBus:
    """Two nodes with oscillators off by ppm, which send each other frames without and with many stuff bits."""
    shape = BitTiming(**timing)
    nodes = [
        TimedNode(Node("a"), shape, clock_ppm=first, delay_ns=delay_ns),
        TimedNode(Node("b"), shape, clock_ppm=second, delay_ns=delay_ns, phase=0.4),
    ]
    bus = TimedBus(nodes, BIT_RATE)
    generator = np.random.default_rng(2)
    for i in range(frames):
        bus.send("ab"[i % 2], Frame(0x100 + i, bytes(8) if i % 3 == 0 else generator.bytes(8)))
    bus.run(frames * 160)
    return bus


def test_bt01_oscillator_tolerance() -> None:
    """Bosch CAN 2.0 part B, section 9: |df| <= SJW / (20 bits) and min(PS1, PS2) / (2 (13 bits - PS2)), 0.98 % here.

    Nodes at plus and minus 0.9 % understand each other, at 3 % they do not.
    """
    good = pair(9000.0, -9000.0)
    assert [len(good.nodes[name].received) for name in "ab"] == [10, 10]
    assert good.nodes["a"].errors == good.nodes["b"].errors == []
    bad = pair(30_000.0, -30_000.0)
    assert len(bad.nodes["a"].received) < 10
    assert bad.nodes["a"].errors


def test_jump_width_of_one_quantum_tolerates_less() -> None:
    """SJW = 1: 1 / 400 = 0.25 % for each node."""
    assert pair(2000.0, -2000.0, jump_width=1).nodes["a"].errors == []
    assert pair(9000.0, -9000.0, jump_width=1).nodes["a"].errors != []


@pytest.mark.parametrize(("delay_ns", "arrives"), [(300.0, True), (500.0, False)])
def test_acknowledgement_has_to_be_back_before_the_sample_point(delay_ns: float, arrives: bool) -> None:
    """Two nodes each ``delay`` from the bus: there and back are four delays, the sample is 1500 ns after the edge."""
    bus = TimedBus([TimedNode(Node(name), delay_ns=delay_ns) for name in "ab"], BIT_RATE)
    bus.send("a", FRAME)
    bus.run(120)
    assert ("ack" not in bus.nodes["a"].errors) == arrives
    assert (bus.nodes["b"].received[:1] == [FRAME]) == arrives


@pytest.mark.parametrize("rate", [1_000_000, 800_000, 500_000, 250_000])
def test_in_line_device_with_the_delay_of_table_7(rate: int) -> None:
    """Enisz 2015, 5.2.5: behind the device every edge is late by the table's delay, and the ECU still answers.

    At 1 Mbit/s the acknowledgement is back 720 ns after its bit began: in time for a sample at 80 %, not for one at
    50 %. So the source's verdict holds for late sample points only.
    """
    for phase_2, works in [(4, True), (10, rate < 800_000)]:
        timing = BitTiming(19 - phase_2 - 4, 4, phase_2, 4)
        device = TimedNode(Node("ecu"), timing, delay_ns=mean_delay_ns(rate))
        bus = TimedBus([TimedNode(Node("bench"), timing), device], rate)
        bus.send("bench", FRAME)
        bus.run(300)
        assert (bus.nodes["bench"].errors == []) == works
        sampled = {name: next(s.time_ns for s in bus.samples if s.node == name and s.level == 0) for name in bus.names}
        late = sampled["ecu"] - sampled["bench"]
        assert late == pytest.approx(mean_delay_ns(rate), abs=1e9 / rate / 20)


@pytest.mark.parametrize("length", [0, 8, 16, 64])
@pytest.mark.parametrize("iso", [True, False])
def test_fd_frames_with_a_fast_data_phase(length: int, iso: bool) -> None:
    """BRS: 500 kbit/s and 2 Mbit/s; the frame lasts as long as its bits, sampled at the rate of their phase (FD06)."""
    timing, data = BitTiming(), BitTiming(2, 3, 2, 2)
    nodes = [TimedNode(Node(name, iso=iso), timing, data, phase=phase) for name, phase in (("a", 0.0), ("b", 0.6))]
    bus = TimedBus(nodes, 500e3, data_bit_rate=2e6)
    frame = Frame(0x123, bytes(range(length)), fd=True, bit_rate_switch=True, iso=iso)
    bus.send("a", frame)
    bus.run(1000, until_idle=True)
    assert bus.nodes["b"].received == [frame]
    assert bus.nodes["a"].errors == bus.nodes["b"].errors == []
    times = [sample.time_ns for sample in bus.samples if sample.node == "a"]
    names = list(frame.bit_names())
    steps = np.diff(times[: len(names)])
    assert np.allclose(steps[names.index("esi.0") : names.index("crc_del.0") - 1], 500.0)
    assert np.allclose(steps[: names.index("brs.0")], 2000.0)
    assert np.allclose(steps[names.index("crc_del.0") + 1 :], 2000.0)
    # the bit in which the rate changes goes on at the data rate after its sample point
    assert steps[names.index("brs.0")] == pytest.approx(2 * 62.5 + 6 * 62.5)
    # in the acknowledge slot the sender follows the edge of the receiver, whose quanta begin less than one later
    assert 2000.0 <= steps[names.index("crc_del.0")] <= 2100.0


@pytest.mark.parametrize("shift", [-2, 3])
def test_bt01_fd_hard_synchronisation_at_the_res_bit_of_can_fd(shift: int) -> None:
    """The edge from FDF to res restarts the bit of a receiver however far it is off, here 4 or 6 quanta with SJW 1."""
    frame = Frame(0x2AA, b"\x55", fd=True)
    bits, names = [int(bit) for bit in frame.bits()], list(frame.bit_names())
    bits[names.index("ack_slot.0")] = 0
    res = names.index("res.0")
    levels = [bit for i, bit in enumerate(bits) for _ in range(QUANTA + (2 * shift if i == res - 1 else 0))]
    bus = receiver(levels, timing=BitTiming(jump_width=1))
    begin = res * QUANTA + 2 * shift
    assert samples_after(bus, begin)[0] == begin + TO_SAMPLE
    assert bus.nodes["node"].received == [frame]


def test_bt02_janus_frame_with_resynchronising_nodes() -> None:
    """One waveform, two sample points, two different frames with valid CRC, nobody reports an error (canhack's Janus).

    Edges in the middle of bits move the nodes: with a jump width of one quantum and three such edges they stay in step.
    """
    late, early = Frame(0x2AA, b"\x4a\xbd"), Frame(0x2AA, b"\x5c\x8b")
    assert split_edges(late, early) == 3
    bus = two_faced(late, early)
    assert bus.nodes["early"].received == [early]
    assert bus.nodes["late"].received == [late]
    assert all(view.errors == [] for view in bus.nodes.values())
    assert {(sample.transmit_errors, sample.receive_errors) for sample in bus.samples} == {(0, 0)}


def test_bt02_many_split_edges_put_the_nodes_out_of_step() -> None:
    late, early = Frame(0x2AA, b"\xda\x84"), Frame(0x2AA, b"\xfe\xdd")
    assert split_edges(late, early) == 11
    assert two_faced(late, early).nodes["early"].errors != []


def two_faced(late: Frame, early: Frame) -> TimedBus:
    sampling_late, sampling_early = BitTiming(7, 7, 5, 1), BitTiming(3, 1, 15, 1)
    nodes = [
        TimedNode(Node("sender"), sampling_late),
        TimedNode(Node("early"), sampling_early),
        TimedNode(Node("late"), sampling_late),
    ]
    bus = TimedBus(nodes, BIT_RATE)
    for disturbance in janus(late, early, "sender"):
        bus.disturb(disturbance)
    bus.send("sender", late)
    bus.run(200)
    return bus


def test_glitch_in_time_reaches_only_who_samples_in_it() -> None:
    """Half a bit of the sender's line forced recessive: the receiver that samples there sees a stuff or form error."""
    nodes = [TimedNode(Node("sender")), TimedNode(Node("early"), BitTiming(4, 2, 13, 2)), TimedNode(Node("late"))]
    bus = TimedBus(nodes, BIT_RATE)
    bus.send("sender", FRAME)
    bus.disturb(Disturbance("dominant", "ack_del", begin=0.3, width=0.2))
    bus.run(NAMES.index("ack_del.0") + 2)
    assert [event.node for event in bus.events if event.place == "ack_del.0"] == ["early"]


def test_a_disturbance_may_begin_at_a_bit_of_the_bus() -> None:
    bus = TimedBus([TimedNode(Node("sender")), TimedNode(Node("other"))], BIT_RATE)
    bus.run(START)
    bus.send("sender", FRAME)
    bus.disturb(Disturbance("recessive", START + NAMES.index("data.0"), tap="receive", node="sender"))
    bus.run(100)
    assert bus.nodes["sender"].errors == ["bit"]
    assert bus.time_s == pytest.approx(104 / BIT_RATE)


@pytest.mark.parametrize("shape", [{"phase_2": 0}, {"jump_width": 6}, {"propagation": -1}, {"jump_width": 0}])
def test_impossible_timings_are_refused(shape: dict[str, int]) -> None:
    with pytest.raises(ValueError, match=r"quantum|quanta"):
        BitTiming(**shape)


def test_sample_point_of_the_default_is_three_quarters() -> None:
    assert BitTiming().quanta == QUANTA
    assert BitTiming().sample_point == 0.75


def test_same_bus_in_whole_bits_and_in_time_gives_the_same_frames_and_counters() -> None:
    """Without delays and deviations the timed bus is the bus of whole bits, error frames and repetition included."""
    results = []
    for bus in (Bus(["a", "b", "c"]), TimedBus([TimedNode(Node(name)) for name in "abc"], BIT_RATE)):
        for name in "abc":
            for i in range(5):
                bus.send(name, Frame(0x100 + 16 * i + ord(name), bytes([i, 0, 255])))
        bus.disturb(Disturbance("flip", "data.3", tap="receive", node="b", repeat=4))
        bus.disturb(Disturbance("recessive", "ack_slot", repeat=2, skip=2))
        bus.run(6000)
        events = [(event.node, event.kind, event.error, event.place) for event in bus.events]
        results.append((events, [(view.transmit_errors, view.receive_errors) for view in bus.nodes.values()]))
        results[-1][0].sort()
    assert results[0] == results[1]


def test_wires_disturbances_by_time_and_their_end() -> None:
    """A broken wire, a disturbance from a time on, and one that is withdrawn act as on the bus of whole bits."""
    line = Line(("a", "b"))
    bus = TimedBus([TimedNode(Node(name)) for name in "ab"], BIT_RATE)
    bus.connect(wiring(line, bus.names, "both_open"))
    bus.send("a", FRAME)
    bus.run(100)
    assert bus.nodes["a"].errors[:1] == ["ack"]
    bus.connect(None)
    bus.run(2000, until_idle=True)
    assert bus.nodes["b"].received == [FRAME]
    bus.forget()
    late = bus.disturb(Disturbance("flip", "data.3", tap="receive", node="b", repeat=-1, from_time_s=200 / BIT_RATE))
    bus.send("a", FRAME)
    bus.run(150)
    assert (bus.hits(late), bus.nodes["b"].received) == (0, [FRAME])
    bus.run(100)
    bus.send("a", FRAME)
    bus.run(100)
    assert bus.hits(late) >= 1
    bus.withdraw(late)
    bus.run(1000, until_idle=True)
    assert bus.nodes["b"].received == [FRAME, FRAME]
