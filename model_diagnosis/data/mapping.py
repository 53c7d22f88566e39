"""Suggestions for a channel map: which column is which of our signals, by its name, unit, sign and correlation.

Names come first. The kinematic twins then say unit and sign where the log does not, or not rightly, and find columns
whose names tell nothing.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np

from model_diagnosis.data.channel_names import NamedColumn, signals_by_name, unit_of
from model_diagnosis.data.geometry import Geometry
from model_diagnosis.data.lags import find_lag
from model_diagnosis.data.samples import FloatArray
from model_diagnosis.data.twin_kinds import LEAST_OF
from model_diagnosis.data.twins import Motion, members, slope, twins_of
from model_diagnosis.data.unit_checks import Wrong, explain, relations_of
from model_diagnosis.data.unmapped_logs import UnmappedLogs
from model_diagnosis.manoeuvre import Manoeuvre
from signals.measured.channel_map import Channel, ChannelMap, Clock, channel_units
from signals.quantities import to_si
from signals.wheels import WHEELS
from vehicle_model.vehicle_file import VehicleFile

_SURE = 0.95
"""Correlation from which a column without a name is taken: a tenth of its variance may be noise or another motion."""
_SAME_SIZE = 0.01
"""Share by which sizes of one unit differ: a g is 9.81 m/s² here and 9.80665 there."""
_LARGEST_PRESSURE_PA = (5e5, 3.5e7)
"""Of some drive: 5 bar stop no car, and no hydraulic unit makes 350."""
_USUAL_UNITS = {
    "m/s": ("m/s", "km/h", "mph"),
    "rad/s": ("rad/s", "deg/s", "rpm"),
    "rad": ("rad", "deg"),
    "m/s^2": ("m/s^2", "g"),
    "Pa": ("bar", "MPa", "kPa", "Pa", "psi"),
    "N m": ("N m", "ft*lbf"),
}
_COMPARISONS = 4
"""Of ten groups of channels that twins compare, three at a time."""
_AGREES = "the other channels agree"


@dataclass(frozen=True)
class Suggestion:
    """One line of a channel map and why.

    Attributes
    ----------
    unit : None where neither the log nor the other channels tell one: ours is taken then
    reason : why this column, in words
    is_likely : True where the unit is the one in which the size of the values is usual
    motion : what the other channels say of its unit and sign: "" nothing, else that they agree or what they ask for
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
    is_likely: bool = False
    motion: str = ""


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


def suggest_channels(paths: Sequence[str | Path], vehicle: VehicleFile, dbc: str | None = None) -> SuggestedMap:
    """Suggest a channel map for logs of one logger that nobody has mapped yet.

    Parameters
    ----------
    paths : logs of the same columns
    vehicle : its radii, steering ratio and brakes are what units are told by
    dbc : database of CAN logs

    Raises
    ------
    InputError
        If a log cannot be read.
    """
    logs = UnmappedLogs.of([Path(path) for path in paths], vehicle, dbc)
    by_name = signals_by_name(list(logs.columns), logs.columns)
    largest = logs.largest([column.source for columns in by_name.values() for column in columns])
    found = _with_values({signal: _by_name(signal, columns) for signal, columns in by_name.items()}, largest)
    if any(name.startswith("slip_") for name in found):
        found = {name: _angle_in_degrees(one, largest[one.source]) for name, one in found.items()}
    elif found:
        found = _pressures_in_likely_units(found, largest)
        found = _agreeing(logs, found)
        correlated = _by_correlation(logs, _unused(logs, found), _manoeuvres(logs, found))
        if correlated:
            found = _agreeing(logs, found | correlated)
    order = list(channel_units())
    ordered = sorted(found.values(), key=lambda one: order.index(one.name))
    return SuggestedMap(logs.empty.clock, dbc, tuple(ordered), tuple(_unused(logs, found)))


def _unused(logs: UnmappedLogs, found: Mapping[str, Suggestion]) -> list[str]:
    used = {one.source for one in found.values()}
    return [name for name in logs.columns if name not in used]


def _manoeuvres(logs: UnmappedLogs, found: Mapping[str, Suggestion]) -> list[Manoeuvre]:
    return logs.manoeuvres({name: _channel(one) for name, one in found.items()})


def _by_name(signal: str, columns: Sequence[NamedColumn]) -> Suggestion:
    first, *others = columns
    told = None if first.unit == "1" else first.unit
    reason = "by its name, in the unit that the log says" if told else "by its name"
    return Suggestion(signal, first.source, told, 1, reason, tuple(other.source for other in others))


def _channel(one: Suggestion) -> Channel:
    return Channel(source=one.source, unit=one.unit, sign=-1 if one.sign < 0 else 1)


def _with_values(found: Mapping[str, Suggestion], largest: Mapping[str, float]) -> dict[str, Suggestion]:
    """Suggestions whose column the logs have values of; another column whose name fits where the first has none."""
    kept = {}
    for name, one in found.items():
        sources = [source for source in (one.source, *one.others) if source in largest]
        if sources:
            kept[name] = replace(one, source=sources[0], others=tuple(sources[1:]))
    return kept


