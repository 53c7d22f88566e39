"""Logs of several loggers laid together to drives.

The logger with the most channels leads: each of its logs is a drive, and the others give what they recorded then.
Clocks that are apart are laid together by the speeds, which every logger of a car's motion has. Loggers whose logs
all begin anew, at 0 say, have a clock per log: two of them are paired by the names of their files.
"""

from collections.abc import Mapping, Sequence
from dataclasses import replace
from itertools import combinations, takewhile

import numpy as np

from model_diagnosis.data.drives import Drive, between, duration_s, moved, span_s, together
from model_diagnosis.data.samples import Samples
from model_diagnosis.data.speed_match import ClockMatch, match_clocks
from model_diagnosis.result import DataFault

_SHARED = 0.5
"""Share of the shorter log's time from which two logs ran together: one drive's loggers do, seconds apart."""
_MARGIN_S = 3.0
"""What a part of another logger's log has more on both sides: clocks that are off by up to 2.5 s are found later."""


def join_loggers(logs: Sequence[Mapping[str, Samples]], radii: Mapping[str, float]) -> list[Drive]:
    """Drives of the leading logger with what the others recorded at the same time; logs that fit nowhere by themselves.

    Parameters
    ----------
    logs : channels of each log by catalogue name
    radii : wheel -> rolling radius [m]
    """
    leads, *others = _by_logger([Drive((next(iter(log.values())).logger,), dict(log)) for log in logs if log])
    alone: list[Drive] = []
    for other in others:
        leads, left = _laid_together(leads, other, radii)
        alone += left
    return leads + alone


def _by_logger(drives: Sequence[Drive]) -> list[list[Drive]]:
    """Logs that have channels in common, as those of one logger have; the one with the most channels first."""
    loggers: list[list[Drive]] = []
    for drive in drives:
        own = max(loggers, key=lambda one: _alike(one[0], drive), default=None)
        if own is None or not _alike(own[0], drive):
            loggers.append([drive])
        else:
            own.append(drive)
    return sorted(loggers, key=lambda one: -max(len(drive.channels) for drive in one))


def _alike(one: Drive, other: Drive) -> float:
    """Share of the channels of two logs that both have."""
    names, others = set(one.channels), set(other.channels)
    return len(names & others) / len(names | others)


def _laid_together(
    leads: Sequence[Drive], others: Sequence[Drive], radii: Mapping[str, float]
) -> tuple[list[Drive], list[Drive]]:
    """The leading logger's drives with what one other logger recorded then, and the other's logs that fit nowhere."""
    anew = _begin_anew(leads), _begin_anew(others)
    if all(anew):
        return _by_names(leads, others)
    if not any(anew):
        found = match_clocks(leads, others, radii) or _by_begins(leads, others)
        if found:
            return _by_time(leads, _set_back(leads, others, found))
        at_one_time = any(_shared(lead, other) >= _SHARED for lead in leads for other in others)
        return _by_time(leads, others) if at_one_time else (list(leads), _told(leads, others))
    joined, left = _each_lead(leads, others, radii) if anew[0] else _each_other(leads, others, radii)
    return (joined, _told(leads, left)) if len(left) < len(others) else _by_names(leads, others)


def _each_lead(
    leads: Sequence[Drive], others: Sequence[Drive], radii: Mapping[str, float]
) -> tuple[list[Drive], list[Drive]]:
    """As ``_laid_together``, where each of the leads' logs has a clock of its own."""
    joined, left = [], list(others)
    for lead in leads:
        found = match_clocks([lead], others, radii)
        if found is None:
            joined += _told(others, [lead])
            continue
        (whole,), unused = _by_time([lead], _set_back([lead], others, found, of_lead=True))
        joined.append(whole)
        left = [log for log in left if log.loggers[0] in {one.loggers[0] for one in unused}]
    return joined, left


def _each_other(
    leads: Sequence[Drive], others: Sequence[Drive], radii: Mapping[str, float]
) -> tuple[list[Drive], list[Drive]]:
    """As ``_laid_together``, where each of the other logger's logs has a clock of its own."""
    placed, left = [], []
    for other in others:
        found = match_clocks(leads, [other], radii)
        if found:
            placed += _set_back(leads, [other], found)
        else:
            left.append(other)
    joined, unused = _by_time(leads, placed)
    return joined, left + unused


