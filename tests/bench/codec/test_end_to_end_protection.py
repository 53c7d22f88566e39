"""AUTOSAR E2E Profile 2 against two implementations that nobody here wrote, and what a receiver refuses."""

import numpy as np
import pytest
from cantools.autosar.end_to_end import compute_profile2_crc
from e2e.p02 import e2e_p02_check, e2e_p02_protect
from numpy.typing import NDArray

from bench.codec.codec import AGE_NAMES, Codec, Receiver
from bench.codec.kernels import profile2_crc
from bench.codec.mapping_file import BUS_NAMES
from bench.links.frame import REMOTE, new_frames

CODEC = Codec.load()
WHEEL_SPEED = BUS_NAMES.index("wheel_speed_fl")
PERIOD = 5


def sent_by_bench(ticks: int, seed: int = 1) -> list[NDArray[np.void]]:
    """All frames of the bench, tick by tick, with random values."""
    rng = np.random.default_rng(seed)
    values = np.zeros(len(BUS_NAMES))
    transmitter = CODEC.transmitter("bench", values)
    frames, ticks_of_frames = new_frames(64), []
    for tick in range(ticks):
        values[:] = rng.uniform(0.0, 1.0, len(values))
        count = transmitter.due(tick, frames)
        ticks_of_frames.append(frames[:count].copy())
    return ticks_of_frames


def front_wheel_frames(count: int) -> NDArray[np.void]:
    """Consecutive frames of one message."""
    frames = np.concatenate(sent_by_bench(count * PERIOD))
    return frames[frames["identifier"] == 0x120][:count]


def listener() -> tuple[Receiver, NDArray[np.float64], NDArray[np.float64]]:
    values, ages = np.zeros(len(BUS_NAMES)), np.zeros(len(AGE_NAMES))
    return CODEC.receiver("ecu", values, ages), values, ages


def test_crc_equals_cantools_and_autosar_e2e_on_random_payloads() -> None:
    rng = np.random.default_rng(2)
    for _ in range(5_000):
        length = int(rng.integers(2, 9))
        payload = bytearray(rng.bytes(length))
        data_ids = rng.bytes(16)
        counter = payload[1] & 15
        ours = profile2_crc(np.frombuffer(bytes(payload), np.uint8), length, data_ids[counter])
        assert ours == compute_profile2_crc(bytes(payload), data_ids[counter])
        payload[0] = ours
        assert e2e_p02_check(bytes(payload), data_ids, length=length)


def test_every_frame_of_a_run_is_what_autosar_e2e_would_have_sent() -> None:
    carriers = {c.message.identifier: c for c in CODEC.layout.carriers}
    last: dict[int, int] = {}
    for frame in np.concatenate(sent_by_bench(200)):
        carrier = carriers[int(frame["identifier"])]
        length = int(frame["length"])
        payload = bytes(frame["data"][:length])
        again = bytearray(payload)
        e2e_p02_protect(again, bytes(carrier.data_ids), length=length, increment_counter=False)
        assert bytes(again) == payload
        counter = payload[1] & 15
        assert counter == (last.get(carrier.message.identifier, -1) + 1) % 16
        last[carrier.message.identifier] = counter


def test_good_frames_are_accepted_and_decoded() -> None:
    receiver, values, _ = listener()
    accepted = sum(receiver.accept(frames, len(frames), tick) for tick, frames in enumerate(sent_by_bench(40)))
    statistics = receiver.statistics()
    assert accepted == sum(row["accepted"] for row in statistics.values())
    assert receiver.rejected_frames == 0
    assert statistics["WHEEL_SPEED_FRONT"]["accepted"] == 8
    assert sum(statistics["WHEEL_SPEED_FRONT"].values()) == 8
    assert 0.0 < values[WHEEL_SPEED] < 1.0


@pytest.mark.parametrize("bit", range(48))
def test_any_flipped_bit_is_refused(bit: int) -> None:
    receiver, values, _ = listener()
    good, bad = front_wheel_frames(2)[:1], front_wheel_frames(2)[1:]
    assert receiver.accept(good, 1, 0) == 1
    before = values.copy()
    bad["data"][0, bit >> 3] ^= 1 << (bit & 7)
    assert receiver.accept(bad, 1, PERIOD) == 0
    assert receiver.statistics()["WHEEL_SPEED_FRONT"]["crc_errors"] == 1
    assert np.array_equal(values, before)


def test_a_rejected_frame_does_not_move_the_expected_counter() -> None:
    receiver, _, ages = listener()
    frames = front_wheel_frames(3)
    spoilt = frames[1:2].copy()
    spoilt["data"][0, 4] ^= 0x10
    assert receiver.accept(frames[:1], 1, 0) == 1
    assert receiver.accept(spoilt, 1, 3) == 0
    assert receiver.accept(frames[1:2], 1, PERIOD) == 1
    assert receiver.accept(frames[2:3], 1, 2 * PERIOD) == 1
    assert receiver.statistics()["WHEEL_SPEED_FRONT"]["lost"] == 0
    assert ages[AGE_NAMES.index("age_wheel_speed")] > 1e3  # the rear wheels' frame has not come yet


def test_a_repeated_frame_is_refused_and_counted() -> None:
    receiver, _, _ = listener()
    frames = front_wheel_frames(2)
    assert [receiver.accept(frames[:1], 1, tick) for tick in (0, PERIOD)] == [1, 0]
    assert receiver.accept(frames[1:2], 1, 2 * PERIOD) == 1
    assert receiver.statistics()["WHEEL_SPEED_FRONT"]["repeated"] == 1


def test_lost_frames_are_counted_and_the_next_one_taken() -> None:
    receiver, _, _ = listener()
    frames = front_wheel_frames(8)
    for number in (0, 1, 5, 6):
        assert receiver.accept(frames[number : number + 1], 1, number * PERIOD) == 1
    assert receiver.statistics()["WHEEL_SPEED_FRONT"]["lost"] == 3


def test_a_counter_that_jumps_without_silence_is_out_of_sequence() -> None:
    receiver, _, _ = listener()
    frames = front_wheel_frames(8)
    assert receiver.accept(frames[:1], 1, 0) == 1
    assert receiver.accept(frames[5:6], 1, PERIOD) == 0
    assert receiver.accept(frames[1:2], 1, PERIOD) == 1
    assert receiver.statistics()["WHEEL_SPEED_FRONT"]["wrong_sequence"] == 1


@pytest.mark.parametrize("missed", [15, 16, 17, 31, 100])
def test_after_a_long_silence_any_counter_is_taken(missed: int) -> None:
    receiver, _, _ = listener()
    frames = front_wheel_frames(missed + 2)
    assert receiver.accept(frames[:1], 1, 0) == 1
    assert receiver.accept(frames[missed + 1 :], 1, (missed + 1) * PERIOD) == 1


def test_wrong_length_remote_and_foreign_frames_change_nothing() -> None:
    receiver, values, _ = listener()
    before = values.copy()
    short, remote, foreign, extended = (front_wheel_frames(1) for _ in range(4))
    short["length"] = 5
    remote["flags"] |= REMOTE
    foreign["identifier"] = 0x345
    extended["flags"] |= 1
    frames = np.concatenate([short, remote, foreign, extended])
    assert receiver.accept(frames, len(frames), 0) == 0
    assert receiver.statistics()["WHEEL_SPEED_FRONT"]["wrong_length"] == 1
    assert receiver.unknown_frames == 2
    assert np.array_equal(values, before)
