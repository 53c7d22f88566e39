"""A writer with the interface of the loop but no models: row ``n`` and frame ``n`` can be told from ``n`` alone.

As a program it is what the tests kill: ``synthetic_loop.py FOLDER MODE TICKS``, where MODE is lockstep, realtime, or
finish (lockstep that ends in order).
"""

import sys
import time
from pathlib import Path

import numpy as np

from bench.links.frame import FRAME_DTYPE, TRANSMITTED
from bench.recording.schema import RunSchema
from bench.recording.session import RecordingSession
from signals.catalogue import catalogue

SIGNALS = catalogue()
SCENARIO = """
name: synthetic
criteria:
  - {id: fast, value: max(speed), at_most: 100 km/h, requirement: R-1}
  - {id: ends, value: last(time) >= 1000}
valid_if: max(time) > 0
"""
FRAMES_PER_TICK = 2


def schema(start_time_ns: int = 0) -> RunSchema:
    """Schema of the synthetic run."""
    return RunSchema.of(
        SIGNALS, phase_names=("hold", "stop"), start_time_ns=start_time_ns, information={"scenario": "synthetic"}
    )


def row(tick: int) -> np.ndarray:
    """Values of a tick: signal ``i`` is ``i + sin(tick)``, time is the tick's."""
    values = np.arange(len(SIGNALS)) + np.sin(tick)
    values[0] = tick * 1e-3
    values[1] = float(tick >= 100)
    return values


def rows(count: int) -> np.ndarray:
    """The first rows, shape (count, signals)."""
    return np.array([row(tick) for tick in range(count)]).reshape(count, len(SIGNALS))


def frames(first: int, count: int, start_time_ns: int = 0) -> np.ndarray:
    """Frames with numbers ``first`` …: the payload is the number, every third is sent by the other side."""
    number = np.arange(first, first + count)
    records = np.zeros(count, FRAME_DTYPE)
    records["tick"] = number // FRAMES_PER_TICK
    records["timestamp_ns"] = start_time_ns + records["tick"] * 1_000_000 + (number % FRAMES_PER_TICK) * 250_001
    records["identifier"] = 0x100 + number % 7
    records["flags"] = np.where(number % 3 == 0, 0, TRANSMITTED)
    records["channel"] = number % 2
    records["length"] = 8
    records["data"][:, :8] = number[:, None].astype("<i8").view(np.uint8).reshape(count, 8)
    return records


def frame_numbers(records: np.ndarray) -> np.ndarray:
    """Numbers of frames, from their payloads."""
    return np.ascontiguousarray(records["data"][:, :8]).view("<i8")[:, 0]


def write(session: RecordingSession, first: int, count: int) -> None:
    """Write ticks as the loop does."""
    for tick in range(first, first + count):
        session.write_row(row(tick), tick)
        session.write_frames(frames(FRAMES_PER_TICK * tick, FRAMES_PER_TICK), FRAMES_PER_TICK)


def main() -> None:
    folder, mode, ticks = Path(sys.argv[1]), sys.argv[2], int(sys.argv[3])
    sys.stdout.write("starting\n")
    sys.stdout.flush()
    session = RecordingSession.start(
        folder,
        schema(),
        scenario="synthetic",
        scenario_text=SCENARIO,
        flow_control=mode != "realtime",
        information={"seed": 5, "mode": mode, "versions": {"bench": "0.1"}},
    )
    sys.stdout.write(f"{session.recorder.process.pid}\n")
    sys.stdout.flush()
    start = time.perf_counter()
    for tick in range(ticks):
        write(session, tick, 1)
        if mode == "realtime":
            time.sleep(max(0.0, start + tick * 1e-3 - time.perf_counter()))
    if mode == "finish":
        from bench.verdict.output_files import write_verdict
        from bench.verdict.result import Verdict

        session.stop()
        write_verdict(folder, Verdict("synthetic"))
        session.seal()


if __name__ == "__main__":
    main()
