"""A car of a few lines for tests of the data checks: kinematics, a slip per force, sensors, a logger.

It shares nothing with the product but numbers of its vehicle: planar motion with a first-order yaw answer to
v delta/(L + K v²), side slip of the rear axle's compliance, wheel slip proportional to braking or driving force, body
pitch into the accelerometer; noise, quantisation, a CAN period with jitter and a few lost frames.
"""

import csv
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]

MASS_KG, RADIUS_M, TRACK_M, WHEELBASE_M, TO_FRONT_M = 1296.0, 0.278, 1.46, 2.57, 1.25
BRAKE_FRONT_NM_PER_PA, BRAKE_REAR_NM_PER_PA = 2 * 0.0016250 * 0.4 * 0.1, 2 * 0.0008125 * 0.4 * 0.1
SLIP_STIFFNESS_FRONT_N, SLIP_STIFFNESS_REAR_N = 80e3, 75e3
UNDERSTEER_S2_M = 0.0025
GRAVITY = 9.81
STEP_S = 1e-3

CHANNELS = {
    "wheel_speed_fl": ("rad/s", 0.06, 0.08),
    "wheel_speed_fr": ("rad/s", 0.06, 0.08),
    "wheel_speed_rl": ("rad/s", 0.06, 0.08),
    "wheel_speed_rr": ("rad/s", 0.06, 0.08),
    "longitudinal_acceleration": ("m/s^2", 0.06, 0.01),
    "lateral_acceleration": ("m/s^2", 0.06, 0.01),
    "yaw_rate": ("rad/s", 0.002, 0.0005),
    "speed": ("m/s", 0.03, 0.0),
    "steering_wheel_angle": ("rad", 0.002, 0.0017),
    "brake_pressure_fl": ("Pa", 3e4, 2.5e4),
    "brake_pressure_fr": ("Pa", 3e4, 2.5e4),
    "brake_pressure_rl": ("Pa", 3e4, 2.5e4),
    "brake_pressure_rr": ("Pa", 3e4, 2.5e4),
    "drive_torque_r": ("N m", 5.0, 1.0),
}


@dataclass
class Drive:
    """True signals at 1 ms; ``time`` (n,), ``signals`` name -> (n,)."""

    time: Array
    signals: dict[str, Array] = field(default_factory=dict)


def _smooth_steps(rng: np.random.Generator, time: Array, levels: Array, rise_s: float) -> Array:
    """Levels held for equal times, joined by first-order answers."""
    target = levels[np.minimum((time / (time[-1] + STEP_S) * len(levels)).astype(int), len(levels) - 1)]
    return lag(target, rise_s)


def lag(values: Array, time_constant_s: float) -> Array:
    """First-order lag at 1 ms."""
    out = np.empty_like(values)
    state, gain = values[0], 1.0 - np.exp(-STEP_S / time_constant_s)
    for k, value in enumerate(values):
        state += gain * (value - state)
        out[k] = state
    return out


def drive(kind: str, rng: np.random.Generator, duration_s: float = 9.0) -> Drive:
    """One manoeuvre: ``coast``, ``stop``, ``slalom``, ``turn_brake`` or ``accelerate``."""
    time = np.arange(0.0, duration_s, STEP_S)
    zero = np.zeros_like(time)
    pressure, torque, steer = zero.copy(), zero.copy(), zero.copy()
    if kind in ("stop", "turn_brake"):
        levels = np.array([0.0, *rng.uniform(8e5, 30e5, 4), 0.0])
        pressure = _smooth_steps(rng, time, levels, 0.06)
    if kind == "accelerate":
        torque = _smooth_steps(rng, time, np.array([0.0, 900.0, 300.0, 1100.0, 0.0, 0.0]), 0.15)
        pressure = _smooth_steps(rng, time, np.array([0.0, 0.0, 0.0, 0.0, 15e5, 8e5]), 0.06)
    if kind == "slalom":
        frequency = rng.uniform(0.35, 0.7)
        steer = 0.35 * np.sin(2 * np.pi * frequency * time) * np.clip(time, 0.0, 1.0)
        steer += 0.12 * np.sin(2 * np.pi * 1.3 * time)
    if kind == "turn_brake":
        steer = _smooth_steps(rng, time, np.array([0.0, 0.45, 0.45, -0.35, -0.35, 0.0]), 0.25)
    return _motion(time, pressure, torque, steer, rng.uniform(24.0, 30.0))


