"""Where the logs of two loggers belong in time, by the speed of the car that both have.

The reading is scale-free: a speed in a wrong unit goes as the right one.
"""

from collections.abc import Mapping, Sequence
from typing import NamedTuple

import numpy as np
from scipy import signal

from model_diagnosis.data.drives import Drive
from model_diagnosis.data.samples import FloatArray, Samples
from signals.wheels import WHEELS

_STEP_S = 0.1
"""Steps in which clocks are compared: lags of up to 2.5 s are told to milliseconds by the checks that follow."""
_LARGEST_DIFFERENCE = 0.05
"""Of two speeds of one drive, over their root mean square: slip, and half a step of the hardest braking at 20 m/s."""
_CLEARLY = 0.5
"""Share of the difference at any other place that the difference at the right one must stay below."""
_ANOTHER_PLACE_S = 3.0
"""Within it a speed that changes slowly differs from itself by little: 0.3 m/s² of a coast make 1 m/s."""
_LEAST_OVERLAP = 0.5
"""Share of the square of the leading logs' speed that has to lie within the other's logs."""
_GAP_S = 1.0
"""Distance of two samples between which a speed is not known: no logger is slower than GPS."""


class ClockMatch(NamedTuple):
    """How far another clock is ahead, and what tells so."""

    ahead_s: float
    reason: str


class _Course(NamedTuple):
    """A speed in equal steps from ``begin_s`` on, 0 where there is none; ``known`` is 1 where there is one."""

    begin_s: float
    speed: FloatArray
    known: FloatArray


def match_clocks(leads: Sequence[Drive], others: Sequence[Drive], radii: Mapping[str, float]) -> ClockMatch | None:
    """Where the logs of one clock belong among those of another.

    Returns
    -------
    None where one side has no speed, the speeds go together nowhere, or at several places
    """
    own, other = _course(leads, radii), _course(others, radii)
    if own is None or other is None:
        return None
    difference = _differences(own, other)
    best = int(np.argmin(difference))
    far = np.abs(np.arange(len(difference)) - best) * _STEP_S > _ANOTHER_PLACE_S
    elsewhere = float(np.min(difference[far], initial=np.inf))
    if difference[best] > min(_LARGEST_DIFFERENCE, _CLEARLY * elsewhere):
        return None
    place = best + _between_steps(difference[max(best - 1, 0) : best + 2] ** 2)
    ahead_s = other.begin_s - own.begin_s + _STEP_S * (place - (len(own.speed) - 1))
    return ClockMatch(ahead_s, f"laid together by the speeds, which then differ by {100.0 * difference[best]:.1f} %")


def _between_steps(squares: FloatArray) -> float:
    """Place of the least of three squares (3,) by a parabola, -0.5 to 0.5; 0 at an end."""
    if len(squares) < 3 or not np.all(np.isfinite(squares)):
        return 0.0
    before, least, after = squares
    bend = before - 2.0 * least + after
    return float(np.clip(0.5 * (before - after) / bend, -0.5, 0.5)) if bend > 0.0 else 0.0


def _differences(own: _Course, other: _Course) -> FloatArray:
    """Root mean square difference of every shift (k,), with the best factor, over the speed's own; inf without overlap.

    Entry k takes the first sample of ``own`` for that of ``other`` at k less the length of ``own``, less 1.
    """

    def sums(left: FloatArray, right: FloatArray) -> FloatArray:
        total: FloatArray = signal.correlate(left, right, "full", method="fft")
        return total

    product = sums(other.speed, own.speed)
    power, own_power = sums(other.speed**2, own.known), sums(other.known, own.speed**2)
    enough = own_power >= _LEAST_OVERLAP * float(np.sum(own.speed**2))
    result = np.full(len(product), np.inf)
    cosine2 = product[enough] ** 2 / np.maximum(power[enough] * own_power[enough], 1e-9)
    result[enough] = np.sqrt(np.clip(1.0 - cosine2, 0.0, 1.0))
    return result


def _course(drives: Sequence[Drive], radii: Mapping[str, float]) -> _Course | None:
    """Speed of logs of one clock; of each the fastest wheel, or the speed where there are no wheels."""
    series = [one for drive in drives if (one := _speed_of(drive.channels, radii)) is not None]
    if not series:
        return None
    begin = min(float(time[0]) for time, _ in series)
    end = max(float(time[-1]) for time, _ in series)
    raster = begin + _STEP_S * np.arange(int((end - begin) / _STEP_S) + 1, dtype=np.float64)
    speed, known = np.zeros(len(raster)), np.zeros(len(raster))
    for time, values in series:
        after = np.clip(np.searchsorted(time, raster), 1, len(time) - 1)
        inside = (raster >= time[0]) & (raster <= time[-1]) & (time[after] - time[after - 1] <= _GAP_S)
        speed[inside] = np.interp(raster[inside], time, values)
        known[inside] = 1.0
    return _Course(begin, speed, known)


def _speed_of(channels: Mapping[str, Samples], radii: Mapping[str, float]) -> tuple[FloatArray, FloatArray] | None:
    """Stamps and speed [m/s] of a log."""
    wheels = [one for wheel in WHEELS if (one := _numbers(channels, f"wheel_speed_{wheel}", radii[wheel])) is not None]
    if not wheels:
        return _numbers(channels, "speed", 1.0)
    time = wheels[0][0]
    return time, np.max([np.interp(time, *one) for one in wheels], axis=0)


def _numbers(channels: Mapping[str, Samples], name: str, factor: float) -> tuple[FloatArray, FloatArray] | None:
    """Stamps in order and values of a channel where it has numbers; None with fewer than two."""
    if name not in channels:
        return None
    channel = channels[name]
    order = np.argsort(channel.time[channel.valid], kind="stable")
    time, values = channel.time[channel.valid][order], np.abs(channel.values[channel.valid][order])
    return (time, factor * values) if len(time) > 1 else None
