"""A small car on a straight road for closed-loop tests of the controller: four wheels, hydraulics, tone rings."""

from collections.abc import Callable
from dataclasses import dataclass, field
from typing import Any

import numpy as np
import pytest
from numba import njit
from numpy.typing import NDArray

from bench.codec.codec import AGE_NAMES, Codec
from bench.ecu.controller import Controller
from bench.ecu.node import EcuNode
from bench.ecu.records import PERIOD_TICKS, PRESENT, SOURCES
from bench.links.frame import new_frames
from hydraulics import HydraulicUnit
from signals.catalogue import block_slice, names

BUS = names()[block_slice("bus")]
POSITION = {name: i for i, name in enumerate(BUS)}

# friction document 6.1.1
MASS, RADIUS, INERTIA, BASE, FRONT, HEIGHT = 1296.0, 0.278, 0.8, 2.57, 1.25, 0.535
TRACK, YAW_INERTIA = 1.5, 1750.0
DRAG, ROLLING, GRAVITY = 0.48, 0.015, 9.81
TEETH = 48
SUB_STEPS = 10
BRAKES = {
    f"brakes.{axle}.{name}": value
    for axle, area in (("front", 1.425e-3), ("rear", 0.7125e-3))
    for name, value in (("pad_area", area), ("pad_friction", 0.38), ("effective_radius", 0.12))
}

# B, C, D, E of friction document Table 2, set T of 2.2.5, and a curve with an early peak for polished ice
SURFACES = {
    "set_t": (14.34, 1.316, 1.0, 0.0),
    "dry": (10.0, 1.9, 1.0, 0.97),
    "wet": (12.0, 2.3, 0.82, 1.0),
    "snow": (5.0, 2.0, 0.3, 1.0),
    "ice": (4.0, 2.0, 0.1, 1.0),
    "ice_polished": (30.0, 1.5, 0.1, 0.0),
}


@njit(cache=True)
def _friction(curve: Any, slip: float) -> float:
    b, c, d, e = curve[0], curve[1], curve[2], curve[3]
    return d * np.sin(c * np.arctan(b * slip - e * (b * slip - np.arctan(b * slip))))


@njit(cache=True)
def _advance(state: Any, out: Any, curve: Any, scale: Any, torque: Any, drive: float) -> None:
    """One millisecond. state: v, a, distance, yaw rate, 4 wheel speeds, 4 wheel angles; out: slip 4, friction 4."""
    step = 1e-3 / SUB_STEPS
    total, moment = 0.0, 0.0
    for _ in range(SUB_STEPS):
        transfer = -state[1] * MASS * HEIGHT / BASE
        total, moment = 0.0, 0.0
        for w in range(4):
            front = w < 2
            share = (BASE - FRONT) / BASE if front else FRONT / BASE
            load = max(0.5 * (MASS * GRAVITY * share + (transfer if front else -transfer)), 0.0)
            side = 0.5 * TRACK if w % 2 else -0.5 * TRACK
            centre = max(state[0] + state[3] * side, 0.0)
            omega = state[4 + w]
            # implicit in the tyre's slope: explicit steps are unstable at low speed
            scale_speed = max(centre, RADIUS * omega, 0.3)
            slip = (RADIUS * omega - centre) / scale_speed
            friction = _friction(curve, slip) * scale[w]
            slope = max(_friction(curve, slip + 1e-4) * scale[w] - friction, 0.0) / 1e-4
            stiffness = load * slope * RADIUS / scale_speed
            inertia = INERTIA + step * stiffness * RADIUS
            free = omega + step * (-load * friction * RADIUS + (0.5 * drive if not front else 0.0)) / inertia
            change = step * torque[w] / inertia
            state[4 + w] = free - change if free > change else (0.0 if free > -change else free + change)
            state[8 + w] += step * state[4 + w]
            force = load * friction
            total += force
            moment += force * side
            out[w], out[4 + w] = slip, friction
        if state[0] <= 0.0:
            state[0], state[1] = 0.0, 0.0
            continue
        state[1] = (total - DRAG * state[0] ** 2 - ROLLING * MASS * GRAVITY) / MASS
        state[0] = max(state[0] + step * state[1], 0.0)
        state[2] += step * state[0]
    # the driver keeps the car straight with some effort; what is left is the yaw rate to look at
    state[3] += 1e-3 * (moment / YAW_INERTIA - 6.0 * state[3])


