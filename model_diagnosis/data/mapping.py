"""Suggestions for a channel map: which column is which of our signals, by its name, unit, sign and correlation.

Names come first. The kinematic twins then say unit and sign where the log does not, or not rightly, and find columns
whose names tell nothing.
"""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np

from model_diagnosis.data.channel_names import plain_name, signals_by_name, unit_of
from model_diagnosis.data.drives import Drive
from model_diagnosis.data.geometry import Geometry, geometry_of
from model_diagnosis.data.grid import on_grid
from model_diagnosis.data.lags import find_lag
from model_diagnosis.data.reading import check_samples
from model_diagnosis.data.samples import FloatArray, read_samples
from model_diagnosis.data.twins import Motion, members, slope, twins_of
from model_diagnosis.data.unit_checks import Wrong, explain, relations_of
from model_diagnosis.manoeuvre import SAMPLE_TIME_S, Manoeuvre
from signals.errors import InputError
from signals.measured.channel_map import Channel, ChannelMap, Clock, channel_units
from signals.measured.measured_log import format_of, holds_frames, log_names, log_units, read_named
from signals.quantities import to_si
from signals.wheels import WHEELS
from vehicle_model.vehicle_file import VehicleFile

_SURE = 0.95
_AT_ONCE = 32
"""Columns that are read together where all are looked at."""
_LIKE_A_UNIT = 0.15
"""Share by which the spread of a column may differ from what a unit makes of it."""
_USUAL_UNITS = {
    "m/s": ("m/s", "km/h", "mph"),
    "rad/s": ("rad/s", "deg/s", "rpm"),
    "rad": ("rad", "deg"),
    "m/s^2": ("m/s^2", "g"),
    "Pa": ("bar", "Pa", "kPa", "MPa", "psi"),
    "N m": ("N m", "ft*lbf"),
}
_TIME_NAMES = ("time", "t", "timestamp", "zeit", "et", "seconds", "sec", "time_s", "time_ms")
_LEAST_TIME_STEP = 0.9
"""Step of a time that cannot be seconds: slower than 1 Hz no manoeuvre is seen."""


@dataclass(frozen=True)
class Suggestion:
    """One line of a channel map and why.

    Attributes
    ----------
    unit : None where neither the log nor the other channels tell one: ours is taken then
    reason : in words
    others : further columns whose names fit as well
    by_name : False where only its values speak for the column
    """

    name: str
    source: str
    unit: str | None
    sign: int
    reason: str
    others: tuple[str, ...] = ()
    by_name: bool = True


@dataclass(frozen=True)
class SuggestedMap:
    """A channel map for a log that nobody has mapped yet.

    Attributes
    ----------
    unused : columns that no signal was found for
    """

    clock: Clock
    dbc: str | None
    channels: tuple[Suggestion, ...]
    unused: tuple[str, ...]

    def channel_map(self) -> ChannelMap:
        """The map itself."""
        return ChannelMap(clock=self.clock, dbc=self.dbc, channels={one.name: _channel(one) for one in self.channels})


def suggest_channels(path: str | Path, vehicle: VehicleFile, dbc: str | None = None) -> SuggestedMap:
    """Suggest a channel map for a log nobody has mapped yet.

    Parameters
    ----------
    vehicle : its radii, steering ratio and brakes are what units are told by
    dbc : database of a CAN log

    Raises
    ------
    InputError
        If the log cannot be read.
    """
    path = Path(path)
    if not path.is_file():
        raise InputError(f"{path}: no such log")
    empty = ChannelMap(dbc=dbc, channels={})
    if holds_frames(format_of(path, empty), empty) and dbc is None:
        raise InputError(f"{path}: a CAN log needs a database", mend="name it: --dbc FILE")
    names, units = log_names(path, empty), log_units(path, empty)
    if dbc is None and any(name.startswith("CAN_DataFrame") for name in names):
        raise InputError(f"{path}: an MF4 of CAN frames needs a database", mend="name it: --dbc FILE")
    log = _Log(path, empty, vehicle)
    if log.is_table:
        clock = _clock(path, names, units)
        log = replace(log, empty=ChannelMap(clock=clock, channels={}))
        names = [name for name in names if name != clock.column]
    else:
        names = [name for name in names if plain_name(name)[0] not in _TIME_NAMES]
    found = {
        signal: _by_name(signal, columns[0].source, columns[0].unit, [other.source for other in columns[1:]])
        for signal, columns in signals_by_name(names, units).items()
    }
    found = log.present(found)
    if found and not any(name.startswith("slip_") for name in found):
        manoeuvre = log.manoeuvre({name: _channel(one) for name, one in found.items()})
        correlated = _by_correlation(log, [n for n in names if n not in {s.source for s in found.values()}], manoeuvre)
        if correlated:
            found |= correlated
            manoeuvre = log.manoeuvre({name: _channel(one) for name, one in found.items()})
        found = _compared(found, manoeuvre, log.geometry)
    else:
        found = {name: _angle_in_degrees(log, one) for name, one in found.items()}
    used = {one.source for one in found.values()}
    order = list(channel_units())
    ordered = sorted(found.values(), key=lambda one: order.index(one.name))
    return SuggestedMap(log.empty.clock, dbc, tuple(ordered), tuple(name for name in names if name not in used))


