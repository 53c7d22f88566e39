"""``bench inject`` between vcan0 and vcan1: two nodes, the injector, and candump -e as listener on both sides."""

import json
import re
import signal
import subprocess
import sys
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path

import numpy as np
import pytest

from bench.links.frame import ERROR, make_frame, new_frames, payload
from bench.links.registry import open_link

FAULTS = """
faults:
  - name: flipped
    trigger: {id: 0x123, direction: to_ecu, every: 10}
    disturbance: {bit_error: {at: data.3}}
    requires: bit_model
  - name: lost
    trigger: {id: 0x124}
    disturbance: {drop: {}}
    times: 3
  - name: other
    trigger: {id: 0x71D, direction: to_bench}
    disturbance: {rewrite_id: {to: 0x05D}}
"""
EVERYTHING = "0:0,#FFFFFFFF"
"""Filter of candump: all frames, all error frames."""


def until(condition: Callable[[], bool], seconds: float = 400.0) -> None:
    end = time.monotonic() + seconds
    while not condition():
        assert time.monotonic() < end, "waited in vain"
        time.sleep(0.02)


@contextmanager
def injecting(tmp_path: Path, faults: str, *options: str) -> Iterator[Callable[[], str]]:
    """`bench inject` as a user starts it; gives a function that ends it and returns what it printed."""
    file, out, told = tmp_path / "faults.yaml", tmp_path / "out.txt", tmp_path / "err.txt"
    file.write_text(faults)
    command = [sys.executable, "-m", "bench.cli", "inject", "--from", "vcan0", "--to", "vcan1", str(file), *options]
    with out.open("w") as stream, told.open("w") as errors:
        process = subprocess.Popen(command, stdout=stream, stderr=errors)

        def end() -> str:
            process.send_signal(signal.SIGTERM)
            assert process.wait(30) == 0, told.read_text()
            return out.read_text()

        try:
            until(lambda: "forwarding" in told.read_text() or process.poll() is not None)
            yield end
        finally:
            if process.poll() is None:
                process.kill()
                process.wait()


@contextmanager
def candump(name: str, log: Path) -> Iterator[None]:
    with log.open("w") as stream:
        witness = subprocess.Popen(["stdbuf", "-oL", "candump", "-e", f"{name},{EVERYTHING}"], stdout=stream)
        time.sleep(0.5)
        try:
            yield
        finally:
            time.sleep(0.5)
            witness.terminate()
            witness.wait()


def test_candump_shows_the_error_frames_and_what_passed(tmp_path: Path) -> None:
    logs = {name: tmp_path / f"{name}.log" for name in ("vcan0", "vcan1")}
    with (
        injecting(tmp_path, FAULTS) as end,
        candump("vcan0", logs["vcan0"]),
        candump("vcan1", logs["vcan1"]),
        open_link("socketcan:vcan0", role="bench") as bench,
        open_link("socketcan:vcan1", role="ecu") as ecu,
    ):
        heard, count = new_frames(256), 0
        for number in range(20):
            bench.send(make_frame(0x123, bytes([number, 0, 0])), 1)
            bench.send(make_frame(0x124, bytes([number])), 1)
            ecu.send(make_frame(0x71D, bytes([number])), 1)
            time.sleep(0.02)
        time.sleep(1.0)
        count = ecu.receive(heard)
        printed = end()
        back = new_frames(256)
        back_count = bench.receive(back)
    frames = [frame for frame in heard[:count] if not frame["flags"] & ERROR]
    assert [payload(frame)[0] for frame in frames if frame["identifier"] == 0x123] == list(range(20))
    assert [payload(frame)[0] for frame in frames if frame["identifier"] == 0x124] == list(range(3, 20))
    assert {int(frame["identifier"]) for frame in back[:back_count] if not frame["flags"] & ERROR} == {0x05D}
    # the sender read back another level: bit error at the sender, six equal bits at the others
    told = re.sub(r"\s+", " ", logs["vcan0"].read_text())
    assert "ERRORFRAME" in told
    assert "error-on-tx" in told
    assert "protocol-violation{{tx-dominant-bit-error,error-on-tx}{data-field}}" in told
    assert re.search(r"error-counter-tx-rx\{\{8\}\{0\}\}", told)
    other = re.sub(r"\s+", " ", logs["vcan1"].read_text())
    assert "bit-stuffing-error" in other
    assert "error-on-tx" not in other
    assert "fault flipped: 2 frames in 1 runs; bit_error, bit_model, E2E class corruption" in printed
    assert re.search(r"added latency of \d+ frames: p50 \d+ us, p99 \d+ us", printed)


@pytest.mark.parametrize("bit_rate", [500_000, 1_000_000])
def test_no_frame_is_lost_at_full_load(tmp_path: Path, bit_rate: int) -> None:
    """As many frames as fit into 0.2 s of the bus: of 47 bits and 3 of intermission, the shortest there are."""
    fits = bit_rate // 5 // (47 + 3)
    with (
        injecting(tmp_path, FAULTS, "--json", "--duration", "60") as end,
        open_link("socketcan:vcan0", role="bench") as bench,
        open_link("socketcan:vcan1", role="ecu") as ecu,
    ):
        ready = new_frames(16)
        until(lambda: bench.send(make_frame(0x001), 1) or ecu.receive(ready) > 0)
        frames, heard, count = new_frames(fits), new_frames(fits + 4096), 0
        frames["identifier"] = 0x300
        while ecu.receive(ready):
            time.sleep(0.1)
        for first in range(0, fits, 100):
            bench.send(frames[first : first + 100], len(frames[first : first + 100]))
            count += ecu.receive(heard, count)
        stop = time.monotonic() + 30.0
        while np.count_nonzero(heard["identifier"][:count] == 0x300) < fits and time.monotonic() < stop:
            count += ecu.receive(heard, count)
        summary = json.loads(end())
    assert np.count_nonzero(heard["identifier"][:count] == 0x300) == fits
    assert summary["links"]["bench_side"]["overflows"] == 0
    assert summary["received"]["to_ecu"] == summary["sent"]["to_ecu"]


def test_cyclic_sending_keeps_its_duration(tmp_path: Path) -> None:
    """The times are absolute: 199 cycles of 5 ms are 0.995 s; a frame may be late here, never early."""
    command = [sys.executable, "-m", "bench.cli", "inject", "--to", "vcan0", "--send", "123#11", "--json"]
    done = subprocess.run([*command, "--every", "0.005", "--count", "200"], capture_output=True, text=True, check=True)
    report = json.loads(done.stdout)
    assert report["frames"] == 200
    assert report["planned_s"] == pytest.approx(0.995)
    assert report["took_s"] > 0.995 - report["jitter_us"]["max"] * 1e-6
