"""A drive: channels of one or several loggers, each on its own stamps of one clock."""

from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from itertools import pairwise

import numpy as np

from model_diagnosis.data.sample_timing import PAUSE_S
from model_diagnosis.data.samples import Samples
from model_diagnosis.result import DataFault


@dataclass(frozen=True)
class Drive:
    """Channels of one drive, of one or several loggers.

    ``set_back_s`` tells by how much the clock of a logger was set back for this drive alone.
    """

    loggers: tuple[str, ...]
    channels: Mapping[str, Samples]
    faults: tuple[DataFault, ...] = ()
    set_back_s: Mapping[str, float] = field(default_factory=dict)

    @property
    def name(self) -> str:
        """Name of the first logger's file without its endings."""
        return self.loggers[0].split(".", 1)[0]

    @property
    def files(self) -> str:
        """Files of all its loggers."""
        return ", ".join(self.loggers)


def span_s(drive: Drive) -> tuple[float, float]:
    """First and last stamp of any channel on the logs' clock [s]."""
    begins = [float(c.time[0]) for c in drive.channels.values() if len(c.time)]
    ends = [float(c.time[-1]) for c in drive.channels.values() if len(c.time)]
    return (min(begins), max(ends)) if begins else (0.0, 0.0)


def begin_s(drive: Drive) -> float:
    """Time of the first sample of any channel on the logs' clock [s]."""
    return span_s(drive)[0]


def duration_s(drive: Drive) -> float:
    """Time from the first to the last sample of any channel [s]."""
    begin, end = span_s(drive)
    return end - begin


def together(first: Drive, second: Drive) -> Drive:
    """Channels of two loggers that ran at the same time."""
    return Drive(
        first.loggers + second.loggers,
        {**first.channels, **second.channels},
        first.faults + second.faults,
        {**first.set_back_s, **second.set_back_s},
    )


def moved(drive: Drive, later_s: float) -> Drive:
    """The drive with its clock set forward."""
    return replace(drive, channels={name: replace(c, time=c.time + later_s) for name, c in drive.channels.items()})


def with_clocks_set_back(drive: Drive, by_s: Mapping[str, float]) -> Drive:
    """The drive with the clocks of some loggers set back."""
    channels = {name: replace(c, time=c.time - by_s.get(c.logger, 0.0)) for name, c in drive.channels.items()}
    return replace(drive, channels=channels, set_back_s=by_s)


def between(drive: Drive, low: float, high: float) -> Drive:
    """What lies between two times, without channels of fewer than two samples there."""
    channels = {name: _between(c, low, high) for name, c in drive.channels.items()}
    return replace(drive, channels={name: c for name, c in channels.items() if len(c.time) > 1})


def split_at_pauses(drive: Drive) -> list[Drive]:
    """One drive for each stretch between pauses of more than two seconds in all channels together."""
    stamps = np.unique(np.concatenate([c.time[c.valid] for c in drive.channels.values()]))
    pauses = np.flatnonzero(np.diff(stamps) > PAUSE_S)
    if not len(pauses):
        return [drive]
    borders = [-np.inf, *(0.5 * (stamps[pauses] + stamps[pauses + 1])), np.inf]
    parts = [between(drive, low, high) for low, high in pairwise(borders)]
    return [part for part in parts if part.channels]


def _between(channel: Samples, low: float, high: float) -> Samples:
    inside = (channel.time > low) & (channel.time < high)
    return replace(channel, time=channel.time[inside], values=channel.values[inside], valid=channel.valid[inside])
