"""Bit timing in time quanta (rule BT01): hard synchronisation, resynchronisation, sample point, delays, oscillators.

A tester drives levels with a resolution of one quantum, 1/20 of a bit; expected sample instants follow from
ISO 11898-1:2015, clause 11.3, and are counted in quanta by hand. Segments: 1 + 7 + 7 + 5, jump width 4.
"""

from collections.abc import Sequence

import numpy as np
import pytest

from can_fault_injector import Bus, Disturbance, Frame, Node
from can_fault_injector.delay_model import mean_delay_ns
from can_fault_injector.janus import janus, split_edges
from can_fault_injector.timed_bus import BitTiming, TimedBus, TimedNode
from can_fault_injector.wire_faults import Line, wiring

QUANTA, TO_SAMPLE, JUMP = 20, 15, 4
BIT_RATE = 500e3
QUANTUM_NS = 1e9 / BIT_RATE / QUANTA
START = 4
FRAME = Frame(0x2AA, b"\x55\x0f")
NAMES = list(FRAME.bit_names())


def bits_of(frame: Frame = FRAME) -> list[int]:
    bits = [int(bit) for bit in frame.bits()]
    bits[list(frame.bit_names()).index("ack_slot.0")] = 0
    return bits


def stretched(lengths: dict[int, int]) -> list[int]:
    """Levels of the frame in quanta; bit n lasts ``lengths[n]`` instead of 20."""
    return [bit for i, bit in enumerate(bits_of()) for _ in range(lengths.get(i, QUANTA))]


