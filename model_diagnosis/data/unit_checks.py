"""Wrong units and signs: the fewest wrong channels that make all kinematic twins agree."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from itertools import combinations

import numpy as np

from model_diagnosis.data.axis_checks import check_swapped_axes
from model_diagnosis.data.faults import joined
from model_diagnosis.data.geometry import Geometry
from model_diagnosis.data.lags import find_lag
from model_diagnosis.data.samples import BoolArray, FloatArray
from model_diagnosis.data.twins import LEAST_SAMPLES, Twin, members, moves, slow, twins_of
from model_diagnosis.manoeuvre import SAMPLE_TIME_S, Manoeuvre
from model_diagnosis.replay.smoothing import noise_of
from model_diagnosis.result import DataFault
from signals.wheels import WHEELS

_BEYOND_NOISE = 10.0
"""Level over noise from which a ratio of two channels is one of what they measure: at rest, offsets have any ratio."""

CORRELATED = 0.8
_ANGLE = {"degrees for radians": 57.29577951308232}
_SPEED = {"km/h for m/s": 3.6, "mph for m/s": 2.2369362920544, "knots for m/s": 1.9438444924406}
_UNITS: dict[str, dict[str, float]] = {
    "speed": _SPEED,
    "wheel_speed": {"deg/s for rad/s": 57.29577951308232, "rpm for rad/s": 9.549296585513721},
    "longitudinal_acceleration": {"g for m/s²": 1.0 / 9.80665},
    "lateral_acceleration": {"g for m/s²": 1.0 / 9.80665},
    "yaw_rate": _ANGLE,
    "yaw_angle": _ANGLE,
    "steering": _ANGLE,
    "side_slip_angle": _ANGLE,
    "lateral_speed": _SPEED,
    "brake_pressure": {"Pa for bar": 1e5, "kPa for bar": 100.0, "psi for bar": 14.503773773, "MPa for bar": 0.1},
    "drive_torque": {"ft lb for N m": 0.7375621492772656},
}
_NEVER_REVERSED = ("speed", "wheel_speed", "brake_pressure")
_RARE = ("psi", "knots", "mph", "ft lb")
_RARE_PENALTY = 4.0
_PENALTY = 9.0
_MARGIN = 9.0
_WORST = 25.0
_TIE_ORDER = (
    "yaw_rate", "lateral_acceleration", "longitudinal_acceleration", "steering", "brake_pressure", "speed",
)  # fmt: skip


@dataclass(frozen=True)
class Relation:
    """A twin as measured: log |left/right|, its sign, and how well it is known."""

    exponents: Mapping[str, float]
    log_ratio: float
    sign: int
    tolerance: float


@dataclass(frozen=True)
class Wrong:
    """A hypothesis: this group's values are ``factor`` times what they should be."""

    group: str
    factor: float
    words: str


def relations_of(twins: Sequence[Twin]) -> list[Relation]:
    """Twins that correlate well enough to say something."""
    return [relation for twin in twins if (relation := _relation(twin)) is not None]


def _relation(twin: Twin) -> Relation | None:
    if twin.kind.level:
        ratios = [a[v & (np.abs(b) > 3.0)] / b[v & (np.abs(b) > 3.0)] for a, b, v in _rows(twin)]
        ratio = np.concatenate(ratios) if ratios else np.zeros(0)
        if len(ratio) < 100:
            return None
        middle = float(np.median(ratio))
        spread = float(np.subtract(*np.percentile(ratio, [75, 25])))
        if middle == 0.0 or spread > 0.3 * abs(middle):
            return None
        return Relation(twin.kind.exponents, float(np.log(abs(middle))), int(np.sign(middle)), twin.kind.log_tolerance)
    if not moves(twin):
        return None
    lag = find_lag(twin.left, twin.right, twin.valid, widest_lag_s=0.3)
    if abs(lag.correlation) < CORRELATED:
        lag = find_lag(twin.left, twin.right, twin.valid)
    if abs(lag.correlation) < CORRELATED:
        return None
    ratio_of_changes = _ratio_of_changes(twin, round(lag.lag_s / SAMPLE_TIME_S))
    if ratio_of_changes <= 0.0:
        return None
    return Relation(
        twin.kind.exponents, float(np.log(ratio_of_changes)), int(np.sign(lag.correlation)), twin.kind.log_tolerance
    )


