"""The offset of a logger's clock by the innovations of a car that was fitted without that logger.

Numbers that are fitted to late data take a part of the delay upon them; those of a car without the logger do not.
"""

from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from model_diagnosis.data.delay_acceptance import fitted_car
from model_diagnosis.data.delay_checks import Late, shifted
from model_diagnosis.data.innovations import total_log_innovation
from model_diagnosis.data.replayed import FloatArray, ReplayFactory
from model_diagnosis.manoeuvre import SAMPLE_TIME_S, Manoeuvre
from signals.wheels import WHEELS
from vehicle_model.vehicle_file import VehicleFile

IntArray = NDArray[np.int64]

ANYWHERE, COARSE, FINE = np.arange(-240, 241, 20), np.arange(-10, 11, 2), np.arange(-4, 5)
"""Shifts [samples] that the innovations are asked about: where no lag tells an offset, around one, and last."""
_BEGIN = 30
"""Samples at a drive's begin that tell nothing of shifts: a replay starts on a straight line through the first ones."""
_LEAST_SAMPLES = 150
"""Of a drive that are compared: three times those from which on the innovations of a channel count."""
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
class FittedCar:
    """A car by its deviations, and how the innovations of its replay depend on a logger's offset."""

    vehicle: VehicleFile
    replay: ReplayFactory
    deviations: Mapping[str, float]

    @classmethod
    def to(cls, manoeuvres: Sequence[Manoeuvre], vehicle: VehicleFile, replay: ReplayFactory) -> "FittedCar":
        """The car that fits manoeuvres."""
        columns = replay(vehicle, manoeuvres).columns
        theta = fitted_car(vehicle, manoeuvres, replay)
        return cls(vehicle, replay, dict(zip(columns, theta.tolist(), strict=True)))

    def searched(self, late: Late, parts: Sequence[Manoeuvre], *shifts: IntArray) -> Late | None:
        """Channels with their delay by innovations, coarse shifts first; None where those are not sharp, or the delay
        is farther than it is known from that of ``late``, where that has a standard deviation."""
        found: Late | None = late
        for tried in shifts:
            found = None if found is None else self.offset(found, parts, tried)
        if found is None or not late.std_s:
            return found
        allowed_s = _AGREEMENT_STDS * float(np.hypot(late.std_s, _STD_S))
        return found if abs(found.delay_s - late.delay_s) <= allowed_s else None

    def offset(self, late: Late, parts: Sequence[Manoeuvre], shifts: IntArray) -> Late | None:
        """Channels with the delay of the least innovations; None where that is not an inner shift, or not sharp."""
        at = round(late.delay_s / SAMPLE_TIME_S)
        spare = max(part.samples for part in parts) - _BEGIN - _LEAST_SAMPLES
        tried = np.array([one for one in shifts if max(0, abs(one) - at) + max(0, abs(one) + at) <= spare])
        if len(tried) < len(FINE):
            return None
        scores = self._scores(late.channels, parts, at + tried)
        best = int(np.argmin(scores))
        if not 0 < best < len(scores) - 1 or min(scores[0], scores[-1]) - scores[best] < _SHARP:
            return None
        before, least, after = scores[best - 1 : best + 2]
        part = 0.5 * (before - after) / (before - 2.0 * least + after)
        shift = float(tried[best] + part * (tried[best + 1] - tried[best]))
        std_s = float(np.hypot(_STD_S, _unsure_s(parts, late.channels)))
        return replace(late, delay_s=SAMPLE_TIME_S * (at + shift), std_s=std_s)

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


def has_speed(channels: Collection[str]) -> bool:
    """Whether a replay has a speed to start from in these channels."""
    return "speed" in channels or all(f"wheel_speed_{wheel}" in channels for wheel in WHEELS)


def without(manoeuvre: Manoeuvre, channels: Collection[str]) -> Manoeuvre:
    """A manoeuvre without some of its channels."""
    return replace(
        manoeuvre,
        channels={name: values for name, values in manoeuvre.channels.items() if name not in channels},
        weights={name: weights for name, weights in manoeuvre.weights.items() if name not in channels},
        origins={name: origin for name, origin in manoeuvre.origins.items() if name not in channels},
        phases={name: phase for name, phase in manoeuvre.phases.items() if name not in channels},
    )


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
