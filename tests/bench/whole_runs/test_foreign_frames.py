"""Frames of somebody else on the link do no harm: same valves, same verdict, counted as unknown."""

import subprocess
import sys
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path

import numpy as np
import pytest

import bench
from bench.links.available import MULTICAST_ROUTE, draw_group_and_port, multicast_works
from bench.links.frame import EXTENDED, FOREIGN
from bench.scenario.schema import ScenarioFile

ROOT = Path(__file__).parents[3]
STRANGER = """
import sys, time
import numpy as np
from bench.links.frame import EXTENDED, REMOTE, new_frames
from bench.links.registry import open_link

random = np.random.default_rng(1)
frames = new_frames(4)
with open_link(sys.argv[1], role="injector") as link:
    while True:
        frames["identifier"] = random.integers(0x400, 0x700, 4)  # none of these is in the database
        frames["identifier"][3] = 0x210                         # this one is, as an extended frame
        frames["flags"] = 0, REMOTE, EXTENDED, EXTENDED
        frames["length"] = random.integers(0, 9, 4)
        frames["data"][:, :8] = random.integers(0, 256, (4, 8))
        link.send(frames, 4)
        time.sleep(0.005)
"""

pytestmark = pytest.mark.skipif(not multicast_works(), reason=f"no multicast route: {MULTICAST_ROUTE}")


@contextmanager
def stranger_on(link: str) -> Iterator[None]:
    process = subprocess.Popen([sys.executable, "-c", STRANGER, link], cwd=ROOT)
    try:
        yield
        assert process.poll() is None, "the stranger was not there until the end"
    finally:
        process.terminate()
        process.wait()


@pytest.fixture
def link() -> str:
    group, port = draw_group_and_port()
    return f"udp:{group}:{port}"


def test_in_lock_step_everything_but_the_bus_load_is_equal(link: str, short_stop: Callable[..., ScenarioFile]) -> None:
    alone = bench.run(short_stop(), record=False)
    with stranger_on(link):
        disturbed = bench.run(short_stop(ecu={"kind": "emulated", "link": link}), record=False)
    foreign = disturbed.frames["sender"] == FOREIGN
    assert foreign.sum() > 10
    assert disturbed.verdict.timing["frames_unknown"] >= np.sum(foreign) / 2  # remote frames are no data frames
    assert disturbed.verdict.timing["frames_rejected"] == 0
    assert disturbed.verdict.verdict == alone.verdict.verdict
    for name in alone.data.names:
        if name != "bus_load":
            assert np.array_equal(disturbed.data.array(name), alone.data.array(name), equal_nan=True), name


@pytest.mark.real_time
def test_in_real_time_they_are_only_counted(link: str, short_stop: Callable[..., ScenarioFile]) -> None:
    with stranger_on(link):
        run = bench.run(short_stop(ecu={"kind": "emulated", "link": link}, pacing="realtime"), record=False)
    assert run.verdict.timing["frames_unknown"] > 10
    assert run.verdict.timing["frames_rejected"] == 0
    assert run.verdict.verdict in ("pass", "inconclusive")  # a busy machine may be late too often
    valve_frames = run.frames[(run.frames["identifier"] == 0x210) & (run.frames["flags"] & EXTENDED == 0)]
    assert run.verdict.timing["frames_from_ecu"]["VALVE_PUMP"]["accepted"] == len(valve_frames) > 300
