"""The SocketCAN link against the kernel, python-can and can-utils."""

import os
import shutil
import subprocess
import sys
import time

import can
import numpy as np
import pytest

from bench.links import kernel_receive
from bench.links.frame import BIT_RATE_SWITCH, ECU, ERROR, EXTENDED, FD, REMOTE, make_frame, new_frames, payload
from bench.links.interface import Link
from bench.links.registry import default_link_text, open_link
from signals.errors import LinkError

FRAMES = [
    make_frame(0x120, bytes(range(8))),
    make_frame(0x7FF),
    make_frame(0x1ABCDEF0, b"\xff\x00\x80", flags=EXTENDED),
    make_frame(0x123, flags=REMOTE),
    make_frame(0x1FFFFFFF, bytes(64), flags=EXTENDED | FD),
    make_frame(0x42, bytes(range(48)), flags=FD | BIT_RATE_SWITCH),
]


@pytest.fixture
def bench():
    with open_link("socketcan:vcan0", role="bench") as link:
        yield link


def receive_exactly(link: Link, count: int):
    frames, number = new_frames(count + 8), 0
    while number < count and link.wait(2.0):
        number += link.receive(frames, number)
    assert number == count
    return frames[:count]


def comparable(frame) -> tuple[int, int, int, bytes]:
    return int(frame["identifier"]), int(frame["flags"]), int(frame["length"]), payload(frame)


def of_message(message: can.Message) -> tuple[int, int, int, bytes]:
    flags = EXTENDED * message.is_extended_id | REMOTE * message.is_remote_frame | ERROR * message.is_error_frame
    flags |= FD * message.is_fd | BIT_RATE_SWITCH * message.bitrate_switch
    return message.arbitration_id, flags, message.dlc, bytes(message.data)


def test_python_can_hears_every_kind_of_frame(bench: Link) -> None:
    with can.Bus(interface="socketcan", channel="vcan0", fd=True) as other:
        for frame in FRAMES:
            bench.send(frame, 1)
            message = other.recv(2.0)
            assert message is not None
            assert of_message(message) == comparable(frame[0])
    assert bench.statistics()["sent"] == len(FRAMES)


def test_every_kind_of_frame_of_python_can_is_heard(bench: Link) -> None:
    with can.Bus(interface="socketcan", channel="vcan0", fd=True) as other:
        for frame in FRAMES:
            identifier, flags, length, data = comparable(frame[0])
            other.send(
                can.Message(
                    arbitration_id=identifier,
                    is_extended_id=bool(flags & EXTENDED),
                    is_remote_frame=bool(flags & REMOTE),
                    is_fd=bool(flags & FD),
                    bitrate_switch=bool(flags & BIT_RATE_SWITCH),
                    dlc=length,
                    data=None if flags & REMOTE else data,
                )
            )
        received = receive_exactly(bench, len(FRAMES))
    assert [comparable(frame) for frame in received] == [comparable(frame[0]) for frame in FRAMES]
    assert set(received["sender"]) == {ECU}


def test_error_frames_pass_both_ways(bench: Link) -> None:
    """Bus-off, CAN_ERR_BUSOFF of linux/can/error.h, as a controller's driver reports it."""
    with can.Bus(interface="socketcan", channel="vcan0") as other:
        other.send(can.Message(arbitration_id=0x40, data=bytes(8), is_error_frame=True, is_extended_id=False))
        (frame,) = receive_exactly(bench, 1)
        assert comparable(frame) == (0x40, ERROR, 8, bytes(8))
        assert bench.statistics()["error_frames"] == 1
        bench.send(make_frame(0x40, bytes(8), flags=ERROR), 1)
        message = other.recv(2.0)
        assert message is not None
        assert message.is_error_frame
        assert message.arbitration_id == 0x40


def test_own_frames_do_not_come_back_but_other_sockets_hear_them(bench: Link) -> None:
    with open_link("socketcan:vcan0", role="ecu") as ecu:
        bench.send(FRAMES[0], 1)
        receive_exactly(ecu, 1)
        assert bench.receive(new_frames(4)) == 0


def test_two_channels_are_told_apart() -> None:
    with (
        open_link("socketcan:vcan0,vcan1", role="bench") as both,
        open_link("socketcan:vcan0", role="ecu") as first,
        open_link("socketcan:vcan1", role="ecu") as second,
    ):
        assert both.channels == ("vcan0", "vcan1")
        assert both.supports_lockstep
        both.send(np.concatenate([make_frame(1, channel=0), make_frame(2, channel=1)]), 2)
        assert receive_exactly(first, 1)["identifier"].tolist() == [1]
        assert receive_exactly(second, 1)["identifier"].tolist() == [2]
        second.send(make_frame(4), 1)
        first.send(make_frame(3), 1)
        received = receive_exactly(both, 2)
        assert sorted(zip(received["channel"].tolist(), received["identifier"].tolist(), strict=True)) == [
            (0, 3),
            (1, 4),
        ]


def test_frames_bear_the_kernels_time_of_reception(bench: Link) -> None:
    with open_link("socketcan:vcan0", role="ecu") as ecu:
        before = time.time_ns()
        for _ in range(3):
            ecu.send(FRAMES[0], 1)
        after = time.time_ns()
        time.sleep(0.2)  # a stamp of the time of reading would show this
        stamps = receive_exactly(bench, 3)["timestamp_ns"]
    assert before <= stamps[0] <= stamps[1] <= stamps[2] <= after
    assert bench.statistics()["timestamp_source"] == "kernel"


