"""What the data of a case can tell apart, by the theory of linear tests on the generator's own model.

Sensitivities are taken in replay mode (recorded inputs, recorded speeds pull the car). With y the whitened change that
the true effect makes, V = 1 + J D Jᵀ the covariance of noise and nominal scatter, the expected log evidence for it is
½ yᵀ V⁻¹ y, and that against a rival which may take any size is the same with the rival's column added to V.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from hidden_effects.car import BALANCE_SCATTER, DATA_SHEET, Numbers, as_record, nominal_car
from hidden_effects.effects import EFFECTS, HiddenEffect
from hidden_effects.manoeuvres import SIX, Script
from hidden_effects.outputs import INDEX
from hidden_effects.recording import CYCLE_S
from hidden_effects.sensors import CHANNELS, RATE_HZ, SENSOR_SHEET, first_order, through_chain, true_channels
from hidden_effects.simulator import Drive, simulate

FloatArray = NDArray[np.float64]

FORM_INFLATION = 6.0
"""Variance over that of the sensor's noise: half of the noise again as form error, correlated over 0.2 s."""
RIVAL_SIZE = 3.0
"""Prior width of a rival in units of its largest size: it may be anything."""
EVIDENCE_NEEDED = 8.0
"""Threshold of about log 20 + ½ log p, and the usual price log(e/s), together."""
_SLOWEST_M_S = 4.0
_STEP = 0.2
_INPUTS = ("pedal_force", "steering_wheel_angle", "drive_torque_r", "master_pressure")
_PRESSURE = INDEX["pressure_fl"]


@dataclass(frozen=True)
class Scene:
    """Recorded truth of one manoeuvre: what every replay of it is driven by."""

    drive: Drive
    columns: FloatArray
    chain: Numbers


def scene(car: Numbers, chain: Numbers, script: Script) -> Scene:
    """Simulate a manoeuvre freely."""
    drive = script.drive()
    return Scene(drive, simulate(as_record(car), drive), chain)


def compared_channels(missing: Sequence[str] = ()) -> tuple[str, ...]:
    """Channels that a replay predicts; without a master pressure the wheel pressures are inputs only."""
    stepped = ("VALVES",)
    names = [n for n, c in CHANNELS.items() if n not in _INPUTS and c.message not in stepped and n not in missing]
    if "master_pressure" in missing:
        names = [name for name in names if not name.startswith("brake_pressure")]
    return tuple(names)


def predicted(car: Numbers, chain: Numbers, seen: Scene, names: Sequence[str]) -> FloatArray:
    """Whitened replay (n·c,) of a recorded manoeuvre by a car and a measuring chain."""
    recorded = seen.columns.copy()
    for i in range(4):
        column = recorded[:, _PRESSURE + i]
        reading = seen.chain["pressure_scale"] * first_order(column, float(seen.chain["pressure_lag"]))
        reading = reading + seen.chain["pressure_offset"]
        acting = (reading - chain["pressure_offset"]) / chain["pressure_scale"]
        if chain["pressure_lag"] > 0.0:
            acting = acting + chain["pressure_lag"] * np.gradient(acting, 1.0 / RATE_HZ)
        recorded[:, _PRESSURE + i] = np.maximum(acting, 0.0)
    columns = simulate(as_record(car), seen.drive, recorded=recorded)
    drive = seen.drive
    series = through_chain(true_channels(columns, drive.pedal, drive.steering_wheel, drive.drive_torque), chain)
    stride = round(CYCLE_S * RATE_HZ)
    fast = seen.columns[::stride, 0] > _SLOWEST_M_S
    parts = [series[name][::stride][fast[: len(series[name][::stride])]] / _spread(name) for name in names]
    return np.concatenate(parts)


def _spread(name: str) -> float:
    channel = CHANNELS[name]
    coloured = np.sqrt((1.0 + channel.colour) / (1.0 - channel.colour))
    noise = np.hypot(channel.noise, channel.resolution / np.sqrt(12.0))
    return float(noise * coloured * np.sqrt(FORM_INFLATION))


def _stacked(car: Numbers, chain: Numbers, scenes: Sequence[Scene], names: Sequence[str]) -> FloatArray:
    return np.concatenate([predicted(car, chain, seen, names) for seen in scenes])


@dataclass(frozen=True)
class Point:
    """Where sensitivities are taken: a car, its measuring chain, and the recorded manoeuvres that it replays."""

    car: Numbers
    chain: Numbers
    scenes: tuple[Scene, ...]
    names: tuple[str, ...]

    def change(self, car: Numbers, chain: Numbers) -> FloatArray:
        """Change (N,) of the whitened replay by another car or chain."""
        return _stacked(car, chain, self.scenes, self.names) - self._base

    @cached_property
    def _base(self) -> FloatArray:
        return _stacked(self.car, self.chain, self.scenes, self.names)


def effect_column(effect: HiddenEffect, place: int, point: Point, like: FloatArray | None = None) -> FloatArray:
    """Change of the whitened replay by an effect of one scatter, from a small step.

    ``like``, the change (N,) of another effect's step, makes this step as large and in the same direction: at the limit
    of adhesion a replay is not smooth, and steps of different size would make equal effects look different.
    """
    step = _STEP if effect.relative else _STEP * effect.signs[-1]
    change = _stepped(effect, place, point, step)
    if like is not None and change @ change > 0.0:
        step *= float(np.copysign(np.sqrt(like @ like / (change @ change)), like @ change))
        change = _stepped(effect, place, point, step)
    return change / step


def _stepped(effect: HiddenEffect, place: int, point: Point, step: float) -> FloatArray:
    car, chain = dict(point.car), dict(point.chain)
    effect.change(car, chain, step * effect.scatter, place)
    return point.change(car, chain)


