"""Late channels, messages and loggers: the fewest delays that explain the lags between all twins.

The lag of a twin is compared with what the car itself makes of it: with the lag of the same twin in a replay where
there is one, else with a usual car's within a wide tolerance. Data are shifted by whole samples, since interpolation
would smooth the noise.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from itertools import combinations

import numpy as np

from model_diagnosis.data.faults import joined
from model_diagnosis.data.geometry import Geometry
from model_diagnosis.data.lags import COARSE_BAND_HZ, FINE_BAND_HZ, Lag, find_lag
from model_diagnosis.data.samples import BoolArray, FloatArray
from model_diagnosis.data.twins import Twin, band, members, moved_by, moves, reached, slope, twins_of
from model_diagnosis.data.unit_checks import CORRELATED
from model_diagnosis.manoeuvre import SAMPLE_TIME_S, Manoeuvre
from model_diagnosis.result import DataFault

INERTIAL = ("longitudinal_acceleration", "lateral_acceleration", "yaw_rate")
_INPUTS = ("brake_pressure", "steering", "drive_torque")
_ENOUGH = 0.6
_SLIDING_SHARE = 3
"""One manoeuvre in so many may be left out of a twin that does not hold in it: on two thirds of its friction a car
slid in two of the six shipped ones."""
_REPLAYED_TOLERANCE_S = 0.006
_LAG_UNCERTAINTY = 0.25
_FOLLOWS = 0.7
NAMED_S, NAMED_STDS = 0.015, 3.0
"""Delay that is named at least, in seconds and in its own standard deviations."""
_ANSWERS = (
    ("wheel_speed", "brake_pressure"),
    ("longitudinal_acceleration", "brake_pressure"),
    ("speed", "brake_pressure"),
    ("yaw_rate", "steering"),
    ("lateral_acceleration", "steering"),
)
_SAME = 0.8
_OWN_TOLERANCE_S = 0.002
_MARGIN = 16.0
PLAIN_GAIN = 0.5 * _MARGIN
"""Log likelihood from which a large delay needs no proof by innovations."""
_PROPOSAL_PENALTY = 2.5
_PROPOSED_S = 0.007
_PENALTY = 9.0
_MOST = 3
_FARTHEST_STDS = 3.0
"""Standard deviations by which the replay may move a delay that the channels tell among themselves."""


@dataclass(frozen=True)
class LagRelation:
    """Lag of one group against another beyond what the car makes of it [s], and its spread."""

    late: str
    early: str
    lag_s: float
    std_s: float


@dataclass(frozen=True)
class Late:
    """Groups that are late together.

    Attributes
    ----------
    kind : of the data fault
    groups : of the twins
    channels : catalogue names
    """

    kind: str
    groups: frozenset[str]
    channels: tuple[str, ...]
    delay_s: float = 0.0
    std_s: float = 0.0
    gain: float = 0.0


def lag_relations(
    manoeuvres: Sequence[Manoeuvre], geometry: Geometry, replayed: Sequence[Manoeuvre] | None = None
) -> list[LagRelation]:
    """Lags of all twins that correlate, less those of the replayed manoeuvres or of a usual car."""
    reference = {twin.kind.name: twin for twin in twins_of(replayed, geometry)} if replayed else {}
    found = []
    for twin in twins_of(manoeuvres, geometry):
        relation = _lag_relation(twin, reference.get(twin.kind.name))
        if relation is not None:
            found.append(relation)
    return found + (_own_relations(manoeuvres, replayed) if replayed else [])


def _own_relations(manoeuvres: Sequence[Manoeuvre], replayed: Sequence[Manoeuvre]) -> list[LagRelation]:
    """Lags of channels against their own replay, which answers the measured pressures and steering without delay."""
    found = []
    measured, answers = ([one.on_one_raster() for one in many] for many in (manoeuvres, replayed))
    for group, early in _ANSWERS:
        pairs = [
            (one, other, members(group, list(one.channels)))
            for one, other in zip(measured, answers, strict=True)
            if members(early, list(one.channels)) and members(group, list(one.channels))
        ]
        if not pairs:
            continue
        own = [_course(one, names) for one, _, names in pairs]
        valid = [np.all([reached(one, name) for name in names], axis=0) for one, _, names in pairs]
        if not any(moved_by(*each) for each in zip(own, valid, strict=True)):
            continue
        lag = find_lag(
            own,
            [_course(other, names) for _, other, names in pairs],
            valid,
            widest_lag_s=0.15,
            band_hz=FINE_BAND_HZ,
            sign=1,
        )
        if lag.correlation > _SAME:
            found.append(LagRelation(group, early, lag.lag_s, float(np.hypot(lag.std_s, _OWN_TOLERANCE_S))))
    return found


def _course(manoeuvre: Manoeuvre, names: Sequence[str]) -> FloatArray:
    """Mean of some channels, the change of speeds."""
    mean: FloatArray = np.mean([manoeuvre.channels[name] for name in names], axis=0)
    return slope(mean) if "speed" in names[0] else mean


def _lag_relation(twin: Twin, simulated: Twin | None) -> LagRelation | None:
    if not moves(twin, _banded):
        return None
    coarse = _coarse_lag(twin)
    if coarse.correlation < _ENOUGH and (regular := _without_slides(twin)) is not None:
        kept, twin = regular
        simulated = None if simulated is None else _of_manoeuvres(simulated, kept)
        coarse = _coarse_lag(twin)
    if coarse.correlation < _ENOUGH:
        return None
    fine = find_lag(*_sides(twin), around_s=coarse.lag_s, widest_lag_s=0.15, band_hz=FINE_BAND_HZ, sign=1)
    estimate = fine if fine.correlation > _ENOUGH else coarse
    usual, tolerance = twin.kind.usual_lag_s, twin.kind.lag_tolerance_s
    if simulated is not None and (own := _replayed_lag(twin, simulated, fine=estimate is fine)):
        usual, tolerance = own
    spread = float(np.sqrt(estimate.std_s**2 + tolerance**2 + (0.1 * SAMPLE_TIME_S) ** 2))
    return LagRelation(twin.kind.late, twin.kind.early, estimate.lag_s - usual, spread)


def _banded(values: FloatArray) -> FloatArray:
    return band(values, *COARSE_BAND_HZ)


def _coarse_lag(twin: Twin) -> Lag:
    near = find_lag(*_sides(twin), widest_lag_s=0.4, sign=1)
    return near if near.correlation >= CORRELATED else find_lag(*_sides(twin), sign=1)


def _without_slides(twin: Twin) -> tuple[list[int], Twin] | None:
    """The manoeuvres in which the twin holds and the twin of them, where leaving out a third at most makes it hold.

    In a car that spins or stands on locked wheels no channel moves as its twin does, and such a motion is the largest.
    """
    kept = list(range(len(twin.left)))
    for _ in range(len(twin.left) // _SLIDING_SHARE):
        fewer = [[one for one in kept if one != left_out] for left_out in kept]
        lags = [find_lag(*_sides(_of_manoeuvres(twin, some)), widest_lag_s=0.4, sign=1) for some in fewer]
        best = int(np.argmax([lag.correlation for lag in lags]))
        kept = fewer[best]
        if lags[best].correlation >= CORRELATED:
            return kept, _of_manoeuvres(twin, kept)
    return None


def _of_manoeuvres(twin: Twin, kept: Sequence[int]) -> Twin:
    return replace(
        twin,
        left=[twin.left[m] for m in kept],
        right=[twin.right[m] for m in kept],
        valid=[twin.valid[m] for m in kept],
    )


def _sides(twin: Twin) -> tuple[Sequence[FloatArray], Sequence[FloatArray], Sequence[BoolArray]]:
    return twin.left, twin.right, twin.valid


def _replayed_lag(twin: Twin, simulated: Twin, *, fine: bool) -> tuple[float, float] | None:
    """Lag of the twin in the replay and how sure it is; None where the replay does not follow the measurement.

    A quarter of the car's own lag stays uncertain, since it goes with stiffnesses that may be off.
    """
    followed = [
        valid & follows(a, b) & follows(c, d)
        for a, b, c, d, valid in zip(twin.left, simulated.left, twin.right, simulated.right, twin.valid, strict=True)
    ]
    if not any(mask.any() for mask in followed):
        return None
    band_hz = FINE_BAND_HZ if fine else COARSE_BAND_HZ
    own = find_lag(simulated.left, simulated.right, followed, widest_lag_s=0.3, band_hz=band_hz, sign=1)
    if own.correlation < CORRELATED:
        return None
    return own.lag_s, float(np.hypot(_REPLAYED_TOLERANCE_S, _LAG_UNCERTAINTY * own.lag_s))


def follows(measured: FloatArray, replayed: FloatArray, least: float = _FOLLOWS) -> bool:
    """True where the replayed series goes the measured one's way, at whatever delay up to 2.5 s."""
    everywhere = np.ones(len(measured), dtype=bool)
    return find_lag([measured], [replayed], [everywhere], sign=1).correlation > least


