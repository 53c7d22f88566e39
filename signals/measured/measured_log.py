"""A measured log under our names, in SI units and ISO 8855 axes, and its resampling to one time base."""

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from signals.errors import InputError
from signals.measured.channel_map import Channel, ChannelMap, FileFormat, channel_units, is_rim_speed
from signals.measured.raw_channels import FloatArray, RawChannels
from signals.quantities import to_si

SHORTEST_STEP_S = 1e-3

# held between samples; everything else is interpolated
_STEPPED = ("gear", "driver_gear", "pump", "brake_switch", "ignition", "manoeuvre_phase")
_STEPPED_PREFIXES = ("valve_", "ecu_phase_", "ecu_fault", "abs_", "ebd_", "hydraulic_state_", "wheel_edge_")


@dataclass(frozen=True)
class MeasuredChannel:
    """One signal of a log: its own time stamps [s], values in ``unit``, where it came from."""

    name: str
    unit: str
    time: FloatArray
    values: FloatArray
    source: str


@dataclass(frozen=True)
class MeasuredLog:
    """Channels of a log.

    Attributes
    ----------
    start_time_s : float
        Time of the log's first sample on its own clock; the channels' times count from it.
    """

    path: Path
    start_time_s: float
    channels: dict[str, MeasuredChannel]

    def step_s(self) -> float:
        """Smallest usual distance of two samples among the channels, at least 1 ms."""
        steps = [float(np.median(np.diff(c.time))) for c in self.channels.values() if len(c.time) > 1]
        return max(min(steps, default=SHORTEST_STEP_S), SHORTEST_STEP_S)

    def resample(self, step_s: float | None = None) -> tuple[FloatArray, dict[str, FloatArray]]:
        """Channels on one time base: the time that all of them cover, in equal steps.

        Continuous channels are interpolated linearly; switches, states and counters hold their last value and do not
        limit the time.

        Raises
        ------
        InputError
            If no time is covered by all channels.
        """
        step = step_s or self.step_s()
        limiting = [c for c in self.channels.values() if not is_stepped(c.name)] or list(self.channels.values())
        latest = max(limiting, key=lambda c: float(c.time[0]))
        earliest = min(limiting, key=lambda c: float(c.time[-1]))
        begin, end = float(latest.time[0]), float(earliest.time[-1])
        if end <= begin:
            raise InputError(
                f"{self.path}: no time is covered by all channels: {earliest.source!r} ends at {end:.3f} s, "
                f"{latest.source!r} begins at {begin:.3f} s"
            )
        time: FloatArray = begin + step * np.arange(int((end - begin) / step + 1e-6) + 1, dtype=np.float64)
        return time, {name: _on(channel, time) for name, channel in self.channels.items()}

    def units(self) -> dict[str, str]:
        """SI unit of each channel."""
        return {name: channel.unit for name, channel in self.channels.items()}


def is_stepped(name: str) -> bool:
    """True for switches, states and counters, which have no values between two samples."""
    return name in _STEPPED or name.startswith(_STEPPED_PREFIXES)


def _on(channel: MeasuredChannel, time: FloatArray) -> FloatArray:
    if not is_stepped(channel.name):
        return np.interp(time, channel.time, channel.values)
    # stamps of a log on a date have a resolution of a quarter microsecond
    row = np.searchsorted(channel.time, time + 1e-6, side="right") - 1
    return channel.values[np.maximum(row, 0)]


def read_log(path: str | Path, channel_map: ChannelMap, *, wheel_radius_m: float | None = None) -> MeasuredLog:
    """Read a log through a channel map.

    Parameters
    ----------
    wheel_radius_m : float, optional
        Rolling radius, needed where the log has wheel speeds as speeds along the road.

    Raises
    ------
    InputError
        If the log cannot be read, lacks a channel of the map, or its time runs backwards.
    """
    path = Path(path)
    if not path.is_file():
        raise InputError(f"{path}: no such log")
    if not channel_map.channels:
        raise InputError(f"{path}: the channel map names no channel")
    raw = read_sources(path, channel_map)
    start = min(float(time[0]) for time, _ in raw.values() if len(time))
    channels = {
        name: _channel(path, name, channel, raw[channel.source], start, wheel_radius_m)
        for name, channel in channel_map.channels.items()
    }
    return MeasuredLog(path, start, channels)


def detect_format(path: Path) -> FileFormat:
    """Format of a log by its content where that is telling, else by its name.

    Raises
    ------
    InputError
        If the file is not there or empty, or neither says.
    """
    if not path.is_file():
        raise InputError(f"{path}: no such log")
    with path.open("rb") as file:
        head = file.read(8)
    if not head:
        raise InputError(f"{path}: the file is empty")
    by_content: dict[bytes, FileFormat] = {b"MDF ": "mf4", b"UnFi": "mf4", b"LOGG": "blf", b"PAR1": "parquet"}
    found = by_content.get(head[:4])
    if found is not None:
        return found
    suffixes: dict[str, FileFormat] = {
        ".csv": "csv", ".txt": "csv", ".blf": "blf", ".asc": "asc", ".log": "candump", ".mf4": "mf4",
        ".parquet": "parquet",
    }  # fmt: skip
    suffix = Path(path.name.lower().removesuffix(".gz")).suffix
    if suffix not in suffixes:
        raise InputError(f"{path}: unknown kind of log", allowed=", ".join(suffixes), mend="say it: file_format: csv")
    return suffixes[suffix]


