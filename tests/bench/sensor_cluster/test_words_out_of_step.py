"""Master and slave on a serial line that lose each other's words, as a process that had to wait makes them do."""

import secrets
import subprocess
import sys
import threading
import time
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

import numpy as np
import pytest
import serial
from serial_line import NullModem

from bench.links.frame import new_frames
from bench.links.registry import open_link
from bench.sensor_cluster.microcontroller import REQUESTS
from bench.sensor_cluster.process import PAUSE_S, out_of_step, run_microcontroller
from bench.sensor_cluster.sensor_block import CHANNELS, FIRST_ADDRESS, SERVED, SILENT_LINE, SensorBlock
from bench.sensor_cluster.words import WORD_BYTES, address_of, is_intact, read_request

INERTIAL = 0x130
PATIENCE_S = 60.0


def _until(condition, text: str) -> None:
    end = time.monotonic() + PATIENCE_S
    while not condition():
        assert time.monotonic() < end, text
        time.sleep(0.01)


def _free_link() -> str:
    """A multicast group and port that no other test has."""
    return f"udp:239.192.{secrets.randbelow(256)}.{1 + secrets.randbelow(250)}:{20000 + secrets.randbelow(20000)}"


@contextmanager
def _slave(block: SensorBlock, registers: Path, modem: NullModem) -> Iterator[None]:
    """The slave's process at end 0 of the line, ready to answer."""
    command = [sys.executable, "-m", "bench.sensor_cluster.slave_process"]
    slave = subprocess.Popen([*command, "--registers", str(registers), "--device", modem.ends[0]])
    try:
        _until(lambda: block.memory[SERVED] > 0, "the slave did not start")
        yield
    finally:
        slave.terminate()
        slave.wait(20)
        modem.close()


def _answers(block: SensorBlock) -> np.ndarray:
    return np.array([block.transfer(int(word)) for word in REQUESTS], np.int64)


def test_answers_in_their_places_are_in_step_and_shifted_ones_are_not(tmp_path: Path) -> None:
    block = SensorBlock(tmp_path / "registers")
    assert not out_of_step(np.full(len(REQUESTS), SILENT_LINE, np.int64))
    block.supply(True)
    for _ in range(200):
        block.transfer(read_request(FIRST_ADDRESS))
    _answers(block)
    answers = _answers(block)
    assert not out_of_step(answers)
    assert all(out_of_step(np.roll(answers, shift)) for shift in range(1, len(CHANNELS)))
    shifted = np.frombuffer(b"\0" + answers.astype(">u4").tobytes()[:-1], ">u4").astype(np.int64)
    assert out_of_step(shifted)


def test_slave_is_in_step_again_after_the_masters_pause(tmp_path: Path) -> None:
    """A byte too many before a whole question leaves the slave with an unfinished word; the pause must end it.

    A machine that holds either side up for 10 ms may spoil a single try, not most of them.
    """
    block, modem = SensorBlock(tmp_path / "registers"), NullModem()
    block.supply(True)
    request = read_request(FIRST_ADDRESS + 1).to_bytes(WORD_BYTES, "big")
    in_step = 0
    with _slave(block, tmp_path / "registers", modem), serial.Serial(modem.ends[1], timeout=1.0) as port:
        for _ in range(20):
            port.write(b"\x12" + len(REQUESTS) * request)
            port.read(len(REQUESTS) * WORD_BYTES)
            time.sleep(PAUSE_S)
            port.reset_input_buffer()
            port.write(2 * request)
            answer = int.from_bytes(port.read(2 * WORD_BYTES)[WORD_BYTES:], "big")
            in_step += is_intact(answer) and address_of(answer) == FIRST_ADDRESS + 1
            time.sleep(2 * PAUSE_S)
    assert in_step > 10


@pytest.mark.parametrize(("end", "stray"), [(0, b"\x12"), (0, b"\x12\x34\x56"), (1, b"\x12\x34"), (1, b"\0" * 12)])
def test_stray_bytes_on_either_side_cost_some_frames_only(tmp_path: Path, end: int, stray: bytes) -> None:
    """Bytes too many in a question (at end 0) or an answer (at end 1), in the middle of the traffic: frames go on."""
    block, modem = SensorBlock(tmp_path / "registers"), NullModem()
    block.supply(True)
    block.set(np.zeros(len(CHANNELS)), np.arange(len(CHANNELS)))
    link, ended, heard, count = _free_link(), threading.Event(), new_frames(4096), [0]
    with (
        open_link(link, role="bench") as sending,
        open_link(link, role="ecu") as witness,
        _slave(block, tmp_path / "registers", modem),
    ):
        master = threading.Thread(
            target=run_microcontroller, args=(sending, modem.ends[1], 1_000_000, ended.is_set), daemon=True
        )

        def arrived() -> int:
            got = witness.receive(heard)
            count[0] += int(np.sum(heard["identifier"][:got] == INERTIAL))
            return count[0]

        master.start()
        try:
            _until(lambda: arrived() > 20, "no frames to begin with")
            modem.disturb(end, stray)
            before = arrived()
            _until(lambda: arrived() > before + 50, "no frames after the stray bytes")
        finally:
            ended.set()
            master.join(5.0)


def test_answers_held_back_as_by_an_adapter_on_usb_are_taken(tmp_path: Path) -> None:
    """16 ms is the latency timer that FTDI's adapters start with (its application note AN232B-04).

    After 20 good cycles a frame goes out with each of the other 80; without an answer in time there is none.
    """
    block, modem = SensorBlock(tmp_path / "registers"), NullModem()
    block.supply(True)
    block.set(np.zeros(len(CHANNELS)), np.arange(len(CHANNELS)))
    ended = threading.Event()
    with open_link(_free_link(), role="bench") as sending, serial.Serial(modem.ends[0], timeout=1.0) as port:
        master = threading.Thread(
            target=run_microcontroller, args=(sending, modem.ends[1], 1_000_000, ended.is_set), daemon=True
        )
        master.start()
        try:
            for _ in range(100):
                port.read(len(REQUESTS) * WORD_BYTES)
                time.sleep(0.016)
                port.write(b"".join(int(word).to_bytes(WORD_BYTES, "big") for word in _answers(block)))
        finally:
            ended.set()
            master.join(5.0)
            modem.close()
        assert sending.statistics()["sent"] > 10
