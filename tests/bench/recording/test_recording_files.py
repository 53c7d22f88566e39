"""What a run leaves: MF4, BLF, ASC, MCAP, read back with our reader and with the libraries' own."""

import json
import os
import subprocess
import sys
from pathlib import Path

import can
import numpy as np
import pytest
from asammdf import MDF
from mcap.reader import make_reader
from synthetic_loop import FRAMES_PER_TICK, SCENARIO, SIGNALS, frame_numbers, frames, rows, schema, write

from bench.links.frame import BIT_RATE_SWITCH, ERROR, EXTENDED, FD, REMOTE, TRANSMITTED, make_frame
from bench.recording.frame_file import BlfFile, read_blf
from bench.recording.reading import Recording
from bench.recording.ring import ROWS
from bench.recording.run_folder import FINISHED_FILES, FileChoice, read_state, remove_orphaned_rings
from bench.recording.session import RecordingSession
from bench.recording.signal_file import CHUNK_BYTES, SignalFile, read_signal_file
from bench.verdict.output_files import write_verdict
from bench.verdict.result import Verdict
from signals.errors import InputError, RunError

TICKS = 3000
NOT_MADE_HERE = {"report.html"}


def start(folder: Path, **options) -> RecordingSession:
    return RecordingSession.start(
        folder, schema(), scenario="synthetic", scenario_text=SCENARIO, flow_control=True, **options
    )


@pytest.fixture(scope="module")
def folder(tmp_path_factory) -> Path:
    """Folder of a run that ended in order."""
    path = tmp_path_factory.mktemp("runs") / "synthetic-1"
    session = start(path, files=FileChoice(asc=True))
    assert session.problem() == ""
    write(session, 0, TICKS)
    outcome = session.stop()
    assert outcome.problem == ""
    assert (outcome.rows, outcome.frames) == (TICKS, FRAMES_PER_TICK * TICKS)
    assert (outcome.rows_lost, outcome.frames_lost) == (0, 0)
    write_verdict(path, Verdict("synthetic", timing={"mode": "lockstep", "overruns": 4}))
    session.seal()
    assert not Path(session.writer.path).exists()
    return path


def test_a_finished_folder_holds_just_its_files(folder: Path) -> None:
    assert {path.name for path in folder.iterdir()} == {*FINISHED_FILES, "frames.asc"} - NOT_MADE_HERE
    assert (folder / "scenario.yaml").read_text() == SCENARIO
    assert "run of synthetic started" in (folder / "log.txt").read_text()


def test_reading_gives_what_was_written(folder: Path) -> None:
    recording = Recording.open(folder)
    expected = rows(TICKS)
    for position, signal in enumerate(SIGNALS):
        assert np.array_equal(recording.array(signal.name), expected[:, position]), signal.name
        assert recording.units[signal.name] == signal.unit
    assert recording.phase_names == ("hold", "stop")
    assert recording.steps() == {"hold": slice(0, 100), "stop": slice(100, TICKS)}
    assert recording.timing["overruns"] == 4
    assert recording.information["scenario"] == "synthetic"
    assert np.array_equal(frame_numbers(recording.frames), np.arange(FRAMES_PER_TICK * TICKS))


def test_equal_runs_have_equal_digests(folder: Path) -> None:
    recording = Recording.open(folder / "signals.mf4")
    again = Recording.open(folder)
    assert recording.digest() == again.digest()
    again.array("speed")[7] += 1e-15 + abs(again.array("speed")[7]) * 1e-15
    assert recording.digest() != again.digest()


def test_mf4_in_the_library_is_finalised_with_units_and_descriptions(folder: Path) -> None:
    assert (folder / "signals.mf4").read_bytes()[:8] == b"MDF     "
    with MDF(folder / "signals.mf4") as mdf:
        speed = mdf.get("speed")
        assert speed.unit == "m/s"
        assert speed.comment.startswith("longitudinal speed")
        assert np.array_equal(speed.timestamps, np.arange(TICKS) * 1e-3)
        assert {channel.name for channel in mdf.groups[0].channels} == {signal.name for signal in SIGNALS}


def test_blf_in_the_library_has_time_direction_and_channel(folder: Path) -> None:
    with can.BLFReader(folder / "frames.blf") as reader:
        assert reader.object_count == FRAMES_PER_TICK * TICKS
        assert reader.file_size == (folder / "frames.blf").stat().st_size
        messages = list(reader)
    written = frames(0, FRAMES_PER_TICK * TICKS)
    assert [m.arbitration_id for m in messages] == written["identifier"].tolist()
    assert [m.is_rx for m in messages] == (written["flags"] & TRANSMITTED == 0).tolist()
    assert [m.channel for m in messages] == written["channel"].tolist()
    assert np.array([m.timestamp for m in messages]) == pytest.approx(written["timestamp_ns"] * 1e-9, abs=1e-9)


def test_asc_on_request_has_the_same_frames(folder: Path) -> None:
    with can.ASCReader(folder / "frames.asc", relative_timestamp=True) as reader:
        messages = list(reader)
    assert len(messages) == FRAMES_PER_TICK * TICKS
    assert bytes(messages[5].data) == (5).to_bytes(8, "little")


