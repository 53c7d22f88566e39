"""Loggers that are started anew for every drive: each drive has an offset of its own between their clocks.

By the lags of twins within each drive, where those differ from drive to drive by more than they are known to, and then
by the innovations of a car that was fitted to all drives.
"""

from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from model_diagnosis.data.delay_acceptance import fitted_car
from model_diagnosis.data.delay_checks import (
    Late,
    candidates,
    explain_lags,
    fitted_delays,
    lag_relations,
    set_right,
    shifted,
    with_rests,
)
from model_diagnosis.data.geometry import Geometry
from model_diagnosis.data.innovations import total_log_innovation
from model_diagnosis.data.replayed import FloatArray, ReplayFactory
from model_diagnosis.manoeuvre import SAMPLE_TIME_S, Manoeuvre
from model_diagnosis.result import DataFault
from signals.wheels import WHEELS
from vehicle_model.vehicle_file import VehicleFile

IntArray = NDArray[np.int64]

_STDS = 3.0
_LEAST_DIFFERENCE_S = 0.03
"""Between the offsets of two drives: what a short drive mistakes of the car's own lags."""
_ANYWHERE, _COARSE, _FINE = np.arange(-240, 241, 20), np.arange(-10, 11, 2), np.arange(-4, 5)
"""Shifts [samples] that the innovations are asked about: where no lag tells an offset, around one, and last."""
_BEGIN = 30
"""Samples at a drive's begin that tell nothing of shifts: a replay starts on a straight line through the first ones."""
_LEAST_SAMPLES = 150
_SHARP = 8.0
"""Log likelihood that both ends of the finest shifts have to lose: the offset is known to some milliseconds then."""
_AGREEMENT_STDS = 2.5
"""Standard deviations of what the lags tell within which the innovations have to agree."""
_STD_S = 0.005
"""Of an offset by innovations at least: half a sample, since only whole ones are tried."""
_FITTED_SHARE = 1e-3
"""By which channels of a fitted car are off: a third of a millimetre of a wheel's radius. On a coast at 25 m/s with
0.4 m/s² that is the speed of 60 ms later."""
_SLOPE_SAMPLES = 50
"""Over which slopes are taken: 0.05 m/s of noise leave 0.14 m/s²."""


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
        model = _FittedCar.to([_set_right(m, current) for m in manoeuvres], vehicle, replay)
        found = [model.offset(clock, _of(manoeuvres, clock.drive), _FINE) for clock in known.values()]
        found += [model.searched(clock, _of(manoeuvres, clock.drive)) for clock in searched if clock.key not in known]
        known = {clock.key: clock for clock in found if clock is not None}
    return [known.get(clock.key, replace(clock, told=False)) for clock in clocks]


