"""Variables that an unknown term may depend on, from a replayed drive and its channels, less their noise."""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.signal import savgol_filter

from model_diagnosis.manoeuvre import SAMPLE_TIME_S
from model_diagnosis.replay.replay import Replay
from model_diagnosis.replay.state import SUBSTEPS
from signals.wheels import WHEELS

FloatArray = NDArray[np.float64]
Series = tuple[FloatArray, ...]
"""One array per manoeuvre: (n,) of the car, or (n, 4) of the wheels."""

_SMOOTHING = 7
"""Samples."""


@dataclass(frozen=True)
class Variable:
    """A quantity that a term may depend on.

    Attributes
    ----------
    name : as the plant's terms know it
    values : (n,) of the car or (n, 4) of the wheels, of each manoeuvre; ``per_sample`` rows of each sample, one after
        the other
    """

    name: str
    unit: str
    values: Series
    per_sample: int = 1

    def course(self, function: Callable[[FloatArray], FloatArray], m: int) -> FloatArray:
        """A function of it at the samples of a manoeuvre, (n,) or (n, 4): its mean about each, not that of the mean."""
        values = function(self.values[m])
        mean: FloatArray = values.reshape(-1, self.per_sample, *values.shape[1:]).mean(axis=1)
        return mean

    @property
    def of_wheels(self) -> bool:
        """True for a value per wheel."""
        return self.values[0].ndim == 2

    @property
    def span(self) -> tuple[float, float]:
        """Lowest and highest value but for the outermost half per cent."""
        low, high = np.quantile(np.concatenate([one.ravel() for one in self.values]), [0.005, 0.995])
        return float(low), float(high)

    @property
    def signed(self) -> bool:
        """True where it takes both signs."""
        low, high = self.span
        return low < -0.05 * max(abs(low), abs(high)) and high > 0.05 * max(abs(low), abs(high))


@dataclass(frozen=True)
class _Drive:
    """One manoeuvre: states of the replay and measured channels."""

    states: dict[str, FloatArray]
    channels: dict[str, FloatArray]

    def state(self, name: str) -> FloatArray:
        """A state of the four wheels, (n, 4)."""
        return np.stack([self.states[f"{name}_{wheel}"] for wheel in WHEELS], axis=1)

    def channel(self, name: str) -> FloatArray:
        """A measured channel, zeros where the log lacks it."""
        return self.channels.get(name, np.zeros(len(self.states["speed"])))


_VARIABLES: tuple[tuple[str, str, Callable[[_Drive], FloatArray]], ...] = (
    ("speed", "m/s", lambda one: one.states["speed"]),
    ("yaw_rate", "rad/s", lambda one: one.channel("yaw_rate")),
    ("lateral_acceleration", "m/s^2", lambda one: one.channel("lateral_acceleration")),
    ("longitudinal_acceleration", "m/s^2", lambda one: one.channel("longitudinal_acceleration")),
    ("steering_wheel_angle", "rad", lambda one: one.channel("steering_wheel_angle")),
    ("brake_disc_temperature", "degC", lambda one: one.state("brake_disc_temperature")),
    ("vertical_load", "N", lambda one: one.state("vertical_load")),
    ("slip_angle", "rad", lambda one: one.state("slip_angle")),
    ("slip_ratio", "1", lambda one: one.state("slip_ratio")),
)


def variables_of(replay: Replay, theta: FloatArray) -> dict[str, Variable]:
    """Every variable that varies, of all manoeuvres of a replay at deviations theta (p,)."""
    count = range(len(replay.manoeuvres))
    drives = [_Drive(replay.states(theta, m), dict(replay.manoeuvres[m].on_one_raster().channels)) for m in count]
    found = [Variable(name, unit, tuple(_smoothed(of(drive)) for drive in drives)) for name, unit, of in _VARIABLES]
    at_samples, before = zip(*(replay.driving_pressures(theta, m) for m in count), strict=True)
    found.append(Variable("brake_pressure", "Pa", at_samples))
    found.append(Variable("brake_pressure_rate", "Pa/s", tuple(map(_rates, before)), SUBSTEPS))
    return {one.name: one for one in found if one.span[1] > one.span[0]}


def _rates(before: FloatArray) -> FloatArray:
    """Rates (n · SUBSTEPS, 4) [Pa/s] in the car's steps about each sample, from pressures (n, SUBSTEPS, 4) before it.

    Valves turn pressures round within a sample. They take some ms to open and to close, which a unit that knows their
    dead times only lacks: each rate is the mean of three steps.
    """
    half = SUBSTEPS // 2
    course = before.reshape(-1, before.shape[2])
    course = np.concatenate([course, np.repeat(course[-1:], half + 2, axis=0)])
    rates: FloatArray = (course[half + 2 :] - course[half - 1 : -3]) / (3.0 * SAMPLE_TIME_S / SUBSTEPS)
    return rates


def _smoothed(values: FloatArray) -> FloatArray:
    """Quadratics fitted over 70 ms."""
    if len(values) < _SMOOTHING:
        return values
    smooth: FloatArray = savgol_filter(values, _SMOOTHING, 2, axis=0)
    return smooth