def test_a_burst_of_3000_frames_arrives_whole(bench: Link) -> None:
    burst = new_frames(3000)
    burst["identifier"] = np.arange(3000) % 2048
    burst["length"] = 8
    with open_link("socketcan:vcan0", role="ecu") as ecu:
        ecu.send(burst, 3000)
    received = receive_exactly(bench, 3000)
    assert received["identifier"].tolist() == burst["identifier"].tolist()
    assert bench.statistics()["overflows"] == 0


def test_frames_that_the_kernel_dropped_are_counted(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(kernel_receive, "RECEIVE_BUFFER_BYTES", 4096)
    with open_link("socketcan:vcan0", role="bench") as bench, open_link("socketcan:vcan0", role="ecu") as ecu:
        ecu.send(new_frames(500), 500)
        into, received = new_frames(500), 0
        received = bench.receive(into)
        assert 0 < received < 500
        ecu.send(new_frames(1), 1)  # carries the count
        received += len(receive_exactly(bench, 1))
        assert bench.statistics()["overflows"] == 501 - received


def test_a_full_queue_is_counted_and_does_not_stop_the_tick() -> None:
    """A token bucket of one frame a second on vcan1: the kernel answers ENOBUFS."""
    if shutil.which("tc") is None:
        pytest.skip("no tc: sudo apt-get install iproute2")
    shape = ["tc", "qdisc", "add", "dev", "vcan1", "root", "tbf", "rate", "128bit", "burst", "16", "limit", "32"]
    if subprocess.run(shape, capture_output=True, check=False).returncode != 0:
        pytest.skip("may not shape vcan1, or no token bucket filter; run: sudo modprobe sch_tbf, as root")
    try:
        with open_link("socketcan:vcan1", role="bench") as bench:
            bench.send(new_frames(50), 50)
            statistics = bench.statistics()
    finally:
        subprocess.run(["tc", "qdisc", "del", "dev", "vcan1", "root"], check=True)
    assert statistics["sent"] + statistics["send_refused"] == 50
    assert statistics["send_refused"] >= 40


def test_default_link_is_vcan0() -> None:
    assert default_link_text() == "socketcan:vcan0"


def test_interface_that_does_not_exist() -> None:
    with pytest.raises(LinkError) as caught:
        open_link("socketcan:vcan7", role="bench")
    text = str(caught.value)
    assert "vcan7: no such interface (AF_CAN is there)" in text
    assert "sudo ip link add vcan7 type vcan && sudo ip link set vcan7 up" in text
    assert "--link udp" in text
    assert caught.value.exit_code == 4


def test_second_channel_that_does_not_exist() -> None:
    with pytest.raises(LinkError, match="vcan7"):
        open_link("socketcan:vcan0,vcan7", role="bench")


def test_interface_that_is_not_can() -> None:
    with pytest.raises(LinkError, match="lo"):
        open_link("socketcan:lo", role="bench")


@pytest.fixture
def spare_interface():
    made = subprocess.run(["ip", "link", "add", "vcan5", "type", "vcan"], capture_output=True, check=False)
    if made.returncode != 0:
        pytest.skip(f"may not make interfaces: {made.stderr.decode().strip()}; run as root, or: make vcan")
    yield "vcan5"
    subprocess.run(["ip", "link", "del", "vcan5"], check=True)


def test_interface_that_is_down(spare_interface: str) -> None:
    with pytest.raises(LinkError, match="vcan5: the interface is down") as caught:
        open_link("socketcan:vcan5", role="bench")
    assert "ip link set vcan5 up" in str(caught.value)


def test_interface_that_goes_down_meanwhile(spare_interface: str) -> None:
    subprocess.run(["ip", "link", "set", "vcan5", "up"], check=True)
    with open_link("socketcan:vcan5", role="bench") as link:
        link.send(FRAMES[0], 1)
        subprocess.run(["ip", "link", "set", "vcan5", "down"], check=True)
        with pytest.raises(LinkError, match="vcan5: the interface is down"):
            link.receive(new_frames(4))
        with pytest.raises(LinkError, match="vcan5: the interface is down"):
            link.send(FRAMES[0], 1)


def test_serial_device_without_permission() -> None:
    """A user who does not own the device; root may open everything, so a child process becomes nobody."""
    if os.getuid() != 0:
        pytest.skip("only root can become nobody; run as root, or: make vcan")
    child = os.fork()
    if child == 0:
        os.setuid(65534)
        try:
            open_link("slcan:/dev/tty1", role="bench")
        except LinkError as error:
            os._exit(0 if "no permission" in str(error) and "usermod -aG" in str(error) else 1)
        os._exit(2)
    assert os.waitstatus_to_exitcode(os.waitpid(child, 0)[1]) == 0


def test_link_text_opens_the_other_side_in_another_process(bench: Link) -> None:
    program = (
        "import sys\nfrom bench.links.registry import open_link\nfrom bench.links.frame import make_frame\n"
        "open_link(sys.argv[1], role='ecu').send(make_frame(0x210, b'hello'), 1)"
    )
    subprocess.run([sys.executable, "-c", program, bench.text], check=True)
    assert payload(receive_exactly(bench, 1)[0]) == b"hello"
