"""Runs of the vehicle-state scenarios with many seeds: one drive, then the sensors' noise again for each seed.

A drive goes over the bench with noise-free sensors: tone rings, low-pass, frames and their ages are real. Each seed
then adds its own white noise to every new sample, where the sensor model adds it, and the estimator is run over that.
"""

import json
import math
from collections.abc import Mapping
from functools import cache
from typing import Any

import numpy as np

import bench
import estimators
from bench.scenario.vehicle_choice import nominal_vehicle
from estimators.channels import CHANNELS

Columns = dict[str, np.ndarray]

QUIET = {f"sensors.{name}.noise": 0.0 for name in ("longitudinal_acceleration", "lateral_acceleration", "yaw_rate")}
WHEELS = ("fl", "fr", "rl", "rr")
NOISE = {"longitudinal_acceleration": 0.05, "lateral_acceleration": 0.1, "yaw_rate": 0.005}
"""Standard deviations of the document's desk checks (C.1, C.2)."""
WHEEL_NOISE = {f"wheel_speed_{wheel}": 0.02 for wheel in WHEELS}
"""rad/s, C.1 and AC-50; on top of the tone rings' own errors."""
ALL_NOISE = {**NOISE, **WHEEL_NOISE}
LAUNCH_NOISE = {name: noise / math.sqrt(5.0) for name, noise in WHEEL_NOISE.items()}
"""C.1 as it was made: 0.02 rad/s in every step of 1 ms, nothing else; a frame of 5 ms tells the mean of five such."""
TUNING_SEEDS = range(20)
"""Seeds with which the observers' own settings (source "assumed") were chosen; none of them judges."""
SEEDS = range(9000, 9020)
"""Seeds that judge: nobody looked at them while a setting was chosen."""


class Drive:
    """A drive with noise-free sensors.

    Attributes
    ----------
    data : RunArrays
        All signals of the run, the truth included.
    vehicle : dict
        Numbers of the nominal vehicle file.
    """

    def __init__(self, run: bench.Run) -> None:
        self.data = run.data
        self.vehicle = nominal_vehicle(run.scenario).numbers()
        self.criteria = {criterion.id: criterion for criterion in run.verdict.criteria}

    def __getitem__(self, name: str) -> np.ndarray:
        array: np.ndarray = self.data.array(name)
        return array

    def columns(self, names: tuple[str, ...], seed: int | None, noise: Mapping[str, float]) -> Columns:
        """Decoded signals with the noise of a seed; without one as they are."""
        columns = {name: self[name].copy() for name in names}
        if seed is None:
            return columns
        for number, name in enumerate(sorted(noise)):
            if name not in columns:
                continue
            age = self[CHANNELS[name].age]
            fresh = np.concatenate(([True], np.diff(age) <= 0.0))
            random = np.random.default_rng([seed, number])
            samples = noise[name] * random.standard_normal(int(fresh.sum()))
            columns[name] += samples[np.cumsum(fresh) - 1]
        return columns


@cache
def _drive(scenario: str, sets: str) -> Drive:
    run = bench.run(scenario, pacing="lockstep", sets=json.loads(sets), record=False)
    assert not run.verdict.errors, run.verdict.errors
    return Drive(run)


def drive(scenario: str, **sets: Any) -> Drive:
    """The drive of a scenario, made once; ``__`` in a key stands for a dot."""
    changes = {key.replace("__", "."): value for key, value in sets.items()}
    return _drive(scenario, json.dumps(QUIET | changes, sort_keys=True))


def forget_drives() -> None:
    """Drop the drives made so far: all signals of a drive over hills take a third of a gigabyte."""
    _drive.cache_clear()


class Replay:
    """Outputs of an estimator over a drive, by name."""

    def __init__(
        self,
        of: Drive,
        name: str,
        settings: Mapping[str, Any] | None = None,
        *,
        seed: int | None = 0,
        noise: Mapping[str, float] = NOISE,
        vehicle: Mapping[str, float] | None = None,
        change: Any = None,
    ) -> None:
        self.estimator = estimators.create(name, vehicle or of.vehicle, settings)
        columns = of.columns(self.estimator.inputs, seed, noise)
        if change is not None:
            change(columns)
        ages = {CHANNELS[name].age: of[CHANNELS[name].age] for name in columns}
        self.values = self.estimator.replay(columns, ages)
        self.positions = {output.name.partition(".")[2]: k for k, output in enumerate(self.estimator.outputs)}

    def __getitem__(self, name: str) -> np.ndarray:
        return self.values[:, self.positions[name]]


def rmse_percent(truth: np.ndarray, estimate: np.ndarray) -> tuple[float, float]:
    """Relative error of 4.1 [%]: over the mean of |x|, and over the mean of x as printed."""
    error = 100.0 * float(np.sqrt(np.mean((truth - estimate) ** 2)))
    return error / float(np.mean(np.abs(truth))), error / abs(float(np.mean(truth)))


def errors_of(run: Drive, found: Replay) -> dict[str, tuple[float, float]]:
    """Errors of a slalom [%] on both bases, from 1 s on; of each axle's slip angles and friction the worse wheel's."""
    part = run["time"] > 1.0
    errors = {
        "a_y": rmse_percent(run["true_lateral_acceleration"][part], found["lateral_acceleration"][part]),
        "yaw_rate": rmse_percent(run["true_yaw_rate"][part], found["yaw_rate"][part]),
    }
    for axle, wheels in (("front", ("fl", "fr")), ("rear", ("rl", "rr"))):
        angles = [rmse_percent(run[f"slip_angle_{w}"][part], found[f"slip_angle_{w}"][part]) for w in wheels]
        used = {w: run[f"lateral_force_{w}"] / run[f"vertical_load_{w}"] for w in wheels}
        frictions = [rmse_percent(used[w][part], found[f"friction_used_lateral_{w}"][part]) for w in wheels]
        errors[axle], errors[f"friction {axle}"] = max(angles), max(frictions)
    return errors


def true_share(run: Drive, event: dict[str, Any]) -> float:
    """Share of the true peak that was in use when a fit was made."""
    k, wheel = round(1e3 * event["time"]) - 1, event["wheel"]
    force = "lateral" if event["direction"] == "lateral" else "longitudinal"
    used = abs(run[f"{force}_force_{wheel}"][k] / run[f"vertical_load_{wheel}"][k])
    return float(used / run[f"friction_limit_{wheel}"][k])


def fits_of(run: Drive, found: Replay) -> list[dict[str, Any]]:
    """Fits of a replay, each with the true share of the peak and the relative error of D."""
    return [
        {
            **event,
            "true_share": true_share(run, event),
            "error": event["limit"] / run[f"friction_limit_{event['wheel']}"][1000] - 1.0,
        }
        for event in found.estimator.events()
    ]
