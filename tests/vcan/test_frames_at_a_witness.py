"""candump of can-utils as an independent witness of what the codec and the link put on the bus."""

import re
import subprocess
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path

import cantools
import numpy as np
import pytest

from bench.codec.codec import Codec
from bench.codec.database import shipped_database
from bench.codec.mapping_file import BUS_NAMES
from bench.links.frame import make_frame, new_frames
from bench.links.interface import Link
from bench.links.registry import open_link

TICKS = 2000
MARK = 0x001
LINE = re.compile(r"\((?P<time>[\d.]+)\) vcan0 (?P<identifier>[0-9A-F]+)#(?P<data>[0-9A-F]*)")


def until(condition: Callable[[], bool]) -> None:
    """Ask again and again, at most half a minute."""
    for _ in range(600):
        if condition():
            return
        time.sleep(0.05)
    pytest.fail("candump did not see the frames that mark begin and end")


@contextmanager
def candump(log: Path, link: Link) -> Iterator[None]:
    """Log vcan0 from a first to a last frame of identifier MARK."""
    with log.open("w") as file:
        witness = subprocess.Popen(["stdbuf", "-oL", "candump", "-L", "-r", "4194304", "vcan0"], stdout=file)
        mark = make_frame(MARK)
        until(lambda: link.send(mark, 1) or bool(log.read_text()))
        yield
        mark = make_frame(MARK, b"end")
        link.send(mark, 1)
        until(lambda: b"end".hex().upper() in log.read_text())
        witness.terminate()
        witness.wait()


@dataclass
class Seen:
    """What candump saw: time and payload of each frame by identifier; and when the sender began each tick, s."""

    frames: dict[int, list[tuple[float, bytes]]]
    tick_begin: list[float]


@pytest.fixture(scope="module")
def seen(tmp_path_factory: pytest.TempPathFactory) -> Seen:
    """Both sides send for two seconds of bench time."""
    log = tmp_path_factory.mktemp("witness") / "candump.log"
    codec, values, frames = Codec.load(), np.zeros(len(BUS_NAMES)), new_frames(64)
    transmitters = [codec.transmitter(role, values) for role in ("bench", "ecu")]
    values[BUS_NAMES.index("wheel_speed_fl")] = 87.65
    with open_link("socketcan:vcan0", role="bench") as link, candump(log, link):
        start, tick_begin = time.monotonic(), []
        for tick in range(TICKS):
            time.sleep(max(0.0, start + tick * 1e-3 - time.monotonic()))
            tick_begin.append(time.monotonic())
            for transmitter in transmitters:
                link.send(frames, transmitter.due(tick, frames))
        assert link.statistics()["send_refused"] == 0
    heard: dict[int, list[tuple[float, bytes]]] = {}
    for line in log.read_text().splitlines():
        match = LINE.match(line)
        assert match is not None, line
        heard.setdefault(int(match["identifier"], 16), []).append((float(match["time"]), bytes.fromhex(match["data"])))
    del heard[MARK]
    return Seen(heard, tick_begin)


DATABASE = cantools.database.load_file(str(shipped_database()))


def test_exactly_the_identifiers_of_the_database(seen) -> None:
    assert sorted(seen.frames) == sorted(message.frame_id for message in DATABASE.messages)


@pytest.mark.parametrize("message", DATABASE.messages, ids=lambda message: message.name)
def test_count_length_and_period(seen, message) -> None:
    times = [instant for instant, _ in seen.frames[message.frame_id]]
    offset = message.dbc.attributes["GenMsgStartDelayTime"].value if message.name not in OFFSET_ZERO else 0
    ticks = range(offset, TICKS, message.cycle_time)
    assert len(times) == len(ticks)
    assert {len(data) for _, data in seen.frames[message.frame_id]} == {message.length}
    # seen in the very ticks that the database tells; a busy machine makes some ticks longer than others
    sent = [seen.tick_begin[tick] for tick in ticks]
    assert np.median(np.abs(np.diff(times) - np.diff(sent))) < 0.05e-3 * message.cycle_time


OFFSET_ZERO = {m.name for m in DATABASE.messages if "GenMsgStartDelayTime" not in m.dbc.attributes}


def test_counters_and_values_as_the_database_reads_them(seen) -> None:
    message = DATABASE.get_message_by_name("WHEEL_SPEED_FRONT")
    decoded = [message.decode(data) for _, data in seen.frames[message.frame_id]]
    assert [row["alive_counter"] for row in decoded] == [number % 16 for number in range(len(decoded))]
    assert {row["wheel_speed_fl"] for row in decoded} == {87.65}