@pytest.mark.parametrize("start_ns", [0, 1_790_000_000_123_456_789])
def test_blf_keeps_every_kind_of_frame_to_the_nanosecond(tmp_path: Path, start_ns: int) -> None:
    written = np.concatenate(
        [
            make_frame(0x123, b"\x01\x02", flags=TRANSMITTED, channel=1),
            make_frame(0x18DAF110, b"", flags=EXTENDED),
            make_frame(0x7FF, flags=REMOTE),
            make_frame(0x100, bytes(range(64)), flags=FD | BIT_RATE_SWITCH | TRANSMITTED),
            make_frame(0x0, bytes(8), flags=ERROR),
        ]
    )
    written["length"][2] = 5
    written["timestamp_ns"] = start_ns + np.array([0, 1, 999_999_999, 5_000_000_001, 5_000_000_002])
    file = BlfFile(tmp_path / "x.blf", start_ns)
    file.write(written)
    file.stop()
    found = read_blf(tmp_path / "x.blf")
    for name in ("timestamp_ns", "identifier", "flags", "channel", "length", "data"):
        assert np.array_equal(found[name], written[name]), name


def test_a_cut_blf_is_read_up_to_the_last_checkpoint(tmp_path: Path) -> None:
    path = tmp_path / "x.blf"
    file = BlfFile(path)
    file.write(frames(0, 3000))
    file.checkpoint()
    safe = path.stat().st_size
    file.write(frames(3000, 3000))
    file.stop()
    content = path.read_bytes()
    for size in (0, 10, 143, 144, 150, safe, safe + 1, safe + 17, len(content) - 1):
        (tmp_path / "cut.blf").write_bytes(content[:size])
        found = frame_numbers(read_blf(tmp_path / "cut.blf"))
        assert np.array_equal(found, np.arange(len(found)))
        assert len(found) >= (3000 if size >= safe else 0)


def test_mcap_is_a_valid_file_with_chunks_of_at_most_64_kib(tmp_path: Path) -> None:
    path = tmp_path / "signals.mcap"
    file = SignalFile(path, schema())
    file.write(0, np.arange(500), rows(500))
    file.close()
    with path.open("rb") as stream:
        summary = make_reader(stream, validate_crcs=True).get_summary()
    assert summary.chunk_indexes
    assert max(index.uncompressed_size for index in summary.chunk_indexes) <= CHUNK_BYTES
    found, blocks = read_signal_file(path)
    assert found == schema()
    assert np.array_equal(np.concatenate([values for _, _, values in blocks]), rows(500))


def test_a_cut_mcap_is_read_up_to_its_last_whole_chunk(tmp_path: Path) -> None:
    path = tmp_path / "signals.mcap"
    file = SignalFile(path, schema())
    file.write(0, np.arange(200), rows(200))
    file.flush()
    safe = path.stat().st_size
    file.write(200, np.arange(200, 400), rows(400)[200:])
    file.close()
    content = path.read_bytes()
    for size in (*range(0, safe, 4099), safe, safe + 1, safe + 9, len(content) - 3):
        (tmp_path / "cut.mcap").write_bytes(content[:size])
        _, blocks = read_signal_file(tmp_path / "cut.mcap")
        ticks = [tick for _, block, _ in blocks for tick in block.tolist()]
        assert ticks == list(range(len(ticks)))
        assert len(ticks) >= (200 if size >= safe else 0)


