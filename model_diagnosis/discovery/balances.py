"""Balances of a replayed car with the variables that an unknown term may depend on.

The error of a balance is what the model lacks; its own acceleration is no variable: its noise would stand on
both sides.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray
from scipy.signal import savgol_filter

from model_diagnosis.discovery.quantities import Balance, Force, Series, Variable, smoothed
from model_diagnosis.manoeuvre import SAMPLE_TIME_S
from model_diagnosis.replay.equations import errors_of
from model_diagnosis.replay.replay import Replay
from signals.wheels import WHEELS

FloatArray = NDArray[np.float64]

LONGITUDINAL, LATERAL, YAW, WHEEL = "longitudinal force", "lateral force", "yaw moment", "wheel torque"
_FEWEST_SAMPLES = 300
_RATE_WINDOW = 5
_CAR_AT_A_WHEEL = ("speed", "lateral_acceleration", "longitudinal_acceleration", "distance")
"""Variables of the car that a wheel's torque may depend on; its rows are four times those of the car."""


@dataclass(frozen=True)
class Problem:
    """A balance with its variables."""

    balance: Balance
    variables: dict[str, Variable]

    def part(self, drives: Sequence[int]) -> "Problem":
        """The same on some of the drives."""

        def of(series: Series) -> Series:
            return tuple(series[m] for m in drives)

        one = self.balance
        balance = replace(
            one,
            error=of(one.error),
            weights=of(one.weights),
            forced={name: of(series) for name, series in one.forced.items()},
            forces={name: replace(force, values=of(force.values)) for name, force in one.forces.items()},
        )
        variables = {name: replace(variable, values=of(variable.values)) for name, variable in self.variables.items()}
        return Problem(balance, variables)


@dataclass(frozen=True)
class _Drive:
    """One manoeuvre: errors of its balances, states of the replay and measured channels."""

    errors: dict[str, FloatArray]
    states: dict[str, FloatArray]
    channels: dict[str, FloatArray]
    car: np.void

    def wheels(self, name: str) -> FloatArray:
        """State of the four wheels, (n, 4)."""
        return np.stack([self.states[f"{name}_{wheel}"] for wheel in WHEELS], axis=1)

    @property
    def samples(self) -> int:
        """Number of samples."""
        return len(self.states["speed"])

    def channel(self, name: str) -> FloatArray:
        """A measured channel, zeros where the log lacks it."""
        return self.channels.get(name, np.zeros(self.samples))


def problems_of(replay: Replay, theta: FloatArray, equations: Sequence[str] | None = None) -> list[Problem]:
    """Balances that the data allow, in the order of ``equations`` (the most violated first) or of this module.

    Parameters
    ----------
    theta : (p,) deviations at which the car is replayed
    """
    drives = [_drive(replay, theta, m) for m in range(len(replay.manoeuvres))]
    wanted = [LONGITUDINAL, WHEEL, LATERAL, YAW]
    if equations is not None:
        named = [WHEEL if name.startswith(WHEEL) else name for name in equations]
        wanted = [name for name in dict.fromkeys(named) if name in wanted]
    makers: dict[str, Callable[[list[_Drive]], Problem | None]] = {
        LONGITUDINAL: _longitudinal,
        WHEEL: _wheels,
        LATERAL: _lateral,
        YAW: _yaw,
    }
    problems = [makers[name](drives) for name in wanted]
    return [problem for problem in problems if problem is not None]


def variables_of(replay: Replay, theta: FloatArray) -> dict[str, Variable]:
    """Every variable that a term may depend on, of all manoeuvres of a replay at deviations theta, without noise."""
    drives = [_drive(replay, theta, m) for m in range(len(replay.manoeuvres))]
    wheels = _wheel_variables(drives, [name for name, *_ in _WHEEL_VARIABLES])
    return _present([smoothed(one) for one in (*_car_variables(drives, ""), *wheels)])


def _drive(replay: Replay, theta: FloatArray, m: int) -> _Drive:
    channels = dict(replay.manoeuvres[m].on_one_raster().channels)
    return _Drive(errors_of(replay, theta, m), replay.states(theta, m), channels, replay.car_at(theta))