def _by_time(leads: Sequence[Drive], others: Sequence[Drive]) -> tuple[list[Drive], list[Drive]]:
    """Each lead with what the others have within its time, and the others that no lead needs."""
    joined, needed = [], set[str]()
    for lead in leads:
        parts = [one for one in others if _shared(lead, one) >= _SHARED and not set(lead.channels) & set(one.channels)]
        needed |= {part.loggers[0] for part in parts}
        begin, end = span_s(lead)
        whole = _one_after_the_other([between(part, begin - _MARGIN_S, end + _MARGIN_S) for part in parts])
        joined.append(together(lead, whole) if whole else lead)
    return joined, [other for other in others if other.loggers[0] not in needed]


def _one_after_the_other(parts: Sequence[Drive]) -> Drive | None:
    """Logs of one logger as one, by rising time."""
    if not parts:
        return None
    first, *rest = sorted(parts, key=lambda part: span_s(part)[0])
    channels = dict(first.channels)
    for part in rest:
        for name, channel in part.channels.items():
            channels[name] = _appended(channels[name], channel) if name in channels else channel
    return Drive(
        tuple(name for part in (first, *rest) for name in part.loggers),
        channels,
        tuple(fault for part in (first, *rest) for fault in part.faults),
    )


def _appended(one: Samples, other: Samples) -> Samples:
    return replace(
        one,
        time=np.concatenate((one.time, other.time)),
        values=np.concatenate((one.values, other.values)),
        valid=np.concatenate((one.valid, other.valid)),
        restored=one.restored + other.restored,
    )


def _by_names(leads: Sequence[Drive], others: Sequence[Drive]) -> tuple[list[Drive], list[Drive]]:
    """Each of the others with the lead that shares its time and whose file is called most alike."""
    joined, alone = list(leads), []
    for other in others:
        free = [
            lead for lead in joined if not set(lead.channels) & set(other.channels) and _shared(lead, other) >= _SHARED
        ]
        if free:
            best = max(free, key=lambda lead: _likeness(lead.name, other.name))
            joined[joined.index(best)] = together(best, other)
        else:
            alone.append(other)
    return joined, alone


def _likeness(one: str, other: str) -> int:
    """Letters that two names begin with alike."""
    return sum(1 for _ in takewhile(lambda pair: pair[0] == pair[1], zip(one, other, strict=False)))


def _begin_anew(logs: Sequence[Drive]) -> bool:
    """Whether logs of one logger overlap each other, which those on one clock cannot."""
    return any(_shared(one, other) >= _SHARED for one, other in combinations(logs, 2))


def _shared(one: Drive, other: Drive) -> float:
    """Time that two drives share over the shorter one's."""
    (a, b), (c, d) = span_s(one), span_s(other)
    return max(0.0, min(b, d) - max(a, c)) / max(min(duration_s(one), duration_s(other)), 1e-9)


def _by_begins(leads: Sequence[Drive], others: Sequence[Drive]) -> ClockMatch | None:
    """Clocks of one log each that share no time, by their first samples; None where that says nothing."""
    if len(leads) != 1 or len(others) != 1 or _shared(leads[0], others[0]) > 0.0:
        return None
    return ClockMatch(
        span_s(others[0])[0] - span_s(leads[0])[0], "they share no time, and first samples are taken as simultaneous"
    )


def _set_back(
    leads: Sequence[Drive], others: Sequence[Drive], match: ClockMatch, *, of_lead: bool = False
) -> list[Drive]:
    """The others' clock set to the leads', and that said; as they are where later checks find what little it is off.

    ``of_lead``: a lead's own clock is told to differ, each lead having another one.
    """
    if abs(match.ahead_s) < _MARGIN_S:
        return list(others)
    subject, standard, ahead_s = (leads, others, -match.ahead_s) if of_lead else (others, leads, match.ahead_s)
    order = "ahead of" if ahead_s > 0.0 else "behind"
    told = f"the clock is {abs(ahead_s):.2f} s {order} that of {_files(standard)}; {match.reason}"
    fault = _fault(subject, told, ahead_s)
    return [replace(moved(one, -match.ahead_s), faults=(*one.faults, fault)) for one in others]


def _told(leads: Sequence[Drive], alone: Sequence[Drive]) -> list[Drive]:
    """Logs that belong to none of the other logger's, with a fault that says so."""
    told = f"no time is shared with {_files(leads)}, and the speeds go together at no one place: taken without"
    return [replace(one, faults=(*one.faults, _fault(alone, told))) for one in alone]


def _files(drives: Sequence[Drive]) -> str:
    first, *rest = [drive.loggers[0] for drive in drives]
    return f"{first} and {len(rest)} more" if rest else first


def _fault(drives: Sequence[Drive], message: str, ahead_s: float | None = None) -> DataFault:
    return DataFault(
        kind="clock_offset",
        channel=_files(drives),
        value=ahead_s,
        unit="s",
        repaired=ahead_s is not None,
        message=f"{_files(drives)}: {message}",
    )