def nominal_point(missing: Sequence[str] = (), scripts: Sequence[Script] = SIX) -> Point:
    """The nominal car in manoeuvres, by default the shipped set."""
    chain = {name: np.array(number.nominal, float) for name, number in SENSOR_SHEET.items()}
    car = nominal_car()
    return Point(car, chain, tuple(scene(car, chain, script) for script in scripts), compared_channels(missing))


def scatter_columns(point: Point, but: Sequence[tuple[str, int | None]] = ()) -> FloatArray:
    """Changes (N, p) of the replay by one standard deviation of every number that scatters.

    ``but`` are numbers that do not, with the entry or None for all: what ``HiddenEffect.numbers_at`` gives.
    """
    fixed = {(name.removeprefix("chain:"), entry) for name, entry in but}
    columns = []
    for in_car, sheet in ((True, DATA_SHEET), (False, SENSOR_SHEET)):
        for name, number in sheet.items():
            if number.scatter == 0.0 or name == "ring_phase":
                continue
            store = point.car if in_car else point.chain
            for entry in [None] if number.common else range(np.size(number.nominal)):
                if fixed.intersection({(name, None), (name, entry)}):
                    continue
                place = slice(None) if entry is None else entry
                values = np.atleast_1d(store[name]).astype(float).copy()
                values[place] += _STEP * number.scatter * (values[place] if number.relative else 1.0)
                other = {**store, name: values.reshape(np.shape(store[name]))}
                cars = (other, point.chain) if in_car else (point.car, other)
                columns.append(point.change(*cars) / _STEP)
    if ("balance", None) not in fixed:
        balance = {**point.car, "balance": point.car["balance"] + _STEP * BALANCE_SCATTER}
        columns.append(point.change(balance, point.chain) / _STEP)
    return np.stack(columns, axis=1)


def expected_evidence(change: FloatArray, nuisance: FloatArray) -> float:
    """½ yᵀ (1 + J Jᵀ)⁻¹ y for columns J already scaled by their standard deviations."""
    inner = np.eye(nuisance.shape[1]) + nuisance.T @ nuisance
    along = nuisance.T @ change
    return 0.5 * float(change @ change - along @ np.linalg.solve(inner, along))


def detection_limit(effect: HiddenEffect, point: Point, nuisance: FloatArray) -> float:
    """Size in scatters from which the shipped set shows an effect, by theory, at its worst place."""
    places = range(max(effect.places, 1))
    per_scatter = min(expected_evidence(effect_column(effect, place, point), nuisance) for place in places)
    return float(np.sqrt(EVIDENCE_NEEDED / max(per_scatter, 1e-12)))


def limits_table() -> list[dict[str, str | float]]:
    """Every effect with its scatter, the limit by theory, and the range of sizes that is drawn, in scatters."""
    point = nominal_point()
    nuisance = scatter_columns(point)
    return [
        {
            "effect": effect.name,
            "unit": effect.unit,
            "scatter": effect.scatter,
            "limit": detection_limit(effect, point, nuisance),
            "smallest": effect.smallest,
            "largest": effect.largest,
        }
        for effect in EFFECTS
    ]


@dataclass(frozen=True)
class Truth:
    """A hidden effect where it is looked at: half of it in the car, all of it in what was recorded.

    Attributes
    ----------
    without, whole : car and measuring chain without the effect and with all of it
    """

    effect: HiddenEffect
    deviation: float
    place: int
    point: Point
    without: tuple[Numbers, Numbers]
    whole: tuple[Numbers, Numbers]

    @cached_property
    def step(self) -> FloatArray:
        """Change (N,) by a small step in its direction."""
        return _stepped(self.effect, self.place, self.point, float(np.copysign(_STEP, self.deviation)))

    @property
    def change(self) -> FloatArray:
        """Change (N,) by the whole effect, as the small step tells it."""
        return self.step * abs(self.deviation) / (_STEP * self.effect.scatter)

    @property
    def secant(self) -> FloatArray:
        """The same from the car without it to the one with all of it: a dead time has no small steps."""
        return self.point.change(*self.whole) - self.point.change(*self.without)


def truth_of(
    hidden: tuple[HiddenEffect, float, int],
    car: Numbers,
    chain: Numbers,
    scripts: Sequence[Script],
    missing: Sequence[str],
) -> Truth:
    """Look at an effect (effect, deviation, place) of a car and a measuring chain that are without it."""
    effect, deviation, place = hidden
    whole, half = (dict(car), dict(chain)), (dict(car), dict(chain))
    effect.change(*whole, deviation, place)
    effect.change(*half, 0.5 * deviation, place)
    point = Point(*half, tuple(scene(*whole, script) for script in scripts), compared_channels(missing))
    return Truth(effect, deviation, place, point, (car, chain), whole)


def separation(truth: Truth, rivals: Sequence[HiddenEffect]) -> dict[str, float]:
    """Expected log evidence for the true effect at its size against each rival, which may take any size."""
    nuisance = scatter_columns(truth.point)
    result = {}
    for rival in rivals:
        columns = [effect_column(rival, at, truth.point, truth.step) for at in range(max(rival.places, 1))]
        wide = RIVAL_SIZE * rival.largest * np.stack(columns, axis=1)
        result[rival.name] = expected_evidence(truth.change, np.column_stack([nuisance, wide]))
    return result


def size_std(truth: Truth) -> float:
    """Smallest standard deviation, over the size, of any unbiased estimate of the effect's size (Cramer and Rao).

    The number that the effect changes has no scatter beside it; all others have.
    """
    nuisance = scatter_columns(truth.point, truth.effect.numbers_at(truth.place))
    information = 2.0 * expected_evidence(truth.secant, nuisance)
    return float(1.0 / np.sqrt(max(information, 1e-12)))
