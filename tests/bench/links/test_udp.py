"""The UDP links: nothing lost, nothing altered, and python-can's own users are on the same bus."""

import can
import numpy as np
import pytest

from bench.links.available import MULTICAST_ROUTE, multicast_works
from bench.links.frame import BIT_RATE_SWITCH, ECU, ERROR, EXTENDED, FD, REMOTE, make_frame, new_frames, payload
from bench.links.interface import Link
from bench.links.registry import open_link
from bench.links.udp_loopback_bus import UdpLoopbackBus
from signals.errors import LinkError

FRAMES = [
    make_frame(0x120, bytes(range(8))),
    make_frame(0x7FF),
    make_frame(0x1ABCDEF0, b"\xff\x00\x80", flags=EXTENDED),
    make_frame(0x123, b"", flags=REMOTE),
    make_frame(0x42, bytes(range(64)), flags=FD | BIT_RATE_SWITCH),
    make_frame(0x004, bytes(8), flags=ERROR),
]


@pytest.fixture(params=["udp", "udp_loopback"])
def bench(request: pytest.FixtureRequest):
    if request.param == "udp" and not multicast_works():
        pytest.skip(f"no multicast route; {MULTICAST_ROUTE}")
    with open_link(request.param, role="bench") as link:
        yield link


@pytest.fixture
def ecu(bench: Link):
    with open_link(bench.text, role="ecu") as link:
        yield link


def receive_exactly(link: Link, count: int):
    """The next ``count`` frames, waiting at most a second for each."""
    frames, number = new_frames(count + 8), 0
    while number < count and link.wait(1.0):
        number += link.receive(frames, number)
    assert number == count
    return frames[:count]


def python_can_bus(link: Link) -> can.BusABC:
    first, second = link.text.split(":")[1:]
    if link.kind == "udp":
        return can.Bus(interface="udp_multicast", channel=first, port=int(second), hop_limit=0)
    return UdpLoopbackBus(channel=f"{second}:{first}")


def comparable(frame) -> tuple[int, int, int, bytes]:
    return int(frame["identifier"]), int(frame["flags"]), int(frame["length"]), payload(frame)


def test_every_kind_of_frame_passes_unaltered_and_in_order(bench: Link, ecu: Link) -> None:
    sent = np.concatenate(FRAMES)
    ecu.send(sent, len(sent))
    received = receive_exactly(bench, len(sent))
    assert [comparable(frame) for frame in received] == [comparable(frame) for frame in sent]
    assert set(received["sender"]) == {ECU}
    assert set(received["tick"]) == {0}
    stamps = received["timestamp_ns"]
    assert (np.diff(stamps) >= 0).all()
    assert stamps[0] > 1_600_000_000_000_000_000  # CLOCK_REALTIME, from the kernel


def test_own_frames_do_not_come_back(bench: Link, ecu: Link) -> None:
    bench.send(make_frame(0x1), 1)
    receive_exactly(ecu, 1)
    assert bench.receive(new_frames(4)) == 0


def test_a_burst_of_3000_frames_arrives_whole_and_in_order(bench: Link, ecu: Link) -> None:
    burst = new_frames(3000)
    burst["identifier"] = np.arange(3000) % 2048
    burst["length"] = 8
    bench.send(burst, 3000)
    received = receive_exactly(ecu, 3000)
    assert received["identifier"].tolist() == burst["identifier"].tolist()
    statistics = ecu.statistics()
    assert (statistics["received"], statistics["overflows"], statistics["malformed"]) == (3000, 0, 0)


def test_what_does_not_fit_stays_for_the_next_call(bench: Link, ecu: Link) -> None:
    frames = new_frames(5)
    frames["identifier"] = range(5)
    bench.send(frames, 5)
    receive_exactly(ecu, 0)
    assert ecu.wait(1.0)
    into = new_frames(3)
    assert ecu.receive(into, 1) == 2
    assert into["identifier"].tolist() == [0, 0, 1]
    assert ecu.receive(into) == 3
    assert into["identifier"].tolist() == [2, 3, 4]


def test_python_can_hears_us(bench: Link) -> None:
    with python_can_bus(bench) as other:
        for frame in FRAMES:
            bench.send(frame, 1)
            message = other.recv(1.0)
            assert message is not None
            flags = (
                EXTENDED * message.is_extended_id | REMOTE * message.is_remote_frame | ERROR * message.is_error_frame
            )
            flags |= FD * message.is_fd | BIT_RATE_SWITCH * message.bitrate_switch
            assert (message.arbitration_id, flags, message.dlc, bytes(message.data)) == comparable(frame[0])


def test_we_hear_python_can(bench: Link) -> None:
    with python_can_bus(bench) as other:
        for identifier, extended, data in ((1, False, b""), (0x7FF, False, bytes(8)), (0x1FFFFFFF, True, b"\x01")):
            other.send(can.Message(arbitration_id=identifier, is_extended_id=extended, data=data))
        received = receive_exactly(bench, 3)
    assert [comparable(frame) for frame in received] == [
        (1, 0, 0, b""),
        (0x7FF, 0, 8, bytes(8)),
        (0x1FFFFFFF, EXTENDED, 1, b"\x01"),
    ]


@pytest.mark.parametrize("rubbish", [b"", b"\x00", b"{}", b"\x8b" + bytes(200), b"\x80", bytes(4000)])
def test_rubbish_is_dropped_and_counted(bench: Link, ecu: Link, rubbish: bytes) -> None:
    ecu._sender.send(rubbish)
    ecu.send(make_frame(0x11, b"good"), 1)
    ecu._sender.send(rubbish)
    into, number = new_frames(8), 0
    while number < 1 and bench.wait(1.0):
        number += bench.receive(into, number)
    while bench.statistics()["malformed"] < 2 and bench.wait(1.0):
        assert bench.receive(into, number) == 0
    assert payload(into[0]) == b"good"
    assert bench.statistics()["malformed"] == 2


def test_multicast_stays_on_this_machine(bench: Link) -> None:
    if bench.kind == "udp":
        assert bench._sender.getsockopt(0, 33) == 0  # IPPROTO_IP, IP_MULTICAST_TTL


def test_two_benches_never_mix() -> None:
    with open_link("udp_loopback", role="bench") as one, open_link("udp_loopback", role="bench") as two:
        assert one.text != two.text
    if multicast_works():
        with open_link("udp", role="bench") as one, open_link("udp", role="bench") as two:
            assert one.text != two.text
            one.send(make_frame(0x1), 1)
            assert not two.wait(0.05)


def test_a_taken_port_is_a_clear_error() -> None:
    with open_link("udp_loopback", role="bench") as link, pytest.raises(LinkError, match=r"port \d+: Address already"):
        open_link(link.text, role="bench")


def test_udp_loopback_is_an_interface_of_python_can() -> None:
    with can.Bus(interface="udp_loopback", channel="0:9") as bus:
        assert isinstance(bus, UdpLoopbackBus)
    with pytest.raises(can.CanInitializationError, match="OWN_PORT:PEER_PORT"):
        UdpLoopbackBus(channel="nonsense")