def _motion(time: Array, pressure: Array, torque: Array, steer: Array, start_speed: float) -> Drive:
    front = lag(BRAKE_FRONT_NM_PER_PA * pressure / RADIUS_M, 0.02)
    rear = lag(BRAKE_REAR_NM_PER_PA * pressure / RADIUS_M, 0.02)
    drive_force = 0.5 * torque / RADIUS_M
    speed, yaw = np.empty_like(time), np.empty_like(time)
    v, r = start_speed, 0.0
    for k in range(len(time)):
        delta = steer[k] / 16.0
        r += STEP_S / 0.08 * (v * delta / (WHEELBASE_M + UNDERSTEER_S2_M * v * v) - r)
        force = 2.0 * (drive_force[k] - front[k] - rear[k]) - 0.48 * v * v - 0.012 * MASS_KG * GRAVITY
        v = max(v + STEP_S * force / MASS_KG, 0.5)
        speed[k], yaw[k] = v, r
    acceleration = np.gradient(speed, STEP_S)
    lateral_speed = (WHEELBASE_M - TO_FRONT_M) * yaw - 0.0017 * speed * speed * yaw
    pitch = lag(0.004 * acceleration, 0.1)
    road = steer / 16.0
    signals = {
        "speed": speed,
        "yaw_rate": yaw,
        "longitudinal_acceleration": acceleration - yaw * lateral_speed + GRAVITY * pitch,
        "lateral_acceleration": speed * yaw + np.gradient(lateral_speed, STEP_S),
        "steering_wheel_angle": steer,
        "drive_torque_r": torque,
    }
    for wheel, side, axle in (("fl", -1, 0), ("fr", 1, 0), ("rl", -1, 1), ("rr", 1, 1)):
        along = speed + side * 0.5 * TRACK_M * yaw
        if axle == 0:
            along = along * np.cos(road) + (lateral_speed + TO_FRONT_M * yaw) * np.sin(road)
        slip = -front / SLIP_STIFFNESS_FRONT_N if axle == 0 else (drive_force - rear) / SLIP_STIFFNESS_REAR_N
        signals[f"wheel_speed_{wheel}"] = along * (1.0 + slip) / RADIUS_M
        signals[f"brake_pressure_{wheel}"] = pressure
    return Drive(time, signals)


def sensed(driven: Drive, rng: np.random.Generator, *, off: float = 0.0) -> dict[str, Array]:
    """Signals at 1 ms as an imperfect car has them: every scale off by ``off`` (standard deviation), small offsets."""
    read = {}
    for name, (_, noise, _) in CHANNELS.items():
        radius_like = 0.1 if name.startswith(("wheel_speed", "speed")) else 1.0
        read[name] = driven.signals[name] * (1.0 + off * radius_like * rng.standard_normal())
        if not name.startswith(("wheel_speed", "speed", "brake", "drive")):
            read[name] = read[name] + noise * rng.standard_normal()
    return read


def logged(
    driven: Drive,
    signals: dict[str, Array],
    rng: np.random.Generator,
    *,
    period_s: float = 0.01,
    jitter_s: float = 8e-4,
    drop: float = 0.001,
    noise: float = 1.0,
    quiet: tuple[str, ...] = (),
) -> dict[str, tuple[Array, Array]]:
    """(stamps, values) of each channel: one clock, noise with colour in the accelerations, quantised, frames lost."""
    count = int(driven.time[-1] / period_s)
    stamps = (
        np.cumsum(np.full(count, period_s)) - period_s + np.clip(jitter_s * rng.standard_normal(count), -4e-3, 4e-3)
    )
    stamps = np.maximum.accumulate(np.maximum(stamps, 0.0)) + 1e-6 * np.arange(count)
    stamps = stamps[rng.random(count) >= drop]
    channels = {}
    for name, (_, sigma, quantum) in CHANNELS.items():
        values = np.interp(stamps, driven.time, signals[name])
        if name in quiet:
            channels[name] = (stamps, values)
            continue
        error = sigma * noise * rng.standard_normal(len(stamps))
        if name.endswith("acceleration"):
            for k in range(1, len(error)):
                error[k] = 0.7 * error[k - 1] + 0.714 * error[k]
        values = values + error
        if name.startswith("brake_pressure"):
            values = np.maximum(values, 0.0)
        channels[name] = (stamps, np.round(values / quantum) * quantum if quantum else values)
    return channels


def write_csv(path: Path, channels: dict[str, tuple[Array, Array]]) -> Path:
    """One table; all channels must share their stamps."""
    stamps = next(iter(channels.values()))[0]
    with path.open("w", newline="") as file:
        writer = csv.writer(file)
        writer.writerow(["t", *channels])
        rows = zip(stamps, *(values for _, values in channels.values()), strict=True)
        writer.writerows([f"{x:.7g}" if np.isfinite(x) else "" for x in row] for row in rows)
    return path
