"""Links by their text, the bus in memory, python-can's interfaces, and what a kernel without CAN says."""

import can
import numpy as np
import pytest

from bench.links.available import interface_is_up, kernel_has_can
from bench.links.frame import BENCH, ECU, make_frame, new_frames, payload
from bench.links.kernel_receive import HardwareClock
from bench.links.python_can import PythonCanLink
from bench.links.registry import default_link_text, open_link
from bench.links.virtual import CAPACITY_FRAMES
from signals.errors import InputError, LinkError


def test_virtual_nodes_hear_each_other_and_not_themselves() -> None:
    names = ("bench", "ecu", "injector")
    bench, ecu, third = (open_link("virtual:three nodes", role=role) for role in names)
    frame = make_frame(0x123, b"\x01\x02", tick=7)
    bench.send(frame, 1)
    into = new_frames(4)
    assert bench.receive(into) == 0
    for node in (ecu, third):
        assert node.receive(into, 2) == 1
        assert into[2].tobytes() == frame[0].tobytes()
        assert node.receive(into) == 0
    for node in (bench, ecu, third):
        node.close()


def test_virtual_buses_are_apart_and_keep_what_does_not_fit() -> None:
    with open_link("virtual:a", role="bench") as a, open_link("virtual:b", role="ecu") as b:
        a.send(make_frame(1), 1)
        assert not b.wait(0.0)
    with open_link("virtual:a", role="bench") as bench, open_link("virtual:a", role="ecu") as ecu:
        frames = new_frames(CAPACITY_FRAMES + 5)
        frames["identifier"] = np.arange(len(frames)) % 2048
        bench.send(frames, len(frames))
        assert ecu.wait(0.0)
        assert ecu.receive(new_frames(10)) == 10
        into = new_frames(CAPACITY_FRAMES)
        assert ecu.receive(into) == CAPACITY_FRAMES - 10
        assert into["identifier"][0] == 10
        assert ecu.statistics()["overflows"] == 5


def test_any_interface_of_python_can() -> None:
    with PythonCanLink("virtual", "some channel", None, "bench") as link:
        other = can.Bus(interface="virtual", channel="some channel")
        other.send(can.Message(arbitration_id=0x1234567, data=b"\x05", is_extended_id=True))
        into = new_frames(4)
        assert link.receive(into) == 1
        assert (into["identifier"][0], into["flags"][0], payload(into[0])) == (0x1234567, 1, b"\x05")
        assert into["sender"][0] == ECU
        link.send(make_frame(0x7FF, bytes(8)), 1)
        message = other.recv(1.0)
        assert message is not None
        assert (message.arbitration_id, bytes(message.data)) == (0x7FF, bytes(8))
        assert link.receive(into) == 0
        other.shutdown()
    assert not link.supports_lockstep


@pytest.mark.parametrize(
    ("text", "expected"),
    [
        ("sockecan:vcan0", "did you mean socketcan?"),
        ("udp:239.0.0.1", "'' is no number"),
        ("udp:10.0.0.1:20000", "no multicast group"),
        ("udp:nonsense:20000", "no multicast group"),
        ("udp_loopback:1", "'' is no number"),
        ("socketcan:", "one or two interfaces"),
        ("socketcan:a,b,c", "one or two interfaces"),
        ("slcan:", "no serial device"),
        ("slcan:/dev/ttyUSB0@fast", "'fast' is no number"),
        ("pcan:", "no channel"),
        ("", "no kind of link"),
    ],
)
def test_texts_that_are_no_link(text: str, expected: str) -> None:
    with pytest.raises(InputError) as caught:
        open_link(text, role="bench")
    assert expected in str(caught.value)
    assert caught.value.exit_code == 2


def test_interface_of_python_can_that_cannot_be_opened() -> None:
    with pytest.raises(LinkError, match="python-can cannot open it") as caught:
        open_link("pcan:PCAN_USBBUS1@500000", role="bench")
    assert caught.value.exit_code == 4


@pytest.mark.skipif(kernel_has_can(), reason="this kernel has CAN")
def test_kernel_without_can_names_the_ways_out() -> None:
    with pytest.raises(LinkError) as caught:
        open_link("socketcan:vcan0", role="bench")
    text = str(caught.value)
    assert "AF_CAN" in text
    assert "ci/can_kernel" in text
    assert "--link udp" in text


def test_default_link_can_be_opened_by_both_sides() -> None:
    text = default_link_text()
    assert text.startswith("socketcan:vcan0" if interface_is_up("vcan0") else "udp")
    with open_link(text, role="bench") as bench, open_link(text, role="ecu") as ecu:
        assert bench.supports_lockstep
        bench.send(make_frame(0x55), 1)
        assert ecu.wait(1.0)
        into = new_frames(1)
        assert ecu.receive(into) == 1
        assert into["sender"][0] == BENCH


def test_without_multicast_the_default_is_loopback(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("bench.links.registry.multicast_works", lambda: False)
    monkeypatch.setattr("bench.links.registry.kernel_has_can", lambda: False)
    assert default_link_text().startswith("udp_loopback:")


def test_hardware_clock_follows_offset_and_drift() -> None:
    """A hardware clock 50 ppm slow, kernel stamps 5 to 300 µs late: mapped within 10 µs once the best stamp came by."""
    rng, clock = np.random.default_rng(3), HardwareClock()
    true_ns = np.arange(1, 20_000) * 1_000_000
    hardware = (true_ns * (1 - 50e-6)).astype(np.int64) - 123_456_789
    software = true_ns + rng.integers(5_000, 300_000, len(true_ns))
    mapped = np.array([clock.realtime_ns(int(h), int(s)) for h, s in zip(hardware, software, strict=True)])
    error = (mapped - true_ns)[1000:]
    assert abs(error).max() < 20_000
    assert abs(software - true_ns)[1000:].max() > 250_000
