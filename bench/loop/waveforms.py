"""Values of a stimulus over the time since it began."""

import math
from collections.abc import Callable, Sequence

import numpy as np

Waveform = Callable[[float], float]


def step(value: float) -> Waveform:
    """Constant ``value``."""
    return lambda elapsed_s: value


def ramp(start: float, end: float, duration_s: float) -> Waveform:
    """Linear from ``start`` to ``end`` within ``duration_s``, then held."""
    if duration_s <= 0.0:
        return step(end)
    slope = (end - start) / duration_s
    return lambda elapsed_s: start + slope * elapsed_s if elapsed_s < duration_s else end


def sine(offset: float, amplitude: float, frequency_hz: float, phase_rad: float = 0.0) -> Waveform:
    """Sine around ``offset``."""
    angular = 2.0 * math.pi * frequency_hz
    return lambda elapsed_s: offset + amplitude * math.sin(angular * elapsed_s + phase_rad)


def sweep(offset: float, amplitude: float, start_hz: float, end_hz: float, duration_s: float) -> Waveform:
    """Sine whose frequency rises linearly from ``start_hz`` to ``end_hz`` within ``duration_s``."""
    rate = (end_hz - start_hz) / duration_s

    def value(elapsed_s: float) -> float:
        inside = min(elapsed_s, duration_s)
        cycles = start_hz * inside + 0.5 * rate * inside * inside + end_hz * (elapsed_s - inside)
        return offset + amplitude * math.sin(2.0 * math.pi * cycles)

    return value


def noise(offset: float, standard_deviation: float, generator: np.random.Generator) -> Waveform:
    """White Gaussian noise around ``offset``, a new value per tick."""
    return lambda elapsed_s: offset + standard_deviation * float(generator.standard_normal())


def table(times_s: Sequence[float], values: Sequence[float]) -> Waveform:
    """Linear interpolation between the points of a table, held before the first and after the last."""
    times, points = np.asarray(times_s, float), np.asarray(values, float)
    return lambda elapsed_s: float(np.interp(elapsed_s, times, points))
