"""Pulses shorter than a bit reach the nodes that sample inside them, and no others; Janus frames in whole bits."""

import numpy as np
import pytest

from can_fault_injector import Bus, Disturbance, Frame, Node
from can_fault_injector.janus import differing_bits, janus

FRAME = Frame(0x2AA, b"\x55\x0f")
NODES = [Node("sender", sample_point=0.8), Node("early", sample_point=0.6), Node("late", sample_point=0.85)]


@pytest.mark.parametrize(
    ("begin", "width", "victims"),
    [
        (0.0, 0.6, set()),
        (0.59, 0.02, {"early"}),
        (0.5, 0.31, {"early", "sender"}),
        (0.61, 0.18, set()),
        (0.79, 0.02, {"sender"}),
        (0.81, 0.19, {"late"}),
        (0.0, 1.0, {"sender", "early", "late"}),
    ],
)
def test_pulse_on_the_bus_is_seen_where_it_covers_the_sample_point(
    begin: float, width: float, victims: set[str]
) -> None:
    """A dominant pulse in the recessive ACK delimiter: a form error for who samples inside it (FC01)."""
    bus = Bus(NODES)
    bus.send("sender", FRAME)
    bus.disturb(Disturbance("dominant", "ack_del", begin=begin, width=width))
    bus.run(len(FRAME.bits()))
    position = list(FRAME.bit_names()).index("ack_del.0")
    assert {event.node for event in bus.events if event.kind == "error" and event.bit == position} == victims


def test_pulse_at_one_receive_line_reaches_that_node_only() -> None:
    pulse = Disturbance("dominant", "ack_del", tap="receive", node="late", begin=0.8, width=0.1)
    bus = Bus(NODES)
    bus.send("sender", FRAME)
    bus.disturb(pulse)
    bus.run(list(FRAME.bit_names()).index("ack_del.0") + 1)
    assert [event.node for event in bus.events if event.kind == "error"] == ["late"]


def test_pulse_on_a_transmit_line_splits_the_receivers() -> None:
    """The first half of a data bit of the sender's line is wrong: only who samples there reads it."""
    bus = Bus([Node("sender", sample_point=0.8), Node("early", sample_point=0.4), Node("late", sample_point=0.8)])
    bus.send("sender", FRAME)
    bus.disturb(Disturbance("flip", "data.3", tap="transmit", node="sender", width=0.5))
    bus.run(list(FRAME.bit_names()).index("data.3") + 1)
    assert bus.trace.seen[-1].tolist() == [1 - bit for bit in (0, 1, 0)]
    assert bus.trace.driven[-1, 0] == bus.trace.seen[-1, 0]


def _twins() -> tuple[Frame, Frame]:
    """Two frames of one identifier and equal length on the wire with different data."""
    generator = np.random.default_rng(5)
    while True:
        late, early = (Frame(0x2AA, generator.bytes(2)) for _ in range(2))
        if late.bits().size == early.bits().size and late.data != early.data:
            return late, early


def test_bt02_janus_frame_is_read_as_two_different_frames() -> None:
    late, early = _twins()
    bus = Bus([Node("sender", sample_point=0.8), Node("early", sample_point=0.3), Node("late", sample_point=0.8)])
    for disturbance in janus(late, early, "sender"):
        bus.disturb(disturbance)
    bus.send("sender", late)
    bus.run(400, until_idle=True)
    assert bus.nodes["early"].received == [early]
    assert bus.nodes["late"].received == [late]
    assert bus.nodes["sender"].counter_steps == []
    assert all(view.errors == [] for view in bus.nodes.values())


def test_janus_frames_of_different_length_are_refused() -> None:
    with pytest.raises(ValueError, match="equal length"):
        differing_bits(Frame(0x2AA, b"\x00"), Frame(0x2AA, b"\x55\x55"))


@pytest.mark.parametrize("pulse", [(0.5, 0.6), (-0.1, 0.2), (0.5, 0.0), (1.0, 0.1)])
def test_pulses_outside_the_bit_are_refused(pulse: tuple[float, float]) -> None:
    with pytest.raises(ValueError, match="inside the bit"):
        Disturbance("flip", "data.0", begin=pulse[0], width=pulse[1])
    with pytest.raises(ValueError, match="sample_point"):
        Node("a", sample_point=1.0)


def test_sample_points_change_nothing_without_pulses() -> None:
    """Neutral values: the trace is the same bit for bit."""
    traces = []
    for points in [(0.75, 0.75), (0.5, 0.9)]:
        bus = Bus([Node(name, sample_point=point) for name, point in zip("ab", points, strict=True)])
        bus.send("a", FRAME)
        bus.disturb(Disturbance("flip", "data.3"))
        bus.run(300, until_idle=True)
        traces.append(np.hstack([bus.trace.bus[:, None], bus.trace.seen, bus.trace.phase]))
    assert np.array_equal(*traces)