def test_a_damaged_chunk_ends_the_reading(tmp_path: Path) -> None:
    path = tmp_path / "signals.mcap"
    file = SignalFile(path, schema())
    file.write(0, np.arange(400), rows(400))
    file.close()
    content = bytearray(path.read_bytes())
    content[len(content) // 2] ^= 0xFF
    path.write_bytes(content)
    _, blocks = read_signal_file(path)
    values = np.concatenate([values for _, _, values in blocks])
    assert 0 < len(values) < 400
    assert np.array_equal(values, rows(len(values)))


def test_a_running_recording_can_be_read(tmp_path: Path) -> None:
    session = start(tmp_path / "run")
    write(session, 0, 500)
    recording = Recording.open(tmp_path / "run")
    assert len(recording) == 500
    session.stop(convert=False)
    assert len(Recording.open(tmp_path / "run" / "signals.mcap")) == 500
    assert read_state(tmp_path / "run").state == "ended"
    session.seal()


def test_more_rows_than_the_ring_holds(tmp_path: Path) -> None:
    count = ROWS + 3000
    session = start(tmp_path / "run")
    values, batch = rows(1)[0], frames(0, 2)
    for tick in range(count):
        values[0] = tick * 1e-3
        session.write_row(values, tick)
        session.write_frames(batch, 2)
    assert session.stop().problem == ""
    recording = Recording.open(tmp_path / "run")
    assert np.array_equal(recording.time, np.arange(count) * 1e-3)
    assert len(recording.frames) == 2 * count
    session.seal()


def test_only_chosen_files_and_signals_stay(tmp_path: Path) -> None:
    chosen = FileChoice(blf=False, mf4_signals=["speed", "slip_ratio_*"])
    session = start(tmp_path / "run", files=chosen)
    write(session, 0, 100)
    assert session.stop().problem == ""
    assert len(Recording.open(tmp_path / "run").names) == len(SIGNALS)
    session.seal()
    assert {path.name for path in (tmp_path / "run").iterdir()} == {"signals.mf4", "scenario.yaml", "log.txt"}
    names = set(Recording.open(tmp_path / "run").names)
    assert names == {"time", "speed", *(f"slip_ratio_{wheel}" for wheel in ("fl", "fr", "rl", "rr"))}


def test_a_folder_in_use_is_refused(tmp_path: Path) -> None:
    (tmp_path / "run").mkdir()
    (tmp_path / "run" / "mine.txt").write_text("x")
    with pytest.raises(InputError, match="already there and not empty"):
        start(tmp_path / "run")
    assert (tmp_path / "run" / "mine.txt").read_text() == "x"


@pytest.mark.parametrize("name", ["missing", "empty", "other.mf4", "foreign.csv"])
def test_what_is_no_recording_is_refused(tmp_path: Path, name: str) -> None:
    (tmp_path / "empty").mkdir()
    (tmp_path / "other.mf4").write_bytes(b"no mf4")
    (tmp_path / "foreign.csv").write_text("t,v\n0,1\n")
    with pytest.raises(InputError):
        Recording.open(tmp_path / name)


def test_a_recorder_that_dies_is_the_run_s_error(tmp_path: Path) -> None:
    session = start(tmp_path / "run")
    write(session, 0, 300)
    session.recorder.process.kill()
    session.recorder.process.wait()
    with pytest.raises(RunError, match="the recorder ended before the run did"):
        write(session, 300, 2 * ROWS)
    outcome = session.stop()
    assert "recorder ended" in outcome.problem
    session.seal()
    assert read_state(tmp_path / "run").state == outcome.problem
    session.writer.path.unlink()


def test_rings_of_finished_runs_are_swept_and_others_kept(tmp_path: Path) -> None:
    from bench.recording.ring import RingWriter

    def orphan(name: str, run_dir: Path) -> Path:
        path = tmp_path / name
        RingWriter(path, type(schema())(SIGNALS, information={"run_dir": str(run_dir)}), rows=16, frames=16)
        return path

    gone = orphan("bench-99999999-1.ring", tmp_path / "gone")
    own = orphan(f"bench-{os.getpid()}-1.ring", tmp_path / "gone")
    assert remove_orphaned_rings(tmp_path) == [gone]
    assert own.exists()


DISK_FULL = """
import os, sys
from pathlib import Path
sys.path.insert(0, {here!r})
from synthetic_loop import *
from signals.errors import RunError
folder = Path("/mnt/run")
session = RecordingSession.start(folder, schema(), scenario="synthetic", scenario_text=SCENARIO, flow_control=True)
tick = 0
try:
    while True:
        values = row(tick)
        values[2:] += np.random.random(len(values) - 2)
        session.write_row(values, tick)
        tick += 1
except RunError as error:
    print("error:", error)
outcome = session.stop()
from bench.verdict.output_files import write_verdict
from bench.verdict.result import Verdict
verdict = Verdict("synthetic", errors=[outcome.problem])
write_verdict(folder, verdict)
session.seal()
print("exit", verdict.exit_code, "kept", len(Recording.open(folder)), "of", tick)
os.system("mount -o remount,size=64m /mnt")
from bench.recording.recover import recover
recovery = recover(folder)
print("recovered", recovery.rows)
import json
print(json.dumps([p.name for p in folder.iterdir()]))
"""


def can_mount() -> bool:
    probe = ["unshare", "-rm", "mount", "-t", "tmpfs", "-o", "size=1m", "x", "/mnt"]
    try:
        return subprocess.run(probe, capture_output=True, check=False).returncode == 0
    except FileNotFoundError:
        return False


@pytest.mark.skipif(not can_mount(), reason="needs the right to mount in a namespace of its own")
def test_a_full_disk_ends_the_run_and_keeps_the_recording() -> None:
    code = "from bench.recording.reading import Recording\n" + DISK_FULL.format(here=str(Path(__file__).parent))
    command = ["unshare", "-rm", "sh", "-c", 'mount -t tmpfs -o size=6m x /mnt && exec "$@"', "sh", sys.executable]
    done = subprocess.run([*command, "-c", code], capture_output=True, text=True, timeout=120, check=False)
    assert done.returncode == 0, done.stderr
    error, kept, recovered, names = [line for line in done.stdout.splitlines() if not line.startswith(" ")]
    assert "no space left on device" in error
    _, exit_code, _, count, _, total = kept.split()
    assert exit_code == "4"
    assert count == total == recovered.split()[1]
    assert {"signals.mf4", "frames.blf", "verdict.json", "junit.xml"} <= set(json.loads(names))
    assert "run.json" not in names
