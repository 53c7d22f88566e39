"""A made-up emergency stop with ABS, written as the loop records it: four wheels that cycle about their slip target.

It serves the tests of what reads recordings; nothing in it is a model of a car, only its signals have the right shape.
"""

import json
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from bench.links.frame import BENCH, ECU, FRAME_DTYPE, TRANSMITTED
from bench.recording.arrays import RunArrays
from bench.recording.frame_file import BlfFile
from bench.recording.mf4_file import write_mf4
from bench.recording.schema import RunSchema
from signals.catalogue import Signal, catalogue
from signals.wheels import WHEELS

RADIUS_M = 0.3
SCENARIO = """format: 1
id: stops/dry
title: Emergency stop on dry asphalt
description: Emergency stop from 95 km/h on dry asphalt with ABS.
vehicle: ekf_car
plant: mujoco
ecu: {kind: emulated, link: udp}
seed: 1
"""
PHASE_NAMES = ("coast", "brake", "stand")
PERIODS_MS = {0x120: 5, 0x121: 5, 0x130: 5, 0x140: 10, 0x141: 10, 0x150: 10, 0x160: 20, 0x210: 5, 0x220: 20}
ESTIMATES = (
    Signal("friction_ekf.active", "1", "filter runs", "estimators", "1", 1.0),
    *(
        Signal(f"friction_ekf.friction_limit_{axle}{ending}", "1", "friction limit", "estimators", "1", 1.0)
        for axle in ("front", "rear")
        for ending in ("", "_std", "_confidence")
    ),
)


