"""Equation errors: how far each balance of the car is from being met by the measured signals.

Accelerations come from a local quadratic fit over 70 ms; what was not measured (lateral speed, loads, tyre forces) is
that of the observer replay. The model's side passes through the same fit. Source: Klein and Morelli, Aircraft System
Identification, ch. 5 (equation error).
"""

import numpy as np
from numpy.typing import NDArray
from scipy.signal import savgol_filter

from model_diagnosis.manoeuvre import SAMPLE_TIME_S, Manoeuvre
from model_diagnosis.replay.replay import Replay
from signals.wheels import WHEELS
from vehicle_model.vehicle_file import VehicleFile

FloatArray = NDArray[np.float64]

UNITS = {
    "longitudinal force": "N",
    "lateral force": "N",
    "yaw moment": "N m",
    **{f"wheel torque {wheel}": "N m" for wheel in WHEELS},
    "load transfer": "N",
    "speed and acceleration": "m/s^2",
    "yaw rate and wheel speeds": "rad/s",
    **{f"hydraulics {wheel}": "Pa" for wheel in WHEELS},
}
"""Unit of each equation's error."""

_WINDOW, _ORDER = 7, 2
_GRAVITY = 9.81
_LOCKED_RAD_S = 1.0


def _slope(values: FloatArray) -> FloatArray:
    fitted: FloatArray = savgol_filter(values, _WINDOW, _ORDER, deriv=1, delta=SAMPLE_TIME_S)
    return fitted


def _smooth(values: FloatArray) -> FloatArray:
    fitted: FloatArray = savgol_filter(values, _WINDOW, _ORDER)
    return fitted


def equation_errors(vehicle: VehicleFile, manoeuvre: Manoeuvre, theta: FloatArray) -> dict[str, FloatArray]:
    """Errors of the balances that the manoeuvre's channels allow.

    Parameters
    ----------
    vehicle : VehicleFile
    manoeuvre : Manoeuvre
    theta : (p,) deviations of all columns of ``Replay(vehicle, …)`` with the whole catalogue

    Returns
    -------
    equation -> (n,) in the unit of ``UNITS``; nan where a sample does not count
    """
    return errors_of(Replay(vehicle, [manoeuvre]), theta, 0)


def errors_of(replay: Replay, theta: FloatArray, m: int) -> dict[str, FloatArray]:
    """The same of manoeuvre ``m`` of a replay."""
    balances = _Balances(replay, theta, m)
    found = {
        "longitudinal force": balances.longitudinal(),
        "lateral force": balances.lateral(),
        "yaw moment": balances.yaw(),
        **{f"wheel torque {wheel}": balances.wheel(i) for i, wheel in enumerate(WHEELS)},
        "load transfer": balances.load_transfer(),
        "speed and acceleration": balances.speed_and_acceleration(),
        "yaw rate and wheel speeds": balances.yaw_rate_and_wheels(),
        **{f"hydraulics {wheel}": balances.pressure(wheel) for wheel in WHEELS},
    }
    return {name: values for name, values in found.items() if values is not None}


