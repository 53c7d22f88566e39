"""Suggestions for a channel map: which column is which of our signals, by its name, unit, sign and correlation.

Names come first; the kinematic twins then say unit and sign, and find columns whose names tell nothing.
"""

import re
from collections.abc import Sequence
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np

from model_diagnosis.data.drives import Drive
from model_diagnosis.data.geometry import geometry_of
from model_diagnosis.data.grid import on_grid
from model_diagnosis.data.lags import find_lag
from model_diagnosis.data.samples import FloatArray, read_samples
from model_diagnosis.data.twins import Motion, members, slope, twins_of
from model_diagnosis.data.unit_checks import explain, relations_of
from model_diagnosis.manoeuvre import SAMPLE_TIME_S, Manoeuvre
from signals.errors import InputError
from signals.measured.channel_map import Channel, ChannelMap, channel_units
from signals.measured.measured_log import log_names
from signals.units import parse_unit
from vehicle_model.vehicle_file import VehicleFile

_SURE = 0.95
_WHEEL_WORDS = {"fl": r"(fl|lf|front_?left|vl)", "fr": r"(fr|rf|front_?right|vr)", "rl": r"(rl|lr|rear_?left|hl)",
                "rr": r"(rr|rear_?right|hr)"}  # fmt: skip
_PATTERNS: list[tuple[str, str]] = [
    *((f"wheel_speed_{w}", rf"(wheel|whl|rad|omega|ws).*{word}($|_)") for w, word in _WHEEL_WORDS.items()),
    *((f"brake_pressure_{w}", rf"(brake|press|pbrk|p_).*{word}($|_)") for w, word in _WHEEL_WORDS.items()),
    ("master_pressure", r"(master|mcp|tmc|brake_?ped|brake_?press|hauptzyl)"),
    ("yaw_rate", r"(yaw_?r|gyro_?z|psi_?p|gier|^omega$|_r$)"),
    ("yaw_angle", r"(yaw|heading|^phi$|^psi$)"),
    ("longitudinal_acceleration", r"(^|_)(ax|a_x|acc(el)?(eration)?_?x|long.*acc|acc.*long)"),
    ("lateral_acceleration", r"(^|_)(ay|a_y|acc(el)?(eration)?_?y|lat.*acc|acc.*lat|querb)"),
    ("steering_wheel_angle", r"(steer.*(wheel|ang)|hand_?wheel|lenk|swa)"),
    ("road_wheel_angle", r"(^delta|road_?wheel|steer)"),
    ("lateral_speed", r"(^|_)(vy|v_y|lat.*(speed|vel))"),
    ("speed", r"(^|_)(vx|v_x|speed|veloc|v_veh|geschw|v)($|_)"),
    ("engine_torque", r"eng.*tor"),
    ("engine_speed", r"(eng.*(speed|rpm)|^rpm)"),
]


@dataclass(frozen=True)
class Suggestion:
    """One line of a channel map and why.

    Attributes
    ----------
    factor : values in the log over what they should be; other than 1 where the unit is not as said
    """

    name: str
    source: str
    unit: str | None
    sign: int
    reason: str
    factor: float = 1.0


def suggest_channels(path: str | Path, vehicle: VehicleFile, dbc: str | None = None) -> list[Suggestion]:
    """Suggest a channel map for a log nobody has mapped yet.

    Raises
    ------
    InputError
        If the log cannot be read.
    """
    path = Path(path)
    empty = ChannelMap(dbc=dbc, channels={})
    names = log_names(path, empty)
    found = _by_name(names)
    if not found:
        return []
    manoeuvre = _read(path, found, dbc, vehicle)
    geometry = geometry_of(vehicle)
    wrong, _ = explain(relations_of(twins_of([manoeuvre], geometry)), geometry)
    for entry in wrong:
        for name in members(entry.group, list(found)):
            sign = -1 if entry.factor < 0.0 else 1
            found[name] = replace(
                found[name],
                sign=sign,
                factor=abs(entry.factor),
                reason=f"{found[name].reason}; has {entry.words} against the other channels",
            )
    return [*found.values(), *_by_correlation(path, names, found, manoeuvre, dbc, vehicle)]