def simulate(
    duration_s: float = 6.0,
    speed_m_s: float = 26.4,
    brake_at_s: float = 1.0,
    *,
    abs_control: bool = True,
    friction: float = 0.95,
    real_time: bool = True,
    seed: int = 1,
) -> RunArrays:
    """Signals of the made-up stop on the catalogue's names."""
    signals = (*catalogue(), *ESTIMATES)
    position = {signal.name: column for column, signal in enumerate(signals)}
    rows = round(duration_s * 1000) + 1
    matrix = np.zeros((rows, len(signals)))
    random = np.random.default_rng(seed)
    state = _Stop(speed_m_s, abs_control, friction, random)
    for row in range(rows):
        time = row * 1e-3
        values = state.step(time, brake_at_s)
        for name, value in values.items():
            matrix[row, position[name]] = value
    if real_time:
        matrix[:, position["lateness"]] = np.abs(random.standard_t(2.0, rows)) * 0.2e-6
        matrix[rows // 2, position["lateness"]] = 3.1e-3
    matrix[:, position["tick_cpu_time"]] = random.lognormal(np.log(130e-6), 0.12, rows)
    matrix[:, position["bus_load"]] = 0.31 + 0.004 * random.standard_normal(rows)
    timing: dict[str, Any] = {
        "mode": "realtime" if real_time else "lockstep",
        "real_time_factor": 1.0 if real_time else 44.2,
        "lateness_us": {"p50": 0.15, "p99": 1.9, "p999": 6.0, "max": 3100.0 if real_time else 0.0},
        "tick_cpu_us": {"p50": 130.0, "p99": 172.0, "p999": 190.0, "max": 204.0},
        "overruns": 1 if real_time else 0,
        "late_ticks": 1 if real_time else 0,
        "links": [{"kind": "udp", "sent": 5400, "received": 1500, "dropped": 0}],
    }
    return RunArrays.from_matrix(matrix, signals, phase_names=PHASE_NAMES, timing=timing)


class _Stop:
    """Speed falls with the friction in use; each wheel's slip runs after its pressure, a bang-bang control holds it."""

    def __init__(self, speed: float, abs_control: bool, friction: float, random: np.random.Generator) -> None:
        self.speed, self.distance, self.abs_control, self.friction, self.random = (
            speed,
            0.0,
            abs_control,
            friction,
            random,
        )
        self.pressure = np.zeros(4)
        self.slip = np.zeros(4)
        self.state = np.zeros(4, np.int64)
        self.target = np.array([0.11, 0.12, 0.08, 0.085])
        self.estimate = np.array([0.5, 0.5])

    def step(self, time: float, brake_at: float) -> dict[str, float]:
        braking = time >= brake_at
        standing = self.speed < 0.05
        pedal = 400.0 * min(1.0, max(0.0, (time - brake_at) / 0.15)) if braking else 0.0
        master = pedal / 400.0 * 12e6
        full = 8e6 * self.friction
        cycling = self.abs_control and braking and not standing and self.speed > 2.0
        for wheel in range(4):
            self._wheel(wheel, master, full * (1.0 if wheel < 2 else 0.6), cycling)
        used = self.friction * np.sin(1.9 * np.arctan(12.0 * self.slip)) if braking else np.zeros(4)
        deceleration = 0.0 if standing else 9.81 * float(np.mean(used)) + (0.15 if not standing else 0.0)
        self.speed = max(0.0, self.speed - deceleration * 1e-3)
        self.distance += self.speed * 1e-3
        self.estimate += (self.friction - self.estimate) * (0.006 if braking else 0.0)
        return self._values(time, braking, standing, pedal, master, used, deceleration, cycling)

    def _wheel(self, wheel: int, master: float, full: float, cycling: bool) -> None:
        if cycling:
            if self.slip[wheel] > 1.35 * self.target[wheel]:
                self.state[wheel] = 3
            elif self.state[wheel] == 3 and self.slip[wheel] < self.target[wheel]:
                self.state[wheel] = 2
            elif self.state[wheel] == 2 and self.slip[wheel] < 0.6 * self.target[wheel]:
                self.state[wheel] = 4
            elif self.state[wheel] == 0:
                self.state[wheel] = 1
        else:
            self.state[wheel] = 0
        rate = {0: 1.0, 1: 1.0, 2: 0.0, 3: -1.6, 4: 0.35}[int(self.state[wheel])]
        self.pressure[wheel] = min(master, max(0.0, self.pressure[wheel] + rate * 6e4 * (1 + 0.1 * wheel)))
        surplus = self.pressure[wheel] / full
        goal = 0.09 * surplus if surplus < 1.0 else 1.0
        self.slip[wheel] += (goal - self.slip[wheel]) * (0.012 if surplus > 1.0 else 0.02)

    def _values(
        self,
        time: float,
        braking: bool,
        standing: bool,
        pedal: float,
        master: float,
        used: NDArray[np.float64],
        deceleration: float,
        cycling: bool,
    ) -> dict[str, float]:
        noise = self.random.standard_normal(3)
        values = {
            "time": time,
            "manoeuvre_phase": 2.0 if standing else float(braking),
            "driver_pedal_force": pedal,
            "driver_master_pressure": master,
            "true_master_pressure": master,
            "speed": self.speed,
            "distance": self.distance,
            "true_longitudinal_acceleration": -deceleration,
            "longitudinal_acceleration": -deceleration + 0.08 * noise[0],
            "true_yaw_rate": 0.01 * np.sin(3.0 * time) * braking,
            "yaw_rate": 0.01 * np.sin(3.0 * time) * braking + 0.002 * noise[1],
            "driver_steering_wheel_angle": 0.03 * np.sin(2.5 * time) * braking,
            "position_y": 0.02 * np.sin(time),
            "abs_active": float(cycling),
            "pump": float(cycling),
            "brake_switch": float(braking),
            "ignition": 1.0,
            "ecu_reference_speed": self.speed * (1 - 0.01 * braking),
            "accumulator_pressure": 3e5 * cycling * (1 + 0.3 * np.sin(40 * time)),
            "friction_ekf.active": float(not standing),
        }
        for axle, name in enumerate(("front", "rear")):
            values[f"friction_ekf.friction_limit_{name}"] = self.estimate[axle] + 0.004 * noise[2]
            values[f"friction_ekf.friction_limit_{name}_std"] = 0.02 + 0.3 * abs(self.friction - self.estimate[axle])
            values[f"friction_ekf.friction_limit_{name}_confidence"] = float(
                abs(self.friction - self.estimate[axle]) < 0.05
            )
        for wheel, name in enumerate(WHEELS):
            slip = 0.0 if standing else -float(self.slip[wheel])
            state = int(self.state[wheel])
            values |= {
                f"wheel_centre_speed_{name}": self.speed,
                f"slip_ratio_{name}": slip,
                f"true_wheel_speed_{name}": self.speed * (1 + slip) / RADIUS_M,
                f"wheel_speed_{name}": self.speed * (1 + slip) / RADIUS_M,
                f"true_brake_pressure_{name}": self.pressure[wheel],
                f"brake_pressure_{name}": self.pressure[wheel],
                f"friction_limit_{name}": self.friction,
                f"friction_used_{name}": -float(used[wheel]),
                f"ecu_phase_{name}": float(state),
                f"valve_inlet_{name}": float(state in (2, 3)),
                f"valve_outlet_{name}": float(state == 3),
            }
        return values


def frames_of(duration_s: float, *, silent: tuple[float, float] | None = None) -> NDArray[np.void]:
    """Frames of the cyclic messages; the ECU's are missing in the stretch ``silent``."""
    records = []
    for offset, (identifier, period) in enumerate(PERIODS_MS.items()):
        from_ecu = identifier >= 0x200
        for tick in range(offset % period, round(duration_s * 1000), period):
            if from_ecu and silent is not None and silent[0] <= tick * 1e-3 < silent[1]:
                continue
            records.append((tick, identifier, ECU if from_ecu else BENCH, 0 if from_ecu else TRANSMITTED))
    records.sort()
    frames = np.zeros(len(records), FRAME_DTYPE)
    for column, name in enumerate(("tick", "identifier", "sender", "flags")):
        frames[name] = [record[column] for record in records]
    frames["timestamp_ns"] = frames["tick"] * 1_000_000
    frames["length"] = 8
    return frames


def verdict_of(data: RunArrays, *, failing: bool = False) -> dict[str, Any]:
    """``verdict.json`` of the made-up stop, with every kind of row."""
    criteria = [
        _criterion(
            "stopping_distance",
            "R13-H A5 2.1.1",
            44.8,
            "m",
            (None, 47.5),
            0.057,
            "distance from the brake start to standstill",
        ),
        _criterion("mean_deceleration", "SPEC 4.8 A2", 8.61, "m/s^2", (8.0, None), 0.076, "loss of speed over time"),
        _criterion(
            "slip_mean", "SPEC 4.8 A4", 0.104, "1", (0.05, 0.2), 0.48, "mean magnitude of slip over wheels and time"
        ),
        {
            **_criterion(
                "friction_error", "SPEC 4.8 A6", 0.031, "1", (None, 0.05), 0.38, "error of the friction estimate"
            ),
            "expression": "estimator_error(friction_ekf.friction_limit_front)",
        },
        {
            **_criterion("friction_settling", "SPEC 4.8 A7", None, "s", (None, 0.5), None, "settling after the jump"),
            "verdict": "inconclusive",
            "reason": "the road's friction does not jump",
            "expression": "settling_time(friction_ekf.friction_limit_front)",
        },
        {
            **_criterion(
                "wheel_lock",
                "FMVSS 135 S7.5, unverified",
                0.131 if failing else 0.04,
                "s",
                (None, 0.1),
                -0.31 if failing else 0.6,
                "longest time a wheel is locked above 15 km/h",
            ),
            "verdict": "fail" if failing else "pass",
            "values": [0.131 if failing else 0.04, 0.02, 0.0, 0.0],
            "phase": "brake",
        },
        _criterion(
            "overruns",
            "own limit",
            1.0,
            "1",
            (None, 5.0),
            0.8,
            "ticks that ended after the next deadline",
            "real_time_overruns",
        ),
    ]
    verdicts = [criterion["verdict"] for criterion in criteria]
    return {
        "scenario": "stops/dry",
        "verdict": max(verdicts, key=("pass", "inconclusive", "fail", "error").index),
        "criteria": criteria,
        "metrics": {
            "stopping_distance_m": 44.8,
            "mean_deceleration_m_s2": 8.61,
            "mfdd_m_s2": 8.84,
            "lock_time_s": [0.04, 0.02, 0.0, 0.0],
            "max_abs_yaw_rate_rad_s": 0.0112,
            "lateral_offset_m": 0.021,
            "slip_mean": 0.104,
        },
        "estimators": {
            "friction_ekf": {"rmse": {"friction_limit_front": 0.031, "friction_limit_rear": 0.029}, "settling_s": None}
        },
        "timing": dict(data.timing),
        "seed": 1,
        "versions": {"bench": "0.1.0", "python": "3.11.7", "numpy": "2.4.6", "mujoco": "4.0.0"},
        "errors": [],
        "remarks": [],
    }


def _criterion(
    id: str,
    requirement: str,
    value: float | None,
    unit: str,
    limits: tuple[float | None, float | None],
    margin: float | None,
    description: str,
    expression: str = "",
) -> dict[str, Any]:
    return {
        "id": id,
        "requirement": requirement,
        "value": value,
        "unit": unit,
        "limits": list(limits),
        "margin": margin,
        "verdict": "pass",
        "description": description,
        "expression": expression or id,
        "phase": None,
        "reason": "",
        "source": "",
    }


def write_run_folder(
    folder: Path, data: RunArrays, verdict: dict[str, Any], frames: NDArray[np.void] | None = None, scenario: str = ""
) -> Path:
    """The files of a finished run, written by the bench's own writers."""
    folder.mkdir(parents=True)
    signals = tuple(signal for signal in (*catalogue(), *ESTIMATES) if signal.name in data)
    schema = RunSchema.of(signals, phase_names=data.phase_names, information={"scenario": "stops/dry"})
    matrix = np.column_stack([data.array(signal.name) for signal in signals])
    write_mf4(folder / "signals.mf4", schema, [(0, np.arange(len(matrix)), matrix)])
    blf = BlfFile(folder / "frames.blf")
    blf.write(frames if frames is not None else frames_of(float(data.time[-1])))
    blf.stop()
    (folder / "verdict.json").write_text(json.dumps(verdict), "utf-8")
    (folder / "scenario.yaml").write_text(scenario or SCENARIO, "utf-8")
    (folder / "log.txt").write_text("2026-03-02T10:11:12+01:00 run of stops/dry started\n", "utf-8")
    return folder
