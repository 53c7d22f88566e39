"""Lengths of frames on the wire against can-utils' canframelen, as canbusload counts with it.

canframelen is no program of its own; ``canbusload -e`` adds up its exact lengths (stuff bits and three bits of
intermission included) and prints frames and bits of every second. 20 000 random classic frames go over vcan in groups,
and each group's sum has to be ours. A frame whose length differed would show unless another one made up for it in the
same group, so the groups are many. Remote frames have length code 0: can-utils 2020.11 counts data bytes that remote
frames with a length code do not have.
"""

import re
import shutil
import subprocess
import time
from collections.abc import Callable, Iterator
from pathlib import Path

import can
import numpy as np
import pytest

from can_fault_injector import Frame

pytestmark = pytest.mark.skipif(
    shutil.which("canbusload") is None, reason="needs canbusload: apt-get install can-utils"
)
GROUPS, GROUP = 10, 2000
BURST, PAUSE_S = 50, 0.02
WAIT_S, ATTEMPTS = 5, 4
INTERMISSION = 3
LINE = re.compile(r"vcan0@500000\s+(?P<frames>\d+)\s+(?P<bits>\d+)\s")


def random_frame(generator: np.random.Generator) -> Frame:
    extended, remote = bool(generator.integers(2)), generator.random() < 0.1
    identifier = int(generator.integers(1 << (29 if extended else 11)))
    length = int(generator.integers(9))
    if remote:
        return Frame(identifier, extended=extended, remote=True)
    # long runs of equal bits make stuff bits
    data = (generator.bytes(length), bytes(length), b"\xff" * length, b"\x1e" * length)[generator.integers(4)]
    return Frame(identifier, data, extended=extended)


def message(frame: Frame) -> can.Message:
    return can.Message(
        arbitration_id=frame.identifier,
        is_extended_id=frame.extended,
        is_remote_frame=frame.remote,
        dlc=frame.length_code,
        data=None if frame.remote else frame.data,
    )


class Counter:
    """Sums of what canbusload printed so far."""

    def __init__(self, log: Path) -> None:
        self._log = log

    def sums(self) -> tuple[int, int]:
        rows = [match.groups() for match in LINE.finditer(self._log.read_text())]
        return sum(int(frames) for frames, _ in rows), sum(int(bits) for _, bits in rows)


@pytest.fixture
def counter(tmp_path: Path) -> Iterator[Counter]:
    log = tmp_path / "canbusload.log"
    with log.open("w") as file:
        witness = subprocess.Popen(["stdbuf", "-oL", "canbusload", "-e", "vcan0@500000"], stdout=file)
        yield Counter(log)
        witness.terminate()
        witness.wait()


def counted(frames: list[Frame], bus: can.BusABC, counter: Counter) -> int | None:
    """Bits that canbusload adds for some frames; None if it missed some of them, as on a busy machine."""
    frames_before, bits_before = counter.sums()
    for i in range(0, len(frames), BURST):
        for frame in frames[i : i + BURST]:
            bus.send(message(frame), timeout=5)
        time.sleep(PAUSE_S)
    end = time.monotonic() + WAIT_S
    while counter.sums()[0] < frames_before + len(frames) and time.monotonic() < end:
        time.sleep(0.2)
    frames_now, bits_now = counter.sums()
    return bits_now - bits_before if frames_now - frames_before == len(frames) else None


def test_lengths_of_20_000_frames_are_those_of_canframelen(counter: Counter, witnessed: Callable[[str], None]) -> None:
    generator = np.random.default_rng(4)
    with can.Bus("vcan0", interface="socketcan") as bus:
        for _ in range(600):  # until it listens
            bus.send(can.Message(arbitration_id=1, is_extended_id=False))
            time.sleep(0.1)
            if counter.sums()[0]:
                break
        time.sleep(2.2)
        for _ in range(GROUPS):
            frames = [random_frame(generator) for _ in range(GROUP)]
            theirs = next((bits for _ in range(ATTEMPTS) if (bits := counted(frames, bus, counter)) is not None), None)
            assert theirs == sum(frame.bits().size + INTERMISSION for frame in frames)
    witnessed(f"{GROUPS * GROUP} classic frames in {GROUPS} groups: bits equal can-utils' canframelen")
