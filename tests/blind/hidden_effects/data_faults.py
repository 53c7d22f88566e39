"""Faults of loggers, wiring and exports: what each does to the recorded channels."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from hidden_effects.car import WHEELS
from hidden_effects.sensors import CHANNELS, LEVELLED, delayed, first_order

FloatArray = NDArray[np.float64]
Series = dict[str, FloatArray]

_WHEEL_SPEEDS = tuple(f"wheel_speed_{wheel}" for wheel in WHEELS)
_INERTIAL = ("longitudinal_acceleration", "lateral_acceleration", "yaw_rate")


@dataclass(frozen=True)
class Fault:
    """A drawn fault: ``channels`` that it touches, its ``value`` in ``unit``."""

    kind: str
    channels: tuple[str, ...]
    value: float
    unit: str


@dataclass(frozen=True)
class FaultKind:
    """A kind of fault and where it acts: on the signals before they are sampled, or on the samples."""

    name: str
    draw: Callable[[np.random.Generator], Fault]
    before_sampling: Callable[[Series, Fault], Series] | None = None
    after_sampling: Callable[[Series, Fault, np.random.Generator], Series] | None = None


def _pick(random: np.random.Generator, *choices: str) -> str:
    return str(random.choice(choices))


def _changed(
    series: Mapping[str, FloatArray], names: tuple[str, ...], change: Callable[[FloatArray], FloatArray]
) -> Series:
    return {name: change(value) if name in names else value for name, value in series.items()}


def _sign(random: np.random.Generator) -> Fault:
    return Fault("channel_sign", (_pick(random, *_INERTIAL, "steering_wheel_angle"),), -1.0, "1")


def _turned_round(series: Series, fault: Fault, random: np.random.Generator) -> Series:
    return _changed(series, fault.channels, lambda value: -value)


_WRONG_UNITS = (
    ("yaw_rate", 57.29577951308232),
    ("longitudinal_acceleration", 1.0 / 9.80665),
    ("lateral_acceleration", 1.0 / 9.80665),
    ("speed", 3.6),
    ("steering_wheel_angle", 57.29577951308232),
)


def _unit(random: np.random.Generator) -> Fault:
    name, factor = _WRONG_UNITS[int(random.integers(len(_WRONG_UNITS)))]
    return Fault("channel_unit", (name,), factor, "1")


def _scaled(series: Series, fault: Fault, random: np.random.Generator) -> Series:
    return _changed(series, fault.channels, lambda value: fault.value * value)


def _swap(random: np.random.Generator) -> Fault:
    pairs = (("fl", "fr"), ("rl", "rr"), ("fl", "rl"), ("fr", "rr"))
    pair = pairs[int(random.integers(len(pairs)))]
    return Fault("channel_swap", tuple(f"wheel_speed_{wheel}" for wheel in pair), 1.0, "1")


def _swapped(series: Series, fault: Fault, random: np.random.Generator) -> Series:
    one, other = fault.channels
    return series | {one: series[other], other: series[one]}


def _wheel_delay(random: np.random.Generator) -> Fault:
    return Fault("wheel_speed_delay", _WHEEL_SPEEDS, float(random.uniform(0.02, 0.06)), "s")


def _latency(random: np.random.Generator) -> Fault:
    return Fault("can_latency", _INERTIAL, float(random.uniform(0.03, 0.1)), "s")


def _late(series: Series, fault: Fault) -> Series:
    return _changed(series, fault.channels, lambda value: delayed(value, fault.value))


def _clock(random: np.random.Generator) -> Fault:
    return Fault("clock_offset", ("speed",), float(random.uniform(0.4, 1.5)), "s")


def _low_pass(random: np.random.Generator) -> Fault:
    name = _pick(random, "yaw_rate", "longitudinal_acceleration", "lateral_acceleration")
    return Fault("low_pass_channel", (name,), float(random.uniform(0.1, 0.4)), "s")


def _filtered(series: Series, fault: Fault) -> Series:
    return _changed(series, fault.channels, lambda value: first_order(value, fault.value))


def _drops(random: np.random.Generator) -> Fault:
    return Fault("frame_drop_hold", (_pick(random, *_INERTIAL, "speed"),), float(random.uniform(0.15, 0.5)), "1")


def _held_at_random(series: Series, fault: Fault, random: np.random.Generator) -> Series:
    def change(value: FloatArray) -> FloatArray:
        fresh = random.random(len(value)) >= fault.value
        fresh[0] = True
        return value[np.maximum.accumulate(np.where(fresh, np.arange(len(value)), 0))]

    return _changed(series, fault.channels, change)


def _gps(random: np.random.Generator) -> Fault:
    return Fault("gps_hold", ("speed",), float(random.choice([10, 20, 50])), "1")


def _held_regularly(series: Series, fault: Fault, random: np.random.Generator) -> Series:
    period = int(fault.value)
    return _changed(series, fault.channels, lambda value: value[(np.arange(len(value)) // period) * period])


def _wrap(random: np.random.Generator) -> Fault:
    return Fault("counter_wrap", ("speed",), 16.0, "m/s")


def _wrapped(series: Series, fault: Fault, random: np.random.Generator) -> Series:
    return _changed(series, fault.channels, lambda value: np.mod(value, fault.value))


def _command(random: np.random.Generator) -> Fault:
    return Fault("command_not_measurement", tuple(f"brake_pressure_{wheel}" for wheel in WHEELS), 0.06, "s")


def _requested(series: Series, fault: Fault) -> Series:
    """Pressures as requested: what the pedal asks for, ahead of the response, without modulation."""
    ahead = delayed(series["pedal_force"], -0.0) * 3e4
    return series | dict.fromkeys(fault.channels, ahead)


def _navigation(random: np.random.Generator) -> Fault:
    return Fault("accelerometer_levelled", _INERTIAL[:2], 1.0, "1")


def _without_gravity(series: Series, fault: Fault) -> Series:
    return series | {name: series[levelled] for name, levelled in zip(fault.channels, LEVELLED, strict=True)}


FAULTS: tuple[FaultKind, ...] = (
    FaultKind("channel_sign", _sign, after_sampling=_turned_round),
    FaultKind("channel_unit", _unit, after_sampling=_scaled),
    FaultKind("channel_swap", _swap, after_sampling=_swapped),
    FaultKind("wheel_speed_delay", _wheel_delay, before_sampling=_late),
    FaultKind("can_latency", _latency, before_sampling=_late),
    FaultKind("clock_offset", _clock, before_sampling=_late),
    FaultKind("low_pass_channel", _low_pass, before_sampling=_filtered),
    FaultKind("frame_drop_hold", _drops, after_sampling=_held_at_random),
    FaultKind("gps_hold", _gps, after_sampling=_held_regularly),
    FaultKind("counter_wrap", _wrap, after_sampling=_wrapped),
    FaultKind("command_not_measurement", _command, before_sampling=_requested),
)

NOT_DEALT = (FaultKind("accelerometer_levelled", _navigation, before_sampling=_without_gravity),)
"""Hidden on request only: among those that are dealt it would make other cases of every seed."""

BY_NAME = {kind.name: kind for kind in (*FAULTS, *NOT_DEALT)}


def noiseless(fault: Fault | None) -> tuple[str, ...]:
    """Channels that carry no sensor noise because they are no measurements."""
    return fault.channels if fault is not None and fault.kind == "command_not_measurement" else ()


def known_channels() -> tuple[str, ...]:
    """Names that a fault may touch."""
    return tuple(CHANNELS)
