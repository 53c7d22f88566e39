"""What takes no part in the search: drives held out, or the last part of each; what is found is measured on it."""

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import replace
from itertools import groupby

from model_diagnosis.data.checks import check_data
from model_diagnosis.data.delay_checks import shifted
from model_diagnosis.data.faults import parted
from model_diagnosis.data.replayed import ReplayFactory
from model_diagnosis.data.segmentation import SHORTEST_S
from model_diagnosis.manoeuvre import SAMPLE_TIME_S, Manoeuvre
from model_diagnosis.result import DataFault
from signals.errors import InputError
from vehicle_model.vehicle_file import VehicleFile

_SAME_LAG_S = 0.05
"""Lags of the held-out drives and of the searched ones that differ by less are one: loggers that were started anew are
this near to what they were before by chance only, and a few drives mistake what the car lacks for a lag of 30 ms."""
_DELAYS = ("clock_offset", "can_latency", "channel_delay", "wheel_speed_delay")
"""Kinds of faults that a shift repairs."""


def check_held_out(
    held_out: Sequence[Manoeuvre],
    searched: Iterable[DataFault],
    vehicle: VehicleFile,
    replay: ReplayFactory | None = None,
) -> list[Manoeuvre]:
    """Held-out manoeuvres repaired as ``check_data`` does, with the lags of the searched ones where they may be those.

    Parameters
    ----------
    searched : faults of the searched manoeuvres, which are more and tell a lag better
    replay : as of ``check_data``
    """
    faults, repaired = check_data(held_out, vehicle, replay)
    here, there = _delays(faults), _delays(searched)
    for channels in dict.fromkeys((*here, *there)):
        own, known = here.get(channels, 0.0), there.get(channels, 0.0)
        if abs(own - known) < _SAME_LAG_S:
            # as whole samples, like the shifts that are taken back
            back = round(known / SAMPLE_TIME_S) - round(own / SAMPLE_TIME_S)
            repaired = [shifted(one, parted(channels), back * SAMPLE_TIME_S) for one in repaired]
    return repaired


def _delays(faults: Iterable[DataFault]) -> Mapping[str, float]:
    """Channels of a fault -> how late they were."""
    return {one.channel: one.value for one in faults if one.kind in _DELAYS and one.value is not None and one.repaired}


def held_out_by_time(manoeuvres: Sequence[Manoeuvre], share: float) -> tuple[list[Manoeuvre], list[Manoeuvre]]:
    """Divide drives by time: whole manoeuvres, and at most one of each drive cut in two at the border.

    Parameters
    ----------
    manoeuvres : in the order of reading, those of one drive by rising time
    share : of each drive's driven time, from its end, that takes no part in the search

    Returns
    -------
    manoeuvres to search, manoeuvres held out

    Raises
    ------
    InputError
        If the share leaves nothing on one side.
    """
    if not 0.0 < share < 1.0:
        raise InputError(
            "hold-out share", found=f"{share:g}", allowed="above 0 and below 1", mend="0.5 is the second half"
        )
    searched: list[Manoeuvre] = []
    held_out: list[Manoeuvre] = []
    for _, drive in groupby(manoeuvres, key=lambda manoeuvre: manoeuvre.drive):
        before, after = _divided(list(drive), share)
        searched += before
        held_out += after
    if not searched or not held_out:
        seconds = sum(manoeuvre.duration_s for manoeuvre in manoeuvres)
        raise InputError(
            f"hold-out share {share:g}: nothing is left {'to search' if not searched else 'to measure the gain on'}",
            found=f"{seconds:.3g} s of manoeuvres",
            allowed=f"parts of at least {SHORTEST_S:.0f} s on both sides",
            mend="choose another share, or leave it out: the gain is cross-validated then",
        )
    return searched, held_out


def _divided(drive: Sequence[Manoeuvre], share: float) -> tuple[list[Manoeuvre], list[Manoeuvre]]:
    border = round((1.0 - share) * sum(manoeuvre.samples for manoeuvre in drive))
    shortest = round(SHORTEST_S / SAMPLE_TIME_S)
    before: list[Manoeuvre] = []
    after: list[Manoeuvre] = []
    passed = 0
    for manoeuvre in drive:
        at = border - passed
        passed += manoeuvre.samples
        if shortest <= at <= manoeuvre.samples - shortest:
            before.append(_part(manoeuvre, 0, at))
            after.append(_part(manoeuvre, at, manoeuvre.samples))
        else:
            (before if 2 * at > manoeuvre.samples else after).append(manoeuvre)
    return before, after


def _part(manoeuvre: Manoeuvre, begin: int, end: int) -> Manoeuvre:
    """Samples ``begin`` to ``end`` as a manoeuvre of another name."""
    which = "to" if begin == 0 else "from"
    return replace(manoeuvre.part(begin, end), name=f"{manoeuvre.name} {which} {SAMPLE_TIME_S * (begin or end):.1f} s")
