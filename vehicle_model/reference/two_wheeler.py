"""Reference rides of a two-wheeler for its attitude filters (attitude document, 7.1).

ride = random_ride(load_vehicle("motorcycle_230kg"), seed=3, sloped=True)
ride.roll_angle             # truth at 500 Hz
measure(ride, seed=3, offsets={"longitudinal_acceleration": 100 * MILLI_G}, onset_s=30.0)

Lean angle, speed and slope are smooth random profiles. The yaw rate follows from the balance of the roll moment, the
elevation angle from the springs under the wheel loads. What an accelerometer feels is the second derivative of its
place in the world, by quintic splines. Nothing here is shared with the estimators.
"""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any, Literal

import numpy as np
from numpy.typing import NDArray
from scipy.interpolate import make_interp_spline

from signals.errors import InputError
from vehicle_model.reference.two_wheeler_step import (
    GRAVITY_M_S2,
    P_ELEVATION,
    P_PITCH,
    P_ROLL,
    P_SPEED,
    PARAMETER_RECORD,
    ride_along,
    solve_yaw,
    springs,
)
from vehicle_model.vehicle_file import VehicleFile

FloatArray = NDArray[np.float64]

SAMPLE_S = 0.002
STRAIGHT_S = 10.0
"""Straight ahead at the start of every ride."""
MILLI_G = 9.80665e-3
"""m/s^2 in 1 mG."""
_TYRE_POLE_HZ = 5.0
"""The tyres' springs follow the loads no faster; without them strokes would act on the loads that make them at once."""
_ROUNDS = 6
"""Repetitions of ride and springs, each with the elevation angle of the last."""


@dataclass(frozen=True)
class Profiles:
    """Lean angle [rad], speed along the road [m/s], slope [rad, positive downhill], each of shape (n,) at 500 Hz."""

    lean: FloatArray
    speed: FloatArray
    slope: FloatArray


@dataclass(frozen=True)
class Ride:
    """Truth of a ride at 500 Hz; arrays of shape (n,), those of three axes (n, 3).

    Attributes
    ----------
    rates, rate_rises, specific_force
        Body axes x forward, y left, z up [rad/s], [rad/s^2], [m/s^2].
    model_force
        Specific force by the mechanics of the rigid body instead of the differentiated places, to compare.
    wheel_speed
        Circumferential speed of the wheel that carries the constraint [m/s].
    loads : shape (n, 2)
        Front and rear wheel [N].
    """

    time: FloatArray
    roll_angle: FloatArray
    pitch_angle: FloatArray
    yaw_angle: FloatArray
    speed: FloatArray
    elevation: FloatArray
    slope: FloatArray
    rates: FloatArray
    rate_rises: FloatArray
    specific_force: FloatArray
    model_force: FloatArray
    wheel_speed: FloatArray
    loads: FloatArray
    wheel_radius: float


def _record(vehicle: VehicleFile, contact: Literal["rear", "front"]) -> NDArray[np.void]:
    given = vehicle.two_wheeler
    rows: NDArray[np.void] = np.zeros(1, PARAMETER_RECORD)
    p = rows[0]

    def number(name: str) -> float:
        value = getattr(given, name)
        if value is None:
            raise InputError(
                f"two_wheeler.{name}: missing in {vehicle.name}",
                mend="give the section two_wheeler, as in vehicles/motorcycle_230kg.yaml",
            )
        return float(value)

    p["to_rear"], p["to_front"] = number("sensor_to_rear_axle"), number("sensor_to_front_axle")
    p["base"] = p["to_rear"] if contact == "rear" else -p["to_front"]
    p["height"], p["crown"] = number("sensor_height"), number("crown_radius")
    p["mass"], p["mass_x"], p["mass_z"] = number("sprung_mass"), number("mass_x"), number("mass_z")
    product = number("inertia_product")
    p["inertia"] = np.diag([number(f"{axis}_inertia") for axis in ("roll", "pitch", "yaw")])
    p["inertia"][0, 2] = p["inertia"][2, 0] = product
    p["caster"], p["arm"], p["lever"] = number("caster_angle"), number("arm_angle"), number("lever_ratio")
    for place, axle in enumerate(("front", "rear")):
        p["stiffness"][place], p["damping"][place] = number(f"spring_rate_{axle}"), number(f"damping_{axle}")
    weight = p["mass"] * GRAVITY_M_S2
    front = weight * (p["to_rear"] + p["mass_x"]) / (p["to_rear"] + p["to_front"])
    rest = front * np.cos(p["caster"]), (weight - front) * np.cos(p["arm"]) * p["lever"]
    for place, axle in enumerate(("front", "rear")):
        chosen = getattr(given, f"preload_{axle}")
        p["preload"][place] = rest[place] if chosen is None else chosen
    p["static_elevation"] = number("static_elevation")
    return rows


