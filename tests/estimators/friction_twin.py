"""A small single-track car of its own for the tests: friction document 2.4 and 2.5, car of Table 8.

It shares no code with the estimators: exact quasi-static loads (drag and rolling resistance in the pitch moment), set-
valued brakes, twenty semi-implicit steps per millisecond, either the reduced curve or the Magic Formula of Table 2.
"""

import math
from dataclasses import dataclass, fields

import numpy as np
from numba import njit
from numpy.typing import NDArray

FloatArray = NDArray[np.float64]

MASS, GRAVITY, WHEELBASE, FRONT, HEIGHT = 1296.0, 9.81, 2.57, 1.25, 0.535
RADIUS, AXLE_INERTIA, DRAG, ROLLING = 0.278, 1.6, 0.48, 0.015
GAIN_F, GAIN_R = 26e-5, 13e-5  # axle torque over the pressure of one wheel, N m / Pa

TABLE_8: dict[str, float] = {
    "body.mass": MASS,
    "body.wheelbase": WHEELBASE,
    "body.centre_of_gravity_to_front_axle": FRONT,
    "body.centre_of_gravity_height": HEIGHT,
    "aerodynamics.air_density": 1.2,
    "aerodynamics.drag_coefficient": 0.4,
    "aerodynamics.frontal_area": 2.0,
    "aerodynamics.drag_height": HEIGHT,
    # torque of one brake = 2 pressure area friction radius; 13 and 6.5 N m/bar
    **{f"brakes.{axle}.pad_friction": 0.4 for axle in ("front", "rear")},
    **{f"brakes.{axle}.effective_radius": 0.1 for axle in ("front", "rear")},
    "brakes.front.pad_area": GAIN_F / 2 / (2 * 0.4 * 0.1),
    "brakes.rear.pad_area": GAIN_R / 2 / (2 * 0.4 * 0.1),
    **{f"wheels.{wheel}.radius": RADIUS for wheel in ("fl", "fr", "rl", "rr")},
    **{f"wheels.{wheel}.inertia": AXLE_INERTIA / 2 for wheel in ("fl", "fr", "rl", "rr")},
    **{f"wheels.{wheel}.rolling_resistance": ROLLING for wheel in ("fl", "fr", "rl", "rr")},
}

SET_T = (1.316, 14.34)
SET_A = (1.25, 25.0)


@dataclass
class Run:
    """Truth of one run, a sample per millisecond after the step that ends there."""

    speed: FloatArray
    wheel_front: FloatArray
    wheel_rear: FloatArray
    acceleration: FloatArray
    torque_front: FloatArray
    torque_rear: FloatArray
    pressure_front: FloatArray
    pressure_rear: FloatArray
    drive: FloatArray
    slip_front: FloatArray
    slip_rear: FloatArray
    used_front: FloatArray
    used_rear: FloatArray
    limit_front: FloatArray
    limit_rear: FloatArray
    load_front: FloatArray
    load_rear: FloatArray
    braking: FloatArray

    def __len__(self) -> int:
        return len(self.speed)

    def brake_onset(self) -> int:
        """Index of the first sample with the brake applied."""
        return int(np.argmax(self.braking > 0))

    def braking_phase(self) -> NDArray[np.int64]:
        """Samples from 0.4 s after brake onset until v < 5 m/s (friction document 4.8)."""
        onset = self.brake_onset()
        slow = onset + int(np.argmax(self.speed[onset:] < 5.0))
        return np.arange(onset + 400, slow)


@njit(cache=True)
def _friction(slip: float, limit: float, k1: float, k2: float, magic: bool) -> float:
    if magic:  # Table 2, dry asphalt, scaled
        b, c, e = 10.0, 1.9, 0.97
        return limit * math.sin(c * math.atan(b * slip - e * (b * slip - math.atan(b * slip))))
    return limit * math.sin(k1 * math.atan(k2 * slip))


@njit(cache=True)
def _slip(speed: float, wheel: float) -> float:
    fastest = max(speed, RADIUS * wheel, 1e-3)
    return (RADIUS * wheel - speed) / fastest


