"""The sensor cluster between the vehicle model and the CAN: simulated microcontroller, and a real one on the SPI line.

Friction document 1.3, 1.7, 5.3; the real microcontroller is played by its twin, a process of its own on a serial line.
"""

import secrets
import subprocess
import sys
import time
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from serial_line import NullModem

import bench
from bench.links.frame import TRANSMITTED
from bench.scenario.resolution import resolve
from bench.sensor_cluster.microcontroller import REQUESTS
from bench.sensor_cluster.words import WORD_BYTES

STOP = Path(__file__).parents[1] / "bench" / "whole_runs" / "short_stop.yaml"
LOCKSTEP = {"pacing": "lockstep", "ecu.kind": "inprocess", "estimators": {"friction_ekf": {}}}
INERTIAL = 0x130
START_PATIENCE_S = 120.0
GRAVITY_M_S2 = 9.81


def in_process(**changes: Any) -> bench.Run:
    return bench.run(resolve(STOP, {**LOCKSTEP, **changes}), record=False)


@pytest.mark.acceptance("F-11", "F-12")
def test_simulated_microcontroller_delays_by_its_filter_only(record: Callable[..., None]) -> None:
    """What it takes off a change is its time constant (3.98 ms at 40 Hz) times the change, by the filter's equation."""
    plain = in_process(**{"ecu.kind": "none"}).data
    filtered = in_process(
        **{"ecu.kind": "none", "sensor_cluster.kind": "simulated", "sensor_cluster.plausibility.cutoff_hz": 40.0}
    ).data
    before, after = plain.array("longitudinal_acceleration"), filtered.array("longitudinal_acceleration")
    begin, end = slice(50, 100), slice(950, 1050)  # before the brake, and under steady braking
    change = before[end].mean() - before[begin].mean()
    lag = float((before - after)[75:1000].sum() * 1e-3 / change)
    record("delay of the acceleration on the bus, ms", 1e3 * lag, "3.98 ± 1")
    assert lag == pytest.approx(3.98e-3, abs=1e-3)


@pytest.mark.acceptance("F-11", "F-12")
def test_supply_cut_by_the_relay_silences_the_cluster(record: Callable[..., None]) -> None:
    """No frame from 5 ms (five bad samples) after the cut until start-up (10 ms) and check (20 ms) are over."""
    relay = {"name": "relay", "target": "sensor_cluster.supply", "step": 0, "when": {"time": 0.5}, "duration": 0.2}
    run = in_process(**{"sensor_cluster.kind": "simulated", "stimuli": [relay]})
    sent = run.frames["tick"][(run.frames["identifier"] == INERTIAL) & ((run.frames["flags"] & TRANSMITTED) != 0)]
    silent = sent[(sent >= 500) & (sent <= 760)]
    gap = np.diff(silent).max()
    record("frames missing for, ms", float(gap), "200 + 10 + 20, and a cycle of 5")
    assert 215 <= gap <= 240
    assert run.data.array("friction_ekf.input_state").max() == 2
    assert run.verdict.timing["sensor_cluster"]["line_errors"] >= 200


@pytest.mark.acceptance("F-12")
def test_a_line_with_bit_errors_costs_samples_and_no_wrong_value(record: Callable[..., None]) -> None:
    clean = in_process(**{"sensor_cluster.kind": "simulated", "ecu.kind": "none"}).data
    errors = {"name": "line", "target": "sensor_cluster.bit_error_rate", "step": 2e-4}
    run = in_process(**{"sensor_cluster.kind": "simulated", "ecu.kind": "none", "stimuli": [errors]})
    difference = np.abs(run.data.array("yaw_rate") - clean.array("yaw_rate")).max()
    seen = run.verdict.timing["sensor_cluster"]["line_errors"]
    expected = len(clean.array("time")) * 6 * 32 * 2e-4
    record("broken words", float(seen), f"{expected:.0f} ± 4 sigma")
    assert seen == pytest.approx(expected, abs=4 * expected**0.5)
    assert difference < 0.02


def await_questions(modem: NullModem, process: "subprocess.Popen[bytes]") -> None:
    """Until it has asked ten times without an answer: what it needs is compiled."""
    end = time.monotonic() + START_PATIENCE_S
    while modem.bytes_written[1] < 10 * len(REQUESTS) * WORD_BYTES:
        assert process.poll() is None, f"the microcontroller ended with exit code {process.returncode}"
        assert time.monotonic() < end, f"the microcontroller asked nothing within {START_PATIENCE_S:g} s"
        time.sleep(0.05)


@pytest.fixture
def microcontroller() -> Iterator[tuple[str, str, "subprocess.Popen[bytes]"]]:
    """Serial line to, and CAN link of, a microcontroller in another process, which asks already."""
    modem = NullModem()
    link = f"udp:239.192.{secrets.randbelow(256)}.{1 + secrets.randbelow(250)}:{20000 + secrets.randbelow(20000)}"
    command = [sys.executable, "-m", "bench.cli", "cluster", "--spi", modem.ends[1], "--link", link]
    process = subprocess.Popen(command, stdout=subprocess.DEVNULL)
    try:
        await_questions(modem, process)
        yield modem.ends[0], link, process
    finally:
        process.terminate()
        process.wait(20)
        modem.close()


@pytest.mark.real_time
@pytest.mark.acceptance("F-11", "F-12")
def test_microcontroller_of_its_own_reads_the_bench_s_sensor_block(
    microcontroller: tuple[str, str, "subprocess.Popen[bytes]"], record: Callable[..., None]
) -> None:
    """Real time, three processes: its frames reach estimator and ECU; the bench sends no inertial frames itself."""
    device, link, process = microcontroller
    changes = {
        "pacing": "realtime",
        "ecu.kind": "emulated",
        "ecu.link": link,
        "sensor_cluster.kind": "external",
        "sensor_cluster.device": device,
        "estimators": {"friction_ekf": {}},
    }
    run = bench.run(resolve(STOP, changes), record=False)
    inertial = run.frames[run.frames["identifier"] == INERTIAL]
    # of some 500 frames; a busy machine lets the microcontroller's process wait
    assert process.poll() is None, f"the microcontroller ended with exit code {process.returncode}"
    assert len(inertial) > 100, run.verdict.timing
    assert not (inertial["flags"] & TRANSMITTED).any()
    # a busy machine lets the processes wait: what they sent in time is what counts
    braking = (run.data.array("speed") < 0.9 * run.data.array("speed").max()) & (run.data.array("age_inertial") < 0.02)
    seen = run.data.array("longitudinal_acceleration")[braking]
    true = run.data.array("true_longitudinal_acceleration")[braking]
    # an accelerometer in a body that dives reads gravity too
    felt = true - GRAVITY_M_S2 * np.sin(run.data.array("pitch_angle")[braking])
    record("mean deceleration over SPI and CAN, m/s²", float(-seen.mean()), f"{-felt.mean():.2f} ± 0.2, as felt")
    assert seen.mean() == pytest.approx(felt.mean(), abs=0.2)
    assert run.data.array("friction_ekf.active").max() == 1
    assert run.verdict.timing["sensor_cluster"]["answered"] > 1000
