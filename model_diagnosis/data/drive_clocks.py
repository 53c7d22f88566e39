"""Loggers that are started anew for every drive: each drive has an offset of its own between their clocks.

By the lags of twins within each drive, where those differ from drive to drive by more than they are known to, and then
by the innovations of a car that was fitted to all drives.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from model_diagnosis.data.clock_search import ANYWHERE, COARSE, FINE, FittedCar, has_speed, without
from model_diagnosis.data.delay_checks import (
    Late,
    candidates,
    explain_lags,
    fitted_delays,
    lag_relations,
    set_right,
    with_rests,
)
from model_diagnosis.data.geometry import Geometry
from model_diagnosis.data.replayed import ReplayFactory
from model_diagnosis.manoeuvre import SAMPLE_TIME_S, Manoeuvre
from model_diagnosis.result import DataFault
from vehicle_model.vehicle_file import VehicleFile

_STDS = 3.0
_LEAST_DIFFERENCE_S = 0.03
"""Between the offsets of two drives: what a short drive mistakes of the car's own lags."""


@dataclass(frozen=True)
class DriveClock:
    """Offset of one logger's clock in one drive.

    Attributes
    ----------
    drive, logger : as of ``Manoeuvre.drive`` and the file's name
    late : its channels and their delay
    told : whether the drive tells it
    needed : whether the drive has no speed without it
    set_back_s : by how much it was set back when it was read, of which ``late`` is the rest
    """

    drive: str
    logger: str
    late: Late
    told: bool
    needed: bool
    set_back_s: float = 0.0

    @property
    def key(self) -> tuple[str, str]:
        """Drive and logger."""
        return self.drive, self.logger

    def fault(self) -> DataFault:
        """The fault, as repaired by a whole-sample shift or by leaving the logger out."""
        delay_s = self.set_back_s + (self.late.delay_s if self.told else 0.0)
        word = "late" if delay_s > 0.0 else "early"
        if self.told:
            told = (
                f"{1e3 * abs(delay_s):.0f} ms {word} against the other logger of this drive "
                f"(± {1e3 * self.late.std_s:.0f} ms), another offset than in other drives; shifted by "
                f"{round(delay_s / SAMPLE_TIME_S)} samples"
            )
        else:
            kept = f"taken {1e3 * abs(delay_s):.0f} ms {word}" if delay_s else "left as it is"
            done = f"but needed: {kept}" if self.needed else "left out here"
            told = f"the offset to the other logger differs from drive to drive, and this one does not tell it; {done}"
        return DataFault(
            kind="clock_offset",
            channel=self.logger,
            value=delay_s if self.told else None,
            unit="s",
            evidence=self.late.gain if self.told else None,
            repaired=self.told or not self.needed,
            message=f"{self.logger}: {told}",
        )


def offsets_by_lags(manoeuvres: Sequence[Manoeuvre], geometry: Geometry) -> dict[str, dict[str, float]]:
    """Offset of each logger [s] by drive and logger, as far as lags tell it; empty where all drives have the same."""
    told = [clock for clock in _all_by_lags(manoeuvres, geometry) if clock.told]
    offsets_s: dict[str, dict[str, float]] = {}
    if _differ([clock.late for clock in told]):
        for clock in told:
            offsets_s.setdefault(clock.drive, {})[clock.logger] = clock.late.delay_s
    return offsets_s


def check_drive_clocks(
    manoeuvres: Sequence[Manoeuvre], geometry: Geometry, vehicle: VehicleFile, replay: ReplayFactory | None
) -> tuple[list[DriveClock], list[Manoeuvre]]:
    """Offsets that differ from drive to drive, and the manoeuvres so shifted; none where all drives have the same.

    Where a drive does not tell its own, a logger whose offset differs between the others is left out, if it can be. The
    innovations are asked where each drive can be replayed without these loggers.
    """
    clocks = _all_by_lags(manoeuvres, geometry)
    set_back = any(clock.set_back_s for clock in clocks)
    if not set_back and not _differ([clock.late for clock in clocks if clock.told]):
        return [], list(manoeuvres)
    if replay is not None and not any(clock.needed for clock in clocks):
        clocks = _by_innovations(clocks, manoeuvres, vehicle, replay)
    return clocks, [_set_right(m, clocks) for m in manoeuvres]


