"""The bus of a run: frames of each identifier, their periods and gaps, and the load."""

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from bench.links.frame import BENCH, ECU, ERROR, EXTENDED, FOREIGN, INJECTOR, TRANSMITTED
from bench.report.charts import Chart, ChartBook, Lane, LaneChart, LineChart, Series, State
from bench.report.run_data import FloatArray, RunData
from bench.report.thinning import presence

SENDERS = {
    BENCH: State("bench", "bench"),
    ECU: State("ECU", "ecu"),
    FOREIGN: State("foreign", "foreign"),
    INJECTOR: State("fault injector", "injector"),
}
MISSED_AFTER_PERIODS = 2.5
MAX_IDENTIFIERS = 40


@dataclass(frozen=True)
class MessageStatistics:
    """Frames with one identifier from one sender.

    Attributes
    ----------
    identifier, extended, name, sender
        What it is, the name from the CAN database (empty if it has none), who sent it.
    count
        Number of frames.
    period_ms, period_p99_ms, largest_gap_ms
        Mean distance of two frames, the distance that 99 % keep, the largest.
    nominal_ms
        Cycle of the CAN database, 0 where it has none.
    times_s
        Instant of each frame.
    """

    identifier: int
    extended: bool
    name: str
    sender: int
    count: int
    period_ms: float
    period_p99_ms: float
    largest_gap_ms: float
    nominal_ms: float
    times_s: FloatArray

    @property
    def label(self) -> str:
        """Identifier as people write it."""
        return f"0x{self.identifier:08X}" if self.extended else f"0x{self.identifier:03X}"


def frame_times(run: RunData, frames: NDArray[np.void]) -> FloatArray:
    """Instant of each frame on the time base of the run, in s.

    In real time the link's time stamps are finer than the tick; they are used where they run along with the ticks.
    """
    ticks = frames["tick"].astype(np.float64) * 1e-3
    if not run.real_time or len(frames) == 0:
        return ticks
    stamps = (frames["timestamp_ns"] - frames["timestamp_ns"].min()).astype(np.float64) * 1e-9
    offset = float(np.median(ticks - stamps))
    follows = bool(np.median(np.abs(ticks - stamps - offset)) < 0.05)
    return stamps + offset if follows else ticks


def message_statistics(run: RunData) -> list[MessageStatistics]:
    """Statistics of every identifier and sender, by identifier."""
    if run.frames is None or len(run.frames) == 0:
        return []
    frames = run.frames[(run.frames["flags"] & ERROR) == 0]
    if "injector" in run.timing:
        frames = frames[frames["channel"] == 0]  # channel 1 has the same traffic as the ECU's side saw it
    times = frame_times(run, frames)
    known = _database(run)
    extended = (frames["flags"] & EXTENDED) != 0
    senders = _senders(frames, extended, known)
    keys = frames["identifier"].astype(np.int64) * 16 + extended * 8 + senders
    found = []
    for key in np.unique(keys):
        identifier, is_extended, sender = int(key) // 16, bool(int(key) & 8), int(key) & 7
        name, nominal = known.get((identifier, is_extended), ("", 0.0))
        found.append(_statistics(identifier, is_extended, name, sender, nominal, np.sort(times[keys == key])))
    return found


def _senders(
    frames: NDArray[np.void], extended: NDArray[np.bool_], known: dict[tuple[int, bool], tuple[str, float]]
) -> NDArray[np.int64]:
    """Who sent each frame. A log only tells which ones the bench sent; what else the database knows is the ECU's."""
    senders = frames["sender"].astype(np.int64)
    received = (senders == BENCH) & ((frames["flags"] & TRANSMITTED) == 0)
    identifiers = frames["identifier"].astype(np.int64) * 2 + extended
    in_database = np.isin(identifiers, [identifier * 2 + is_extended for identifier, is_extended in known])
    return np.where(received, np.where(in_database, ECU, FOREIGN), senders)


def _statistics(
    identifier: int, extended: bool, name: str, sender: int, nominal_ms: float, times: FloatArray
) -> MessageStatistics:
    gaps = np.diff(times) * 1e3
    mean, p99, largest = (
        (float(gaps.mean()), float(np.percentile(gaps, 99)), float(gaps.max())) if len(gaps) else (0.0, 0.0, 0.0)
    )
    return MessageStatistics(identifier, extended, name, sender, len(times), mean, p99, largest, nominal_ms, times)


def _database(run: RunData) -> dict[tuple[int, bool], tuple[str, float]]:
    """Name and cycle in ms of the messages that the run's CAN database knows."""
    from bench.codec.database import load_database
    from signals.errors import InputError

    ecu = run.scenario.get("ecu")
    path: Any = ecu.get("dbc") if isinstance(ecu, dict) else None
    try:
        database = load_database(path)
    except InputError as error:
        run.remarks.append(f"Names of the frames are missing: {error.message}")
        return {}
    return {(m.identifier, m.extended): (m.name, float(m.cycle_ms)) for m in database.messages}


def frames_chart(run: RunData, statistics: list[MessageStatistics]) -> Chart | None:
    """A lane for each identifier, blank where frames failed to come."""
    if not statistics:
        return None
    lanes = [_lane(message) for message in statistics[:MAX_IDENTIFIERS]]
    lanes += _error_lane(run)
    present = {message.sender for message in statistics}
    states = [state for sender, state in SENDERS.items() if sender in present]
    return LaneChart(
        "frames", "Frames on the bus", lanes, states, notes=True,
        explanation="Blank: no frame for more than two and a half cycles. Right: frames and mean distance.",
    )  # fmt: skip


def _lane(message: MessageStatistics) -> Lane:
    usual = message.nominal_ms or message.period_ms or 1.0
    state = SENDERS.get(message.sender, SENDERS[FOREIGN])
    spans = presence(message.times_s, MISSED_AFTER_PERIODS * usual * 1e-3)
    name = message.name or state.label
    return Lane(
        f"{message.label} {name}",
        [(start, max(end, start + usual * 1e-3), state.colour, "") for start, end in spans],
        short=message.label,
        note=f"{message.count:,} · {message.period_ms:.1f} ms".replace(",", "\u2009"),
        empty="no frame",
    )


def _error_lane(run: RunData) -> list[Lane]:
    if run.frames is None:
        return []
    errors = run.frames[(run.frames["flags"] & ERROR) != 0]
    if len(errors) == 0:
        return []
    times = np.unique(np.round(frame_times(run, errors), 3))[:2000]
    return [Lane("error frames", [], short="errors", note=f"{len(errors)}", events=[float(t) for t in times])]


def load_chart(run: RunData, book: ChartBook) -> Chart | None:
    """Share of bus time in use."""
    if not run.has("bus_load"):
        return None
    name = book.add_signal("bus_load", run.time, run.array("bus_load") * 100.0)
    return LineChart(
        "load", "Bus load", "%", [Series("last 100 ms", name, "reference")], smallest_span=10.0, height=120, wide=True
    )  # fmt: skip
