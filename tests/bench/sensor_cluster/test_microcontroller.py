"""Sensor block and microcontroller on a simulated SPI line: the protocol, the filter, and each plausibility check."""

import math

import numpy as np
import pytest

from bench.sensor_cluster.microcontroller import REQUESTS, Microcontroller, Plausibility
from bench.sensor_cluster.sensor_block import SILENT_LINE, STARTUP_TRANSFERS, SensorBlock
from bench.sensor_cluster.words import FAILED, NORMAL, STARTING, is_intact, read_request, status_of, value_of

VALUES = np.array([-7.5, 1.25, 0.3, 0.2, -0.05, 0.01])


class Line:
    """A block and its microcontroller, 1 ms a cycle."""

    def __init__(self, **plausibility: float) -> None:
        self.block = SensorBlock()
        self.block.supply(True)
        self.twin = Microcontroller(Plausibility(**plausibility))
        self.values = VALUES.copy()
        self.ripple = 0.0

    def run(self, cycles: int, flip: int = 0) -> bool:
        valid = False
        for cycle in range(cycles):
            self.values[5] = VALUES[5] + self.ripple * (cycle % 2)
            self.block.set(self.values)
            self.block.supply(True)
            answers = np.array([self.block.transfer(int(word)) ^ flip for word in REQUESTS], np.int64)
            valid = self.twin.take(answers)
        return valid


def test_the_answer_comes_with_the_next_transfer() -> None:
    block = SensorBlock()
    block.supply(True)
    block.set(VALUES)
    for _ in range(STARTUP_TRANSFERS):
        assert status_of(block.transfer(read_request(1))) == STARTING
    block.transfer(read_request(1))
    assert value_of(block.transfer(read_request(4))) == -7500  # 1e-3 m/s² a digit
    assert value_of(block.transfer(read_request(4))) == 2000  # 1e-4 rad/s a digit


def test_a_request_with_a_wrong_crc_or_address_is_answered_as_failed() -> None:
    block = SensorBlock()
    block.supply(True)
    for wrong in (read_request(1) ^ 1, read_request(0x1F)):
        block.transfer(wrong)
        assert status_of(block.transfer(read_request(1))) == FAILED
    assert block.counts()["refused"] == 2


def test_without_supply_the_line_is_silent_and_what_is_read_is_no_word() -> None:
    block = SensorBlock()
    assert block.transfer(read_request(1)) == SILENT_LINE
    assert not is_intact(SILENT_LINE)


def test_values_pass_within_half_a_digit_once_the_block_has_started() -> None:
    line = Line()
    assert not line.run(10)
    assert line.run(40)
    assert line.twin.values == pytest.approx(VALUES, abs=5e-4)
    assert sum(line.twin.counts().values()) == line.twin.counts()["status_errors"]  # the start-up only


def test_low_pass_reaches_1_minus_1_over_e_after_its_time_constant() -> None:
    line = Line(cutoff_hz=20.0)
    line.run(50)
    line.values[0] = -3.5
    cycles = round(1000 / (2 * math.pi * 20.0))
    line.run(cycles)
    share = (line.twin.values[0] + 7.5) / 4.0
    assert share == pytest.approx(1.0 - math.exp(-cycles * 2 * math.pi * 20e-3), abs=1e-3)


@pytest.mark.parametrize(("change", "count"), [(32.0, "out_of_range"), (12.0, "jumps"), (float("nan"), "out_of_range")])
def test_implausible_values_are_held_then_refused(change: float, count: str) -> None:
    line = Line(bad_samples=5)
    line.run(50)
    before = line.twin.counts()[count]
    line.values[0] = change
    assert line.run(1)
    assert line.twin.values[0] == pytest.approx(-7.5, abs=5e-4)
    if count == "out_of_range":
        assert not line.run(5)
        line.values[0] = -7.5
        assert not line.run(10)
        assert line.run(40)
    assert line.twin.counts()[count] > before


def test_a_channel_that_stands_still_while_others_move_is_frozen() -> None:
    line = Line(frozen_samples=200)
    line.run(50)
    assert line.run(1000)  # nothing moves at all: a car that stands
    line.ripple = 1e-3
    assert not line.run(250)
    assert line.twin.counts()["frozen"] > 0


def test_flipped_bits_on_the_line_are_seen_by_the_crc() -> None:
    line = Line()
    line.run(50)
    before = line.twin.counts()["line_errors"]
    line.run(1, flip=1 << 12)
    assert line.twin.counts()["line_errors"] == before + 6
    assert line.twin.values == pytest.approx(VALUES, abs=5e-4)


def test_registers_in_a_file_are_seen_by_another_process_s_block(tmp_path) -> None:
    first = SensorBlock(tmp_path / "registers")
    first.supply(True)
    first.set(VALUES)
    second = SensorBlock(tmp_path / "registers")
    for _ in range(STARTUP_TRANSFERS + 1):
        second.transfer(read_request(2))
    word = second.transfer(read_request(2))
    assert (status_of(word), value_of(word)) == (NORMAL, 1250)
