"""Kinematic twins: pairs of series that must agree because two groups of channels measure the same motion.

A group is a channel, or the channels that a logger brings together: ``wheel_speed`` (four), ``brake_pressure`` (four),
``steering``. Each twin says how a wrong factor, sign or delay of a group would show in it.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from functools import cache

import numpy as np
from scipy import signal

from model_diagnosis.data.geometry import Geometry
from model_diagnosis.data.samples import BoolArray, FloatArray
from model_diagnosis.data.twin_kinds import (
    AX_DRIVE,
    AX_PRESSURE,
    AX_SPEED,
    AX_WHEELS,
    AY_YAW,
    SIDE_SLIP,
    SPEED_WHEELS,
    WHEELS_PRESSURE,
    YAW_HEADING,
    YAW_STEER,
    YAW_WHEELS,
    TwinKind,
)
from model_diagnosis.manoeuvre import SAMPLE_TIME_S, Manoeuvre
from model_diagnosis.replay.smoothing import noise_of
from signals.wheels import WHEELS

GRAVITY = 9.81
_USUAL_UNDERSTEER_S2_M = 0.002
_REACH_S = 0.25
_SLOW_HZ = 2.0
_WORK_M_S2, _SLIPPING_M_S2 = 0.3, 1.5
"""The second makes an axle slip by 1.5 %: a tenth of it more on one side is 0.02 rad/s of the wheels' difference at
20 m/s, twice the least yaw rate that counts."""

LEAST_SAMPLES = 30
"""Valid samples (0.3 s) below which a level or a spread says nothing."""

_BEYOND_NOISE = 2.0
"""Spread of a twin's side below 2 Hz over the noise of its samples, of which a fifth is below 2 Hz."""

_WORK_REACH_S = 0.5


@dataclass(frozen=True)
class Twin:
    """One kind of twin over all manoeuvres: left and right series, and where both are measured."""

    kind: TwinKind
    left: Sequence[FloatArray]
    right: Sequence[FloatArray]
    valid: Sequence[BoolArray]


def members(group: str, channels: Sequence[str]) -> list[str]:
    """Channels of a group among those of a manoeuvre."""
    if group in ("wheel_speed", "brake_pressure", "drive_torque"):
        found = [name for name in channels if name.startswith(f"{group}_")]
        master = [name for name in ("master_pressure",) if name in channels]
        return found or (master if group == "brake_pressure" else [])
    if group == "steering":
        return [name for name in ("steering_wheel_angle", "road_wheel_angle", "steering_command") if name in channels][
            :1
        ]
    return [group] if group in channels else []


def reached(manoeuvre: Manoeuvre, channel: str) -> BoolArray:
    """(n,) True where a measurement of the channel lies within a quarter second."""
    weight = manoeuvre.weight(channel) > 0.0
    reach = round(_REACH_S / SAMPLE_TIME_S)
    near: BoolArray = np.convolve(weight.astype(float), np.ones(2 * reach + 1), "same") > 0.5
    return near


