"""Filters of inertial channels: named where a filter of the replay leaves smaller innovations than any delay of it.

A car that brakes or turns in more slowly than its vehicle file says bends phases too; so a filter has to be asked for
by the vehicle file's own replay and by that of a car refitted to all other channels: what physics can explain, the
refit explains without a filter.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from model_diagnosis.data.delay_acceptance import fitted_car
from model_diagnosis.data.delay_checks import follows
from model_diagnosis.data.innovations import log_innovation
from model_diagnosis.data.low_pass import first_order, least_between, named_and_undone
from model_diagnosis.data.replayed import ReplayFactory, replayed_manoeuvres
from model_diagnosis.data.samples import BoolArray, FloatArray
from model_diagnosis.data.twin_kinds import LEAST_OF
from model_diagnosis.data.twins import moved_by
from model_diagnosis.manoeuvre import SAMPLE_TIME_S, Manoeuvre
from model_diagnosis.result import DataFault
from vehicle_model.vehicle_file import VehicleFile

_TIME_CONSTANTS_S = np.geomspace(0.035, 2.24, 13)
"""By steps of the square root of two, which is near enough for a parabola: the costs bend over a factor of two."""
_SHORTEST_S = 0.06
"""Shorter ones are what a prediction without the noise of its inputs gains by being smoothed."""
_DELAYS = range(-6, 45, 3)
"""Samples; messages and channels are late by less than 0.4 s, and the best and its two neighbours are tried after."""
_GAIN_PER_SAMPLE = 0.02
"""In log σ of the innovations: filters of 0.1 to 0.4 s gain 0.05 to 0.3, no car without one gained anything (24 cars
of tuning seeds 68 and 1 000 002)."""
_FOLLOWS = 0.85
"""Correlation with its prediction, at whatever delay, from which a channel follows it: 0.91 and more in manoeuvres that
were steered, filtered by 0.4 s too; 0.76 and less where a stop with ABS made the car sway."""
_SETTLING_S = 0.3
"""Three time constants of the shortest filter that has to be named."""
_OTHER_LOGGER = ("speed",)
"""Not fitted to where wheels tell the speed too: it often comes from another logger, whose clock is judged later."""


@dataclass(frozen=True)
class _Channel:
    """A channel as measured and as predicted (n,) per manoeuvre, and where it was measured."""

    measured: Sequence[FloatArray]
    predicted: Sequence[FloatArray]
    valid: Sequence[BoolArray]

    def cost(self, predicted: Sequence[FloatArray], delay: int = 0) -> float:
        """Σ N log σ of the innovations beside a prediction of free gain and offset, late by so many samples."""
        late = [_shifted(series, delay) for series in predicted]
        together = np.concatenate([series[known] for series, known in zip(late, self.valid, strict=True)])
        target = np.concatenate([series[known] for series, known in zip(self.measured, self.valid, strict=True)])
        gain, offset = np.polyfit(together, target, 1)
        return sum(
            log_innovation(measured - gain * series - offset, known)
            for measured, series, known in zip(self.measured, late, self.valid, strict=True)
        )

    def filter(self) -> tuple[float, float]:
        """Time constant [s] and what it gains over the best delay; (0, 0) where that is too little."""
        costs = np.array([self.cost([first_order(p, float(t)) for p in self.predicted]) for t in _TIME_CONSTANTS_S])
        by_delay = {delay: self.cost(self.predicted, delay) for delay in _DELAYS}
        best = min(by_delay, key=by_delay.__getitem__)
        least = min(by_delay[best], *(self.cost(self.predicted, best + step) for step in (-1, 1)))
        gain = least - float(costs.min())
        time_constant_s = least_between(_TIME_CONSTANTS_S, costs)
        enough = _GAIN_PER_SAMPLE * sum(int(known.sum()) for known in self.valid)
        return (time_constant_s, gain) if gain > enough and time_constant_s > _SHORTEST_S else (0.0, 0.0)


def check_replayed_filters(
    manoeuvres: Sequence[Manoeuvre],
    replayed: Sequence[Manoeuvre],
    channels: Sequence[str],
    vehicle: VehicleFile,
    replay: ReplayFactory,
) -> tuple[list[DataFault], list[Manoeuvre]]:
    """Name which of the channels a first-order filter has smoothed, and undo it.

    Parameters
    ----------
    replayed : the manoeuvres as the vehicle file predicts them from their inputs
    channels : that the replay predicts
    """
    gains = {name: _filter_of(name, manoeuvres, replayed)[1] for name in channels}
    faults: list[DataFault] = []
    repaired = list(manoeuvres)
    for name in sorted((name for name in channels if gains[name] > 0.0), key=lambda name: -gains[name]):
        time_constant_s, gain = _filter_of(name, repaired, _refitted(repaired, name, vehicle, replay))
        if gain > 0.0:
            fault, repaired = named_and_undone(repaired, name, time_constant_s, gain)
            faults.append(fault)
    return faults, repaired


def _filter_of(name: str, manoeuvres: Sequence[Manoeuvre], replayed: Sequence[Manoeuvre]) -> tuple[float, float]:
    both = [(m, r) for m, r in zip(manoeuvres, replayed, strict=True) if name in m.channels and _is_told(name, m, r)]
    if not both:
        return 0.0, 0.0
    measured, predicted = ([one.channels[name] for one in side] for side in zip(*both, strict=True))
    return _Channel(measured, predicted, [_settled(m.weight(name)) for m, _ in both]).filter()


def _is_told(name: str, manoeuvre: Manoeuvre, replayed: Manoeuvre) -> bool:
    """True where the inputs ask for a motion and the channel follows it.

    Of sway that no input tells, a prediction that is smoothed away leaves less than one that is not.
    """
    sides = manoeuvre.channels[name], replayed.channels[name]
    everywhere = np.ones(manoeuvre.samples, dtype=bool)
    return all(moved_by(side, everywhere) > LEAST_OF[name] for side in sides) and follows(*sides, _FOLLOWS)


def _refitted(
    manoeuvres: Sequence[Manoeuvre], name: str, vehicle: VehicleFile, replay: ReplayFactory
) -> list[Manoeuvre]:
    """The manoeuvres as the car predicts them that fits all channels but this one."""
    wheels = all(any(channel.startswith("wheel_speed") for channel in m.channels) for m in manoeuvres)
    unused = (name, *(_OTHER_LOGGER if wheels else ()))
    others = [replace(m, weights=dict(m.weights) | {c: np.zeros(m.samples) for c in unused}) for m in manoeuvres]
    return replayed_manoeuvres(replay(vehicle, manoeuvres), manoeuvres, fitted_car(vehicle, others, replay))


def _settled(weight: FloatArray) -> BoolArray:
    """Measured, and late enough that what a delay or a filter begins with is forgotten."""
    known: BoolArray = weight > 0.0
    known[: round(_SETTLING_S / SAMPLE_TIME_S)] = False
    return known


def _shifted(values: FloatArray, delay: int) -> FloatArray:
    """Late by so many samples; the first or last value stands where nothing is known."""
    return values[np.clip(np.arange(len(values)) - delay, 0, len(values) - 1)]