class _Balances:
    """Measured channels, states of the replay and the car's numbers at a theta."""

    def __init__(self, replay: Replay, theta: FloatArray, m: int) -> None:
        manoeuvre = replay.manoeuvres[m]
        self.channels = manoeuvre.on_one_raster().channels
        self.weight = manoeuvre.weight
        self.states = replay.states(theta, m)
        self.car = replay.car_at(theta)
        self.signals = replay.signals(m)
        self.moving = replay.moving(m)
        self._residuals = replay.measured(m) - replay.predict(theta, m)

    def _masked(self, values: FloatArray, *channels: str) -> FloatArray:
        known = self.moving.copy()
        for name in channels:
            known &= self.weight(name) > 0.0
        # a fit reaches half its window over the edge of what is known
        reach = np.ones(_WINDOW)
        known &= np.convolve(~known, reach, "same") == 0.0
        return np.where(known, values, np.nan)

    def _has(self, *names: str) -> bool:
        return all(name in self.channels for name in names)

    def _wheel_torque(self, i: int) -> FloatArray:
        """Torque that is left for the tyre: drive, brake, rolling and the wheel's own spin-up."""
        wheel = WHEELS[i]
        turning = _slope(self.channels[f"wheel_speed_{wheel}"])
        rolling = self.car["rolling_resistance"][i] * self.states[f"vertical_load_{wheel}"] * self.car["radius"][i]
        given = self.states[f"drive_torque_{wheel}"] - self.states[f"brake_torque_{wheel}"] - rolling
        left: FloatArray = _smooth(given) - self.car["spin_inertia"][i] * turning
        return left

    def _pushed_along(self) -> FloatArray:
        """Acceleration (n,) by the forces along the car: what the accelerometer reads and the gravity in it."""
        leaning = float(self.car["accelerometer_leaning"])
        felt = leaning * self.states["pitch_angle"] + (1.0 - leaning) * float(self.car["grade"])
        pushed: FloatArray = self.channels["longitudinal_acceleration"] + _GRAVITY * felt
        return pushed

    def wheel(self, i: int) -> FloatArray | None:
        """Torque balance of a wheel."""
        name = f"wheel_speed_{WHEELS[i]}"
        if not self._has(name):
            return None
        tyre = self.states[f"longitudinal_force_{WHEELS[i]}"] * self.car["radius"][i]
        rolling = self.channels[name] > _LOCKED_RAD_S
        return np.where(rolling, self._masked(_smooth(tyre) - self._wheel_torque(i), name), np.nan)

    def longitudinal(self) -> FloatArray | None:
        """Force balance along the car, tyre forces by the wheels' torque balances."""
        wheels = [f"wheel_speed_{wheel}" for wheel in WHEELS]
        if not self._has("longitudinal_acceleration", *wheels) or "longitudinal_acceleration" not in self.signals:
            return None
        force = -self.car["drag"] * self.states["speed"] ** 2
        for i, wheel in enumerate(WHEELS):
            angle, side = self.states[f"road_wheel_angle_{wheel}"], self.states[f"lateral_force_{wheel}"]
            force += self._wheel_torque(i) / self.car["radius"][i] * np.cos(angle) - _smooth(side * np.sin(angle))
        felt = self._pushed_along()
        error = self.car["mass"] * _smooth(felt) - force
        rolling = np.all([self.channels[name] > _LOCKED_RAD_S for name in wheels], axis=0)
        return np.where(rolling, self._masked(error, "longitudinal_acceleration", *wheels), np.nan)

    def lateral(self) -> FloatArray | None:
        """Force balance across the car."""
        return self._residual("lateral_acceleration", float(self.car["mass"]))

    def _residual(self, signal: str, factor: float) -> FloatArray | None:
        if signal not in self.signals:
            return None
        residual = self._residuals[:, self.signals.index(signal)]
        return self._masked(factor * _smooth(residual), signal)

    def yaw(self) -> FloatArray | None:
        """Moment balance about the vertical axis."""
        if "yaw_rate" not in self.signals:
            return None
        difference = _slope(self.channels["yaw_rate"]) - _smooth(self.states["yaw_acceleration"])
        return self._masked(float(self.car["yaw_inertia"]) * difference, "yaw_rate")

    def load_transfer(self) -> FloatArray | None:
        """Load of the front axle, where the loads are measured."""
        names = [f"vertical_load_{wheel}" for wheel in WHEELS[:2]]
        if not all(name in self.signals for name in names):
            return None
        error = sum(self._residuals[:, self.signals.index(name)] for name in names)
        return self._masked(_smooth(np.asarray(error)), *names)

    def speed_and_acceleration(self) -> FloatArray | None:
        """Change of the speed reference against the accelerometer."""
        if not self._has("speed", "longitudinal_acceleration"):
            return None
        turn = self.channels.get("yaw_rate", np.zeros(len(self.moving)))
        felt = self._pushed_along() - _GRAVITY * self.car["grade"]
        error = _slope(self.channels["speed"]) - _smooth(felt + self.states["lateral_speed"] * turn)
        return self._masked(error, "speed", "longitudinal_acceleration")

    def yaw_rate_and_wheels(self) -> FloatArray | None:
        """Yaw rate against the difference of the rear wheels' speeds, each less its slip."""
        names = ("wheel_speed_rl", "wheel_speed_rr")
        if not self._has("yaw_rate", *names):
            return None
        right, left = (
            self.car["radius"][i] * self.channels[name] * (1.0 - self.states[f"slip_ratio_{WHEELS[i]}"])
            for i, name in ((3, names[1]), (2, names[0]))
        )
        error = self.channels["yaw_rate"] - (right - left) / float(self.car["track_rear"])
        return self._masked(_smooth(error), "yaw_rate", *names)

    def pressure(self, wheel: str) -> FloatArray | None:
        """Pressure of a wheel brake against the hydraulic unit's."""
        return self._residual(f"brake_pressure_{wheel}", 1.0)
