"""Rides of the attitude document's two-wheeler, its filters on them, and the errors that its section 7 tabulates."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cache
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.signal import butter, lfilter

from estimators import create
from estimators.attitude_bank import AttitudeFilter
from estimators.attitude_settings import SENSORS
from vehicle_model.reference.two_wheeler import MILLI_G, SAMPLE_S, Ride, measure, random_ride
from vehicle_model.vehicle_file import VehicleFile, load_vehicle

FloatArray = NDArray[np.float64]

SEEDS = (101, 102, 103, 104, 105, 106)
"""Never used to choose a setting; those came from seeds 1 to 4."""
ONSET_S, JUDGED_S = 30.0, 90.0
DEGREE = float(np.deg2rad(1.0))
DOCUMENT = {"cycle": "document"}
"""The cycle as the document writes it (3.6), on which its acceptance list binds."""
STEP = 5
STEPPED = slice(4, None, STEP)
"""Samples between two steps of the filters; rows in which they step, the first at the 25th sample."""
_LOW_PASS = butter(2, 8.0, fs=1.0 / SAMPLE_S)


@cache
def motorcycle() -> VehicleFile:
    """The document's two-wheeler."""
    return load_vehicle("motorcycle_230kg")


@cache
def numbers() -> dict[str, float]:
    """Its numbers, as an estimator gets them."""
    return motorcycle().numbers()


@cache
def ride(seed: int, sloped: bool, seconds: float = 150.0, lean_scale: float = 1.0, contact: str = "rear") -> Ride:
    """A random ride, kept for the module that asks first and for all others."""
    return random_ride(
        motorcycle(), seed, seconds=seconds, sloped=sloped, lean_scale=lean_scale, contact=contact  # type: ignore[arg-type]
    )  # fmt: skip


def until(end: float, source: Ride, measured: Mapping[str, FloatArray]) -> tuple[Ride, dict[str, FloatArray]]:
    """A ride and what was measured on it up to ``end`` [s]: a filter tells the same there as on the whole ride."""
    rows = slice(int(np.searchsorted(source.time, end)))
    parts = {name: value[rows] for name, value in vars(source).items() if isinstance(value, np.ndarray)}
    return replace(source, **parts), {name: values[rows] for name, values in measured.items()}


def delayed(values: FloatArray) -> FloatArray:
    """Truth through the low-pass of the sensors: what an estimate is compared with (7.2)."""
    b, a = _LOW_PASS
    start = values[0]
    result: FloatArray = lfilter(b, a, values - start) + start
    return result


@dataclass(frozen=True)
class Estimate:
    """Outputs of a filter over a ride at 100 Hz, by name, and truth at the same times."""

    time: FloatArray
    outputs: dict[str, FloatArray]
    truth: dict[str, FloatArray]

    def __getitem__(self, name: str) -> FloatArray:
        return self.outputs[name]

    def after(self, start: float = JUDGED_S, end: float = np.inf) -> slice:
        """Rows of a stretch of time."""
        return slice(*np.searchsorted(self.time, [start, end]))

    def error(self, name: str, start: float = JUDGED_S, end: float = np.inf) -> float:
        """Root mean square error of an angle [degrees]."""
        rows = self.after(start, end)
        return float(np.sqrt(np.mean(np.square(self.outputs[name][rows] - self.truth[name][rows]))) / DEGREE)

    def mean(self, name: str, start: float = JUDGED_S, end: float = np.inf) -> float:
        """Mean of an offset, in mG or degree/s."""
        unit = DEGREE if name.endswith("rate_offset") else MILLI_G
        return float(np.mean(self.outputs[name][self.after(start, end)]) / unit)


def observe(
    source: Ride,
    measured: Mapping[str, FloatArray],
    settings: Mapping[str, Any],
    name: str = "attitude_bank",
    car: Mapping[str, float] | None = None,
) -> Estimate:
    """Run a filter of the registry over a ride."""
    built = create(name, car or numbers(), settings, SAMPLE_S)
    columns = {key: values for key, values in measured.items() if key in built.inputs}
    columns["abs_active"] = np.zeros(len(source.time))
    results = built.replay(columns)[STEPPED]
    found = {signal.name.partition(".")[2]: results[:, k] for k, signal in enumerate(built.outputs)}
    truth = {
        "roll_angle": delayed(source.roll_angle)[STEPPED],
        "pitch_angle": delayed(source.pitch_angle)[STEPPED],
        "elevation_angle": delayed(source.elevation)[STEPPED],
        "road_slope": delayed(source.slope)[STEPPED],
    }
    return Estimate(source.time[STEPPED], found, truth)


def offsets(**values: float) -> dict[str, float]:
    """Offsets of sensors by short names: roll, pitch, yaw in degree/s, x, y, z in mG."""
    axes = {"x": "longitudinal_acceleration", "y": "lateral_acceleration", "z": "vertical_acceleration"}
    return {axes.get(key, f"{key}_rate"): value * (MILLI_G if key in axes else DEGREE) for key, value in values.items()}


def grid(*values_mg: float) -> list[float]:
    """Virtual offsets [m/s^2] from mG."""
    return [value * MILLI_G for value in values_mg]


def noise(y: float, z: float, speed: float, balance: float | None = None) -> dict[str, float]:
    """Measurement noise of the filters, as the document lists it."""
    rows = {
        "measurement_lateral_acceleration": y,
        "measurement_vertical_acceleration": z,
        "measurement_speed": speed,
    }
    return rows if balance is None else rows | {"measurement_roll_balance": balance}


def mean_of(values: Sequence[float]) -> float:
    """Mean over the seeds."""
    return float(np.mean(values))


TUNED = 1
"""Seed of the rides here: these tests are about how the filters are built, not about how well they do."""


def built(settings: dict[str, Any], name: str = "attitude_bank") -> AttitudeFilter:
    found = create(name, numbers(), settings, SAMPLE_S)
    assert isinstance(found, AttitudeFilter)
    return found


def still(seconds: float = 4.0, speed: float = 15.0, **values: Any) -> dict[str, np.ndarray]:
    """Signals of an upright ride straight on without noise."""
    n = round(seconds / SAMPLE_S)
    columns = {name: np.zeros(n) for name in (*SENSORS, "abs_active")}
    columns |= {f"wheel_speed_{wheel}": np.full(n, speed / 0.31) for wheel in ("fl", "fr", "rl", "rr")}
    return columns | values


def ridden(seconds: float = 40.0, sloped: bool = True, **wrong: float) -> dict[str, np.ndarray]:
    """Signals of a random ride."""
    source = ride(TUNED, sloped, seconds)
    columns = measure(source, TUNED, offsets=offsets(**wrong), onset_s=10.0)
    return columns | {"abs_active": np.zeros(len(source.time))}


def replayed(columns: dict[str, np.ndarray], settings: dict[str, Any], name: str = "attitude_bank") -> AttitudeFilter:
    found = built(settings, name)
    found.replay(columns)
    return found


def outputs(filter_: AttitudeFilter, columns: dict[str, np.ndarray]) -> dict[str, np.ndarray]:
    results = filter_.replay(columns)
    return {signal.name.partition(".")[2]: results[:, k] for k, signal in enumerate(filter_.outputs)}
