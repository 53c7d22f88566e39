"""A drive of minutes for tests of clocks: kinematics with random driving, nothing of the product in it.

Acceleration and yaw rate are band-limited noise; speed, wheel speeds (with a slip that goes with the acceleration),
lateral acceleration and steering angle follow. Every channel has its own clock: value at true time t is stamped
(1 + drift) t.
"""

import numpy as np
from numpy.typing import NDArray
from scipy.signal import butter, detrend, sosfiltfilt

Array = NDArray[np.float64]

RADIUS_M, TRACK_M, WHEELBASE_M, STEERING_RATIO = 0.278, 1.46, 2.57, 16.0
UNDERSTEER_S2_M, SLIP_PER_M_S2 = 0.0025, 0.006
NOISE = {
    "speed": 0.03,
    "longitudinal_acceleration": 0.06,
    "lateral_acceleration": 0.06,
    "yaw_rate": 0.002,
    "steering_wheel_angle": 0.002,
    **{f"wheel_speed_{wheel}": 0.06 for wheel in ("fl", "fr", "rl", "rr")},
}
UNITS = {
    "speed": "m/s",
    "longitudinal_acceleration": "m/s^2",
    "lateral_acceleration": "m/s^2",
    "yaw_rate": "rad/s",
    "steering_wheel_angle": "rad",
    **{f"wheel_speed_{wheel}": "rad/s" for wheel in ("fl", "fr", "rl", "rr")},
}


def _band(random: np.random.Generator, time: Array, low_hz: float, high_hz: float, rms: float) -> Array:
    sections = butter(2, (low_hz, high_hz), "bandpass", fs=1.0 / (time[1] - time[0]), output="sos")
    values = sosfiltfilt(sections, random.standard_normal(len(time)))
    return rms * values / np.std(values)


def drive(random: np.random.Generator, duration_s: float) -> tuple[Array, dict[str, Array]]:
    """True signals at 5 ms."""
    step = 0.005
    time = step * np.arange(round(duration_s / step))
    acceleration = _band(random, time, 0.05, 1.5, 1.2)
    # the car does not get faster over the minutes
    speed = np.maximum(22.0 + detrend(step * np.cumsum(acceleration)), 8.0)
    acceleration = np.gradient(speed, step)
    yaw = _band(random, time, 0.05, 1.0, 0.12)
    signals = {
        "speed": speed,
        "longitudinal_acceleration": acceleration,
        "lateral_acceleration": speed * yaw,
        "yaw_rate": yaw,
        # the car answers the wheel 0.1 s later
        "steering_wheel_angle": STEERING_RATIO
        * np.interp(time + 0.1, time, yaw * (WHEELBASE_M + UNDERSTEER_S2_M * speed**2) / speed),
    }
    for wheel, side in (("fl", -1), ("fr", 1), ("rl", -1), ("rr", 1)):
        signals[f"wheel_speed_{wheel}"] = (
            (speed + 0.5 * side * TRACK_M * yaw) * (1.0 + SLIP_PER_M_S2 * acceleration) / RADIUS_M
        )
    return time, signals


def log(
    random: np.random.Generator, time: Array, signals: dict[str, Array], drift: dict[str, float], late_s: float = 0.0
) -> tuple[Array, dict[str, Array]]:
    """Stamps at 10 ms and what each channel has there; channels in ``drift`` have a clock that is fast by so much."""
    stamps = np.arange(0.0, time[-1] - 1.0, 0.01)
    values = {}
    for name, series in signals.items():
        at = (stamps - late_s) / (1.0 + drift[name]) if name in drift else stamps
        values[name] = np.interp(at, time, series) + NOISE[name] * random.standard_normal(len(stamps))
    return stamps, values


def columns(stamps: Array, values: dict[str, Array]) -> dict[str, tuple[Array, Array]]:
    """As ``kinematic_car.write_csv`` takes them."""
    return {name: (stamps, series) for name, series in values.items()}