def candidates(manoeuvres: Sequence[Manoeuvre]) -> list[Late]:
    """Every set of groups that may be late together: one group, a CAN message, a logger, the inertial unit."""
    channels = list(dict.fromkeys(name for m in manoeuvres for name in m.channels))
    origins = {name: origin for m in manoeuvres for name, origin in m.origins.items()}
    singles = [g for g in ("wheel_speed", *_INPUTS, *INERTIAL, "speed", "yaw_angle") if members(g, channels)]
    found = [_single(group, members(group, channels)) for group in singles]
    inertial = [name for name in INERTIAL if name in channels]
    if len(inertial) > 1:
        found.append(Late("can_latency", frozenset(inertial), tuple(inertial)))
    for kind, sets in (("can_latency", _sets(origins, message=True)), ("clock_offset", _sets(origins, message=False))):
        for names in sets:
            groups = frozenset(g for g in singles if set(members(g, channels)) <= set(names))
            if groups and groups != frozenset(singles):
                found.append(Late(kind, groups, tuple(n for n in channels if n in names)))
    return found


def _single(group: str, channels: Sequence[str]) -> Late:
    kind = {"wheel_speed": "wheel_speed_delay", "speed": "clock_offset"}.get(group, "channel_delay")
    return Late(kind, frozenset({group}), tuple(channels))