@njit(cache=True)
def _simulate(
    out: FloatArray,
    start_speed: float,
    top_speed: float,
    brake_speed: float,
    limits: FloatArray,
    after: FloatArray,
    jump_time: float,
    k1: float,
    k2: float,
    magic: bool,
    abs_on: bool,
    spin_torque: float,
    pressure_rate: float,
    driver_pressure: float,
    stop_speed: float,
) -> int:
    substeps = 20
    h = 0.001 / substeps
    v, wf, wr = start_speed, start_speed / RADIUS, start_speed / RADIUS
    pf, pr, master = 0.0, 0.0, 0.0
    released, braking, brake_time = top_speed <= start_speed, False, 0.0
    valve_f, valve_r = 0, 0
    for n in range(out.shape[1]):
        if v >= top_speed:
            released = True
        if released and v <= brake_speed:
            braking = True
        drive = 0.0
        if not released:
            drive = spin_torque if v < 12.0 else (0.65 * spin_torque if v < 20.0 else 0.45 * spin_torque)
            rev_limit = 18.0 if v < 12.0 else (30.0 if v < 20.0 else 60.0)  # of the gear, as rim speed
            drive *= min(1.0, max(0.0, 0.5 * (rev_limit - RADIUS * wr)))
        if braking:
            brake_time += 0.001
            master = min(driver_pressure, brake_time * pressure_rate)
        lf, lr = limits[0], limits[1]
        if brake_time >= jump_time:
            lf, lr = after[0], after[1]
        if abs_on and braking and v > 1.5:
            sf, sr = _slip(v, wf), _slip(v, wr)
            valve_f = -1 if sf < -0.15 else (1 if sf > -0.10 else (0 if valve_f == 1 else valve_f))
            valve_r = -1 if sr < -0.15 else (1 if sr > -0.10 else (0 if valve_r == 1 else valve_r))
            pf += _pressure_step(valve_f, master, pf)
            pr += _pressure_step(valve_r, master, pr)
        else:
            pf, pr = master, master
        a, used_f, used_r, zf, zr, tf, tr = 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0
        mean_a, mean_tf, mean_tr = 0.0, 0.0, 0.0
        for _ in range(substeps):
            used_f = _friction(_slip(v, wf), lf, k1, k2, magic)
            used_r = _friction(_slip(v, wr), lr, k1, k2, magic)
            drag = DRAG * v * v
            roll = MASS * GRAVITY * ROLLING if v > 0.0 else 0.0
            lever = WHEELBASE + HEIGHT * (used_f - used_r)
            # pitch moment about the ground: m a h = (Fx - drag - roll) h and drag at its own height (here h)
            zf = (MASS * GRAVITY * (WHEELBASE - FRONT - HEIGHT * used_r) + roll * HEIGHT) / lever
            zr = MASS * GRAVITY - zf
            ff, fr = used_f * zf, used_r * zr
            a = (ff + fr - drag - roll) / MASS
            wf, tf = _wheel(wf, v, 0.0, GAIN_F * pf, ff, lf * k1 * k2 * zf, h)
            wr, tr = _wheel(wr, v, drive, GAIN_R * pr, fr, lr * k1 * k2 * zr, h)
            v = max(0.0, v + h * a)
            mean_a += a / substeps
            mean_tf += tf / substeps
            mean_tr += tr / substeps
        row = out[:, n]
        row[0], row[1], row[2], row[3] = v, wf, wr, mean_a
        row[4], row[5], row[6], row[7], row[8] = mean_tf, mean_tr, pf, pr, drive
        row[9], row[10], row[11], row[12] = _slip(v, wf), _slip(v, wr), used_f, used_r
        row[13], row[14], row[15], row[16], row[17] = lf, lr, zf, zr, 1.0 if braking else 0.0
        if braking and v <= stop_speed:
            return n + 1
    return out.shape[1]


@njit(cache=True)
def _pressure_step(valve: int, master: float, pressure: float) -> float:
    if valve > 0:
        return (master - pressure) * 0.001 / 0.05
    if valve < 0:
        return (5e5 - pressure) * 0.001 / 0.03
    return 0.0


@njit(cache=True)
def _wheel(
    w: float, v: float, drive: float, brake: float, force: float, stiffness: float, h: float
) -> tuple[float, float]:
    """Linearly implicit step of an axle's wheels with a set-valued brake; wheel speed and torque that acted."""
    slope = stiffness * RADIUS / max(v, RADIUS * w, 0.05)
    inertia = AXLE_INERTIA + h * RADIUS * slope
    free = w + h * (drive - RADIUS * force) / inertia
    change = h * brake / inertia
    if free > change:
        new = free - change
    elif free < -change:
        new = free + change
    else:
        new = 0.0
    torque = (new - w) * AXLE_INERTIA / h + RADIUS * force
    return new, torque


