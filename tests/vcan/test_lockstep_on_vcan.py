"""Two processes in lock-step over vcan, alone and with cangen of can-utils on the same bus."""

import importlib.util
import subprocess
from pathlib import Path

import pytest

from bench.links.frame import new_frames
from bench.links.registry import open_link

TESTS = Path(__file__).parents[1]


def links_test_module():
    spec = importlib.util.spec_from_file_location("links_test_barrier", TESTS / "bench" / "links" / "test_barrier.py")
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


BARRIER = links_test_module()


@pytest.mark.parametrize("text", ["socketcan:vcan0", "socketcan:vcan1,vcan0"])
def test_two_processes_see_what_one_process_sees(text: str, tmp_path: Path) -> None:
    assert BARRIER.run_in_two_processes(text, tmp_path)[:2] == BARRIER.reference()


def test_frames_of_cangen_do_no_harm(tmp_path: Path) -> None:
    """Random frames, and frames of the pair's own identifier 0x300.

    400 in a second: of 2000 a kernel in user mode on a busy machine hands out fewer than come, and no answer gets by.
    """
    generators = [
        subprocess.Popen(["cangen", "vcan0", "-g", "5", "-i"]),
        subprocess.Popen(["cangen", "vcan0", "-g", "5", "-i", "-I", "300", "-L", "0"]),
    ]
    try:
        *digests, strangers = BARRIER.run_in_two_processes("socketcan:vcan0", tmp_path)
    finally:
        for generator in generators:
            generator.terminate()
            generator.wait()
    assert tuple(digests) == BARRIER.reference()
    assert strangers > 0


def test_cangen_in_real_time_is_only_counted() -> None:
    """What the receiver of the codec makes of a bus full of random frames: nothing but counts."""
    import numpy as np

    from bench.codec.codec import AGE_NAMES, Codec
    from bench.codec.mapping_file import BUS_NAMES

    values, ages = np.zeros(len(BUS_NAMES)), np.zeros(len(AGE_NAMES))
    receiver = Codec.load().receiver("bench", values, ages)
    frames = new_frames(4096)
    with open_link("socketcan:vcan0", role="bench") as link:
        subprocess.run(["cangen", "vcan0", "-g", "0", "-n", "3000", "-I", "210", "-L", "3", "-i"], check=True)
        count = link.receive(frames)
    assert count == 3000
    accepted = receiver.accept(frames, count, 0)
    statistics = receiver.statistics()["VALVE_PUMP"]
    # one in 256 has the right CRC by chance, and few of those a counter in sequence
    assert accepted < 3000 / 256 * 2
    assert statistics["crc_errors"] > 2900
    assert sum(statistics.values()) - statistics["lost"] == 3000