def random_profiles(seed: int, *, seconds: float = 150.0, sloped: bool = False, lean_scale: float = 1.0) -> Profiles:
    """Random turns of 12 to 38 degrees to both sides, speeds of 11 to 24 m/s, slopes within 6 %.

    Parameters
    ----------
    lean_scale : float
        Multiplies the lean angle; 0 rides straight on.
    """
    random = np.random.default_rng(seed)
    time = _samples(round(seconds / SAMPLE_S) // 2 * 2 + 1)
    now, at = 0.0, STRAIGHT_S
    lean: FloatArray = np.zeros(len(time))
    side = 1.0 if random.random() < 0.5 else -1.0
    while at < seconds:
        target = side * np.deg2rad(random.uniform(12.0, 38.0))
        # the steepest point of the step is 2.1875 of its mean
        takes = max(2.1875 * abs(target - now) / np.deg2rad(random.uniform(40.0, 70.0)), 0.8)
        lean += (target - now) * _smooth_step((time - at) / takes)
        at += takes + random.uniform(1.0, 3.0)
        now, side = target, -side
    pace, at = random.uniform(13.0, 20.0), 3.0
    speed: FloatArray = np.full(len(time), pace)
    while at < seconds:
        target = random.uniform(11.0, 24.0)
        takes = max(2.1875 * abs(target - pace) / random.uniform(1.0, 3.5), 1.0)
        speed += (target - pace) * _smooth_step((time - at) / takes)
        at += takes + random.uniform(0.5, 3.0)
        pace = target
    at, now = 5.0, 0.0
    slope: FloatArray = np.zeros(len(time))
    while sloped and at < seconds:
        target, takes = random.uniform(-0.06, 0.06), random.uniform(4.0, 8.0)
        slope += (target - now) * _smooth_step((time - at) / takes)
        at += takes + random.uniform(1.0, 4.0)
        now = target
    return Profiles(lean_scale * lean, speed, slope)


def _samples(n: int) -> FloatArray:
    """Times of n samples [s]."""
    return SAMPLE_S * np.arange(n, dtype=np.float64)


def _smooth_step(x: FloatArray) -> FloatArray:
    """From 0 to 1 with three continuous derivatives."""
    t = np.clip(x, 0.0, 1.0)
    result: FloatArray = t**4 * (35.0 - 84.0 * t + 70.0 * t**2 - 20.0 * t**3)
    return result


def random_ride(
    vehicle: VehicleFile,
    seed: int,
    *,
    seconds: float = 150.0,
    sloped: bool = False,
    lean_scale: float = 1.0,
    contact: Literal["rear", "front"] = "rear",
    drag_area: float = 0.0,
) -> Ride:
    """Ride with random profiles; on a flat road the body does not pitch (embodiment 1), on slopes its springs work.

    Parameters
    ----------
    contact
        Wheel whose contact point does not slide sideways, and whose speed is measured. With the front one the last
        half second settles.
    drag_area : float
        c_d A of a drag at the mass centre [m^2].

    Raises
    ------
    InputError
        If the vehicle file lacks a number of its section ``two_wheeler``.
    """
    profiles = random_profiles(seed, seconds=seconds, sloped=sloped, lean_scale=lean_scale)
    return ride(vehicle, profiles, suspended=sloped, contact=contact, drag_area=drag_area)


def ride(
    vehicle: VehicleFile,
    profiles: Profiles,
    *,
    suspended: bool,
    contact: Literal["rear", "front"] = "rear",
    drag_area: float = 0.0,
) -> Ride:
    """Ride along given profiles; arguments as of :func:`random_ride`."""
    rows = _record(vehicle, contact)
    rows[0]["drag"] = 0.5 * vehicle.aerodynamics.air_density * drag_area
    time = _samples(len(profiles.lean))
    table = np.zeros((len(time), 4, 3))
    table[:, P_ROLL], table[:, P_SPEED] = _derived(time, profiles.lean, profiles.speed)
    results = np.zeros((len(time), 14))
    elevation = np.zeros(len(time))
    yaw = np.zeros((len(time), 2))
    for _ in range(_ROUNDS if suspended else 1):
        pitch = pitch_on(profiles.slope, elevation, profiles.lean)
        table[:, P_ELEVATION], table[:, P_PITCH] = _derived(time, elevation, pitch)
        coarse = np.zeros((len(time) + 1) // 2)
        solve_yaw(rows, table, SAMPLE_S, coarse, contact == "front")
        spline = make_interp_spline(time[::2], coarse, k=5)
        yaw[:, 0], yaw[:, 1] = spline(time), spline(time, 1)
        ride_along(rows, table, yaw, results)
        if suspended:
            springs(rows, results, SAMPLE_S, 2.0 * np.pi * _TYRE_POLE_HZ, elevation)
    return _told(rows[0], time, table, profiles, spline, results, vehicle, contact)


def _derived(time: FloatArray, *values: FloatArray) -> list[FloatArray]:
    """Value, first and second derivative of a quintic spline through each of the values (n,), shape (n, 3) each."""
    found = [np.column_stack([one, np.zeros((len(one), 2))]) for one in values]
    moving = [k for k, one in enumerate(values) if np.ptp(one)]
    if moving:
        # one spline of all: its matrix is factored once
        spline = make_interp_spline(time, np.column_stack([values[k] for k in moving]), k=5)
        first, second = spline(time, 1), spline(time, 2)
        for column, k in enumerate(moving):
            found[k][:, 1], found[k][:, 2] = first[:, column], second[:, column]
    return found


def pitch_on(slope: FloatArray, elevation: FloatArray, lean: FloatArray) -> FloatArray:
    """Pitch angle of a body that leans on a slope [rad]: its road axis points as far down as the slope."""
    a, b = np.cos(elevation), np.cos(lean) * np.sin(elevation)
    result: FloatArray = np.arcsin(np.sin(slope) / np.hypot(a, b)) + np.arctan2(b, a)
    return result


def rotation(roll: FloatArray, pitch: FloatArray, yaw: FloatArray) -> FloatArray:
    """From body to world, z-y-x, shape (n, 3, 3)."""
    (sr, cr), (sp, cp), (sy, cy) = ((np.sin(angle), np.cos(angle)) for angle in (roll, pitch, yaw))
    rows = [
        [cy * cp, cy * sp * sr - sy * cr, cy * sp * cr + sy * sr],
        [sy * cp, sy * sp * sr + cy * cr, sy * sp * cr - cy * sr],
        [-sp, cp * sr, cp * cr],
    ]
    return np.moveaxis(np.array(rows), 2, 0)


def _told(
    p: np.void,
    time: FloatArray,
    table: FloatArray,
    profiles: Profiles,
    yaw_rate: Any,
    results: FloatArray,
    vehicle: VehicleFile,
    contact: str,
) -> Ride:
    roll, pitch, zeta = table[:, P_ROLL, 0], table[:, P_PITCH, 0], table[:, P_ELEVATION, 0]
    yaw = yaw_rate.antiderivative()(time)
    turned = rotation(roll, pitch, yaw)
    along = profiles.speed[:, None] * np.column_stack([np.cos(zeta), np.zeros(len(time)), np.sin(zeta)])
    arm = np.column_stack(
        [
            np.full(len(time), p["base"]),
            p["crown"] * np.sin(roll),
            p["height"] - p["crown"] * (1.0 - np.cos(roll)),
        ]
    )
    velocity = make_interp_spline(time, np.einsum("nij,nj->ni", turned, along), k=5)
    place = velocity.antiderivative()(time) + np.einsum("nij,nj->ni", turned, arm)
    felt = make_interp_spline(time, place, k=5)(time, 2)
    felt[:, 2] += GRAVITY_M_S2
    wheel = vehicle.wheels.rl if contact == "rear" else vehicle.wheels.fl
    return Ride(
        time=time,
        roll_angle=roll,
        pitch_angle=pitch,
        yaw_angle=yaw,
        speed=profiles.speed * np.cos(zeta),
        elevation=zeta,
        slope=profiles.slope,
        rates=results[:, 0:3].copy(),
        rate_rises=results[:, 3:6].copy(),
        specific_force=np.einsum("nji,nj->ni", turned, felt),
        model_force=results[:, 6:9].copy(),
        wheel_speed=profiles.speed / (1.0 - p["crown"] / wheel.radius * (1.0 - np.cos(roll))),
        loads=results[:, 12:14].copy(),
        wheel_radius=wheel.radius,
    )


SENSORS = (
    "roll_rate",
    "pitch_rate",
    "yaw_rate",
    "longitudinal_acceleration",
    "lateral_acceleration",
    "vertical_acceleration",
)


@dataclass(frozen=True)
class Noise:
    """Standard deviation of white noise at 500 Hz (7.1) [rad/s], [m/s^2], [m/s]."""

    gyroscope: float = np.deg2rad(0.1)
    accelerometer: float = 0.25
    speed: float = 0.03


def measure(
    source: Ride,
    seed: int,
    *,
    offsets: Mapping[str, float] | None = None,
    onset_s: float = 30.0,
    noise: Noise | None = None,
) -> dict[str, FloatArray]:
    """What the sensors of a ride report, by catalogue name, at 500 Hz.

    Parameters
    ----------
    offsets : mapping
        Sensor to the offset [rad/s or m/s^2] that comes on at ``onset_s``.
    noise : Noise, optional
        By default that of 7.1.

    Raises
    ------
    InputError
        If there is no sensor of a name.
    """
    level = noise or Noise()
    random = np.random.default_rng([seed, 1])
    columns = dict(zip(SENSORS, np.column_stack([source.rates, source.specific_force]).T, strict=True))
    # the bus reports the z channel without g
    columns["vertical_acceleration"] = columns["vertical_acceleration"] - GRAVITY_M_S2
    for name in SENSORS:
        spread = level.gyroscope if name.endswith("rate") else level.accelerometer
        columns[name] = columns[name] + random.normal(0.0, spread, len(source.time))
    for name, value in (offsets or {}).items():
        if name not in SENSORS:
            raise InputError(f"{name}: no such sensor", allowed=", ".join(SENSORS))
        columns[name] = columns[name] + value * (source.time >= onset_s)
    turning = (source.wheel_speed + random.normal(0.0, level.speed, len(source.time))) / source.wheel_radius
    return columns | {f"wheel_speed_{wheel}": turning for wheel in ("fl", "fr", "rl", "rr")}
