"""Thirty manoeuvres that a plan chooses from, as inputs over time; speeds in m/s, times in s."""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from model_diagnosis.manoeuvre import SAMPLE_TIME_S
from signals.wheels import WHEELS

FloatArray = NDArray[np.float64]
Course = Callable[[FloatArray], FloatArray]

PA_PER_BAR = 1e5
REAR_SHARE = 0.6
"""Rear over front wheel pressure where a manoeuvre does not say otherwise (both axles on one line would be 1)."""


def _zero(time: FloatArray) -> FloatArray:
    return np.zeros_like(time)


def _line(*points: tuple[float, float]) -> Course:
    """Straight lines through (time, value)."""
    times, values = zip(*points, strict=True)
    return lambda time: np.interp(time, times, values)


def _steps(levels: tuple[float, ...], hold: float, rise: float = 0.15, begin: float = 0.5) -> Course:
    """Levels held one after the other, joined by ramps."""
    points = [(begin, 0.0)]
    for number, level in enumerate(levels):
        start = begin + number * hold
        points += [(start + rise, level), (start + hold, level)]
    end = points[-1][0]
    return _line(*points, (end + rise, 0.0))


def _sine(amplitude: float, first_hz: float, last_hz: float, duration: float) -> Course:
    """Sine whose frequency rises linearly."""

    def course(time: FloatArray) -> FloatArray:
        phase = 2.0 * np.pi * (first_hz * time + 0.5 * (last_hz - first_hz) * time**2 / duration)
        return amplitude * np.sin(phase)

    return course


def _pulses(level: float, period: float, share: float = 0.5, base: float = 0.0) -> Course:
    return lambda time: np.where((time > 0.5) & (np.mod(time - 0.5, period) < share * period), level, base)


@dataclass(frozen=True)
class PlannedManoeuvre:
    """One manoeuvre of the library.

    Attributes
    ----------
    speed : at its start [m/s]
    duration : [s]
    pressure : front wheel pressure over time [bar]
    steering : steering-wheel angle over time [rad]
    drive : drive torque of the driven axle over time [N m]
    grade : slope of the road, uphill positive [1]
    rear_share : rear over front wheel pressure
    """

    name: str
    description: str
    speed: float
    duration: float
    pressure: Course = _zero
    steering: Course = _zero
    drive: Course = _zero
    grade: float = 0.0
    rear_share: float = REAR_SHARE

    def inputs(self, drive_axles: str) -> tuple[FloatArray, dict[str, FloatArray]]:
        """Time (n,) and channels that drive a replay; ``drive_axles`` is ``f``, ``r`` or both."""
        time = SAMPLE_TIME_S * np.arange(round(self.duration / SAMPLE_TIME_S), dtype=np.float64)
        front = PA_PER_BAR * np.maximum(self.pressure(time), 0.0)
        channels = {
            f"brake_pressure_{wheel}": front if wheel.startswith("f") else self.rear_share * front for wheel in WHEELS
        }
        channels["steering_wheel_angle"] = self.steering(time)
        for axle in "fr":
            driven = self.drive(time) / len(drive_axles) if axle in drive_axles else np.zeros_like(time)
            channels[f"drive_torque_{axle}"] = driven
        if self.grade:
            channels["road_grade"] = np.full_like(time, self.grade)
        return time, channels


_P = PlannedManoeuvre

