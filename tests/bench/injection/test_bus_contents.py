"""What the injector knows of the messages, against cantools and the codec's own receiver."""

import cantools
import numpy as np
import pytest

from bench.codec.codec import AGE_NAMES, Codec
from bench.codec.database import shipped_database
from bench.codec.mapping_file import BUS_NAMES
from bench.injection.contents import BusContents
from bench.injection.records import frame_of, write_frame
from bench.links.frame import new_frames
from can_fault_injector.frame import Frame

DATABASE = cantools.database.load_file(str(shipped_database()))


@pytest.fixture(scope="module")
def codec() -> Codec:
    return Codec.load()


@pytest.fixture(scope="module")
def frames(codec) -> list[Frame]:
    """One frame of each message, with random values."""
    generator = np.random.default_rng(5)
    values = generator.uniform(0.0, 50.0, len(BUS_NAMES))
    found: dict[int, Frame] = {}
    records = new_frames(64)
    for role in ("bench", "ecu"):
        transmitter = codec.transmitter(role, values)
        for tick in range(40):
            for number in range(transmitter.due(tick, records)):
                frame = frame_of(records[number])
                found[frame.identifier] = frame
    return list(found.values())


def test_decoded_signals_are_those_of_cantools(codec, frames) -> None:
    contents = BusContents(codec)
    assert len(frames) == len(DATABASE.messages)
    compared = 0
    for frame in frames:
        message = DATABASE.get_message_by_frame_id(frame.identifier)
        expected = message.decode(frame.data, decode_choices=False)
        for name, value in contents.decode(frame).items():
            if name in expected:
                assert value == pytest.approx(expected[name], abs=1e-9)
                compared += 1
    assert compared > 40


def test_a_changed_signal_leaves_the_others_and_the_protection_fits(codec, frames) -> None:
    contents = BusContents(codec)
    front = next(frame for frame in frames if frame.identifier == 0x120)
    before = contents.decode(front)
    changed = contents.protected(contents.changed(front, {"wheel_speed_fl": 12.5}))
    after = contents.decode(changed)
    assert after["wheel_speed_fl"] == pytest.approx(12.5, abs=0.01)
    assert {k: v for k, v in after.items() if k != "wheel_speed_fl"} == {
        k: v for k, v in before.items() if k != "wheel_speed_fl"
    }
    assert contents.counter(changed) == contents.counter(front)


@pytest.mark.parametrize(("repaired", "accepted"), [(False, 0), (True, 1)])
def test_the_receiver_accepts_exactly_the_repaired_frame(codec, frames, repaired, accepted) -> None:
    contents = BusContents(codec)
    front = next(frame for frame in frames if frame.identifier == 0x120)
    changed = contents.changed(front, {"wheel_speed_fl": 12.5})
    if repaired:
        changed = contents.protected(changed, counter=9)
        assert contents.counter(changed) == 9
    record = new_frames(1)
    write_frame(record[0], changed, "to_ecu", 0, 0)
    receiver = codec.receiver("ecu", np.zeros(len(BUS_NAMES)), np.zeros(len(AGE_NAMES)))
    assert receiver.accept(record, 1, 0) == accepted


def test_unknown_short_and_remote_frames_have_no_contents(codec) -> None:
    contents = BusContents(codec)
    for frame in (Frame(0x7FF, bytes(8)), Frame(0x120, b"\x00"), Frame(0x120, remote=True, dlc=8)):
        assert contents.decode(frame) == {}
        assert contents.counter(frame) is None
        assert contents.protected(frame, 3) == contents.changed(frame, {"wheel_speed_fl": 1.0}) == frame


def test_frames_survive_the_way_into_records_and_back() -> None:
    record = new_frames(1)
    for frame in (
        Frame(0x123, b"\x01\x02"),
        Frame(0x12345678, bytes(8), extended=True),
        Frame(0x7E0, remote=True, dlc=4),
        Frame(0x55, bytes(20), fd=True, bit_rate_switch=True),
    ):
        write_frame(record[0], frame, "to_bench", 3, 4)
        assert frame_of(record[0]) == frame