def simulate(
    limits: tuple[float, float] = (1.12, 0.98),
    *,
    abs_on: bool = False,
    start_speed: float = 95 / 3.6,
    top_speed: float = 0.0,
    brake_speed: float = 95 / 3.6,
    after_jump: tuple[float, float] | None = None,
    jump_time: float = 1e9,
    curve: tuple[float, float] = SET_T,
    magic: bool = False,
    spin_torque: float = 2600.0,
    pressure_rate: float = 400e5,
    driver_pressure: float = 150e5,
    duration_s: float = 40.0,
    stop_speed: float = 0.0,
) -> Run:
    """One manoeuvre: accelerate to ``top_speed``, roll to ``brake_speed``, brake hard to ``stop_speed`` [m/s]."""
    out = np.zeros((len(fields(Run)), round(duration_s * 1000)))
    length = _simulate(
        out, start_speed, top_speed, brake_speed, np.array(limits), np.array(after_jump or limits), jump_time,
        curve[0], curve[1], magic, abs_on, spin_torque, pressure_rate, driver_pressure, stop_speed,
    )  # fmt: skip
    return Run(*(row[:length].copy() for row in out))


def join(*runs: Run) -> Run:
    """Several runs one after the other as one recording."""
    return Run(*(np.concatenate([getattr(run, f.name) for run in runs]) for f in fields(Run)))


def measured(
    run: Run, *, seed: int = 0, acceleration_noise: float = 0.05, wheel_noise: float = 0.05, actual_torque: bool = False
) -> dict[str, FloatArray]:
    """Signals as decoded from a bus that is as fast as the filter."""
    random = np.random.default_rng(seed)
    columns = {"longitudinal_acceleration": run.acceleration + acceleration_noise * random.standard_normal(len(run))}
    for wheel in ("fl", "fr", "rl", "rr"):
        truth = run.wheel_front if wheel.startswith("f") else run.wheel_rear
        # the axle's mean carries the stated noise
        columns[f"wheel_speed_{wheel}"] = truth + math.sqrt(2) * wheel_noise * random.standard_normal(len(run))
        columns[f"brake_pressure_{wheel}"] = run.pressure_front if wheel.startswith("f") else run.pressure_rear
    columns["drive_torque_f"] = np.zeros(len(run))
    columns["drive_torque_r"] = run.drive
    if actual_torque:
        columns |= {f"brake_pressure_{wheel}": np.zeros(len(run)) for wheel in ("fl", "fr", "rl", "rr")}
        columns["drive_torque_f"], columns["drive_torque_r"] = run.torque_front, run.torque_rear
    return columns


def tone_ring(
    columns: dict[str, FloatArray], run: Run, *, teeth: int = 48, window: int = 5, timeout: int = 300
) -> dict[str, FloatArray]:
    """The same signals with wheel speeds as a control unit makes them from edges, ``window`` and ``timeout`` in ms."""
    result = dict(columns)
    pitch = 2 * math.pi / teeth
    for wheel in ("fl", "fr", "rl", "rr"):
        truth = run.wheel_front if wheel.startswith("f") else run.wheel_rear
        angle = np.concatenate([[0.0], np.cumsum(0.0005 * (truth[1:] + truth[:-1]))])
        count = np.floor(angle / pitch).astype(int)
        # time of every edge in ms; where the wheel stands the angle does not rise, the first instant counts
        rising = np.concatenate([[True], np.diff(angle) > 0])
        edges = np.interp(pitch * np.arange(count[-1] + 1), angle[rising], np.flatnonzero(rising).astype(float))
        speeds = np.zeros(len(run))
        for k in range(len(run)):
            last, before = count[k], count[max(0, k - window)]
            since = k - edges[last]
            speed = speeds[k - 1] if k else 0.0
            if last > before:
                speed = (last - before) * pitch / (0.001 * (edges[last] - edges[before]))
            speeds[k] = 0.0 if since > timeout else min(speed, pitch / (0.001 * since)) if since > 0 else speed
        result[f"wheel_speed_{wheel}"] = speeds
    return result


def held(columns: dict[str, FloatArray]) -> tuple[dict[str, FloatArray], dict[str, FloatArray]]:
    """The same signals as frames of 5 ms (speeds, inertial) and 10 ms (pressures, powertrain), with their ages."""
    length = len(next(iter(columns.values())))
    index = np.arange(length)
    period = {"wheel_speed": (5, 0), "longitudinal": (5, 3), "brake_pressure": (10, 5), "drive_torque": (10, 1)}
    names = {
        "wheel_speed": "age_wheel_speed",
        "longitudinal": "age_inertial",
        "brake_pressure": "age_wheel_pressure",
        "drive_torque": "age_powertrain",
    }
    result, ages = {}, {}
    for group, (step, offset) in period.items():
        last = np.maximum((index - offset) // step * step + offset, 0)
        age = (index - last) * 0.001
        age[:offset] = np.inf
        ages[names[group]] = age
        for name, values in columns.items():
            if name.startswith(group):
                result[name] = values[last]
    return result, ages
