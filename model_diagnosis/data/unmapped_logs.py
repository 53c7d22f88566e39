"""Logs that have no channel map yet: their columns, clock and units, and what a map would make of them."""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from model_diagnosis.data.channel_names import plain_name
from model_diagnosis.data.drives import Drive
from model_diagnosis.data.geometry import Geometry, geometry_of
from model_diagnosis.data.grid import on_grid
from model_diagnosis.data.reading import check_samples
from model_diagnosis.data.samples import FloatArray, read_samples
from model_diagnosis.manoeuvre import SAMPLE_TIME_S, Manoeuvre
from signals.errors import InputError
from signals.measured.channel_map import Channel, ChannelMap, Clock
from signals.measured.measured_log import format_of, holds_frames, log_columns, read_named
from signals.measured.raw_channels import RawChannels
from signals.quantities import to_si
from vehicle_model.vehicle_file import VehicleFile

_AT_ONCE = 32
"""Columns that are read together where all are looked at."""
_TIME_NAMES = ("time", "t", "timestamp", "zeit", "et", "seconds", "sec", "time_s", "time_ms")
_LEAST_TIME_STEP = 0.9
"""Step of a time that cannot be seconds: slower than 1 Hz no manoeuvre is seen."""


@dataclass(frozen=True)
class UnmappedLogs:
    """Logs of the same columns.

    Attributes
    ----------
    columns : names without the time -> unit as the first log writes it, "" where it tells none
    empty : a map of no channel, with the logs' clock and database
    """

    paths: tuple[Path, ...]
    columns: Mapping[str, str]
    empty: ChannelMap
    vehicle: VehicleFile

    @classmethod
    def of(cls, paths: Sequence[Path], vehicle: VehicleFile, dbc: str | None) -> "UnmappedLogs":
        """Look at the first log's columns and clock.

        Raises
        ------
        InputError
            If the log is not there, cannot be read, or is one of CAN frames without a database.
        """
        first, empty = paths[0], ChannelMap(dbc=dbc, channels={})
        if holds_frames(format_of(first, empty), empty) and dbc is None:
            raise InputError(f"{first}: a CAN log needs a database", mend="name it: --dbc FILE")
        columns = log_columns(first, empty)
        if dbc is None and any(name.startswith("CAN_DataFrame") for name in columns):
            raise InputError(f"{first}: an MF4 of CAN frames needs a database", mend="name it: --dbc FILE")
        time_names = [name for name in columns if plain_name(name)[0] in _TIME_NAMES]
        if format_of(first, empty) in ("csv", "parquet"):
            clock = _clock(first, columns)
            empty, time_names = ChannelMap(clock=clock, channels={}), [clock.column]
        columns = {name: unit for name, unit in columns.items() if name not in time_names}
        return cls(tuple(paths), columns, empty, vehicle)

    @property
    def geometry(self) -> Geometry:
        """Of the car."""
        return geometry_of(self.vehicle)

    def largest(self, names: Sequence[str]) -> dict[str, float]:
        """Largest magnitude of those columns that hold numbers in any log."""
        found: dict[str, float] = {}
        for batch in _batches(names):
            for path in self.paths:
                for name, (_, values) in self._read(path, batch).items():
                    if np.isfinite(values).any():
                        found[name] = max(found.get(name, 0.0), float(np.nanmax(np.abs(values))))
        return found

    def on_time_of(
        self, manoeuvres: Sequence[Manoeuvre], names: Sequence[str]
    ) -> Iterator[tuple[str, list[FloatArray | None]]]:
        """(column, its course at the instants of each log's manoeuvre; None where it has no numbers or is constant)."""
        for batch in _batches(names):
            logs = [self._read(path, batch) for path in self.paths]
            for name in batch:
                yield (
                    name,
                    [
                        _course(log[name], one.start_s + one.time) if name in log else None
                        for log, one in zip(logs, manoeuvres, strict=True)
                    ],
                )

    def manoeuvres(self, channels: Mapping[str, Channel]) -> list[Manoeuvre]:
        """Each whole log as one manoeuvre, its samples checked."""
        channel_map = self.empty.model_copy(update={"channels": dict(channels)})
        return [self._manoeuvre(path, channel_map) for path in self.paths]

    def _manoeuvre(self, path: Path, channel_map: ChannelMap) -> Manoeuvre:
        drive = Drive((path.name,), check_samples(read_samples(path, channel_map, self.vehicle))[0])
        try:
            time, values, weights = on_grid(drive.channels)
        except InputError as error:
            raise InputError(f"{path}: {error}") from None
        steps = SAMPLE_TIME_S * np.arange(len(time), dtype=np.float64)
        return Manoeuvre(drive.name, steps, values, weights, path.name, start_s=float(time[0]))

    def _read(self, path: Path, names: Sequence[str]) -> RawChannels:
        """Those of some columns that hold numbers; one by one where any of them holds words."""
        try:
            return read_named(path, names, self.empty, missing_ok=True)
        except InputError:
            if len(names) == 1:
                return {}
            return {name: raw for one in names for name, raw in self._read(path, [one]).items()}


def _batches(names: Sequence[str]) -> Iterator[list[str]]:
    distinct = list(dict.fromkeys(names))
    for begin in range(0, len(distinct), _AT_ONCE):
        yield distinct[begin : begin + _AT_ONCE]


def _course(raw: tuple[FloatArray, FloatArray], time: FloatArray) -> FloatArray | None:
    stamps, values = raw
    known = np.isfinite(values)
    if known.sum() < 2 or np.any(np.diff(stamps[known]) < 0.0) or np.ptp(values[known]) == 0.0:
        return None
    course: FloatArray = np.interp(time, stamps[known], values[known])
    return course


def _clock(path: Path, columns: Mapping[str, str]) -> Clock:
    """Column and unit of a table's time: named so, else the first one."""
    plain = {name: plain_name(name) for name in columns}
    column = next((name for word in _TIME_NAMES for name in columns if plain[name][0] == word), next(iter(columns)))
    told = plain[column][1] or columns[column]
    unit = {"sec": "s", "seconds": "s", "msec": "ms", "usec": "us", "µs": "us"}.get(told.lower(), told)
    if unit not in ("s", "ms", "us", "ns", "min", "h"):
        ((time, _),) = read_named(path, [column], ChannelMap(clock=Clock(column=column), channels={})).values()
        steps = np.diff(time)
        steps = steps[steps > 0.0]
        step = float(np.median(steps)) if len(steps) else 0.0
        unit = next((u for u in ("s", "ms", "us", "ns") if step * to_si(f"1 {u}", "s") < _LEAST_TIME_STEP), "s")
    return Clock(column=column, unit=unit)
