"""Frames sent by the clock: a recorded log as it was, or one frame in a cycle.

Each frame has a due time from the start, so nothing adds up: the sender sleeps until shortly before it and spins the
rest, and a late frame does not move the next one.
"""

import time
from collections.abc import Callable, Iterable, Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from bench.links.frame import BIT_RATE_SWITCH, EXTENDED, FD, REMOTE, make_frame, new_frames
from bench.links.interface import Link
from can_fault_injector.notation import parse_frame
from signals.errors import InputError

SPIN_S = 0.5e-3
_CLASSIC_BYTES = 8
Timed = tuple[float, NDArray[np.void]]
"""Due time in s since the start, and an array with one frame."""


@dataclass(frozen=True)
class SendingReport:
    """How well the times were kept.

    Attributes
    ----------
    frames : int
    planned_s, took_s : float
        From the first to the last frame, as planned and as sent.
    p50_us, p99_us, max_us : float
        Jitter: how late frames were sent.
    """

    frames: int
    planned_s: float
    took_s: float
    p50_us: float
    p99_us: float
    max_us: float

    @property
    def duration_error(self) -> float:
        """Relative error of the total duration; 0 where nothing was planned to take time."""
        return self.took_s / self.planned_s - 1.0 if self.planned_s > 0 else 0.0

    def as_data(self) -> dict[str, Any]:
        """Plain data."""
        return {
            "frames": self.frames,
            "planned_s": self.planned_s,
            "took_s": self.took_s,
            "duration_error": self.duration_error,
            "jitter_us": {"p50": self.p50_us, "p99": self.p99_us, "max": self.max_us},
        }


def send_timed(link: Link, frames: Iterable[Timed], goes_on: Callable[[], bool] = lambda: True) -> SendingReport:
    """Send frames when they are due; returns how well that went. The clock starts when the first frame is there."""
    late: list[float] = []
    due = first = began = last = 0.0
    for due, frame in frames:
        if not goes_on():
            break
        if not late:
            # opening a log takes time, which is none of its own
            first, began = due, time.perf_counter() - due
        ahead = began + due - time.perf_counter()
        if ahead > SPIN_S:
            time.sleep(ahead - SPIN_S)
        while time.perf_counter() < began + due:
            pass
        link.send(frame, 1)
        last = time.perf_counter()
        late.append(last - began - due)
    jitter = np.array(late or [0.0]) * 1e6
    start = began + first + (late[0] if late else 0.0)
    p50, p99 = np.percentile(jitter, (50, 99))
    return SendingReport(len(late), due - first, last - start, float(p50), float(p99), float(jitter.max()))


def cyclic(text: str, period_s: float, count: int) -> Iterator[Timed]:
    """One frame, in the notation of can-utils, so many times in a cycle."""
    frame = parse_frame(text)
    flags = EXTENDED * frame.extended | REMOTE * frame.remote | FD * frame.fd | BIT_RATE_SWITCH * frame.bit_rate_switch
    record = make_frame(frame.identifier, frame.data, flags=flags)
    if frame.remote:
        record["length"] = min(frame.length_code, _CLASSIC_BYTES)
    for number in range(count):
        yield number * period_s, record


def replayed(path: Path, speed: float = 1.0) -> Iterator[Timed]:
    """Frames of a log (BLF, ASC, candump log, CSV, TRC) at their times, error frames left out.

    Raises
    ------
    InputError
        If there is no such log, or it cannot be read.
    """
    from bench.links.python_can_library import can

    if not path.is_file():
        raise InputError(f"{path}: no such log", allowed="a log of CAN frames: .blf, .asc, .log, .csv, .trc")
    start = None
    try:
        with can.LogReader(path) as reader:
            for message in reader:
                if message.is_error_frame:
                    continue
                start = message.timestamp if start is None else start
                yield (message.timestamp - start) / speed, _record(message)
    except (ValueError, OSError) as error:
        raise InputError(f"{path}: not a log of CAN frames ({error})") from None


def _record(message: Any) -> NDArray[np.void]:
    record = new_frames(1)
    record["identifier"] = message.arbitration_id
    record["flags"] = (
        EXTENDED * message.is_extended_id
        | REMOTE * message.is_remote_frame
        | FD * message.is_fd
        | BIT_RATE_SWITCH * message.bitrate_switch
    )
    record["length"] = message.dlc if message.is_remote_frame else len(message.data)
    record["data"][0, : len(message.data)] = np.frombuffer(bytes(message.data), np.uint8)
    return record
