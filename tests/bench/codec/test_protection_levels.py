"""What a receiver believes at each level of protection: all checks, the CRC alone, nothing."""

import numpy as np
import pytest
from numpy.typing import NDArray

from bench.codec.codec import AGE_NAMES, Codec, Receiver
from bench.codec.mapping_file import BUS_NAMES, Protection
from bench.ecu.faults import FAULTS, PROTECTION, TIMEOUT
from bench.ecu.node import EcuNode
from bench.ecu.records import SPEED_FRONT
from bench.links.frame import new_frames

CODEC = Codec.load()
PERIOD = 5


def front_wheel_frames(count: int) -> NDArray[np.void]:
    """Consecutive frames of one message."""
    transmitter = CODEC.transmitter("bench", np.ones(len(BUS_NAMES)))
    frames, kept = new_frames(64), []
    for tick in range(count * PERIOD):
        sent = transmitter.due(tick, frames)
        kept.append(frames[:sent].copy())
    every = np.concatenate(kept)
    return every[every["identifier"] == 0x120][:count]


def listener(protection: Protection) -> Receiver:
    return CODEC.receiver("ecu", np.zeros(len(BUS_NAMES)), np.zeros(len(AGE_NAMES)), protection=protection)


def accepted(receiver: Receiver, frames: list[NDArray[np.void]]) -> list[int]:
    return [receiver.accept(frame, 1, number * PERIOD) for number, frame in enumerate(frames)]


@pytest.mark.parametrize(
    ("protection", "corrupted", "repeated", "jumped"), [("full", 0, 0, 0), ("crc", 0, 1, 1), ("none", 1, 1, 1)]
)
def test_each_level_refuses_what_it_checks(protection: Protection, corrupted: int, repeated: int, jumped: int) -> None:
    frames = front_wheel_frames(8)
    spoilt = frames[1:2].copy()
    spoilt["data"][0, 4] ^= 0x10
    assert accepted(listener(protection), [frames[:1], spoilt]) == [1, corrupted]
    assert accepted(listener(protection), [frames[:1], frames[:1]]) == [1, repeated]
    assert accepted(listener(protection), [frames[:1], frames[6:7]]) == [1, jumped]


def test_neither_crc_error_nor_repetition_nor_jump_moves_the_counter_of_the_check() -> None:
    """COVESA/vsomeip 1055: a check whose counter follows refused frames takes a replay for the next frame."""
    frames = front_wheel_frames(16)
    receiver = listener("full")
    spoilt = frames[9:10].copy()
    spoilt["data"][0, 4] ^= 0x10
    assert accepted(receiver, [frames[:1], spoilt, frames[:1], frames[11:12]]) == [1, 0, 0, 0]
    # after three refused frames the expected counter is still that after the first one
    assert receiver.accept(frames[1:2], 1, 4 * PERIOD) == 1
    assert receiver.statistics()["WHEEL_SPEED_FRONT"] == {
        "accepted": 2,
        "crc_errors": 1,
        "repeated": 1,
        "lost": 0,
        "wrong_sequence": 1,
        "wrong_length": 0,
    }


def ecu_after_silence(protection: Protection) -> list[int]:
    """Fault codes of an ECU that heard all messages for a second, then no front wheel speeds for another."""
    node = EcuNode("sensitive", CODEC, protection=protection)
    values = np.zeros(len(BUS_NAMES))
    values[BUS_NAMES.index("ignition")] = 1.0
    transmitter = CODEC.transmitter("bench", values)
    frames, answers = new_frames(64), new_frames(64)
    for tick in range(2000):
        count = transmitter.due(tick, frames)
        heard = frames[:count][(frames["identifier"][:count] != 0x120) | (tick < 1000)].copy()
        node.tick(tick, np.concatenate([heard, new_frames(1)]), len(heard), answers)
    return [code for code in node.statistics()["fault_codes"] if FAULTS[code].reaction == "abs off"]


def test_only_full_protection_watches_for_missing_messages() -> None:
    assert ecu_after_silence("full") == [TIMEOUT + SPEED_FRONT]
    assert ecu_after_silence("crc") == []
    assert ecu_after_silence("none") == []


def test_refused_frames_are_a_fault_of_their_own_under_crc() -> None:
    node = EcuNode("sensitive", CODEC, protection="crc")
    transmitter = CODEC.transmitter("bench", np.ones(len(BUS_NAMES)))
    frames, answers = new_frames(64), new_frames(64)
    for tick in range(1000):
        count = transmitter.due(tick, frames)
        frames["data"][:count, 3][frames["identifier"][:count] == 0x120] ^= 1
        node.tick(tick, frames, count, answers)
    assert PROTECTION + SPEED_FRONT in node.statistics()["fault_codes"]