def _pressures_in_likely_units(found: Mapping[str, Suggestion], largest: Mapping[str, float]) -> dict[str, Suggestion]:
    """Brake pressures whose unit nobody tells, in the one in which the largest is one of a brake.

    In a wrong one they are no pressures at all for what compares them with the motion.
    """
    names = [name for name, one in found.items() if channel_units()[name] == "Pa" and one.unit is None]
    most = max((largest[found[name].source] for name in names), default=0.0)
    low, high = _LARGEST_PRESSURE_PA
    unit = next((u for u in _USUAL_UNITS["Pa"] if low <= most * to_si(f"1 {u}", "Pa") <= high), None)
    likely = {name: replace(found[name], unit=unit, is_likely=True) for name in names if unit is not None}
    return dict(found) | likely


def _angle_in_degrees(one: Suggestion, largest: float) -> Suggestion:
    """A slip angle that no wheel has in radians is one in degrees."""
    if one.unit is not None or channel_units()[one.name] != "rad" or largest < 0.5 * np.pi:
        return one
    return replace(
        one, unit="deg", reason=f"{one.reason}; up to {largest:.3g}, which no angle of a wheel is in radians"
    )


def _agreeing(logs: UnmappedLogs, found: dict[str, Suggestion]) -> dict[str, Suggestion]:
    """Units and signs as the kinematic twins ask for them; read anew with them, until nothing is wrong any more.

    One comparison explains three wrong groups at most, so that what is still wrong shows beside what is mended.
    """
    for _ in range(_COMPARISONS):
        relations = relations_of(twins_of(_manoeuvres(logs, found), logs.geometry))
        wrong, _ = explain(relations, logs.geometry)
        if not wrong:
            break
        for entry in wrong:
            for name in members(entry.group, list(found)):
                mended = _mended(found[name], entry, logs.geometry)
                if mended is not None:
                    del found[name]
                    found.setdefault(mended.name, mended)
    agreeing = {group for relation in relations for group in relation.exponents} - {entry.group for entry in wrong}
    for name in (name for group in agreeing for name in members(group, list(found))):
        one = found[name]
        found[name] = replace(one, unit=one.unit or channel_units()[name], motion=one.motion or _AGREES)
    return found


def _mended(one: Suggestion, wrong: Wrong, geometry: Geometry) -> Suggestion | None:
    """A suggestion in the unit and with the sign that make it agree; None where no usual unit does."""
    name, factor = one.name, abs(wrong.factor)
    if name == "steering_wheel_angle" and abs(factor * geometry.steering_ratio - 1.0) < _SAME_SIZE:
        name, factor = "road_wheel_angle", 1.0
    written = one.unit or channel_units()[name]
    sign = -one.sign if wrong.factor < 0.0 else one.sign
    unit = written if factor == 1.0 else _unit_of_size(name, _size(name, written, geometry) / factor, geometry)
    motion = f"{wrong.words}, by the other channels"
    return None if unit is None else replace(one, name=name, unit=unit, sign=sign, motion=motion)


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
    return best if best is not None and sizes[best] < _SAME_SIZE else None


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


def _by_correlation(logs: UnmappedLogs, spare: Sequence[str], manoeuvres: Sequence[Manoeuvre]) -> dict[str, Suggestion]:
    """Columns without a telling name that go the way of a missing signal."""
    targets = [_targets(manoeuvre, logs.geometry) for manoeuvre in manoeuvres]
    wanted = list(dict.fromkeys(name for one in targets for name in one))
    best: dict[str, tuple[float, str]] = {}
    for source, courses in logs.on_time_of(manoeuvres, spare) if wanted else ():
        for signal in wanted:
            correlation = _correlation(courses, [one.get(signal) for one in targets], LEAST_OF[signal])
            if abs(correlation) > max(_SURE, abs(best.get(signal, (0.0, ""))[0])):
                best[signal] = (correlation, source)
    found: dict[str, Suggestion] = {}
    for signal, (correlation, source) in best.items():
        if source not in {one.source for one in found.values()}:
            reason = f"correlation {correlation:.3f} with what the other channels ask of it"
            found[signal] = Suggestion(signal, source, None, 1, reason, by_name=False)
    return found


def _correlation(
    courses: Sequence[FloatArray | None], targets: Sequence[FloatArray | None], least_spread: float
) -> float:
    """Median over the logs that move the target: one manoeuvre in which its law does not hold decides nothing."""
    found = [
        find_lag([course], [target], [np.ones(len(course), dtype=bool)], widest_lag_s=0.3).correlation
        for course, target in zip(courses, targets, strict=True)
        if course is not None and target is not None and np.std(target) > least_spread
    ]
    return float(np.median(found)) if found else 0.0
