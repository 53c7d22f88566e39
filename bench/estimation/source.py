"""What an offline estimate reads: a recording of the bench, or a measured log through a channel map.

Both become rows a millisecond apart, as the live estimators see them: the decoded value of each signal, held since its
last sample, and the time since then.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from bench.recording.arrays import FloatArray, RunArrays
from estimators.channels import CHANNELS
from signals.catalogue import catalogue
from signals.errors import InputError

if TYPE_CHECKING:
    from signals.measured.measured_log import MeasuredChannel

TICK_S = 1e-3
# time stamps of a log on a date have a resolution of a quarter microsecond
_STAMP_S = 1e-6


@dataclass(frozen=True)
class Source:
    """Signals for estimators, one row per millisecond.

    Attributes
    ----------
    path : Path
        Recording or log.
    data : RunArrays
        Decoded signals, and whatever estimates can be compared with.
    channel_ages : mapping of str to array, optional
        Time since the last sample of each signal of a measured log [s]; a recording of the bench has the ages of its
        frames in ``data``.
    vehicle : str
        Car of the scenario; empty for a measured log.
    estimators : mapping
        Estimators that the scenario ran live, with their settings.
    """

    path: Path
    data: RunArrays
    channel_ages: Mapping[str, FloatArray] | None = None
    vehicle: str = ""
    estimators: Mapping[str, Mapping[str, Any]] = field(default_factory=dict)

    @property
    def measured(self) -> bool:
        """True for a measured log."""
        return self.channel_ages is not None

    def missing(self, inputs: Sequence[str]) -> list[str]:
        """Those of the signals, and of the ages that belong to them, that are not there."""
        wanted = list(inputs)
        if not self.measured:
            wanted += sorted({CHANNELS[name].age for name in inputs})
        return [name for name in wanted if name not in self.data]

    def columns(self, inputs: Sequence[str]) -> dict[str, FloatArray]:
        """Values of the signals by name."""
        return {name: self.data.array(name) for name in inputs}

    def ages(self, inputs: Sequence[str]) -> dict[str, FloatArray]:
        """Ages by their name; where signals of a log share one, the oldest counts: a sensor that died is noticed."""
        groups: dict[str, list[str]] = {}
        for name in inputs:
            groups.setdefault(CHANNELS[name].age, []).append(name)
        if self.channel_ages is None:
            return {age: self.data.array(age) for age in groups}
        return {age: np.max([self.channel_ages[name] for name in members], axis=0) for age, members in groups.items()}


def open_source(log: str | Path, channels: str | Path | None = None, vehicle: str | Path | None = None) -> Source:
    """Open a run's folder, a recording of the bench, or with a channel map any log.

    Raises
    ------
    InputError
        If there is no such file, or it cannot be read.
    """
    if channels is not None:
        return _open_measured(Path(log), channels, vehicle)
    from bench.recording.reading import Recording
    from bench.report.run_data import find_run

    path = Path(log)
    recording = Recording.open(path if path.exists() else find_run(log))
    if len(recording) == 0:
        raise InputError(f"{recording.path}: the recording holds no row")
    scenario = _scenario(recording.folder)
    estimators = {name: settings or {} for name, settings in dict(scenario.get("estimators") or {}).items()}
    return Source(recording.path, recording, None, str(scenario.get("vehicle") or ""), estimators)


def _scenario(folder: Path) -> Mapping[str, Any]:
    path = folder / "scenario.yaml"
    if not path.is_file():
        return {}
    from signals.yaml_files import load_yaml

    data = load_yaml(path).data
    return data if isinstance(data, Mapping) else {}


def _open_measured(path: Path, channels: str | Path, vehicle: str | Path | None) -> Source:
    from bench.verdict.rejudge import wheel_radius_m
    from signals.measured.channel_map import load_channel_map
    from signals.measured.measured_log import read_log

    log = read_log(path, load_channel_map(channels), wheel_radius_m=wheel_radius_m(vehicle))
    end = max(float(channel.time[-1]) for channel in log.channels.values())
    time: FloatArray = TICK_S * np.arange(round(end / TICK_S) + 1, dtype=np.float64)
    inputs = {signal.name for signal in catalogue() if signal.block == "bus"}
    columns: dict[str, FloatArray] = {"time": time}
    ages: dict[str, FloatArray] = {}
    for name, channel in log.channels.items():
        if name in inputs:
            columns[name], ages[name] = held(channel, time)
        else:
            # a reference is only compared with: its value between two samples is the likeliest one
            columns[name] = np.interp(time, channel.time, channel.values, left=np.nan, right=np.nan)
    units = {"time": "s"} | log.units()
    return Source(path, RunArrays(time, columns, units), ages)


def held(channel: "MeasuredChannel", time: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Last value of a channel at each time, and how old it is [s]; infinite before the first sample."""
    row = np.searchsorted(channel.time, time + _STAMP_S, side="right") - 1
    last = np.maximum(row, 0)
    age = np.where(row < 0, np.inf, np.maximum(time - channel.time[last], 0.0))
    return channel.values[last], age