def receiver(levels: Sequence[int], **settings: object) -> TimedBus:
    """One node that listens to a tester, whose levels last a quantum each and begin at bit ``START``."""
    bus = TimedBus([TimedNode(Node("node", silent=True), **settings)], BIT_RATE)  # type: ignore[arg-type]
    bus.drive(levels, START, 1 / QUANTA)
    bus.run(START + len(levels) // QUANTA + 20)
    return bus


def samples_after(bus: TimedBus, quantum: int) -> list[float]:
    """Instants of the node's samples in quanta since the tester began, from an instant on."""
    begin = START * QUANTA
    times = [sample.time_ns / QUANTUM_NS - begin for sample in bus.samples if sample.node == "node"]
    return [time for time in times if time >= quantum]


def falling_edges() -> list[int]:
    """Bits of the frame that begin with an edge from recessive to dominant, SOF left out."""
    bits = bits_of()
    return [i for i in range(1, len(bits)) if bits[i] == 0 and bits[i - 1] == 1]


EDGE = falling_edges()[3]


@pytest.mark.parametrize("phase", [0.0, 0.1, 0.37, 0.5, 0.74, 0.76, 0.99])
def test_bt01_iso_7_7_2_hard_synchronisation_at_sof(phase: float) -> None:
    """Wherever the idle node is in its bit: the SOF edge restarts it, less than a quantum late."""
    bus = receiver(stretched({}), phase=phase)
    assert 0 <= samples_after(bus, 0)[0] - TO_SAMPLE < 1
    assert bus.nodes["node"].received == [FRAME]


@pytest.mark.parametrize("late", range(9))
def test_bt01_iso_7_7_3_iso_7_7_4_late_edge_lengthens_by_the_phase_error_up_to_the_jump_width(late: int) -> None:
    """The bit before the edge lasts ``late`` quanta longer: 0 < e <= SJW moves by e, more by SJW."""
    bus = receiver(stretched({EDGE - 1: QUANTA + late}))
    sample = next(time for time in samples_after(bus, EDGE * QUANTA))
    assert sample == EDGE * QUANTA + TO_SAMPLE + min(late, JUMP)


@pytest.mark.parametrize("jump", [1, 2, JUMP])
@pytest.mark.parametrize("early", range(1, 5))
def test_bt01_iso_7_7_5_iso_7_7_6_early_edge_shortens_by_the_phase_error_up_to_the_jump_width(
    early: int, jump: int
) -> None:
    """The edge lies in phase segment 2 of the bit before: the next sample is earlier, at most by SJW."""
    bus = receiver(stretched({EDGE - 1: QUANTA - early}), timing=BitTiming(jump_width=jump))
    before = (EDGE - 1) * QUANTA + TO_SAMPLE
    sample = next(time for time in samples_after(bus, before + 1))
    assert sample - before == QUANTA - min(early, jump)


@pytest.mark.parametrize("late", [1, 3])
def test_bt01_edges_from_dominant_to_recessive_move_nothing(late: int) -> None:
    bits = bits_of()
    rising = next(i for i in range(10, len(bits)) if bits[i] == 1 and bits[i - 1] == 0)
    bus = receiver(stretched({rising - 1: QUANTA + late}))
    assert samples_after(bus, rising * QUANTA)[0] == rising * QUANTA + TO_SAMPLE


def test_bt01_iso_7_7_7_one_synchronisation_between_two_samples() -> None:
    """Two falling edges in one bit: the one at 2 quanta counts, the one at 4 does not."""
    levels = stretched({})
    at = EDGE * QUANTA
    levels[at : at + 2] = [1, 1]
    levels[at + 3] = 1
    bus = receiver(levels)
    assert samples_after(bus, at)[0] == at + TO_SAMPLE + 2


def test_bt01_iso_7_7_10_no_synchronisation_on_a_glitch_in_a_dominant_bit() -> None:
    """A recessive spike ends with an edge, but the last sample was dominant."""
    bits = bits_of()
    flat = next(i for i in range(10, len(bits)) if bits[i] == 0 and bits[i - 1] == 0)
    levels = stretched({})
    levels[flat * QUANTA + 2 : flat * QUANTA + 4] = [1, 1]
    bus = receiver(levels)
    assert samples_after(bus, flat * QUANTA)[0] == flat * QUANTA + TO_SAMPLE


@pytest.mark.parametrize("length", [1, 10, 14, 15, 16, 20])
def test_bt01_iso_7_7_1_sample_point(length: int) -> None:
    """The recessive ACK delimiter is dominant for some quanta after the dominant slot: an error from the 16th on.

    The node looks at the beginning of the quantum after phase segment 1.
    """
    delimiter = NAMES.index("ack_del.0")
    levels = stretched({})
    levels[delimiter * QUANTA : delimiter * QUANTA + length] = [0] * length
    bus = receiver(levels)
    assert bus.nodes["node"].errors == (["form"] if length > TO_SAMPLE else [])


def test_bt01_dominant_pulse_in_idle_that_is_over_at_the_sample_point_is_no_sof() -> None:
    for length, begins in [(TO_SAMPLE, False), (TO_SAMPLE + 1, True)]:
        bus = receiver([0] * length + [1] * 400)
        assert bool(bus.nodes["node"].errors) == begins


def test_bt01_hard_synchronisation_in_the_intermission_from_its_second_bit_on() -> None:
    """The next SOF comes a third of a bit early or late: its edge restarts the bit."""
    for shift in (-6, 6):
        levels = [*stretched({}), *[1] * (3 * QUANTA + shift)]
        begin = len(levels)
        bus = receiver([*levels, *stretched({}), *[1] * 200])
        assert bus.nodes["node"].received == [FRAME, FRAME]
        if shift > 0:
            assert samples_after(bus, begin)[0] == begin + TO_SAMPLE


@pytest.mark.parametrize("delay_ns", [0.0, 150.0, 300.0])
def test_bt01_iso_8_7_7_sender_ignores_the_delay_of_its_own_dominant_bits(delay_ns: float) -> None:
    """The sender's bits stay 20 quanta long although it sees each of its edges late."""
    bus = TimedBus([TimedNode(Node("sender"), delay_ns=delay_ns), TimedNode(Node("other"))], BIT_RATE)
    bus.send("sender", FRAME)
    bus.run(60)
    times = np.array([sample.time_ns for sample in bus.samples if sample.node == "sender"][: NAMES.index("ack_slot.0")])
    assert np.allclose(np.diff(times), QUANTA * QUANTUM_NS)


@pytest.mark.parametrize("early", [1, 3])
def test_bt01_iso_7_7_8_second_edge_after_an_early_one_moves_nothing(early: int) -> None:
    """An edge in phase segment 2 shortens the bit; a second one before the next sample point is not followed."""
    levels = stretched({EDGE - 1: QUANTA - early})
    begin = EDGE * QUANTA - early
    levels[begin + 3] = 1
    bus = receiver(levels)
    before = (EDGE - 1) * QUANTA + TO_SAMPLE
    assert samples_after(bus, before + 1)[0] - before == QUANTA - early


@pytest.mark.parametrize("early", [1, 3])
def test_bt01_iso_7_7_11_early_edge_in_the_acknowledge_slot(early: int) -> None:
    """Somebody else acknowledges a little before the node's slot begins: its own dominant bit begins there too."""
    slot = NAMES.index("ack_slot.0")
    levels = stretched({slot - 1: QUANTA - early, slot: QUANTA + early})
    bus = TimedBus([TimedNode(Node("node"))], BIT_RATE)
    bus.drive(levels, START, 1 / QUANTA)
    bus.run(START + len(NAMES) + 4)
    before = (slot - 1) * QUANTA + TO_SAMPLE
    assert samples_after(bus, before + 1)[0] - before == QUANTA - early
    assert bus.nodes["node"].errors == []


def sender(levels: dict[int, int]) -> TimedBus:
    """A node that sends the frame from ``START`` on; a tester drives levels at some quanta, and acknowledges."""
    quanta = [1] * (len(NAMES) + 4) * QUANTA
    for quantum in range(NAMES.index("ack_slot.0") * QUANTA, NAMES.index("ack_del.0") * QUANTA):
        quanta[quantum] = 0
    for quantum, level in levels.items():
        quanta[quantum] = level
    bus = TimedBus([TimedNode(Node("node"))], BIT_RATE)
    bus.run(START)
    bus.send("node", FRAME)
    bus.drive(quanta, START, 1 / QUANTA)
    bus.run(len(NAMES) + 4)
    return bus


@pytest.mark.parametrize("length", [1, 14, 15, 16, 20])
def test_bt01_iso_8_7_1_sample_point_of_a_sender(length: int) -> None:
    delimiter = NAMES.index("ack_del.0") * QUANTA
    bus = sender({delimiter + i: 0 for i in range(length)})
    assert bus.nodes["node"].errors == (["form"] if length > TO_SAMPLE else [])


@pytest.mark.parametrize("early", range(1, 5))
def test_bt01_iso_8_7_4_early_edge_at_a_sender(early: int) -> None:
    """Another node's edge before the sender's own: its dominant bit, and all that follows, begins earlier."""
    begin = EDGE * QUANTA
    bus = sender({begin - i: 0 for i in range(1, early + 1)})
    before = (EDGE - 1) * QUANTA + TO_SAMPLE
    assert samples_after(bus, before + 1)[0] - before == QUANTA - early


@pytest.mark.parametrize("pulse", [6, 10, 14])
def test_bt01_a_sender_of_a_recessive_bit_follows_a_late_edge(pulse: int) -> None:
    """Somebody else's dominant level during a recessive bit: e > SJW moves the sample by the jump width."""
    bits = bits_of()
    recessive = next(i for i in range(14, len(bits)) if bits[i] == 1 and bits[i - 1] == 1)
    bus = sender({recessive * QUANTA + pulse: 0})
    assert samples_after(bus, recessive * QUANTA)[0] == recessive * QUANTA + TO_SAMPLE + JUMP
    assert bus.nodes["node"].errors == []


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
