"""The slcan link on a pty: the same lines as python-can's own slcan, and whatever the line does to them."""

import os
import pty
import tty

import can
import pytest

from bench.links.frame import BIT_RATE_SWITCH, EXTENDED, FD, REMOTE, make_frame, new_frames, payload
from bench.links.registry import open_link
from bench.links.slcan import SlcanLink, frame_line, read_line
from signals.errors import InputError, LinkError

FRAMES = [
    make_frame(0x120, bytes(range(8))),
    make_frame(0x7FF),
    make_frame(0x1ABCDEF0, b"\xff\x00\x80", flags=EXTENDED),
    make_frame(0x123, flags=REMOTE),
    make_frame(0x1, flags=REMOTE | EXTENDED),
    make_frame(0x42, bytes(range(64)), flags=FD),
    make_frame(0x42, bytes(range(12)), flags=FD | EXTENDED),
    make_frame(0x43, bytes(range(24)), flags=FD | BIT_RATE_SWITCH),
    make_frame(0x43, bytes(range(6)), flags=FD | BIT_RATE_SWITCH | EXTENDED),
]


class Line:
    """A serial line of which the test holds the adapter's end."""

    def __init__(self) -> None:
        self.adapter, device = pty.openpty()
        tty.setraw(device)
        self.path = os.ttyname(device)
        self._device = device
        os.set_blocking(self.adapter, False)

    def read(self) -> bytes:
        try:
            return os.read(self.adapter, 1 << 16)
        except BlockingIOError:
            return b""

    def write(self, data: bytes) -> None:
        os.write(self.adapter, data)

    def close(self) -> None:
        os.close(self.adapter)
        os.close(self._device)


@pytest.fixture
def line():
    pair = Line()
    yield pair
    pair.close()


@pytest.fixture
def link(line: Line):
    with open_link(f"slcan:{line.path}@500000", role="bench") as opened:
        assert line.read() == b"C\rS6\rO\r"
        yield opened


def test_lines_equal_python_cans_for_every_kind_of_frame(line: Line) -> None:
    with can.Bus(interface="slcan", channel=line.path, sleep_after_open=0) as bus:
        line.read()
        for frame in FRAMES:
            flags = int(frame["flags"][0])
            bus.send(
                can.Message(
                    arbitration_id=int(frame["identifier"][0]),
                    is_extended_id=bool(flags & EXTENDED),
                    is_remote_frame=bool(flags & REMOTE),
                    is_fd=bool(flags & FD),
                    bitrate_switch=bool(flags & BIT_RATE_SWITCH),
                    dlc=int(frame["length"][0]),
                    data=None if flags & REMOTE else payload(frame[0]),
                )
            )
            assert line.read() == frame_line(frame[0])


def test_a_line_read_back_is_the_frame() -> None:
    for frame in FRAMES:
        record = new_frames(1)
        assert read_line(frame_line(frame[0])[:-1], record[0])
        assert record.tobytes()[16:] == frame.tobytes()[16:]  # but for tick and time


def test_frames_are_written_at_once(line: Line, link: SlcanLink) -> None:
    frames = new_frames(2)
    frames["identifier"] = 0x123, 0x456
    link.send(frames, 2)
    assert line.read() == b"t1230\rt4560\r"
    assert link.statistics()["sent"] == 2


def test_answers_errors_and_halves_of_lines(line: Line, link: SlcanLink) -> None:
    into = new_frames(8)
    line.write(b"\r\rz\rV1013\rt1232AA")
    assert link.wait(1.0)
    assert link.receive(into) == 0
    line.write(b"BB\r\a\rt12\rtXYZ0\rT00000001")
    assert link.receive(into) == 1
    assert payload(into[0]) == b"\xaa\xbb"
    line.write(b"0\r")
    assert link.receive(into) == 1
    assert into["identifier"][0] == 1
    assert into["flags"][0] == EXTENDED
    assert link.statistics()["malformed"] == 1


def test_what_does_not_fit_stays_for_the_next_call(line: Line, link: SlcanLink) -> None:
    line.write(b"t0010\rt0020\rt0030\r")
    link.wait(1.0)
    into = new_frames(2)
    assert link.receive(into) == 2
    assert link.receive(into) == 1
    assert into["identifier"].tolist() == [3, 2]


def test_a_line_that_takes_nothing_does_not_stop_the_tick(line: Line, link: SlcanLink) -> None:
    frames = new_frames(64)
    for _ in range(400):  # more than a pty holds, and nobody reads
        link.send(frames, 64)
    statistics = link.statistics()
    assert statistics["send_refused"] > 0
    assert statistics["sent"] + statistics["send_refused"] == 400 * 64
    got = b""
    while chunk := line.read():
        got += chunk
        link.receive(new_frames(1))
    assert got.count(b"t0000\r") == statistics["sent"]


def test_closing_closes_the_channel(line: Line) -> None:
    with open_link(f"slcan:{line.path}", role="bench"):
        line.read()
    assert line.read() == b"C\r"


def test_no_such_device() -> None:
    with pytest.raises(LinkError, match="no such serial device") as caught:
        open_link("slcan:/dev/ttyNONE0@500000", role="bench")
    assert "ls -l /dev/serial" in str(caught.value)


def test_no_permission(monkeypatch: pytest.MonkeyPatch) -> None:
    def denied(path: str, *_: object) -> int:
        raise PermissionError(13, "Permission denied", path)

    monkeypatch.setattr("serial.serialposix.os.open", denied)
    with pytest.raises(LinkError, match="no permission") as caught:
        open_link("slcan:/dev/ttyS0", role="bench")
    assert "usermod -aG" in str(caught.value)


def test_in_use(line: Line, link: SlcanLink) -> None:
    with pytest.raises(LinkError, match="in use"):
        open_link(f"slcan:{line.path}", role="bench")


def test_no_serial_device() -> None:
    with pytest.raises(LinkError, match="not usable as a serial device"):
        open_link("slcan:/dev/null", role="bench")


def test_bit_rate_that_slcan_does_not_have(line: Line) -> None:
    with pytest.raises(InputError, match="no bit rate") as caught:
        open_link(f"slcan:{line.path}@400000", role="bench")
    assert "500000" in str(caught.value)