@dataclass(frozen=True)
class _FittedCar:
    """A car by its deviations, and how the innovations of its replay depend on a logger's offset."""

    vehicle: VehicleFile
    replay: ReplayFactory
    deviations: Mapping[str, float]

    @classmethod
    def to(cls, manoeuvres: Sequence[Manoeuvre], vehicle: VehicleFile, replay: ReplayFactory) -> "_FittedCar":
        """The car that fits manoeuvres."""
        columns = replay(vehicle, manoeuvres).columns
        theta = fitted_car(vehicle, manoeuvres, replay)
        return cls(vehicle, replay, dict(zip(columns, theta.tolist(), strict=True)))

    def searched(self, clock: DriveClock, parts: Sequence[Manoeuvre]) -> DriveClock | None:
        """A clock from what the lags tell, or from anywhere; None where the innovations are not sharp or disagree."""
        found: DriveClock | None = clock
        for shifts in (_COARSE, _FINE) if clock.told else (_ANYWHERE, _COARSE, _FINE):
            found = None if found is None else self.offset(found, parts, shifts)
        if found is None or not clock.told:
            return found
        allowed_s = _AGREEMENT_STDS * float(np.hypot(clock.late.std_s, _STD_S))
        return found if abs(found.late.delay_s - clock.late.delay_s) <= allowed_s else None

    def offset(self, clock: DriveClock, parts: Sequence[Manoeuvre], shifts: IntArray) -> DriveClock | None:
        """The clock with the shift of the least innovations; None where that is not an inner one, or not sharp."""
        at = round(clock.late.delay_s / SAMPLE_TIME_S)
        spare = max(part.samples for part in parts) - _BEGIN - _LEAST_SAMPLES
        tried = np.array([one for one in shifts if max(0, abs(one) - at) + max(0, abs(one) + at) <= spare])
        if len(tried) < len(_FINE):
            return None
        scores = self._scores(clock.late.channels, parts, at + tried)
        best = int(np.argmin(scores))
        if not 0 < best < len(scores) - 1 or min(scores[0], scores[-1]) - scores[best] < _SHARP:
            return None
        before, least, after = scores[best - 1 : best + 2]
        part = 0.5 * (before - after) / (before - 2.0 * least + after)
        shift = float(tried[best] + part * (tried[best + 1] - tried[best]))
        std_s = float(np.hypot(_STD_S, _unsure_s(parts, clock.late.channels)))
        late = replace(clock.late, delay_s=SAMPLE_TIME_S * (at + shift), std_s=std_s)
        return replace(clock, late=late, told=True)

    def _scores(self, channels: Sequence[str], parts: Sequence[Manoeuvre], shifts: IntArray) -> FloatArray:
        """Σ N log σ of the innovations (k,) for shifts (k,) [samples] of channels, over what none of them lacks.

        A replay also leaves out what is slow, which it takes from the shifted speed.
        """
        begin, end = _BEGIN + max(0, -int(shifts.min())), max(0, int(shifts.max()))
        residuals, weights = [], []
        for shift in shifts:
            moved = [shifted(part, channels, SAMPLE_TIME_S * int(shift)) for part in parts]
            whole = [one.part(begin, one.samples - end) for one in moved if one.samples - end - begin >= _LEAST_SAMPLES]
            model = self.replay(self.vehicle, whole)
            theta = np.array([self.deviations.get(column, 0.0) for column in model.columns])
            residuals.append(model.residuals(theta))
            weights.append(model.weights())
        common = [np.min(of_part, axis=0) for of_part in zip(*weights, strict=True)]
        return np.array([total_log_innovation(one, common) for one in residuals])


def _unsure_s(parts: Sequence[Manoeuvre], channels: Sequence[str]) -> float:
    """Delay [s] that the fitted car's own error makes of the channel that tells the most: error over slope."""
    unsure = []
    for name in channels:
        series = [part.channels[name] for part in parts if name in part.channels and part.samples > _SLOPE_SAMPLES]
        if series:
            slopes = [
                (one[_SLOPE_SAMPLES:] - one[:-_SLOPE_SAMPLES]) / (SAMPLE_TIME_S * _SLOPE_SAMPLES) for one in series
            ]
            level, slope = (float(np.sqrt(np.mean(np.concatenate(some) ** 2))) for some in (series, slopes))
            unsure.append(_FITTED_SHARE * level / max(slope, 1e-9))
    return min(unsure, default=0.0)


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
            needed=not _has_speed(origins.keys() - own[logger]),
            set_back_s=set_back_s.get(logger, 0.0),
        )
        for logger, late in known.items()
    ]


def _has_speed(channels: Collection[str]) -> bool:
    return "speed" in channels or all(f"wheel_speed_{wheel}" in channels for wheel in WHEELS)


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
    return replace(
        manoeuvre,
        channels={name: values for name, values in manoeuvre.channels.items() if name not in out},
        weights={name: weights for name, weights in manoeuvre.weights.items() if name not in out},
        origins={name: origin for name, origin in manoeuvre.origins.items() if name not in out},
        phases={name: phase for name, phase in manoeuvre.phases.items() if name not in out},
    )
