"""The slcan link on one end of a serial line, the kernel's own slcan line discipline on the other."""

import shutil
import subprocess
import time

import numpy as np
import pytest
from serial_line import NullModem

from bench.links.available import interface_is_up
from bench.links.frame import EXTENDED, REMOTE, make_frame, new_frames, payload
from bench.links.registry import open_link


@pytest.fixture
def line():
    if shutil.which("slcand") is None:
        pytest.skip("no slcand: sudo apt-get install can-utils")
    modem = NullModem()
    daemon = subprocess.Popen(["slcand", "-F", "-o", "-s6", modem.ends[1], "slcan9"])
    deadline = time.monotonic() + 5.0
    while not interface_is_up("slcan9") and time.monotonic() < deadline:
        subprocess.run(["ip", "link", "set", "slcan9", "up"], capture_output=True, check=False)
        time.sleep(0.05)
    yield modem.ends[0]
    daemon.terminate()
    daemon.wait()
    modem.close()


def receive_exactly(link, count: int):
    frames, number = new_frames(count + 8), 0
    while number < count and link.wait(2.0):
        number += link.receive(frames, number)
    assert number == count
    return frames[:count]


def test_frames_pass_both_ways_through_the_kernels_slcan(line: str) -> None:
    frames = np.concatenate(
        [
            make_frame(0x120, bytes(range(8))),
            make_frame(0x7FF),
            make_frame(0x1ABCDEF0, b"\xff\x00\x80", flags=EXTENDED),
            make_frame(0x123, flags=REMOTE),
        ]
    )
    with (
        open_link(f"slcan:{line}@500000", role="bench") as adapter,
        open_link("socketcan:slcan9", role="ecu") as kernel,
    ):
        assert not adapter.supports_lockstep
        assert not kernel.supports_lockstep
        for sender, listener in ((adapter, kernel), (kernel, adapter)):
            sender.send(frames, len(frames))
            received = receive_exactly(listener, len(frames))
            assert received["identifier"].tolist() == frames["identifier"].tolist()
            assert received["flags"].tolist() == frames["flags"].tolist()
            assert [payload(frame) for frame in received] == [payload(frame) for frame in frames]


def test_a_second_of_the_whole_bus_passes_without_loss(line: str) -> None:
    from bench.codec.codec import AGE_NAMES, Codec
    from bench.codec.mapping_file import BUS_NAMES

    codec, frames, into = Codec.load(), new_frames(64), new_frames(4096)
    values = np.random.default_rng(1).uniform(0.0, 1.0, len(BUS_NAMES))
    decoded, ages = np.zeros(len(BUS_NAMES)), np.zeros(len(AGE_NAMES))
    transmitter, receiver = codec.transmitter("bench", values), codec.receiver("ecu", decoded, ages)
    sent = accepted = 0
    with open_link(f"slcan:{line}", role="bench") as adapter, open_link("socketcan:slcan9", role="ecu") as kernel:
        for tick in range(1000):
            count = transmitter.due(tick, frames)
            adapter.send(frames, count)
            sent += count
            accepted += receiver.accept(into, kernel.receive(into), tick)
            time.sleep(0.5e-3)
        deadline = time.monotonic() + 10.0
        while accepted < sent and time.monotonic() < deadline:
            adapter.receive(frames)  # lets the line take what still waits
            accepted += receiver.accept(into, kernel.receive(into), 1000)
            time.sleep(1e-3)
    assert accepted == sent
    assert receiver.rejected_frames == 0