def _by_name(signal: str, source: str, unit: str | None, others: Sequence[str]) -> Suggestion:
    told = None if unit == "1" else unit
    reason = "by its name, in the unit that the log says" if told else "by its name"
    return Suggestion(signal, source, told, 1, reason, tuple(others))


def _channel(one: Suggestion) -> Channel:
    return Channel(source=one.source, unit=one.unit, sign=-1 if one.sign < 0 else 1)


def _angle_in_degrees(log: "_Log", one: Suggestion) -> Suggestion:
    """A slip angle that no wheel has in radians is one in degrees."""
    if one.unit is not None or channel_units()[one.name] != "rad":
        return one
    largest = max(float(np.nanmax(np.abs(values))) for _, (_, values) in log.columns([one.source]))
    if largest < 0.5 * np.pi:
        return one
    return replace(
        one, unit="deg", reason=f"{one.reason}, up to {largest:.3g}, which no angle of a wheel is in radians"
    )


def _clock(path: Path, names: Sequence[str], units: Mapping[str, str]) -> Clock:
    """Column and unit of a table's time: named so, else the first one."""
    plain = {name: plain_name(name) for name in names}
    column = next((name for word in _TIME_NAMES for name in names if plain[name][0] == word), names[0])
    told = plain[column][1] or units.get(column, "")
    unit = {"sec": "s", "seconds": "s", "msec": "ms", "usec": "us", "µs": "us"}.get(told.lower(), told)
    if unit not in ("s", "ms", "us", "ns", "min", "h"):
        ((time, _),) = read_named(path, [column], ChannelMap(clock=Clock(column=column), channels={})).values()
        steps = np.diff(time)
        steps = steps[steps > 0.0]
        step = float(np.median(steps)) if len(steps) else 0.0
        unit = next((u for u in ("s", "ms", "us", "ns") if step * to_si(f"1 {u}", "s") < _LEAST_TIME_STEP), "s")
    return Clock(column=column, unit=unit)


@dataclass(frozen=True)
class _Log:
    """A log whose columns are looked at; ``empty`` is a map of no channel with its clock and database."""

    path: Path
    empty: ChannelMap
    vehicle: VehicleFile

    @property
    def is_table(self) -> bool:
        return format_of(self.path, self.empty) in ("csv", "parquet")

    @property
    def geometry(self) -> Geometry:
        return geometry_of(self.vehicle)

    def present(self, found: dict[str, Suggestion]) -> dict[str, Suggestion]:
        """Suggestions whose column the log has values of; another column whose name fits where the first has none."""
        wanted = [source for one in found.values() for source in (one.source, *one.others)]
        held = {source for source, _ in self.columns(wanted)}
        kept = {}
        for name, one in found.items():
            sources = [source for source in (one.source, *one.others) if source in held]
            if sources:
                kept[name] = replace(one, source=sources[0], others=tuple(sources[1:]))
        return kept

    def columns(self, names: Sequence[str]) -> Iterator[tuple[str, tuple[FloatArray, FloatArray]]]:
        """(name, (time [s], values)) of those columns that hold numbers."""
        for begin in range(0, len(names), _AT_ONCE):
            batch = list(dict.fromkeys(names[begin : begin + _AT_ONCE]))
            try:
                yield from read_named(self.path, batch, self.empty, missing_ok=True).items()
            except InputError:  # one of them holds words
                for name in batch:
                    try:
                        yield from read_named(self.path, [name], self.empty, missing_ok=True).items()
                    except InputError:
                        continue

    def manoeuvre(self, channels: Mapping[str, Channel]) -> Manoeuvre:
        """The whole log as one manoeuvre, its samples checked."""
        samples = read_samples(self.path, self.empty.model_copy(update={"channels": dict(channels)}), self.vehicle)
        drive = Drive((self.path.name,), check_samples(samples)[0])
        time, values, weights = on_grid(drive.channels)
        return Manoeuvre(
            name=drive.name,
            time=SAMPLE_TIME_S * np.arange(len(time), dtype=np.float64),
            channels=values,
            weights=weights,
            source=self.path.name,
            start_s=float(time[0]),
        )