def _rows(twin: Twin) -> list[tuple[FloatArray, FloatArray, BoolArray]]:
    return list(zip(twin.left, twin.right, twin.valid, strict=True))


def _ratio_of_changes(twin: Twin, shift: int) -> float:
    """Root of the ratio of the two sides' slow variances, the right side taken ``shift`` samples earlier."""
    left_power = right_power = 0.0
    for left, right, valid in _rows(twin):
        mask = valid & np.roll(valid, shift)
        if mask.sum() < LEAST_SAMPLES:
            continue
        a, b = slow(left)[mask], np.roll(slow(right), shift)[mask]
        left_power += float(np.sum((a - a.mean()) ** 2))
        right_power += float(np.sum((b - b.mean()) ** 2))
    return float(np.sqrt(left_power / right_power)) if right_power > 0.0 else 0.0


def explain(relations: Sequence[Relation], geometry: Geometry) -> tuple[list[Wrong], float]:
    """The fewest wrong groups (at most three) that bring all relations within their tolerances.

    Returns
    -------
    wrong groups (empty where nothing is clearly wrong), and by how much they win against no fault (log likelihood)
    """
    groups = sorted({group for relation in relations for group in relation.exponents})
    hypotheses = [wrong for group in groups for wrong in _hypotheses(group, geometry)]
    clean = _cost(relations, ())
    best: tuple[float, tuple[Wrong, ...]] = (clean, ())
    for count in (1, 2, 3):
        if clean <= _MARGIN:
            break
        found = [
            (_cost(relations, combination) + sum(map(_penalty, combination)), combination)
            for combination in combinations(hypotheses, count)
            if len({wrong.group for wrong in combination}) == count
        ]
        if found:
            candidate = min(found, key=lambda entry: (entry[0], _tie_rank(entry[1])))
            best = min(best, candidate, key=lambda entry: entry[0])
        if best[1] and best[0] <= _PENALTY * count + _MARGIN:
            break
    gain = 0.5 * (clean - best[0])
    return (list(best[1]), gain) if clean - best[0] > _MARGIN else ([], 0.0)


def _penalty(wrong: Wrong) -> float:
    return _PENALTY + (_RARE_PENALTY if any(unit in wrong.words for unit in _RARE) else 0.0)


def _tie_rank(combination: Sequence[Wrong]) -> int:
    return sum(_TIE_ORDER.index(w.group) if w.group in _TIE_ORDER else len(_TIE_ORDER) for w in combination)


def _hypotheses(group: str, geometry: Geometry) -> list[Wrong]:
    units = dict(_UNITS.get(group, {}))
    if group == "steering":
        units["road-wheel angle for steering-wheel angle"] = 1.0 / geometry.steering_ratio
    if group == "wheel_speed":
        radius = float(np.mean(list(geometry.radii.values())))
        units |= {f"{name.partition(' ')[0]} for rad/s": factor * radius for name, factor in _SPEED.items()}
        units["m/s for rad/s"] = radius
        units |= _SPEED  # a speed along the road that the map takes for one in another unit
    factors = [(words, factor) for words, factor in units.items() if abs(np.log(factor)) > 0.2]
    factors += [(_inverse(words), 1.0 / factor) for words, factor in factors]
    wrong = [Wrong(group, factor, words) for words, factor in factors]
    if group not in _NEVER_REVERSED:
        wrong += [Wrong(group, -entry.factor, f"{entry.words} and the wrong sign") for entry in wrong]
        wrong.append(Wrong(group, -1.0, "the wrong sign"))
    return wrong


def _inverse(words: str) -> str:
    first, _, second = words.partition(" for ")
    return f"{second} for {first}"