def with_common(clocks: Sequence[DriveClock], *found: Sequence[Late]) -> tuple[list[DriveClock], list[list[Late]]]:
    """Clocks with what was found later in common of all drives, and shifted; of each list of late sets the others."""
    own = {clock.late.channels for clock in clocks}
    common = [late for lates in found for late in lates if late.channels in own]
    whole = []
    for clock in clocks:
        (late,), _ = with_rests([clock.late], [late for late in common if late.channels == clock.late.channels])
        whole.append(replace(clock, late=late))
    return whole, [[late for late in lates if late.channels not in own] for lates in found]


def _by_innovations(
    clocks: Sequence[DriveClock], manoeuvres: Sequence[Manoeuvre], vehicle: VehicleFile, replay: ReplayFactory
) -> list[DriveClock]:
    """Clocks by the innovations of each drive, where those are sharp and agree with the lags.

    First by a car that is fitted without these loggers, since a number that is fitted to late data takes a part of the
    delay upon it; then by one fitted to the drives whose offset is known, which tells the others', too.
    """
    known: dict[tuple[str, str], DriveClock] = {}
    for searched in ([clock for clock in clocks if clock.told], clocks, ()):
        if searched is clocks and not known:
            break  # a car without any speed tells no offset that the lags do not
        current = [known.get(clock.key, replace(clock, told=False)) for clock in clocks]
        car = FittedCar.to([_set_right(m, current) for m in manoeuvres], vehicle, replay)
        found = [(c, car.offset(c.late, _of(manoeuvres, c.drive), FINE)) for c in known.values()]
        found += [
            (
                c,
                car.searched(
                    c.late, _of(manoeuvres, c.drive), *((COARSE, FINE) if c.told else (ANYWHERE, COARSE, FINE))
                ),
            )
            for c in searched
            if c.key not in known
        ]
        known = {c.key: replace(c, late=late, told=True) for c, late in found if late is not None}
    return [known.get(clock.key, replace(clock, told=False)) for clock in clocks]


def _of(manoeuvres: Sequence[Manoeuvre], drive: str) -> list[Manoeuvre]:
    return [m for m in manoeuvres if m.drive == drive]


def _all_by_lags(manoeuvres: Sequence[Manoeuvre], geometry: Geometry) -> list[DriveClock]:
    drives = [name for name in dict.fromkeys(m.drive for m in manoeuvres) if name]
    return [clock for drive in drives for clock in _by_lags(drive, _of(manoeuvres, drive), geometry)]


def _by_lags(drive: str, parts: Sequence[Manoeuvre], geometry: Geometry) -> list[DriveClock]:
    """Offset of the loggers that a drive has besides its first one, as far as its lags tell them."""
    origins = {name: origin.partition(":")[0] for part in parts for name, origin in part.origins.items()}
    _, *followers = dict.fromkeys(origins.values())
    own = {logger: {name for name, origin in origins.items() if origin == logger} for logger in followers}
    if not own:
        return []
    sets = candidates(parts)
    set_back_s = {logger: by_s for part in parts for logger, by_s in part.set_back_s.items()}
    known = {
        logger: late for logger, names in own.items() for late in sets if set(late.channels) == names and late.groups
    }
    relations = lag_relations(parts, geometry)
    compared = {group for one in relations for group in (one.late, one.early)}
    measured = fitted_delays(relations, list(known.values()))
    found = {late.channels: replace(late, delay_s=0.0) for late in measured}
    found |= {late.channels: late for late in explain_lags(relations, list(known.values()), proposed=True)}
    return [
        DriveClock(
            drive,
            logger,
            found[late.channels],
            told=bool(late.groups & compared),
            needed=not has_speed(origins.keys() - own[logger]),
            set_back_s=set_back_s.get(logger, 0.0),
        )
        for logger, late in known.items()
    ]


def _differ(lates: Sequence[Late]) -> bool:
    """Whether any two offsets of the same channels differ by more than they are known to."""
    return any(
        one.channels == other.channels
        and abs(one.delay_s - other.delay_s) > _LEAST_DIFFERENCE_S + _STDS * float(np.hypot(one.std_s, other.std_s))
        for k, one in enumerate(lates)
        for other in lates[:k]
    )


def _set_right(manoeuvre: Manoeuvre, clocks: Sequence[DriveClock]) -> Manoeuvre:
    """A manoeuvre with its drive's loggers taken earlier by their delays; without those whose delay is not known."""
    out: set[str] = set()
    for clock in clocks:
        if clock.drive == manoeuvre.drive and clock.told:
            manoeuvre = set_right(manoeuvre, clock.late.channels, clock.late.delay_s)
        elif clock.drive == manoeuvre.drive and not clock.needed:
            out |= set(clock.late.channels)
    return without(manoeuvre, out)