def log_columns(path: Path, channel_map: ChannelMap) -> dict[str, str]:
    """Every name that a log offers as a source, and its unit as the log writes it, "" where it tells none.

    Of a CAN log the names are those of its database, whether it has them or not.

    Raises
    ------
    InputError
        If the log or its database cannot be read.
    """
    kind = format_of(path, channel_map)
    if kind == "csv":
        from signals.measured.tables import csv_columns

        return csv_columns(path)
    if kind == "parquet":
        from signals.measured.tables import parquet_columns

        return parquet_columns(path)
    if not holds_frames(kind, channel_map):
        from signals.measured.mf4_log import mf4_columns

        return mf4_columns(path)
    from signals.measured.can_log import can_columns

    return can_columns(channel_map.dbc) if channel_map.dbc is not None else {}


def format_of(path: Path, channel_map: ChannelMap) -> FileFormat:
    """Format of a log: the map's, else :func:`detect_format`."""
    return detect_format(path) if channel_map.file_format == "auto" else channel_map.file_format


def holds_frames(kind: FileFormat, channel_map: ChannelMap) -> bool:
    """True where a log of this format is one of CAN frames; an MF4 is, if the map names a database."""
    return kind in ("blf", "asc", "candump") or (kind == "mf4" and channel_map.dbc is not None)


def read_sources(
    path: Path, channel_map: ChannelMap, *, missing_ok: bool = False, restored: dict[str, int] | None = None
) -> RawChannels:
    """The map's sources as they stand in the log, in the log's units.

    With ``missing_ok`` what the log lacks is left out; else it is an InputError. ``restored`` is filled with the number
    of CAN frames of a source that an export has cut short and that were completed.
    """
    sources = list(dict.fromkeys(channel.source for channel in channel_map.channels.values()))
    return read_named(path, sources, channel_map, missing_ok=missing_ok, restored=restored)


def read_named(
    path: Path,
    sources: Sequence[str],
    channel_map: ChannelMap,
    *,
    missing_ok: bool = False,
    restored: dict[str, int] | None = None,
) -> RawChannels:
    """As :func:`read_sources`, of sources that the map need not have; it says format, clock and database."""
    if missing_ok:
        offered = log_columns(path, channel_map)
        sources = [s for s in sources if s in offered or s.rpartition("#")[0] in offered]
        if not sources:
            return {}
    kind = format_of(path, channel_map)
    if kind == "csv":
        from signals.measured.tables import read_csv

        return read_csv(path, sources, channel_map.clock)
    if kind == "parquet":
        from signals.measured.tables import read_parquet

        return read_parquet(path, sources, channel_map.clock)
    if not holds_frames(kind, channel_map):
        from signals.measured.mf4_log import read_mf4_log

        return read_mf4_log(path, sources)
    from signals.measured.can_log import read_can_log

    return read_can_log(path, kind, sources, channel_map.dbc, missing_ok=missing_ok, restored=restored)


def _channel(
    path: Path,
    name: str,
    channel: Channel,
    raw: tuple[FloatArray, FloatArray],
    start: float,
    wheel_radius_m: float | None,
) -> MeasuredChannel:
    unit = channel_units()[name]
    time, values = raw
    present = np.isfinite(values)
    time, values = time[present] - start - channel.delay_s, values[present]
    if len(time) == 0:
        raise InputError(f"{path}: the channel {channel.source!r} holds no numbers")
    backwards = np.flatnonzero(np.diff(time) < 0)
    if len(backwards):
        row = int(backwards[0])
        raise InputError(
            f"{path}: the time of {channel.source!r} runs backwards after sample {row + 1} "
            f"({time[row] + start:.6g} s, then {time[row + 1] + start:.6g} s)"
        )
    fresh = np.concatenate(([True], np.diff(time) > 0))
    return MeasuredChannel(
        name, unit, time[fresh], in_si(path, name, channel, values[fresh], wheel_radius_m), channel.source
    )


def in_si(path: Path, name: str, channel: Channel, values: FloatArray, wheel_radius_m: float | None) -> FloatArray:
    """Values of a log in our unit and sign.

    Raises
    ------
    InputError
        If a wheel speed stands in the log as a speed along the road and no wheel radius is given.
    """
    own = channel_units()[name]
    target, divisor = own, 1.0
    if is_rim_speed(name, channel):
        if wheel_radius_m is None:
            raise InputError(
                f"{path}: {name} is a speed in the log ({channel.unit}), its rotation needs the wheel radius",
                mend="give the car: --vehicle FILE",
            )
        target, divisor = "m/s", wheel_radius_m
    unit = channel.unit or own
    zero, one = to_si(f"0 {unit}", target), to_si(f"1 {unit}", target)
    return channel.sign * ((values * channel.scale) * (one - zero) + zero) / divisor
