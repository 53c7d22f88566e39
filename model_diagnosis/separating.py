"""Which manoeuvre tells effects apart, before any data: the library simulated with the vehicle file.

Source: model discrepancy anchor, section 3.7. Expected log evidence Δ = θ² G_ii (1 - ρ²)/2 by the sensors' own noise,
with the effects that look like either as nuisance; the smallest over all ordered pairs counts.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from itertools import permutations

import numpy as np

from model_diagnosis.effects.catalogue import effect as find_effect
from model_diagnosis.evidence.groups import SEPARATION_NEEDED, separation
from model_diagnosis.evidence.manoeuvre_library import LIBRARY, PlannedManoeuvre
from model_diagnosis.evidence.priors import Priors
from model_diagnosis.evidence.quadratic import Quadratic
from model_diagnosis.evidence.structure import separating_sensor
from model_diagnosis.evidence.whitening import sensor_whitener
from model_diagnosis.manoeuvre import Manoeuvre
from model_diagnosis.next_manoeuvre import simulator
from model_diagnosis.replay import Replay
from signals.errors import InputError
from signals.wheels import WHEELS
from vehicle_model.vehicle_file import VehicleFile

USUAL_SIGNALS = (
    *(f"wheel_speed_{wheel}" for wheel in WHEELS),
    "speed",
    "longitudinal_acceleration",
    "lateral_acceleration",
    "yaw_rate",
)


@dataclass(frozen=True)
class Separation:
    """How well one manoeuvre of the library separates the effects.

    Attributes
    ----------
    expected_evidence : smallest over all ordered pairs
    """

    name: str
    description: str
    duration_s: float
    expected_evidence: float

    @property
    def enough(self) -> bool:
        """True where it reaches what is needed to tell two causes apart."""
        return self.expected_evidence >= SEPARATION_NEEDED


def separations(
    vehicle: VehicleFile,
    effects: Sequence[str],
    signals: Sequence[str] = USUAL_SIGNALS,
    size: float = 1.0,
    progress: Callable[[str, float], None] | None = None,
) -> list[Separation]:
    """Every manoeuvre of the library, the one that separates best first, of equals the shortest.

    Parameters
    ----------
    effects : names, at least two
    signals : compared ones that the measurement will have
    size : of the effects, in their widths in the catalogue

    Raises
    ------
    InputError
        If an effect is unknown, or is none that a replay shows.
    """
    if len(set(effects)) < 2:
        raise InputError("one effect has nothing to be told apart from", mend="name at least two")
    names = list(dict.fromkeys(effects))
    like = Replay(vehicle, [_placeholder(LIBRARY[0], signals, vehicle)])
    place = {effect.name: number for number, effect in enumerate(like.effects)}
    for name in names:
        if find_effect(name).name not in place:
            raise InputError(f"{name}: settled by the checks of the data, not by a manoeuvre")
    own = {name: [int(c) for c in np.flatnonzero(like.owner == place[name])] for name in names}
    beside = {other for name in names for other in find_effect(name).confounded_with if other in place}
    columns = sorted({c for group in own.values() for c in group}.union(*_columns(like, place, sorted(beside))))
    simulate, neutral = simulator(vehicle, like), np.zeros(len(like.columns))
    ranked = []
    for number, planned in enumerate(LIBRARY):
        if progress is not None:
            progress(planned.name.replace("_", " "), number / len(LIBRARY))
        made = simulate(planned, neutral)
        if made is not None:
            expected = _expected(made, columns, list(own.values()), size)
            ranked.append(Separation(planned.name, planned.description, planned.duration, expected))
    return sorted(ranked, key=lambda one: (-round(one.expected_evidence, 1), one.duration_s))


def sensor_for(effects: Sequence[str], signals: Sequence[str]) -> str | None:
    """A sensor that separates the first pair of the effects by the structure of the equations, or None."""
    first, second, *_ = effects
    return separating_sensor(signals, first, second)


def _columns(like: Replay, place: dict[str, int], names: Sequence[str]) -> list[list[int]]:
    return [[int(c) for c in np.flatnonzero(like.owner == place[name])] for name in names]


def _expected(made: object, columns: Sequence[int], groups: Sequence[Sequence[int]], size: float) -> float:
    assert isinstance(made, Replay)
    priors = Priors.of(made.parameters)
    chosen = np.asarray(columns, dtype=np.int64)
    raw = made.sensitivities(np.zeros(len(made.columns)), list(columns))
    matrices = sensor_whitener(made).sensitivities([values * priors.effect[chosen] for values in raw])
    information = np.sum([matrix.T @ matrix for matrix in matrices], axis=0)
    ratios = (priors.nuisance / priors.effect)[chosen]
    _, projected = Quadratic(information, np.zeros(len(chosen))).projected(ratios)
    where = {column: k for k, column in enumerate(columns)}
    places = [[where[column] for column in group] for group in groups]
    return min(
        separation(projected, np.full(len(first), size / np.sqrt(len(first))), first, second)
        for first, second in permutations(places, 2)
    )


def _placeholder(planned: PlannedManoeuvre, signals: Sequence[str], vehicle: VehicleFile) -> Manoeuvre:
    """A manoeuvre with the channels that will be measured; only their names count."""
    time, inputs = planned.inputs("fr")
    channels = {name: np.zeros_like(time) for name in signals} | {"speed": np.full_like(time, planned.speed)}
    for wheel in WHEELS:
        channels[f"wheel_speed_{wheel}"] = channels["speed"] / getattr(vehicle.wheels, wheel).radius
    channels |= inputs
    return Manoeuvre(planned.name, time, channels, {name: np.ones_like(time) for name in channels}, source="planned")
