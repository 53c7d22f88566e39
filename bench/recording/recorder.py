"""The recorder: a process of its own that moves rows and frames from the ring into files.

``python -m bench.recording.recorder --ring FILE --out FOLDER --parent PID [--blf] [--asc]``. It ends when the writer
has closed the ring or when its parent has ended, in both cases after it has taken what is left. When it cannot write
(disk full) it says so in the ring and ends with exit code 4; what is written stays.
"""

import argparse
import os
import signal
import sys
import time
from pathlib import Path
from types import FrameType

from bench.loop.scheduling import die_with_parent
from bench.recording.frame_file import AscFile, BlfFile
from bench.recording.ring import FAILED, FINISHED, RECORDING, ROWS, RingReader
from bench.recording.run_folder import ASC_FILE, FRAME_FILE, RESERVE_FILE, STREAM_FILE
from bench.recording.signal_file import SignalFile

POLL_S = 0.005
FLUSH_S = 0.1
ROWS_AT_ONCE = 2048
FRAMES_AT_ONCE = 4096
RESERVE_BYTES = 2 << 20


class Recorder:
    """Files of one run and the ring that fills them."""

    def __init__(self, ring: RingReader, folder: Path, *, blf: bool = True, asc: bool = False) -> None:
        self._ring = ring
        self._rows_due = self._frames_due = 0
        start_ns = ring.schema.start_time_ns
        self._signals = SignalFile(folder / STREAM_FILE, ring.schema)
        self._frame_files: list[BlfFile | AscFile] = []
        if blf:
            self._frame_files.append(BlfFile(folder / FRAME_FILE, start_ns))
        if asc:
            self._frame_files.append(AscFile(folder / ASC_FILE, start_ns))

    def take(self) -> bool:
        """Move what the ring has; False if it had nothing."""
        first, ticks, values = self._ring.take_rows(ROWS_AT_ONCE)
        if len(ticks):
            self._ring.count_lost(first - self._rows_due, 0)
            self._rows_due = first + len(ticks)
            self._signals.write(first, ticks, values)
        first, frames = self._ring.take_frames(FRAMES_AT_ONCE)
        if len(frames):
            self._ring.count_lost(0, first - self._frames_due)
            self._frames_due = first + len(frames)
            for file in self._frame_files:
                file.write(frames)
        return bool(len(ticks) or len(frames))

    @property
    def flush_is_urgent(self) -> bool:
        """True if much of the ring waits for a flush, as it does where virtual time runs fast."""
        return self._ring.unreleased_rows > ROWS // 4

    def flush(self) -> None:
        """Make what was moved outlive this process, then give its room back to the writer."""
        self._signals.flush()
        for file in self._frame_files:
            file.checkpoint()
        self._ring.release()

    def close(self) -> None:
        """Finish all files."""
        self._signals.close()
        for file in self._frame_files:
            file.stop()
        self._ring.release()

    def abandon(self) -> None:
        """Leave the files as they are after a write has failed; what was not flushed is still in the ring."""
        self._signals.abandon()
        for file in self._frame_files:
            file.abandon()


def record(ring: RingReader, folder: Path, *, blf: bool, asc: bool, ended: list[bool]) -> None:
    """Record until the ring is closed or ``ended`` holds something, and everything is taken."""
    recorder = Recorder(ring, folder, blf=blf, asc=asc)
    ring.set_state(RECORDING)
    try:
        _record(recorder, ring, ended)
    except OSError:
        recorder.abandon()
        raise
    ring.set_state(FINISHED)


def _record(recorder: Recorder, ring: RingReader, ended: list[bool]) -> None:
    last_flush = time.monotonic()
    while True:
        last_round = ring.closed or bool(ended)
        took = recorder.take()
        if not took and last_round:
            break
        now = time.monotonic()
        if now - last_flush >= FLUSH_S or recorder.flush_is_urgent:
            recorder.flush()
            last_flush = now
        if not took:
            time.sleep(POLL_S)
    recorder.close()


def reserve_space(folder: Path) -> None:
    """Keep some room on the disk for verdict and log, for the case that the recording fills it."""
    with (folder / RESERVE_FILE).open("wb") as file:
        os.posix_fallocate(file.fileno(), 0, RESERVE_BYTES)


def main() -> int:
    """Entry point of the recorder process."""
    parser = argparse.ArgumentParser(prog="recorder")
    parser.add_argument("--ring", type=Path, required=True)
    parser.add_argument("--out", type=Path, required=True)
    parser.add_argument("--parent", type=int, required=True, help="process to end with")
    parser.add_argument("--blf", action="store_true", help="write frames.blf")
    parser.add_argument("--asc", action="store_true", help="write frames.asc")
    arguments = parser.parse_args()
    ended: list[bool] = []

    def end(_number: int, _frame: FrameType | None) -> None:
        ended.append(True)

    signal.signal(signal.SIGTERM, end)
    # an interrupt from the terminal goes to the whole process group; the loop ends the run, and the ring with it
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    signal.signal(signal.SIGHUP, signal.SIG_IGN)
    die_with_parent(signal.SIGTERM)
    if os.getppid() != arguments.parent:
        ended.append(True)
    ring = RingReader(arguments.ring, recorder=True)
    try:
        reserve_space(arguments.out)
        record(ring, arguments.out, blf=arguments.blf, asc=arguments.asc, ended=ended)
    except OSError as error:
        (arguments.out / RESERVE_FILE).unlink(missing_ok=True)
        text = f"{arguments.out}: {(error.strerror or str(error)).lower()}"
        ring.set_state(FAILED, text)
        sys.stderr.write(f"error: recording failed: {text}\n")
        return 4
    return 0


if __name__ == "__main__":
    sys.exit(main())