def _error(drives: Sequence[_Drive], name: str) -> tuple[list[_Drive], Series, Series]:
    """Drives that have the balance, its error with zeros where it does not count, and its weights."""
    having = [drive for drive in drives if name in drive.errors]
    raw = [drive.errors[name] for drive in having]
    weights = tuple(np.isfinite(one).astype(np.float64) for one in raw)
    return having, tuple(np.nan_to_num(one, nan=0.0) for one in raw), weights


def _enough(weights: Series) -> bool:
    return sum(float(one.sum()) for one in weights) >= _FEWEST_SAMPLES


def _present(variables: Sequence[Variable]) -> dict[str, Variable]:
    """Variables that vary."""
    return {one.name: one for one in variables if one.span[1] > one.span[0]}


def _turned(speeds: FloatArray) -> FloatArray:
    turned: FloatArray = np.cumsum(speeds, axis=0) * SAMPLE_TIME_S
    return turned


def _car_variables(drives: Sequence[_Drive], without: str) -> list[Variable]:
    def series(of: Callable[[_Drive], FloatArray]) -> Series:
        return tuple(of(drive) for drive in drives)

    variables = [
        Variable("speed", "m/s", series(lambda one: one.states["speed"])),
        Variable("yaw_rate", "rad/s", series(lambda one: one.channel("yaw_rate"))),
        Variable("lateral_acceleration", "m/s^2", series(lambda one: one.channel("lateral_acceleration"))),
        Variable("longitudinal_acceleration", "m/s^2", series(lambda one: one.channel("longitudinal_acceleration"))),
        Variable("steering_wheel_angle", "rad", series(lambda one: one.channel("steering_wheel_angle"))),
        Variable("distance", "m", series(lambda one: _turned(one.states["speed"])), cumulative=True),
        Variable("time", "s", series(lambda one: _turned(np.ones(one.samples))), cumulative=True),
    ]
    return [variable for variable in variables if variable.name != without]


def _pressure(drive: _Drive) -> FloatArray:
    return np.stack([drive.channel(f"brake_pressure_{wheel}") for wheel in WHEELS], axis=1)


def _spins(drive: _Drive) -> FloatArray:
    return np.stack([drive.channel(f"wheel_speed_{wheel}") for wheel in WHEELS], axis=1)


def _pressure_rate(drive: _Drive) -> FloatArray:
    """Change of the wheel pressures [Pa/s] by a straight line over 50 ms."""
    rate: FloatArray = savgol_filter(_pressure(drive), _RATE_WINDOW, 1, deriv=1, delta=SAMPLE_TIME_S, axis=0)
    return rate


_WHEEL_VARIABLES: tuple[tuple[str, str, bool, Callable[[_Drive], FloatArray]], ...] = (
    ("brake_pressure", "Pa", False, _pressure),
    ("brake_disc_temperature", "degC", False, lambda one: one.wheels("brake_disc_temperature")),
    ("vertical_load", "N", False, lambda one: one.wheels("vertical_load")),
    ("slip_angle", "rad", False, lambda one: one.wheels("slip_angle")),
    ("slip_ratio", "1", False, lambda one: one.wheels("slip_ratio")),
    ("wheel_angle", "rad", True, lambda one: _turned(_spins(one))),
    ("brake_pressure_rate", "Pa/s", False, _pressure_rate),
)


def _wheel_variables(drives: Sequence[_Drive], names: Sequence[str]) -> list[Variable]:
    return [
        Variable(name, unit, tuple(of(drive) for drive in drives), cumulative)
        for name, unit, cumulative, of in _WHEEL_VARIABLES
        if name in names
    ]


def _longitudinal(drives: Sequence[_Drive]) -> Problem | None:
    having, error, weights = _error(drives, LONGITUDINAL)
    if not _enough(weights):
        return None
    brakes = tuple(-one.wheels("brake_torque") / one.car["radius"] for one in having)
    steered = tuple(
        -(one.wheels("lateral_force") * np.sin(one.wheels("road_wheel_angle"))).sum(axis=1) for one in having
    )
    forced = {
        "mass": tuple(one.channel("longitudinal_acceleration") for one in having),
        "drag": tuple(one.states["speed"] ** 2 for one in having),
        "rolling": tuple(np.ones(one.samples) for one in having),
        "brakes": tuple(one.sum(axis=1) for one in brakes),
        "drive": tuple((one.wheels("drive_torque") / one.car["radius"]).sum(axis=1) for one in having),
        "steered": steered,
    }
    balance = Balance(
        LONGITUDINAL,
        "N",
        error,
        weights,
        forced,
        {"brake force": Force(brakes, "brake_torque_factor")},
        "body_longitudinal_force",
    )
    names = ("brake_pressure", "brake_disc_temperature", "wheel_angle", "brake_pressure_rate")
    car = _car_variables(having, "longitudinal_acceleration")
    return Problem(balance, _present([*car, *_wheel_variables(having, names)]))