class Motion:
    """Series of one manoeuvre that twins are made of; None where channels are missing."""

    def __init__(self, manoeuvre: Manoeuvre, geometry: Geometry) -> None:
        self.manoeuvre = manoeuvre
        self.geometry = geometry
        self.channels = manoeuvre.channels

    def rim_speeds(self) -> FloatArray | None:
        """Radius times speed of the four wheels, (n, 4) [m/s]."""
        names = [f"wheel_speed_{w}" for w in WHEELS]
        if not all(name in self.channels for name in names):
            return None
        radii = [self.geometry.radii[w] for w in WHEELS]
        return np.stack([r * self.channels[n] for r, n in zip(radii, names, strict=True)], axis=1)

    def wheels_speed(self) -> FloatArray | None:
        """Mean rim speed of the wheels that the log has [m/s]."""
        rims = [
            self.geometry.radii[w] * self.channels[f"wheel_speed_{w}"]
            for w in WHEELS
            if f"wheel_speed_{w}" in self.channels
        ]
        return np.mean(rims, axis=0) if rims else None

    def pressure_deceleration(self) -> FloatArray | None:
        """Acceleration [m/s²] that the wheel pressures (or the master pressure) should make, negative."""
        force = np.zeros(self.manoeuvre.samples)
        found = False
        for wheel in WHEELS:
            name = f"brake_pressure_{wheel}"
            name = name if name in self.channels else "master_pressure"
            if name in self.channels:
                force += self.geometry.brake_gains[wheel] / self.geometry.radii[wheel] * self.channels[name]
                found = True
        return -force / self.geometry.mass if found else None

    def drive_acceleration(self) -> FloatArray | None:
        """Acceleration [m/s²] that the axles' drive torques should make."""
        names = members("drive_torque", list(self.channels))
        if not names:
            return None
        radius = float(np.mean(list(self.geometry.radii.values())))
        total: FloatArray = np.sum([self.channels[n] for n in names], axis=0)
        return total / radius / self.geometry.mass

    def kinematic_yaw_rate(self, speed: FloatArray) -> FloatArray | None:
        """Yaw rate [rad/s] that the steering angle asks for at this speed, with a usual understeer."""
        names = members("steering", list(self.channels))
        if not names:
            return None
        ratio = self.geometry.steering_ratio if names[0] == "steering_wheel_angle" else 1.0
        return speed * self.channels[names[0]] / ratio / (self.geometry.wheelbase + _USUAL_UNDERSTEER_S2_M * speed**2)

    def wheels_yaw_rate(self) -> FloatArray | None:
        """Yaw rate [rad/s] of the rear wheels' difference, or of the front wheels'."""
        for axle, track in (("r", self.geometry.track_rear), ("f", self.geometry.track_front)):
            left, right = f"{axle}l", f"{axle}r"
            if f"wheel_speed_{left}" in self.channels and f"wheel_speed_{right}" in self.channels:
                rims = [self.geometry.radii[w] * self.channels[f"wheel_speed_{w}"] for w in (left, right)]
                return (rims[1] - rims[0]) / track
        return None


def slope(values: FloatArray) -> FloatArray:
    """Time derivative of a series on the common time base, of a local line over 90 ms."""
    if len(values) < 9:
        return np.gradient(values, SAMPLE_TIME_S)
    derivative: FloatArray = signal.savgol_filter(values, 9, 1, deriv=1, delta=SAMPLE_TIME_S)
    return derivative


def _sides(motion: Motion) -> list[tuple[TwinKind, FloatArray, FloatArray]]:
    """Every twin that this manoeuvre's channels allow: kind, left, right."""
    channels = motion.channels
    wheels, speed = motion.wheels_speed(), channels.get("speed")
    ax, ay, yaw = (channels.get(n) for n in ("longitudinal_acceleration", "lateral_acceleration", "yaw_rate"))
    found: list[tuple[TwinKind, FloatArray | None, FloatArray | None]] = [
        (SPEED_WHEELS, speed, wheels),
        (AX_SPEED, ax, None if speed is None else slope(speed)),
        (AX_WHEELS, ax, None if wheels is None else slope(wheels)),
        (YAW_WHEELS, yaw, motion.wheels_yaw_rate()),
        (AX_PRESSURE, ax, motion.pressure_deceleration()),
        (WHEELS_PRESSURE, None if wheels is None else slope(wheels), motion.pressure_deceleration()),
        (AX_DRIVE, ax, motion.drive_acceleration()),
    ]
    if yaw is not None:
        pace = wheels if speed is None else speed
        paced = "wheel_speed" if speed is None else "speed"
        found.append((_paced(AY_YAW, paced), ay, None if pace is None else pace * yaw))
        found.append((_paced(YAW_STEER, paced), yaw, None if pace is None else motion.kinematic_yaw_rate(pace)))
        found.append((YAW_HEADING, yaw, None if "yaw_angle" not in channels else slope(channels["yaw_angle"])))
    if speed is not None and "lateral_speed" in channels:
        ratio = channels["lateral_speed"] / np.maximum(np.abs(speed), 1.0)
        found.append((SIDE_SLIP, channels.get("side_slip_angle"), ratio))
    return [(kind, left, right) for kind, left, right in found if left is not None and right is not None]