def _cost(relations: Sequence[Relation], wrong: Sequence[Wrong]) -> float:
    logs = {entry.group: float(np.log(abs(entry.factor))) for entry in wrong}
    signs = {entry.group: -1 if entry.factor < 0 else 1 for entry in wrong}
    cost = 0.0
    for relation in relations:
        expected = sum(power * logs.get(group, 0.0) for group, power in relation.exponents.items())
        sign = int(np.prod([signs.get(group, 1) for group in relation.exponents]))
        misfit = ((relation.log_ratio - expected) / relation.tolerance) ** 2
        cost += min(misfit, _WORST) + (_WORST if sign != relation.sign else 0.0)
    return cost


def check_units(manoeuvres: Sequence[Manoeuvre], geometry: Geometry) -> tuple[list[DataFault], list[Manoeuvre]]:
    """Name and repair swapped accelerometer axes, then wrong units and signs of channels."""
    swapped, in_order = check_swapped_axes(manoeuvres, geometry)
    faults, repaired = _check_single_wheels(in_order)
    faults = swapped + faults
    wrong, gain = explain(relations_of(twins_of(repaired, geometry)), geometry)
    for entry in wrong:
        names = list(dict.fromkeys(n for m in repaired for n in members(entry.group, list(m.channels))))
        faults.append(_fault(entry, names, gain))
        repaired = [_divided(m, names, entry.factor) for m in repaired]
    return faults, repaired


def _fault(wrong: Wrong, names: Sequence[str], gain: float) -> DataFault:
    sign_only = wrong.factor == -1.0
    return DataFault(
        kind="channel_sign" if sign_only else "channel_unit",
        channel=joined(names),
        value=wrong.factor,
        unit="1",
        evidence=gain,
        repaired=True,
        message=f"{joined(names)} has {wrong.words} (factor {wrong.factor:.4g} against the other channels); repaired",
    )


def _divided(manoeuvre: Manoeuvre, names: Sequence[str], factor: float) -> Manoeuvre:
    channels = {n: v / factor if n in names else v for n, v in manoeuvre.channels.items()}
    return replace(manoeuvre, channels=channels)


def _check_single_wheels(manoeuvres: Sequence[Manoeuvre]) -> tuple[list[DataFault], list[Manoeuvre]]:
    """One wheel's speed or pressure in another unit or sign than the other three."""
    faults: list[DataFault] = []
    repaired = list(manoeuvres)
    for group in ("wheel_speed", "brake_pressure"):
        names = [f"{group}_{wheel}" for wheel in WHEELS]
        for name in names:
            wrong = _single_wheel(repaired, name, [n for n in names if n != name], group)
            if wrong is not None:
                faults.append(_fault(wrong, [name], _WORST))
                repaired = [_divided(m, [name], wrong.factor) for m in repaired]
    return faults, repaired


def _single_wheel(manoeuvres: Sequence[Manoeuvre], name: str, others: Sequence[str], group: str) -> Wrong | None:
    ratios = []
    for manoeuvre in manoeuvres:
        if name not in manoeuvre.channels or not all(n in manoeuvre.channels for n in others):
            continue
        rest = np.median([manoeuvre.channels[n] for n in others], axis=0)
        large = np.abs(rest) > max(0.3 * float(np.max(np.abs(rest))), _BEYOND_NOISE * noise_of(rest), 1e-9)
        ratios.append(manoeuvre.channels[name][large] / rest[large])
    ratio = float(np.median(np.concatenate(ratios))) if ratios and sum(map(len, ratios)) > 50 else 1.0
    if ratio == 0.0 or (abs(np.log(abs(ratio))) < 0.5 and ratio > 0.0):
        return None
    factors = _UNITS[group] | (_SPEED if group == "wheel_speed" else {}) | {"": 1.0}
    candidates = [(w, s * f) for w, f in factors.items() for s in (1, -1)]
    candidates += [(_inverse(w) if w else w, s / f) for w, f in factors.items() for s in (1, -1)]
    words, factor = min(candidates, key=lambda entry: _distance(ratio, entry[1]))
    if factor == 1.0 or _distance(ratio, factor) > (0.08 if group == "wheel_speed" else 0.4):
        return None
    text = " and ".join(part for part in (words, "the wrong sign" if factor < 0 else "") if part)
    return Wrong(group, factor, text)


def _distance(ratio: float, factor: float) -> float:
    return np.inf if ratio * factor < 0.0 else abs(float(np.log(abs(ratio / factor))))
