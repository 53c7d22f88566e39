"""Pairs of slip angle and friction that the lateral fit takes, with either of them replaced by the truth.

All angles and frictions are the document's: to the right is positive, a positive slip angle makes a positive force.
"""

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np
from state_runs import Columns, Drive, true_share

import estimators
from estimators.channels import CHANNELS
from estimators.magic_formula_fit_step import forget_curve, observe_pair
from estimators.vehicle_state_record import BUFFER, CURVE_RECORD, CURVES, LOG_COLUMNS, LOG_ROWS

DOCUMENT_WHEELS = ("fr", "fl", "rr", "rl")
STEP = 10
"""Ticks in a step of the lateral filter."""
LOW_PASS_S = 0.03
"""The filter's own for slip angle and friction (``lateral.signal_time_constant``)."""


@dataclass(frozen=True)
class Wheel:
    """What the fit of a wheel is fed with, one value for each step of the filter; arrays of shape (n,)."""

    name: str
    time: np.ndarray
    slip_angle: np.ndarray
    friction: np.ndarray
    now: np.ndarray
    true_slip_angle: np.ndarray
    true_friction: np.ndarray

    @property
    def number(self) -> int:
        return DOCUMENT_WHEELS.index(self.name)


class Pairs:
    """A replay of the lateral filter without noise that keeps its pairs.

    ``change`` alters the signals that it is fed with, ``vehicle`` the car that it is told of.
    """

    def __init__(
        self,
        run: Drive,
        settings: dict[str, Any],
        *,
        change: Callable[[Columns, Drive], None] | None = None,
        vehicle: dict[str, float] | None = None,
    ) -> None:
        self.run = run
        self.estimator = estimators.create("vehicle_state_ukf", vehicle or run.vehicle, settings)
        columns = run.columns(self.estimator.inputs, None, {})
        if change is not None:
            change(columns, run)
        ages = {CHANNELS[name].age: run[CHANNELS[name].age] for name in columns}
        self.ends, rows = [], []
        first, length = 0, len(run["time"])
        while first < length:
            # the first samples one by one, up to the end of a step
            last = min(first + (STEP if rows else 1), length)
            part = {name: column[first:last] for name, column in columns.items()}
            self.estimator.replay(part, {name: age[first:last] for name, age in ages.items()})
            first = last
            state = self.estimator._rows[0]
            if rows or (state["ticks"] > 0 and state["ticks"] % STEP == 0):
                rows.append(state.copy())
                self.ends.append(last - 1)
        self.rows = np.array(rows)

    def wheel(self, name: str) -> Wheel:
        number = DOCUMENT_WHEELS.index(name)
        return Wheel(
            name,
            self.rows["time"],
            self.rows["filtered_alpha"][:, number],
            self.rows["wheel_friction"][:, number],
            np.abs(self.rows["alpha"][:, number]),
            tyre_slip_angle(self.run, name)[self.ends],
            -(self.run[f"lateral_force_{name}"] / self.run[f"vertical_load_{name}"])[self.ends],
        )

    def events(self, name: str) -> list[dict[str, Any]]:
        """The filter's own fits of a wheel."""
        return [event for event in self.estimator.events() if event["wheel"] == name]

    def fits(self, wheel: Wheel, slip_angle: np.ndarray, friction: np.ndarray, now: np.ndarray) -> list[dict[str, Any]]:
        """Fits of the shipped rule over other pairs, each with the relative error of D and the true share."""
        tuning = self.estimator._tuning[0]
        curves = np.zeros(CURVES, CURVE_RECORD)
        curve = curves[wheel.number]
        forget_curve(curve, tuning, 0)
        pairs, scratch = np.zeros((2, BUFFER)), np.zeros((2, BUFFER))
        log, logged = np.zeros((LOG_ROWS, len(LOG_COLUMNS))), np.zeros(1)
        for x, mu, at, time in zip(slip_angle, friction, now, wheel.time, strict=True):
            observe_pair(curve, pairs[0], pairs[1], scratch, log, logged, wheel.number, x, mu, at, time, tuning)
        limit = float(self.run[f"friction_limit_{wheel.name}"][1000])
        found = []
        for row in log[: int(logged[0])]:
            event = dict(zip(LOG_COLUMNS, row.tolist(), strict=True)) | {"wheel": wheel.name, "direction": "lateral"}
            found.append({**event, "error": event["limit"] / limit - 1.0, "true_share": true_share(self.run, event)})
        return found


def tyre_slip_angle(run: Drive, wheel: str) -> np.ndarray:
    """Slip angle with which the tyre of a MuJoCo car makes its force [rad].

    That of the contact: it sweeps over the road by rolling radius times the body's roll rate, to the left where the
    body rolls to the right, which the recorded one of the wheel's centre does not have.
    """
    radius = run.vehicle[f"wheels.{wheel}.radius"]
    sweep = radius * run["true_roll_rate"] / run[f"wheel_centre_speed_{wheel}"]
    return np.asarray(np.arctan(np.tan(run[f"slip_angle_{wheel}"]) + sweep))


def flat_slip_angle(run: Drive, wheel: str) -> np.ndarray:
    """Slip angle of a wheel of the document's flat car that moves as the centre of gravity does (2.2) [rad]."""
    side = 1.0 if wheel[1] == "l" else -1.0
    front = run.vehicle["body.centre_of_gravity_to_front_axle"]
    arm = front if wheel[0] == "f" else front - run.vehicle["body.wheelbase"]
    axle = "front" if wheel[0] == "f" else "rear"
    along = run["speed"] - side * run["true_yaw_rate"] * 0.5 * run.vehicle[f"axles.{axle}.track"]
    across = run["lateral_speed"] + arm * run["true_yaw_rate"]
    return np.asarray(np.arctan(across / along) - run[f"true_road_wheel_angle_{wheel}"])


def low_pass(values: np.ndarray) -> np.ndarray:
    """The filter's low-pass over its steps."""
    weight = 0.01 / (0.01 + LOW_PASS_S)
    result, y = np.zeros(len(values)), 0.0
    for k, value in enumerate(values):
        y += weight * (value - y)
        result[k] = y
    return result


def delayed(values: np.ndarray, delay_ms: float) -> np.ndarray:
    """Values of the steps, so much later."""
    clock = 10.0 * np.arange(len(values))
    return np.interp(clock - delay_ms, clock, values)


def age(values: np.ndarray, truth: np.ndarray) -> float:
    """Delay [ms] of the truth at which it resembles ``values`` most, from 2 s on."""
    delays = np.arange(-60.0, 100.0, 2.0)
    alike = [np.corrcoef(values[200:-50], delayed(truth, delay)[200:-50])[0, 1] for delay in delays]
    return float(delays[int(np.argmax(alike))])
