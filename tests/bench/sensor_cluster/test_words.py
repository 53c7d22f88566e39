"""Words of the SPI line against published ones and an independent CRC."""

import numpy as np
import pytest
from crccheck.crc import Crc8SaeJ1850

from bench.sensor_cluster.words import FAILED, NORMAL, address_of, answer, is_intact, read_request, status_of, value_of

# Murata SCL3300 data sheet, operations: acceleration x, y, z, self-test output, temperature, status, who am i
PUBLISHED = {0x01: 0x040000F7, 0x02: 0x080000FD, 0x03: 0x0C0000FB, 0x04: 0x100000E9, 0x05: 0x140000EF, 0x06: 0x180000E5}
PUBLISHED[0x10] = 0x40000091


@pytest.mark.parametrize(("address", "word"), PUBLISHED.items())
def test_requests_are_those_of_the_data_sheet(address: int, word: int) -> None:
    assert read_request(address) == word


def test_answers_carry_what_was_put_in_and_an_independent_crc_agrees() -> None:
    random = np.random.default_rng(7)
    for _ in range(1000):
        address, value = int(random.integers(32)), int(random.integers(-32768, 32768))
        status = int(random.choice([NORMAL, FAILED]))
        word = answer(address, status, value)
        assert (address_of(word), status_of(word), value_of(word)) == (address, status, value)
        assert Crc8SaeJ1850.calc((word >> 8).to_bytes(3, "big")) == word & 0xFF


def test_every_single_flipped_bit_breaks_a_word() -> None:
    word = answer(4, NORMAL, -1234)
    assert is_intact(word)
    assert not any(is_intact(word ^ (1 << bit)) for bit in range(32))