def _wheels(drives: Sequence[_Drive]) -> Problem | None:
    """The four wheels behind each other: one term with the same coefficient for all."""
    parts = [_error(drives, f"{WHEEL} {wheel}") for wheel in WHEELS]
    if not any(_enough(weights) for _, _, weights in parts):
        return None
    rows = [(drive, i) for i, (having, _, _) in enumerate(parts) for drive in having]

    def series(of: Callable[[_Drive, int], FloatArray]) -> Series:
        return tuple(of(drive, i) for drive, i in rows)

    def torque(name: str, sign: float, drive: _Drive, i: int) -> FloatArray:
        return sign * drive.states[f"{name}_{WHEELS[i]}"]

    def tyre(drive: _Drive, i: int) -> FloatArray:
        return -drive.states[f"longitudinal_force_{WHEELS[i]}"] * float(drive.car["radius"][i])

    def spin_up(drive: _Drive, i: int) -> FloatArray:
        return np.gradient(drive.channel(f"wheel_speed_{WHEELS[i]}"), SAMPLE_TIME_S)

    brake = series(lambda drive, i: torque("brake_torque", -1.0, drive, i))
    forced = {
        "inertia": series(spin_up),
        "brakes": brake,
        "drive": series(lambda drive, i: torque("drive_torque", 1.0, drive, i)),
        "tyre": series(tyre),
        "rolling": series(lambda drive, i: torque("vertical_load", 1.0, drive, i)),
    }
    balance = Balance(
        WHEEL,
        "N m",
        tuple(one for _, error, _ in parts for one in error),
        tuple(one for _, _, weights in parts for one in weights),
        forced,
        {
            "brake torque": Force(brake, "brake_torque_factor"),
            "tyre force": Force(series(tyre), "tyre_friction_factor"),
        },
        "drive_torque",
    )
    own = [
        Variable(name, unit, tuple(of(drive)[:, i] for drive, i in rows), cumulative)
        for name, unit, cumulative, of in _WHEEL_VARIABLES
        if name not in ("slip_angle",)
    ]
    car = [one for one in _car_variables([drive for drive, _ in rows], "") if one.name in _CAR_AT_A_WHEEL]
    return Problem(balance, _present([*car, *own]))


def _lateral(drives: Sequence[_Drive]) -> Problem | None:
    having, error, weights = _error(drives, LATERAL)
    if not _enough(weights):
        return None
    side = tuple(one.wheels("lateral_force") for one in having)
    forced = {
        "mass": tuple(one.channel("lateral_acceleration") for one in having),
        "front": tuple(one[:, :2].sum(axis=1) for one in side),
        "rear": tuple(one[:, 2:].sum(axis=1) for one in side),
        "offset": tuple(np.ones(one.samples) for one in having),
    }
    balance = Balance(LATERAL, "N", error, weights, forced, {}, "body_lateral_force")
    car = _car_variables(having, "lateral_acceleration")
    return Problem(balance, _present([*car, *_wheel_variables(having, ("vertical_load", "slip_angle"))]))


def _yaw(drives: Sequence[_Drive]) -> Problem | None:
    having, error, weights = _error(drives, YAW)
    if not _enough(weights):
        return None
    side = tuple(one.wheels("lateral_force") for one in having)
    forced = {
        "inertia": tuple(one.states["yaw_acceleration"] for one in having),
        "front": tuple(one[:, :2].sum(axis=1) for one in side),
        "rear": tuple(one[:, 2:].sum(axis=1) for one in side),
        "offset": tuple(np.ones(one.samples) for one in having),
    }
    balance = Balance(YAW, "N m", error, weights, forced, {}, "yaw_moment")
    return Problem(
        balance, _present([*_car_variables(having, ""), *_wheel_variables(having, ("vertical_load", "slip_angle"))])
    )
