"""Frames sent by the clock: what is due when, from a log and in a cycle."""

from collections.abc import Iterator
from pathlib import Path

import pytest

from bench.injection import sending
from bench.injection.sending import Timed, cyclic, replayed, send_timed
from bench.links.frame import EXTENDED, REMOTE, new_frames, payload
from bench.links.registry import open_link
from signals.errors import InputError

LOG = """(1700000000.000000) vcan0 123#DEADBEEF
(1700000000.010000) vcan0 20000088#000082180000080000
(1700000000.020000) vcan0 12345678#01
(1700000000.050000) vcan0 7E0#R4
"""


def test_a_log_is_due_at_its_own_distances(tmp_path: Path) -> None:
    path = tmp_path / "drive.log"
    path.write_text("\n".join(line for line in LOG.splitlines() if "20000088" not in line) + "\n")
    listed = list(replayed(path, speed=2.0))
    assert [due for due, _ in listed] == pytest.approx([0.0, 0.01, 0.025], abs=1e-6)
    records = [record[0] for _, record in listed]
    assert [int(record["identifier"]) for record in records] == [0x123, 0x12345678, 0x7E0]
    assert payload(records[0]) == bytes.fromhex("DEADBEEF")
    assert [int(record["flags"]) for record in records] == [0, EXTENDED, REMOTE]


def test_cyclic_frames_do_not_add_up_errors() -> None:
    """The n-th frame is due after n cycles, whatever became of the ones before."""
    listed = list(cyclic("123#11", 0.007, 1000))
    assert listed[-1][0] == pytest.approx(999 * 0.007, abs=1e-12)


def test_everything_is_sent_once_in_order_and_never_early() -> None:
    with open_link("virtual:sending", role="bench") as sender, open_link("virtual:sending", role="ecu") as receiver:
        report = send_timed(sender, cyclic("123#11", 0.001, 50))
        heard = new_frames(64)
        assert receiver.receive(heard) == 50
    assert (report.frames, report.planned_s) == (50, pytest.approx(0.049))
    assert report.took_s >= 0.049 - report.max_us * 1e-6
    assert 0.0 <= report.p50_us <= report.p99_us <= report.max_us


class SteppedClock:
    """Time that passes in sleeping, by a quarter of a microsecond a look, and where a test says so."""

    def __init__(self) -> None:
        self.now = 100.0

    def perf_counter(self) -> float:
        self.now += 0.25e-6
        return self.now

    def sleep(self, seconds: float) -> None:
        self.now += seconds


class Deaf:
    """A link that takes everything."""

    def send(self, frames: object, count: int) -> int:
        return count


def test_the_clock_starts_when_the_first_frame_has_been_read(monkeypatch: pytest.MonkeyPatch) -> None:
    """What opening a log takes is no time of its frames: they would follow at once, and the whole be too short."""
    clock = SteppedClock()
    monkeypatch.setattr(sending, "time", clock)

    def slow_to_open() -> Iterator[Timed]:
        clock.now += 1.0
        for number, (due, frame) in enumerate(cyclic("123#11", 0.01, 400)):
            clock.now += 0.02 if number == 200 else 0.0  # a block of the log is unpacked: late, and nothing adds up
            yield due, frame

    report = send_timed(Deaf(), slow_to_open())  # type: ignore[arg-type]
    assert report.planned_s == pytest.approx(3.99)
    assert abs(report.duration_error) < 1e-3
    assert report.p50_us < 2.0
    assert report.max_us == pytest.approx(10_000, abs=10)


def test_a_missing_or_strange_log_is_refused(tmp_path: Path) -> None:
    with pytest.raises(InputError, match="no such log"):
        list(replayed(tmp_path / "none.blf"))
    strange = tmp_path / "notes.txt"
    strange.write_text("hello")
    with pytest.raises(InputError, match="not a log"):
        list(replayed(strange))
