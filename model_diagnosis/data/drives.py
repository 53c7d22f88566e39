"""Drives out of logs: one log each, or several loggers' logs of one drive laid together."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from itertools import pairwise, takewhile

import numpy as np

from model_diagnosis.data.sample_timing import PAUSE_S
from model_diagnosis.data.samples import Samples
from model_diagnosis.result import DataFault

_SHARED = 0.5


@dataclass(frozen=True)
class Drive:
    """Channels of one drive, of one or several loggers."""

    loggers: tuple[str, ...]
    channels: Mapping[str, Samples]
    faults: tuple[DataFault, ...] = ()

    @property
    def name(self) -> str:
        """Name of the first logger's file without its endings."""
        return self.loggers[0].split(".", 1)[0]


def join_loggers(logs: Sequence[Mapping[str, Samples]]) -> list[Drive]:
    """Logs of different channels that ran at the same time become one drive, the most alike file names first.

    Clocks that share no time at all are laid together by their first samples, and that is reported.
    """
    drives = [Drive((_logger(log),), dict(log)) for log in logs if log]
    joined: list[Drive] = []
    for drive in drives:
        partners = [other for other in joined if not set(other.channels) & set(drive.channels)]
        together = [other for other in partners if _shared(other, drive) >= _SHARED]
        apart = [other for other in partners if _shared(other, drive) == 0.0 and len(drives) == 2]
        if not together and not apart:
            joined.append(drive)
            continue
        best = max(together or apart, key=lambda other: _likeness(other.name, drive.name))
        joined[joined.index(best)] = _merged(best, drive if together else _moved(best, drive))
    return joined


def _likeness(one: str, other: str) -> int:
    """Letters that two names begin with alike."""
    return sum(1 for _ in takewhile(lambda pair: pair[0] == pair[1], zip(one, other, strict=False)))


def _logger(log: Mapping[str, Samples]) -> str:
    return next(iter(log.values())).logger


def _span(drive: Drive) -> tuple[float, float]:
    begins = [float(c.time[0]) for c in drive.channels.values() if len(c.time)]
    ends = [float(c.time[-1]) for c in drive.channels.values() if len(c.time)]
    return (min(begins), max(ends)) if begins else (0.0, 0.0)


def begin_s(drive: Drive) -> float:
    """Time of the first sample of any channel on the logs' clock [s]."""
    return _span(drive)[0]


def duration_s(drive: Drive) -> float:
    """Time from the first to the last sample of any channel [s]."""
    begin, end = _span(drive)
    return end - begin


def _shared(one: Drive, other: Drive) -> float:
    """Time that two drives share over the shorter one's."""
    (a, b), (c, d) = _span(one), _span(other)
    return max(0.0, min(b, d) - max(a, c)) / max(min(b - a, d - c), 1e-9)


def _moved(first: Drive, second: Drive) -> Drive:
    offset = _span(second)[0] - _span(first)[0]
    message = (
        f"{second.loggers[0]} and {first.loggers[0]} share no time; their first samples are taken as simultaneous "
        f"({offset:.6g} s between the clocks)"
    )
    fault = DataFault(
        kind="clock_offset", channel=second.loggers[0], value=offset, unit="s", repaired=True, message=message
    )
    channels = {name: replace(c, time=c.time - offset) for name, c in second.channels.items()}
    return Drive(second.loggers, channels, (*second.faults, fault))


def _merged(first: Drive, second: Drive) -> Drive:
    return Drive(first.loggers + second.loggers, {**first.channels, **second.channels}, first.faults + second.faults)


def split_at_pauses(drive: Drive) -> list[Drive]:
    """One drive for each stretch between pauses of more than two seconds in all channels together."""
    stamps = np.unique(np.concatenate([c.time[c.valid] for c in drive.channels.values()]))
    pauses = np.flatnonzero(np.diff(stamps) > PAUSE_S)
    if not len(pauses):
        return [drive]
    borders = [-np.inf, *(0.5 * (stamps[pauses] + stamps[pauses + 1])), np.inf]
    parts = []
    for low, high in pairwise(borders):
        channels = {name: _between(c, low, high) for name, c in drive.channels.items()}
        parts.append(Drive(drive.loggers, {name: c for name, c in channels.items() if len(c.time) > 1}, drive.faults))
    return [part for part in parts if part.channels]


def _between(channel: Samples, low: float, high: float) -> Samples:
    inside = (channel.time > low) & (channel.time < high)
    return replace(channel, time=channel.time[inside], values=channel.values[inside], valid=channel.valid[inside])