LIBRARY: tuple[PlannedManoeuvre, ...] = (
    _P("coast_fast", "coast down from 40 m/s, clutch open", 40.0, 12.0),
    _P("coast_slow", "coast down from 15 m/s, clutch open", 15.0, 12.0),
    _P("coast_uphill", "coast down from 25 m/s on a 4 % climb (and back)", 25.0, 10.0, grade=0.04),
    _P("coast_downhill", "coast from 25 m/s on a 4 % descent", 25.0, 10.0, grade=-0.04),
    _P("constant_20", "constant 20 m/s under power", 20.0, 10.0, drive=lambda t: np.full_like(t, 120.0)),
    _P("constant_40", "constant 40 m/s under power", 40.0, 10.0, drive=lambda t: np.full_like(t, 350.0)),
    _P("full_throttle", "full throttle from 8 m/s, coast, brake", 8.0, 12.0, _line((9.0, 0), (9.3, 25), (12, 25)),
       drive=_line((0.5, 0), (0.9, 1800), (6, 1800), (6.3, 0))),
    _P("throttle_pulses", "drive torque pulses at 15 m/s, straight", 15.0, 10.0, drive=_pulses(1200.0, 2.0)),
    _P("stop_gentle", "straight stop at 2 m/s^2 from 25 m/s", 25.0, 9.0, _line((0.5, 0), (0.8, 15), (20, 15))),
    _P("stop_medium", "straight stop at 4 m/s^2 from 25 m/s", 25.0, 6.0, _line((0.5, 0), (0.8, 30), (20, 30))),
    _P("stop_hard", "straight stop at 6 m/s^2 from 30 m/s", 30.0, 5.0, _line((0.5, 0), (0.8, 45), (20, 45))),
    _P("stop_fast", "the same pressure from 45 m/s, ended at 15 m/s", 45.0, 8.0, _line((0.5, 0), (0.8, 30), (20, 30))),
    _P("stop_slow", "the same pressure from 12 m/s", 12.0, 4.0, _line((0.5, 0), (0.8, 30), (20, 30))),
    _P("pressure_stairs", "staircase of pressures from 40 m/s", 40.0, 10.0, _steps((8, 16, 24, 32, 40), 1.6)),
    _P("pressure_triangle", "slow triangle of pressure at 35 m/s", 35.0, 8.0, _line((0.5, 0), (3.5, 35), (7.0, 0))),
    _P("pressure_pulses_fast", "pressure pulses at 35 m/s", 35.0, 8.0, _pulses(30.0, 1.0)),
    _P("pressure_pulses_slow", "pressure pulses at 12 m/s", 12.0, 5.0, _pulses(15.0, 1.0, 0.4)),
    _P("light_braking", "constant light braking from 30 m/s", 30.0, 12.0, _line((0.5, 0), (0.8, 6), (20, 6))),
    _P("fade_series", "six stops of 4 m/s^2 between 40 and 20 m/s, driven up again", 40.0, 60.0,
       lambda t: np.where(np.mod(t, 10.0) < 5.0, 35.0, 0.0),
       drive=lambda t: np.where(np.mod(t, 10.0) > 5.3, 1700.0, 0.0)),
    _P("cold_hot_drag", "drag the brake for 20 s under power, then coast", 20.0, 30.0,
       _line((0.5, 0), (1, 10), (20, 10), (20.5, 0)), drive=_line((0.5, 0), (1, 900), (20, 900), (20.5, 0))),
    _P("limit_ramp", "slow pressure ramp to the limit of adhesion from 35 m/s", 35.0, 7.0, _line((0.5, 0), (6.5, 90))),
    _P("limit_front", "ramp to the limit with front brakes only", 30.0, 6.0, _line((0.5, 0), (5, 100)), rear_share=0.0),
    _P("steady_circle_left", "steady circle to the left at 15 m/s", 15.0, 8.0,
       steering=_line((0.5, 0), (1.5, 0.9), (20, 0.9)), drive=lambda t: np.full_like(t, 150.0)),
    _P("steady_circle_right", "steady circle to the right at 15 m/s", 15.0, 8.0,
       steering=_line((0.5, 0), (1.5, -0.9), (20, -0.9)), drive=lambda t: np.full_like(t, 150.0)),
    _P("slow_circle", "slow circle at 6 m/s with large steering angle", 6.0, 8.0,
       steering=_line((0.5, 0), (1.5, 3.5), (20, 3.5)), drive=lambda t: np.full_like(t, 150.0)),
    _P("rising_circle", "circle with rising lateral acceleration at 20 m/s", 20.0, 10.0,
       steering=_line((0.5, 0), (9.0, 1.2)), drive=lambda t: np.full_like(t, 250.0)),
    _P("sine_sweep", "sine steer 0.2 to 3 Hz at 22 m/s", 22.0, 12.0, steering=_sine(0.5, 0.2, 3.0, 12.0),
       drive=lambda t: np.full_like(t, 150.0)),
    _P("step_steer", "step of steering at 28 m/s", 28.0, 6.0, steering=_line((1.0, 0), (1.15, 0.6), (20, 0.6))),
    _P("brake_in_turn", "brake at 4 m/s^2 in a turn from 22 m/s", 22.0, 5.0, _line((2.0, 0), (2.2, 30), (20, 30)),
       _line((0.5, 0), (1.2, 0.7), (20, 0.7))),
    _P("brake_release", "sudden release of the brake at 6 m/s^2", 32.0, 6.0,
       _line((0.5, 0), (0.8, 45), (2.2, 45), (2.25, 0), (3.5, 0), (3.6, 45), (4.6, 45), (4.65, 0))),
    _P("slalom", "slalom at 0.6 Hz and 20 m/s, then brake", 20.0, 8.0, _line((6.0, 0), (6.2, 35), (20, 35)),
       _sine(0.7, 0.6, 0.6, 8.0)),
)  # fmt: skip
"""The library; what only a standing car shows (offsets at rest) is asked for as a sensor check, not as a drive."""
