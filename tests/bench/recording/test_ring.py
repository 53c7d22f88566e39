"""The ring: what one writes, others read; full, overtaken, torn and killed."""

import threading
import time
from pathlib import Path

import numpy as np
import pytest
from synthetic_loop import SIGNALS, frame_numbers, frames, row, rows, schema

from bench.recording.ring import FAILED, FRAMES_BEGUN, RingReader, RingWriter, place_for_ring
from bench.recording.schema import RunSchema
from signals.errors import InputError, RunError


@pytest.fixture
def path(tmp_path: Path) -> Path:
    return tmp_path / "signals.ring"


def fill(writer: RingWriter, count: int, first: int = 0) -> None:
    for tick in range(first, first + count):
        writer.write_row(row(tick), tick)


def test_schema_survives_the_file(path: Path) -> None:
    RingWriter(path, schema(7))
    found = RingReader(path).schema
    assert found == schema(7)
    assert RunSchema.from_json(found.to_json()) == found


def test_rows_arrive_whole_and_once(path: Path) -> None:
    writer = RingWriter(path, schema(), rows=64)
    reader = RingReader(path)
    fill(writer, 40)
    first, ticks, values = reader.take_rows(limit=30)
    assert (first, ticks.tolist()) == (0, list(range(30)))
    fill(writer, 20, first=40)
    first, ticks, values = reader.take_rows()
    assert (first, len(ticks)) == (30, 30)
    assert np.array_equal(values, rows(60)[30:])
    assert len(reader.take_rows()[1]) == 0


def test_several_readers_each_see_everything(path: Path) -> None:
    writer = RingWriter(path, schema(), rows=64)
    readers = [RingReader(path), RingReader(path), RingReader(path, recorder=True)]
    fill(writer, 10)
    assert [len(reader.take_rows()[1]) for reader in readers] == [10, 10, 10]


def test_latest_row(path: Path) -> None:
    writer = RingWriter(path, schema(), rows=64)
    reader = RingReader(path)
    assert reader.latest() is None
    fill(writer, 100)
    assert np.array_equal(reader.latest(), row(99))
    reader.skip_to_newest()
    assert len(reader.take_rows()[1]) == 0


def test_in_real_time_the_oldest_rows_are_overwritten(path: Path) -> None:
    writer = RingWriter(path, schema(), rows=64)
    reader = RingReader(path)
    fill(writer, 200)
    first, ticks, values = reader.take_rows()
    # one slot less than the capacity: the writer may be at work on the next
    assert (first, len(ticks)) == (137, 63)
    assert np.array_equal(values, rows(200)[137:])


def test_frames_wrap_around_the_end(path: Path) -> None:
    writer = RingWriter(path, schema(), frames=64)
    reader = RingReader(path)
    batch = np.zeros(100, frames(0, 1).dtype)
    seen: list[int] = []
    for first in range(0, 300, 25):
        batch[:25] = frames(first, 25)
        writer.write_frames(batch, 25)
        seen += frame_numbers(reader.take_frames()[1]).tolist()
    assert seen == list(range(300))


def test_frames_that_are_being_overwritten_are_not_read(path: Path) -> None:
    writer = RingWriter(path, schema(), frames=64)
    writer.write_frames(frames(0, 60), 60)
    # killed in the middle of the next batch: begun, not written
    writer._control[FRAMES_BEGUN] = 80
    first, records = RingReader(path).take_frames()
    assert (first, frame_numbers(records).tolist()) == (16, list(range(16, 60)))


def test_in_lockstep_the_writer_waits_for_the_recorder(path: Path) -> None:
    writer = RingWriter(path, schema(), rows=64, frames=64, flow_control=True)
    recorder = RingReader(path, recorder=True)
    taken: list[int] = []
    numbers: list[int] = []

    def record() -> None:
        while len(taken) < 1000 or len(numbers) < 1000:
            taken.extend(recorder.take_rows(16)[1].tolist())
            numbers.extend(frame_numbers(recorder.take_frames(16)[1]).tolist())
            recorder.release()
            time.sleep(1e-4)

    thread = threading.Thread(target=record)
    thread.start()
    for tick in range(1000):
        writer.write_row(row(tick), tick)
        writer.write_frames(frames(tick, 1), 1)
    thread.join(10)
    assert taken == list(range(1000))
    assert numbers == list(range(1000))


def test_what_is_taken_but_not_safe_is_not_overwritten(path: Path) -> None:
    writer = RingWriter(path, schema(), rows=64, flow_control=True)
    recorder = RingReader(path, recorder=True)
    fill(writer, 63)
    recorder.take_rows()
    writer.recorder_alive = lambda: False
    assert recorder.unreleased_rows == 63
    with pytest.raises(RunError, match="recorder ended"):
        fill(writer, 1, first=63)
    writer.recorder_alive = None
    recorder.release()
    fill(writer, 1, first=63)


def test_in_real_time_a_dead_recorder_ends_the_run_within_256_ticks(path: Path) -> None:
    writer = RingWriter(path, schema())
    fill(writer, 10)
    writer.recorder_alive = lambda: False
    with pytest.raises(RunError, match="recorder ended"):
        fill(writer, 256)


def test_a_failed_recorder_stops_the_writer(path: Path) -> None:
    writer = RingWriter(path, schema())
    RingReader(path, recorder=True).set_state(FAILED, "/runs/x: no space left on device")
    with pytest.raises(RunError, match="no space left on device"):
        fill(writer, 300)
    assert writer.error == "/runs/x: no space left on device"


def test_statistics_count_what_was_lost(path: Path) -> None:
    writer = RingWriter(path, schema())
    fill(writer, 3)
    RingReader(path, recorder=True).count_lost(2, 5)
    assert writer.statistics() == {"rows": 3, "rows_lost": 2, "frames": 0, "frames_lost": 5}


def test_closing_is_seen_by_readers(path: Path) -> None:
    writer = RingWriter(path, schema())
    reader = RingReader(path)
    assert not reader.closed
    writer.close()
    assert reader.closed


@pytest.mark.parametrize("content", [b"", b"BENCHRG1", b"x" * 100000])
def test_another_file_is_no_ring(path: Path, content: bytes) -> None:
    path.write_bytes(content)
    with pytest.raises(InputError, match="no recording ring"):
        RingReader(path)


def test_no_room_is_one_clear_message(tmp_path: Path) -> None:
    with pytest.raises(RunError, match="no room for the recording ring"):
        RingWriter(tmp_path / "missing" / "x.ring", schema())


def test_the_ring_lies_where_no_disk_can_hold_up_the_loop(tmp_path: Path) -> None:
    place = place_for_ring(tmp_path, 1 << 20)
    assert place.parent in (Path("/dev/shm"), tmp_path)
    assert place_for_ring(tmp_path, 1 << 60) == tmp_path / "signals.ring"


def test_a_row_has_every_signal_of_the_catalogue() -> None:
    assert len(row(0)) == len(SIGNALS)