def _compared(found: dict[str, Suggestion], manoeuvre: Manoeuvre, geometry: Geometry) -> dict[str, Suggestion]:
    """Units and signs as the kinematic twins ask for them."""
    relations = relations_of(twins_of([manoeuvre], geometry))
    wrong, _ = explain(relations, geometry)
    agreeing = {group for relation in relations for group in relation.exponents} - {entry.group for entry in wrong}
    result = dict(found)
    for group in agreeing:
        for name in members(group, list(found)):
            one = found[name]
            unit = one.unit or channel_units()[name]
            result[name] = replace(one, unit=unit, reason=f"{one.reason}, as the other channels ask")
    for entry in wrong:
        for name in members(entry.group, list(found)):
            mended = _mended(result.pop(name), entry, geometry)
            if mended is not None:
                result.setdefault(mended.name, mended)
    return result


def _mended(one: Suggestion, wrong: Wrong, geometry: Geometry) -> Suggestion | None:
    """A suggestion in the unit and with the sign that make it agree; None where no usual unit does."""
    name, factor = one.name, abs(wrong.factor)
    if name == "steering_wheel_angle" and abs(factor * geometry.steering_ratio - 1.0) < _LIKE_A_UNIT:
        name, factor = "road_wheel_angle", 1.0
    written = one.unit or channel_units()[name]
    reason = f"{one.reason}, but {wrong.words} by the other channels"
    sign = -1 if wrong.factor < 0.0 else 1
    unit = written if factor == 1.0 else _unit_of_size(name, _size(name, written, geometry) / factor, geometry)
    return None if unit is None else replace(one, name=name, unit=unit, sign=sign, reason=reason)


def _size(name: str, unit: str, geometry: Geometry) -> float:
    """One of a unit in the signal's own; of a speed along the road at the mean radius."""
    if name.startswith("wheel_speed_") and unit_of("speed", unit) is not None:
        return to_si(f"1 {unit}", "m/s") / float(np.mean([geometry.radii[wheel] for wheel in WHEELS]))
    return to_si(f"1 {unit}", channel_units()[name])


def _unit_of_size(name: str, size: float, geometry: Geometry) -> str | None:
    """The usual unit of a signal that is so large in its own one."""
    usual = _USUAL_UNITS.get(channel_units()[name], ()) + (_USUAL_UNITS["m/s"] * name.startswith("wheel_speed_"))
    sizes = {unit: abs(np.log(_size(name, unit, geometry) / size)) for unit in usual}
    best = min(sizes, key=sizes.__getitem__, default=None)
    return best if best is not None and sizes[best] < _LIKE_A_UNIT else None


def _targets(manoeuvre: Manoeuvre, geometry: Geometry) -> dict[str, FloatArray]:
    """What missing signals should look like, from those that are there."""
    motion = Motion(manoeuvre, geometry)
    wheels = motion.wheels_speed()
    pace = manoeuvre.channels.get("speed", wheels)
    yaw_rate = manoeuvre.channels.get("yaw_rate", motion.wheels_yaw_rate())
    targets: dict[str, FloatArray | None] = {
        "speed": wheels,
        "yaw_rate": motion.wheels_yaw_rate(),
        "longitudinal_acceleration": None if pace is None else slope(pace),
        "lateral_acceleration": None if pace is None or yaw_rate is None else pace * yaw_rate,
    }
    return {name: series for name, series in targets.items() if series is not None and name not in manoeuvre.channels}


def _by_correlation(log: _Log, spare: Sequence[str], manoeuvre: Manoeuvre) -> dict[str, Suggestion]:
    """Columns without a telling name that go the way of a missing signal."""
    targets = _targets(manoeuvre, log.geometry)
    time = manoeuvre.start_s + manoeuvre.time
    everywhere = np.ones(len(time), dtype=bool)
    best: dict[str, tuple[float, str]] = {}
    for source, (stamps, values) in log.columns(spare) if targets else ():
        known = np.isfinite(values)
        if known.sum() < 2 or np.any(np.diff(stamps[known]) < 0.0) or np.ptp(values[known]) == 0.0:
            continue
        series = np.interp(time, stamps[known], values[known])
        for signal, target in targets.items():
            correlation = find_lag([series], [target], [everywhere], widest_lag_s=0.3).correlation
            if abs(correlation) > max(_SURE, abs(best.get(signal, (0.0, ""))[0])):
                best[signal] = (correlation, source)
    found: dict[str, Suggestion] = {}
    for signal, (correlation, source) in best.items():
        if source not in {one.source for one in found.values()}:
            reason = f"correlation {correlation:.3f} with what the other channels ask of it"
            found[signal] = Suggestion(signal, source, None, 1, reason, by_name=False)
    return found
