"""Bit timing in time quanta (rule BT01): hard synchronisation, resynchronisation, sample point, delays, oscillators.

A tester drives levels with a resolution of one quantum, 1/20 of a bit; expected sample instants follow from
ISO 11898-1:2015, clause 11.3, and are counted in quanta by hand. Segments: 1 + 7 + 7 + 5, jump width 4.
"""

import numpy as np
import pytest
from bit_tester import FRAME, NAMES, START
from timed_tester import (
    BIT_RATE,
    JUMP,
    QUANTA,
    QUANTUM_NS,
    TO_SAMPLE,
    receiver,
    samples_after,
    timed_counter_steps,
)

from can_fault_injector import Frame, Node
from can_fault_injector.timed_bus import BitTiming, TimedBus, TimedNode


def bits_of(frame: Frame = FRAME) -> list[int]:
    bits = [int(bit) for bit in frame.bits()]
    bits[list(frame.bit_names()).index("ack_slot.0")] = 0
    return bits


def stretched(lengths: dict[int, int]) -> list[int]:
    """Levels of the frame in quanta; bit n lasts ``lengths[n]`` instead of 20."""
    return [bit for i, bit in enumerate(bits_of()) for _ in range(lengths.get(i, QUANTA))]


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
    bus = TimedBus([TimedNode(Node("node", receive_errors=2))], BIT_RATE)
    bus.drive(levels, START, 1 / QUANTA)
    bus.run(START + len(NAMES) + 4)
    before = (slot - 1) * QUANTA + TO_SAMPLE
    assert samples_after(bus, before + 1)[0] - before == QUANTA - early
    assert bus.nodes["node"].errors == []
    assert timed_counter_steps(bus) == [(START + NAMES.index("eof.5"), 0, 1)]


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
    steps = timed_counter_steps(bus)[:1]
    assert steps == ([(START + NAMES.index("ack_del.0"), 8, 0)] if length > TO_SAMPLE else [])


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
