"""The driver's six manoeuvres for a diagnosis and two that are held out, as scripts over time."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from hidden_effects.simulator import STEP_S, Drive

FloatArray = NDArray[np.float64]

FADE_OUT_S = 0.3
"""Time in which a driver brings the wheel back from a sweep."""


@dataclass(frozen=True)
class Script:
    """One manoeuvre: speed at its start [m/s], duration [s], and what the driver does over time [s]."""

    name: str
    speed: float
    duration_s: float
    pedal_n: Callable[[FloatArray], FloatArray]
    steering_wheel_rad: Callable[[FloatArray], FloatArray]
    drive_torque_nm: Callable[[FloatArray], FloatArray]

    def drive(self) -> Drive:
        """The script at the simulator's steps."""
        time: FloatArray = np.arange(round(self.duration_s / STEP_S), dtype=np.float64) * STEP_S
        values = (self.pedal_n(time), self.steering_wheel_rad(time), self.drive_torque_nm(time))
        return Drive(self.speed, *(np.broadcast_to(value, time.shape).astype(float).copy() for value in values))


def tabulated(name: str, table: Mapping[str, Any]) -> Script:
    """A manoeuvre from ``speed`` and lists ``time``, ``pedal``, ``steering_wheel`` and ``drive_torque``."""
    time = [float(value) for value in table["time"]]

    def course(key: str) -> Callable[[FloatArray], FloatArray]:
        values = [float(value) for value in table[key]]
        return lambda at: np.interp(at, time, values)

    return Script(
        name, float(table["speed"]), time[-1], course("pedal"), course("steering_wheel"), course("drive_torque")
    )


def nothing(time: FloatArray) -> FloatArray:
    """Hands and feet off."""
    return np.zeros_like(time)


def ramps(*points: tuple[float, float]) -> Callable[[FloatArray], FloatArray]:
    """Straight lines through (time, value)."""
    times, values = zip(*points, strict=True)
    return lambda time: np.interp(time, times, values)


def sweep(
    amplitude: float, low_hz: float, high_hz: float, begin: float, end: float
) -> Callable[[FloatArray], FloatArray]:
    """Sine whose frequency rises linearly from ``begin`` to ``end`` [s]; it fades out, as no hand jumps."""

    def value(time: FloatArray) -> FloatArray:
        t = np.clip(time - begin, 0.0, end - begin)
        phase = 2.0 * np.pi * (low_hz * t + 0.5 * (high_hz - low_hz) * t * t / (end - begin))
        left: FloatArray = np.clip((end - time) / FADE_OUT_S, 0.0, 1.0)
        result: FloatArray = np.where(time > begin, amplitude * left * np.sin(phase), 0.0)
        return result

    return value


def _press(begin: float, force: float, rise: float, end: float) -> tuple[tuple[float, float], ...]:
    return (0.0, 0.0), (begin, 0.0), (begin + rise, force), (end, force), (end + 0.3, 0.0)


def _two_presses(first: float, second: float) -> Callable[[FloatArray], FloatArray]:
    return ramps(
        (0.0, 0.0),
        (0.8, 0.0),
        (1.1, first),
        (2.9, first),
        (3.2, 0.0),
        (4.5, 0.0),
        (4.7, second),
        (7.2, second),
        (7.5, 0.0),
    )


def _pulsed(low: float, high: float, times: tuple[float, ...]) -> Callable[[FloatArray], FloatArray]:
    """Pedal that changes between two forces within 0.1 s at the given times, first to ``high``."""
    points: list[tuple[float, float]] = [(0.0, 0.0), (0.5, 0.0), (0.7, low)]
    level = low
    for at in times:
        points += [(at, level)]
        level = high if level == low else low
        points += [(at + 0.1, level)]
    return ramps(*points)


def _turn(angle: float, begin: float, rise: float) -> Callable[[FloatArray], FloatArray]:
    return ramps((0.0, 0.0), (begin, 0.0), (begin + rise, angle), (1e3, angle))


SIX: tuple[Script, ...] = (
    Script("coast", 35.0, 10.0, nothing, ramps((0, 0), (6, 0), (6.4, 0.12), (7.6, 0.12), (8, 0), (10, 0)), nothing),
    Script("gentle_stops", 30.0, 9.5, _two_presses(60.0, 130.0), nothing, nothing),
    Script("abs_stop", 30.0, 9.0, ramps(*_press(0.8, 480.0, 0.15, 60.0)), nothing, nothing),
    Script("sine_steer", 22.0, 10.0, nothing, sweep(0.6, 0.2, 2.6, 0.5, 9.5), ramps((0, 150.0), (10, 150.0))),
    Script("brake_in_turn", 22.0, 9.0, _pulsed(70.0, 150.0, (3.6, 4.1, 4.6, 5.1)), _turn(0.6, 0.6, 0.8), nothing),
    Script(
        "accelerate_and_brake",
        8.0,
        10.0,
        ramps((0, 0), (5.6, 0), (5.9, 220.0), (7.0, 220.0), (7.4, 40.0), (10, 40.0)),
        ramps((0, 0), (1.5, 0), (2.0, -0.6), (3.0, -0.6), (3.5, 0.0), (10, 0.0)),
        ramps((0, 0), (0.5, 0), (0.9, 1400.0), (4.8, 1400.0), (5.2, 0.0), (10, 0.0)),
    ),
)
"""The shipped set."""

HELD_OUT: tuple[Script, ...] = (
    Script("stop_from_speed", 38.0, 10.0, ramps(*_press(0.8, 260.0, 0.3, 60.0)), nothing, nothing),
    Script(
        "slalom_and_brake",
        24.0,
        9.0,
        ramps((0, 0), (4.5, 0), (4.8, 420.0), (60.0, 420.0)),
        sweep(0.6, 0.35, 0.9, 0.5, 5.5),
        ramps((0, 300.0), (4.0, 300.0), (4.3, 0.0), (60, 0.0)),
    ),
)
"""Never given to the search."""

SCRIPTS = {script.name: script for script in SIX + HELD_OUT}