def _by_name(names: Sequence[str]) -> dict[str, Suggestion]:
    """The first column whose name, without its unit, fits a signal's pattern."""
    found: dict[str, Suggestion] = {}
    taken: set[str] = set()
    for signal, pattern in _PATTERNS:
        for source in names:
            plain, unit = _name_and_unit(source)
            if source not in taken and re.search(pattern, plain) and _fits(signal, source, unit):
                found[signal] = Suggestion(signal, source, unit, 1, "by its name")
                taken.add(source)
                break
    return found


def _name_and_unit(source: str) -> tuple[str, str | None]:
    """Name in small letters with underscores, and a unit from brackets at its end."""
    match = re.fullmatch(r"(.*?)\s*[\[(]([^\])]*)[\])]\s*", source)
    text, unit = (match.group(1), match.group(2)) if match else (source, None)
    unit = {"kmph": "km/h", "kph": "km/h", "m/s2": "m/s^2"}.get(unit or "", unit)
    snake = re.sub(r"(?<=[a-z0-9])(?=[A-Z])", "_", text.rsplit(".", 1)[-1]).lower()
    return re.sub(r"[^a-z0-9]+", "_", snake), unit if unit and parse_unit(unit) is not None else None


def _fits(signal: str, source: str, unit: str | None) -> bool:
    """True where the unit, if there is one, is one that the signal may have."""
    try:
        ChannelMap(channels={signal: Channel(source=source, unit=unit)})
    except ValueError:
        return False
    return True


def _read(path: Path, found: dict[str, Suggestion], dbc: str | None, vehicle: VehicleFile) -> Manoeuvre:
    channels = {name: Channel(source=s.source, unit=s.unit) for name, s in found.items()}
    drive = Drive((path.name,), read_samples(path, ChannelMap(dbc=dbc, channels=channels), vehicle))
    time, values, weights = on_grid(drive.channels)
    return Manoeuvre(
        name=drive.name,
        time=SAMPLE_TIME_S * np.arange(len(time), dtype=np.float64),
        channels=values,
        weights=weights,
        source=path.name,
    )


def _targets(manoeuvre: Manoeuvre, vehicle: VehicleFile) -> dict[str, FloatArray]:
    """What missing signals should look like, from those that are there."""
    motion = Motion(manoeuvre, geometry_of(vehicle))
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


def _by_correlation(
    path: Path,
    names: Sequence[str],
    found: dict[str, Suggestion],
    manoeuvre: Manoeuvre,
    dbc: str | None,
    vehicle: VehicleFile,
) -> list[Suggestion]:
    """Columns without a telling name that go the way of a missing signal."""
    spare = [name for name in names if name not in {s.source for s in found.values()}]
    suggestions = []
    for signal, target in _targets(manoeuvre, vehicle).items():
        if signal not in channel_units():
            continue
        scores = {source: _correlation(path, source, found, signal, target, dbc, vehicle) for source in spare}
        best = max(scores, key=lambda s: abs(scores[s]), default=None)
        if best is not None and abs(scores[best]) > _SURE:
            sign = 1 if scores[best] > 0.0 else -1
            reason = f"correlation {scores[best]:.3f} with what the other channels ask of it"
            suggestions.append(Suggestion(signal, best, None, sign, reason))
            spare.remove(best)
    return suggestions


def _correlation(
    path: Path,
    source: str,
    found: dict[str, Suggestion],
    signal: str,
    target: FloatArray,
    dbc: str | None,
    vehicle: VehicleFile,
) -> float:
    try:
        manoeuvre = _read(path, found | {signal: Suggestion(signal, source, None, 1, "")}, dbc, vehicle)
    except InputError:
        return 0.0
    values = manoeuvre.channels.get(signal)
    if values is None or len(values) != len(target) or np.ptp(values) == 0.0:
        return 0.0
    everywhere = np.ones(len(values), dtype=bool)
    return find_lag([values], [target], [everywhere], widest_lag_s=0.3).correlation