@njit(cache=True)
def _edges(angle: Any, before: Any, time: float, pitch: Any, count: Any, stamp: Any) -> None:
    """Tone ring edges of a millisecond in continuous time; pitch: angle of each tooth."""
    turn = 2.0 * np.pi
    for w in range(4):
        while True:
            number = count[w] + 1
            edge = turn * (number // TEETH) + pitch[w, number % TEETH]
            if edge > angle[w]:
                break
            share = (edge - before[w]) / max(angle[w] - before[w], 1e-12)
            stamp[w] = time - 1e-3 + 1e-3 * min(max(share, 0.0), 1.0)
            count[w] = number


def fresh_health() -> NDArray[np.int64]:
    """Health of the ECU's sources when all of them are there and up to date."""
    health = np.zeros((len(SOURCES), 4), np.int64)
    health[:, PERIOD_TICKS] = (5, 5, 5, 5, 5, 5, 10, 20, 5)
    health[:, PRESENT] = 1
    return health


@dataclass
class Trace:
    """What a stop looked like, one row per millisecond."""

    time: NDArray[np.float64]
    speed: NDArray[np.float64]
    distance: NDArray[np.float64]
    reference: NDArray[np.float64]
    wheel: NDArray[np.float64]
    slip: NDArray[np.float64]
    pressure: NDArray[np.float64]
    valves: NDArray[np.float64]
    phase: NDArray[np.float64]
    friction: NDArray[np.float64]
    yaw_rate: NDArray[np.float64]
    status: NDArray[np.float64]

    def braking(self, onset_s: float, last_speed: float = 5.0) -> NDArray[np.bool_]:
        """Braking phase of friction document 4.8: from 0.4 s after onset until v < 5 m/s."""
        return (self.time > onset_s + 0.4) & (self.speed > last_speed)

    def stopping_distance(self, onset_s: float) -> float:
        return float(self.distance[-1] - np.interp(onset_s, self.time, self.distance))

    def longest_lock_s(self, above_m_s: float = 15.0 / 3.6) -> float:
        """Longest time that any wheel stood while the car was faster than a limit."""
        longest = 0
        for w in range(4):
            run = 0
            for locked in (self.wheel[:, w] < 0.1) & (self.speed > above_m_s):
                run = run + 1 if locked else 0
                longest = max(longest, run)
        return longest * 1e-3


@dataclass
class Stop:
    """A straight stop with the emulated controller."""

    calibration: str = "sensitive"
    surface: str = "set_t"
    start_speed: float = 95 / 3.6
    onset_s: float = 0.5
    pressure_bar: float = 150.0
    ramp_bar_s: float = 600.0
    axle_friction: tuple[float, float] = (1.0, 1.0)
    scale: Callable[[float, float], tuple[float, float]] = field(default=lambda time, distance: (1.0, 1.0))
    seed: int = 1
    pitch_error: float = 0.01
    acceleration_offset: float = 0.0
    acceleration_noise: float = 0.1
    with_controller: bool = True
    longest_s: float = 30.0
    change_inputs: Callable[[int, NDArray[np.float64], NDArray[np.int64]], None] | None = None

    def run(self) -> Trace:
        controller = Controller(self.calibration)
        generator = np.random.default_rng(self.seed)
        pitch = np.linspace(0.0, 2.0 * np.pi, TEETH, endpoint=False) + 2.0 * np.pi / TEETH * (
            self.pitch_error * generator.standard_normal((4, TEETH))
        )
        unit = HydraulicUnit(BRAKES)
        state, out = np.zeros(12), np.zeros(8)
        state[0], state[4:8] = self.start_speed, self.start_speed / RADIUS
        count, stamp = np.zeros(4, np.int64), np.zeros(4)
        values, command, hydraulics = np.zeros(len(BUS)), np.zeros(len(BUS)), np.zeros(18)
        ages = fresh_health()
        valves = np.zeros(9)
        curve = np.array(SURFACES[self.surface])
        acceleration = 0.0
        rows = []
        torque = np.zeros(4)
        p = POSITION
        for tick in range(int(self.longest_s * 1000)):
            time = tick * 1e-3
            master = min(max((time - self.onset_s) * self.ramp_bar_s, 0.0), self.pressure_bar) * 1e5
            unit.tick(master, valves[0:4], valves[4:8], valves[8], hydraulics)
            torque[:] = hydraulics[10:14]
            left, right = self.scale(time, state[2])
            f, r = self.axle_friction
            before = state[8:12].copy()
            _advance(state, out, curve, np.array([f * left, f * right, r * left, r * right]), torque, 0.0)
            _edges(state[8:12], before, time, pitch, count, stamp)
            acceleration += (state[1] - acceleration) * 0.06
            phase = tick % 5
            if phase == 0:
                values[p["wheel_speed_fl"] : p["wheel_speed_fl"] + 4] = state[4:8]
            if phase == 1:
                values[p["wheel_edge_count_fl"] : p["wheel_edge_count_fl"] + 4] = count % 65536
                values[p["wheel_edge_time_fl"] : p["wheel_edge_time_fl"] + 4] = np.round(stamp % 1.048576, 6)
            if phase == 3:
                noise = self.acceleration_noise * generator.standard_normal()
                values[p["longitudinal_acceleration"]] = acceleration + self.acceleration_offset + noise
                values[p["yaw_rate"]] = state[3]
            if tick % 10 == 0:
                values[p["master_pressure"]] = master
                values[p["brake_switch"]] = float(master > 2e5)
                values[p["pedal_force"]] = master / 5e4
            values[p["ignition"]] = 1.0
            if self.change_inputs is not None:
                self.change_inputs(tick, values, ages)
            if phase == 4 and self.with_controller:
                controller.task(values, ages, command)
                first = p["valve_inlet_fl"]
                valves[:] = command[first : first + 9]
            rows.append(
                np.concatenate(
                    (
                        [time, state[0], state[2], command[p["ecu_reference_speed"]], state[3]],
                        state[4:8],
                        out,
                        hydraulics[1:5],
                        valves,
                        command[p["ecu_phase_fl"] : p["ecu_phase_fl"] + 4],
                        command[p["abs_active"] : p["abs_active"] + 4],
                    )
                )
            )
            if state[0] <= 0.0:
                break
        table = np.array(rows)
        return Trace(
            time=table[:, 0],
            speed=table[:, 1],
            distance=table[:, 2],
            reference=table[:, 3],
            yaw_rate=table[:, 4],
            wheel=table[:, 5:9],
            slip=table[:, 9:13],
            friction=table[:, 13:17],
            pressure=table[:, 17:21] / 1e5,
            valves=table[:, 21:30],
            phase=table[:, 30:34],
            status=table[:, 34:38],
        )


@pytest.fixture(scope="session")
def stop() -> type[Stop]:
    return Stop


class CanCar:
    """Frames of a car whose wheel speeds, brake and ignition a test sets, and an ECU that answers them.

    A frame of tick n is seen by the other side in tick n + 1, as in lock-step.
    """

    def __init__(self, calibration: str = "sensitive", **options: Any) -> None:
        codec = Codec.load()
        self.node = EcuNode(calibration, codec, **options)
        self.values, self.heard = np.zeros(len(BUS)), np.zeros(len(BUS))
        self._send = codec.transmitter("bench", self.values)
        self._hear = codec.receiver("bench", self.heard, np.zeros(len(AGE_NAMES)))
        self._identifiers = {c.message.name: c.message.identifier for c in codec.layout.carriers}
        self._angle = np.zeros(4)
        self._to_ecu, self._waiting = new_frames(64), 0
        self.answers, self.answered = new_frames(64), 0
        self.tick = 0
        self.log: list[NDArray[np.void]] = []
        self.frames_to_ecu: list[NDArray[np.void]] = []

    def __getitem__(self, name: str) -> float:
        """Value of a signal of the ECU as the bench decoded it."""
        return float(self.heard[POSITION[name]])

    def drive(
        self,
        seconds: float,
        speed: float | tuple[float, float, float, float],
        *,
        master_bar: float = 0.0,
        brake_switch: float | None = None,
        acceleration: float = 0.0,
        ignition: float = 1.0,
        dead_wheels: tuple[int, ...] = (),
        drop: tuple[str, ...] = (),
        corrupt: tuple[str, ...] = (),
        change: Callable[[NDArray[np.float64]], None] | None = None,
    ) -> None:
        """Go on for a while with constant wheel speeds (m/s); dropped and corrupted messages by name."""
        speeds = np.broadcast_to(np.asarray(speed, np.float64), (4,)).copy() / RADIUS
        pitch = 2.0 * np.pi / TEETH
        p = POSITION
        lost = {self._identifiers[name] for name in drop}
        bad = {self._identifiers[name] for name in corrupt}
        for _ in range(round(seconds * 1000)):
            time = self.tick * 1e-3
            moving = np.array([0.0 if w in dead_wheels else speeds[w] for w in range(4)])
            self._angle += moving * 1e-3
            count = np.floor(self._angle / pitch)
            since = np.where(moving > 0, (self._angle - count * pitch) / np.maximum(moving, 1e-9), 0.0)
            for w in range(4):
                if w not in dead_wheels:
                    self.values[p["wheel_edge_time_fl"] + w] = (time - since[w]) % 1.048576
                self.values[p["wheel_edge_count_fl"] + w] = count[w] % 65536
                self.values[p["wheel_speed_fl"] + w] = moving[w]
            self.values[p["master_pressure"]] = master_bar * 1e5
            self.values[p["brake_switch"]] = float(master_bar > 1.0) if brake_switch is None else brake_switch
            self.values[p["longitudinal_acceleration"]] = acceleration
            self.values[p["ignition"]] = ignition
            if change is not None:
                change(self.values)
            self._exchange(lost, bad)

    def _exchange(self, lost: set[int], bad: set[int]) -> None:
        self._hear.accept(self.answers, self.answered, self.tick)
        self.frames_to_ecu.append(self._to_ecu[: self._waiting].copy())
        self.answered = self.node.tick(self.tick, self._to_ecu, self._waiting, self.answers)
        self.log.append(self.answers[: self.answered].copy())
        due = self._send.due(self.tick, self._to_ecu)
        kept = 0
        for i in range(due):
            identifier = int(self._to_ecu["identifier"][i])
            if identifier in lost:
                continue
            if identifier in bad:
                self._to_ecu["data"][i, 1] ^= 0x40
            self._to_ecu[kept] = self._to_ecu[i]
            kept += 1
        self._waiting = kept
        self.tick += 1


@pytest.fixture(scope="session")
def can_car() -> type[CanCar]:
    return CanCar