def moves(twin: Twin, course: Callable[[FloatArray], FloatArray] | None = None) -> bool:
    """True where in some manoeuvre both sides change by more than their noise, and one by what a driver asks for.

    What counts as change is a series' ``course``, without one what is below 2 Hz. Straight on, at a steady speed or off
    the pedal a chance correlation is as good as any. The other side may be in another unit.
    """
    for left, right, valid in zip(twin.left, twin.right, twin.valid, strict=True):
        spreads = [moved_by(side, valid, course) for side in (left, right)]
        if min(spreads) > 0.0 and max(spreads) >= twin.kind.least:
            return True
    return False


def moved_by(values: FloatArray, valid: BoolArray, course: Callable[[FloatArray], FloatArray] | None = None) -> float:
    """Spread of the slow changes of a series (n,); 0 where it is no more than noise makes."""
    if valid.sum() <= LEAST_SAMPLES:
        return 0.0
    spread = float(np.std((course or slow)(values)[valid]))
    return spread if spread > _BEYOND_NOISE * noise_of(values) else 0.0


def _paced(kind: TwinKind, group: str) -> TwinKind:
    """The same twin with its speed taken from another group."""
    return replace(kind, exponents={group if g == "speed" else g: power for g, power in kind.exponents.items()})


def twins_of(manoeuvres: Sequence[Manoeuvre], geometry: Geometry) -> list[Twin]:
    """Every twin that the channels allow, over all manoeuvres that have it."""
    sides: dict[str, tuple[TwinKind, list[FloatArray], list[FloatArray], list[BoolArray]]] = {}
    for manoeuvre in (one.on_one_raster() for one in manoeuvres):
        motion = Motion(manoeuvre, geometry)
        braking, driving = motion.pressure_deceleration(), motion.drive_acceleration()
        for kind, left, right in _sides(motion):
            entry = sides.setdefault(kind.name, (kind, [], [], []))
            entry[1].append(left)
            entry[2].append(right)
            valid = _valid(manoeuvre, kind) & (_at_work(right) if kind.driven else True)
            if kind.unbraked and braking is not None:
                valid = valid & ~_at_work(braking)
            for commanded in (braking, driving) if kind.gentle else ():
                if commanded is not None:
                    valid = valid & ~_near(np.abs(slow(commanded)) > _SLIPPING_M_S2)
            entry[3].append(valid)
    return [Twin(*entry) for entry in sides.values()]


def _at_work(acceleration: FloatArray) -> BoolArray:
    """(n,) True within half a second of a commanded acceleration that is more than noise."""
    return _near(np.abs(slow(acceleration)) > max(_WORK_M_S2, 0.1 * float(np.max(np.abs(acceleration)))))


def _near(marked: BoolArray) -> BoolArray:
    """(n,) True within half a second of what is marked."""
    reach = round(_WORK_REACH_S / SAMPLE_TIME_S)
    near: BoolArray = np.convolve(marked.astype(float), np.ones(2 * reach + 1), "same") > 0.5
    return near


def _valid(manoeuvre: Manoeuvre, kind: TwinKind) -> BoolArray:
    valid = np.ones(manoeuvre.samples, dtype=bool)
    for group in kind.exponents:
        for channel in members(group, list(manoeuvre.channels)):
            valid &= reached(manoeuvre, channel)
    return valid


def slow(values: FloatArray, cut_off_hz: float = _SLOW_HZ) -> FloatArray:
    """Low-passed without a shift."""
    return _filtered(values, "lowpass", cut_off_hz)


def band(values: FloatArray, low_hz: float, high_hz: float) -> FloatArray:
    """Band-passed without a shift; short series have their mean removed only."""
    return _filtered(values - np.mean(values), "bandpass", (low_hz, high_hz))


@cache
def _sections(kind: str, edges: float | tuple[float, float]) -> FloatArray:
    sections: FloatArray = signal.butter(2, edges, kind, fs=1.0 / SAMPLE_TIME_S, output="sos")
    return sections


def _filtered(values: FloatArray, kind: str, edges: float | tuple[float, float]) -> FloatArray:
    if len(values) < 30:
        return values
    result: FloatArray = signal.sosfiltfilt(_sections(kind, edges), values, padlen=min(150, len(values) - 1))
    return result