def _sets(origins: Mapping[str, str], *, message: bool) -> list[set[str]]:
    """Channels of each message, or of each logger, where there is more than one."""
    keys = {n: o if message else o.partition(":")[0] for n, o in origins.items() if not message or ":" in o}
    sets = [{n for n, key in keys.items() if key == one} for one in dict.fromkeys(keys.values())]
    return sets if len(sets) > 1 else []


def explain_lags(
    relations: Sequence[LagRelation], sets: Sequence[Late], *, proposed: bool = False, most: int = _MOST
) -> list[Late]:
    """The fewest late sets that explain the lags, each with its delay; the cheapest of all choices of up to ``most``.

    Chosen one after the other, what acts early in two relations (the pressures, say) would be taken for what is late in
    both. ``proposed`` ones are judged by innovations afterwards, so that less is asked of them here.
    A set of channels is late, seldom early: a negative delay needs more evidence unless it is a whole logger's clock.
    """
    penalty = _PROPOSAL_PENALTY if proposed else _PENALTY
    cost = {frozenset[int](): _fit(relations, [])[1]}
    best: tuple[float, list[Late]] = (cost[frozenset()], [])
    for size in range(1, most + 1):
        for chosen in combinations(range(len(sets)), size):
            if any(sets[a].groups <= sets[b].groups for a in chosen for b in chosen if a != b):
                continue
            fitted, cost[frozenset(chosen)] = _fit(relations, [sets[k] for k in chosen])
            total = cost[frozenset(chosen)] + sum(_price(late, relations, penalty) for late in fitted)
            if total >= best[0]:
                continue
            gains = [cost.get(frozenset(chosen) - {k}, np.inf) - cost[frozenset(chosen)] for k in chosen]
            named = [replace(late, gain=0.5 * gain) for late, gain in zip(fitted, gains, strict=True)]
            if all(_is_telling(late, proposed=proposed) for late in named):
                best = total, named
    return sorted(best[1], key=lambda late: -late.gain)


def _is_telling(late: Late, *, proposed: bool) -> bool:
    """True for a delay long enough to be named, that the other ones do not explain."""
    least_s = _PROPOSED_S if proposed else max(NAMED_S, NAMED_STDS * late.std_s)
    return abs(late.delay_s) >= least_s and (proposed or 2.0 * late.gain >= _MARGIN)


def refined_delays(
    known: Sequence[Late], relations: Sequence[LagRelation], manoeuvres: Sequence[Manoeuvre]
) -> tuple[list[Late], list[Manoeuvre]]:
    """Late sets that were shifted already, with what the lags against the replay say of the rest of their delay.

    That they are late is settled; by how much, a usual car's lag tells only within its tolerance of tens of ms.
    """
    refined, current = [], list(manoeuvres)
    for late, rest in zip(known, _fit(relations, known)[0], strict=True):
        told = any((one.late in late.groups) != (one.early in late.groups) for one in relations)
        if not told or rest.std_s > late.std_s or abs(rest.delay_s) > _FARTHEST_STDS * late.std_s:
            refined.append(late)
            continue
        exact = replace(late, delay_s=SAMPLE_TIME_S * round(late.delay_s / SAMPLE_TIME_S) + rest.delay_s)
        moved = round(exact.delay_s / SAMPLE_TIME_S) - round(late.delay_s / SAMPLE_TIME_S)
        current = [shifted(one, late.channels, moved * SAMPLE_TIME_S) for one in current]
        refined.append(replace(exact, std_s=rest.std_s))
    return refined, current


