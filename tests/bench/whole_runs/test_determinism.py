"""Lock-step runs of one seed are equal bit for bit, whoever plays the ECU and on whichever link."""

from collections.abc import Callable

import numpy as np
import pytest

import bench
from bench.links.frame import ECU, payload
from bench.scenario.schema import ScenarioFile

COMMANDS = [f"valve_{kind}_{wheel}" for kind in ("inlet", "outlet") for wheel in ("fl", "fr", "rl", "rr")] + ["pump"]


@pytest.fixture(scope="module")
def in_process(short_stop: Callable[..., ScenarioFile]) -> bench.Run:
    return bench.run(short_stop(), record=False)


def frames_of(run: bench.Run) -> list[tuple[int, int, int, int, bytes]]:
    """Tick, sender, flags, identifier and payload of every frame."""
    numbers = ("tick", "sender", "flags", "identifier")
    return [(*(int(f[name]) for name in numbers), payload(f)) for f in run.frames]


@pytest.mark.acceptance("F-40")
def test_the_same_seed_twice(in_process: bench.Run, short_stop: Callable[..., ScenarioFile]) -> None:
    again = bench.run(short_stop(), record=False)
    assert again.data.digest() == in_process.data.digest()
    assert again.frames.tobytes() == in_process.frames.tobytes()


def test_another_seed_differs(in_process: bench.Run, short_stop: Callable[..., ScenarioFile]) -> None:
    assert bench.run(short_stop(seed=2), record=False).data.digest() != in_process.data.digest()


@pytest.mark.acceptance("F-39", "F-40")
def test_another_process_behind_a_link(
    udp_link: str, in_process: bench.Run, short_stop: Callable[..., ScenarioFile]
) -> None:
    apart = bench.run(short_stop(ecu={"kind": "emulated", "link": udp_link}), record=False)
    assert apart.data.digest() == in_process.data.digest()
    assert frames_of(apart) == frames_of(in_process)
    assert apart.verdict.verdict == in_process.verdict.verdict == "pass"


def test_a_recorded_run(in_process: bench.Run, short_stop: Callable[..., ScenarioFile], tmp_path) -> None:
    """The recording holds what a run in memory holds, and recording changes nothing."""
    from bench.recording.reading import Recording

    recorded = bench.run(short_stop(), out=tmp_path / "run")
    assert recorded.data.digest() == in_process.data.digest()
    opened = Recording.open(tmp_path / "run")
    for name in in_process.data.names:
        assert np.array_equal(opened.array(name), in_process.data.array(name), equal_nan=True), name
    assert [(f["tick"], f["flags"], f["identifier"], payload(f)) for f in opened.frames] == [
        (tick, flags, identifier, data) for tick, _, flags, identifier, data in frames_of(in_process)
    ]


@pytest.mark.acceptance("F-39")
def test_valves_of_e8_in_process_and_in_another_process() -> None:
    """In-process and separate-process lock-step runs of E8 give identical valve sequences."""
    runs = [
        bench.run("friction/e8_abs_high_grip", pacing="lockstep", ecu=kind, link=link, record=False)
        for kind, link in (("inprocess", None), ("emulated", "udp_loopback"))
    ]
    one, other = (np.column_stack([run.data.array(name) for name in COMMANDS]) for run in runs)
    assert np.array_equal(one, other)
    worked = np.count_nonzero(np.diff(one, axis=0), axis=0)
    assert worked[:8].min() > 10
    assert worked[8] > 0
    sent = [[frame for frame in frames_of(run) if frame[1] == ECU] for run in runs]
    assert sent[0] == sent[1]