def with_rests(first: Sequence[Late], later: Sequence[Late]) -> tuple[list[Late], list[Late]]:
    """Late sets with what was found later of the same channels, which were shifted by both; the other later ones."""
    rests = {late.channels: late for late in later}
    whole = []
    for late in first:
        rest = rests.pop(late.channels, None)
        if rest is not None:
            late = replace(late, delay_s=SAMPLE_TIME_S * round(late.delay_s / SAMPLE_TIME_S) + rest.delay_s)
        whole.append(late)
    return whole, list(rests.values())


def _price(late: Late, relations: Sequence[LagRelation], penalty: float) -> float:
    early = 0.0 if late.delay_s >= 0.0 or late.kind == "clock_offset" else 0.5 * penalty
    touched = {g for r in relations for g in (r.late, r.early)}
    return penalty + early + 0.1 * len(late.groups - touched) + 0.01 * len(late.groups)


def fitted_delays(relations: Sequence[LagRelation], sets: Sequence[Late]) -> list[Late]:
    """Late sets with the delays that go best with the lags, be they long enough to be named or not."""
    return _fit(relations, sets)[0]


def _fit(relations: Sequence[LagRelation], sets: Sequence[Late]) -> tuple[list[Late], float]:
    """Delays of given sets by weighted least squares, and the cost that remains."""
    if not relations:
        return list(sets), 0.0
    weights = np.array([1.0 / r.std_s for r in relations])
    target = np.array([r.lag_s for r in relations]) * weights
    if not sets:
        return [], float(np.sum(target**2))
    columns = np.array([[float(r.late in s.groups) - float(r.early in s.groups) for s in sets] for r in relations])
    design = columns * weights[:, None]
    delays, *_ = np.linalg.lstsq(design, target, rcond=None)
    spread = np.sqrt(np.diag(np.linalg.pinv(design.T @ design)))
    cost = float(np.sum((target - design @ delays) ** 2))
    fitted = [replace(s, delay_s=float(d), std_s=float(e)) for s, d, e in zip(sets, delays, spread, strict=True)]
    return fitted, cost


def shifted(manoeuvre: Manoeuvre, channels: Sequence[str], delay_s: float) -> Manoeuvre:
    """The manoeuvre with late channels taken earlier by whole samples; what then lacks has weight 0."""
    shift = round(delay_s / SAMPLE_TIME_S)
    if shift == 0:
        return manoeuvre
    moved = {n: _earlier(v, shift, float("nan")) if n in channels else v for n, v in manoeuvre.channels.items()}
    weights = {n: _earlier(w, shift, 0.0) if n in channels else w for n, w in manoeuvre.weights.items()}
    return replace(manoeuvre, channels=moved, weights=weights)


def set_right(manoeuvre: Manoeuvre, channels: Sequence[str], delay_s: float) -> Manoeuvre:
    """As ``shifted``, without the begin that early channels then lack: a replay starts from what they say there."""
    lacking = min(max(0, -round(delay_s / SAMPLE_TIME_S)), manoeuvre.samples // 2)
    return shifted(manoeuvre, channels, delay_s).part(lacking, manoeuvre.samples)


def _earlier(values: FloatArray, shift: int, fill: float) -> FloatArray:
    """Values taken ``shift`` samples earlier; the open end holds its last value, or ``fill`` where that is a number."""
    rows = np.arange(len(values)) + shift
    inside = (rows >= 0) & (rows < len(values))
    taken: FloatArray = values[np.clip(rows, 0, len(values) - 1)]
    return taken if np.isnan(fill) else np.where(inside, taken, fill)


def fault_of(late: Late) -> DataFault:
    """The fault of a late set, as repaired by a whole-sample shift."""
    word = "late" if late.delay_s > 0.0 else "early"
    message = (
        f"{joined(late.channels)}: {1e3 * abs(late.delay_s):.0f} ms {word} against the other channels "
        f"(± {1e3 * late.std_s:.0f} ms); shifted by {round(late.delay_s / SAMPLE_TIME_S)} samples"
    )
    return DataFault(
        kind=late.kind,
        channel=joined(late.channels),
        value=late.delay_s,
        unit="s",
        evidence=late.gain,
        repaired=True,
        message=message,
    )
