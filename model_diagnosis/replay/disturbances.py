"""Answers of the observer replay to an error of its own in each equation: force, torque, moment, pressure rate, sensor.

An equation's error in a manoeuvre is a constant and a share of the force, torque or signal that the equation is about:
what is wrong with a model acts for longer than a noise, and mostly in proportion.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from model_diagnosis.effects.sensor_chain import without_lag
from model_diagnosis.manoeuvre import SAMPLE_TIME_S
from model_diagnosis.replay.disturb_step import (
    BANK,
    FORCE_X,
    FORCE_Y,
    NOWHERE,
    PITCH,
    ROLL,
    SLOPE,
    WHEEL,
    YAW,
)
from model_diagnosis.replay.hydraulic import GAIN as PRESSURE_GAIN
from model_diagnosis.replay.prepared import PRESSURES, Prepared
from model_diagnosis.replay.record import CORRECTED
from model_diagnosis.replay.replay import Replay
from model_diagnosis.replay.side_by_side_cars import run_one
from signals.wheels import WHEELS

FloatArray = NDArray[np.float64]

_SENSORS = ("longitudinal_acceleration", "lateral_acceleration", "yaw_rate")
_SCALED = ("speed", *(f"wheel_speed_{wheel}" for wheel in WHEELS))
"""Sensors that have an offset and a scale, and those (with the rolling radius behind them) that have a scale only."""

_TRIED_SHARE = 0.002
_TRIED_PA = 1e4
_LEAST_LEVEL = {"N": 20.0, "N m": 5.0}
"""Root mean square below which a force or torque has no share worth asking for."""

ALIKE = "wheel torques of an axle"
"""Torque balances of both wheels of an axle with one error: what all pads or a differential get wrong, no single wheel
explains."""
_AXLES = ((0, 1), (2, 3))
_CONSTANTS: Mapping[str, tuple[int, ...]] = {
    "longitudinal force": (FORCE_X, SLOPE),
    "lateral force": (FORCE_Y, BANK),
    "yaw moment": (YAW,),
    **{f"wheel torque {wheel}": (WHEEL + i,) for i, wheel in enumerate(WHEELS)},
}
"""Equation -> where a constant error of it acts."""

UNITS: Mapping[str, str] = {
    "longitudinal force": "N",
    "lateral force": "N",
    "yaw moment": "N m",
    **{f"wheel torque {wheel}": "N m" for wheel in WHEELS},
    ALIKE: "N m",
    "load transfer": "N m",
    **{f"hydraulics {wheel}": "Pa/s" for wheel in WHEELS},
    "sensor longitudinal_acceleration": "m/s^2",
    "sensor lateral_acceleration": "m/s^2",
    "sensor yaw_rate": "rad/s",
    "sensor speed": "m/s",
    **{f"sensor wheel_speed_{wheel}": "rad/s" for wheel in WHEELS},
}
"""Equation -> unit of its error."""


@dataclass(frozen=True)
class Course:
    """One error that an equation may have in a manoeuvre.

    Attributes
    ----------
    kind : "constant", or what the error is a share of
    values : (n,) root mean square 1, or 0 throughout where there is nothing to have a share of
    level : root mean square of what a whole share is, 1 of a constant
    place : of `disturb_step` where it acts
    """

    kind: str
    values: FloatArray
    level: float
    place: int = NOWHERE


@dataclass(frozen=True)
class ErrorAnswers:
    """What the observer replay of a manoeuvre answers to k errors of an equation.

    Attributes
    ----------
    kinds, levels : (k,) of each error as in `Course`
    changes : (n, c, k) change of measured minus predicted per unit of an error's root mean square
    """

    kinds: tuple[str, ...]
    levels: FloatArray
    changes: FloatArray

    @classmethod
    def of(cls, courses: Sequence[Course], changes: FloatArray) -> "ErrorAnswers":
        """Answers to the errors of these courses."""
        return cls(tuple(one.kind for one in courses), np.array([one.level for one in courses]), changes)


def disturbance_answers(replay: Replay, theta: FloatArray, m: int) -> dict[str, ErrorAnswers]:
    """Answers of manoeuvre ``m`` at theta to the errors of each equation of ``UNITS``.

    Parameters
    ----------
    theta : (p,) deviations
    """
    prepared, deviations = replay.prepared[m], replay.deviations_at(theta, m)
    found = _moved(replay, theta, m)
    if prepared.replays_pressures:
        found |= _pressure_answers(replay, deviations, prepared)
    return found | _sensor_answers(replay, deviations, prepared)


def possible_errors(replay: Replay, theta: FloatArray, m: int) -> dict[str, list[Course]]:
    """Equation -> its possible errors [N or N m] in manoeuvre ``m``."""
    states, car = replay.states(theta, m), replay.car_at(theta)
    angles = [states[f"road_wheel_angle_{wheel}"] for wheel in WHEELS]
    along = [states[f"longitudinal_force_{wheel}"] for wheel in WHEELS]
    across = [states[f"lateral_force_{wheel}"] for wheel in WHEELS]
    force_x = sum(x * np.cos(a) - y * np.sin(a) for x, y, a in zip(along, across, angles, strict=True))
    force_y = sum(x * np.sin(a) + y * np.cos(a) for x, y, a in zip(along, across, angles, strict=True))
    height, yaw_inertia = float(car["height"]), float(car["yaw_inertia"])
    shares: dict[str, list[tuple[str, int, FloatArray]]] = {
        "longitudinal force": [("force", FORCE_X, np.asarray(force_x))],
        "lateral force": [("force", FORCE_Y, np.asarray(force_y))],
        "yaw moment": [("moment", YAW, yaw_inertia * states["yaw_acceleration"])],
        "load transfer": [("pitch", PITCH, height * np.asarray(force_x)), ("roll", ROLL, height * np.asarray(force_y))],
        **{
            f"wheel torque {wheel}": [
                (kind, WHEEL + i, states[f"{kind}_torque_{wheel}"]) for kind in ("brake", "drive")
            ]
            for i, wheel in enumerate(WHEELS)
        },
    }
    return {
        name: [
            *(_constant(replay.manoeuvres[m].samples, place) for place in _CONSTANTS.get(name, ())),
            *(_share(kind, of, _LEAST_LEVEL[UNITS[name]], place) for kind, place, of in mine),
        ]
        for name, mine in shares.items()
    }


def _constant(samples: int, place: int = NOWHERE) -> Course:
    return Course("constant", np.ones(samples), 1.0, place)


def _share(kind: str, of: FloatArray, least: float, place: int = NOWHERE) -> Course:
    level = float(np.sqrt(np.mean(of**2)))
    return Course(kind, of / level, level, place) if level > least else Course(kind, np.zeros_like(of), 0.0, place)


def _moved(replay: Replay, theta: FloatArray, m: int) -> dict[str, ErrorAnswers]:
    """Answers to forces, torques and moments."""
    prepared, deviations = replay.prepared[m], replay.deviations_at(theta, m)
    driven = replay.run_of(deviations, prepared, replay.pressures.at(deviations, prepared))
    car = driven.cars[0]
    tried = {"N": 0.005 * 9.81 * float(car["mass"]), "N m": 0.01 * float(np.sum(car["static_load"])) * 0.1}

    def run(place: int, disturbance: FloatArray) -> FloatArray:
        return run_one(driven, replay.gains, 0, prepared.chosen, place, disturbance)

    usual = run(NOWHERE, np.zeros(0))
    found = {}
    for name, courses in possible_errors(replay, theta, m).items():
        changes = np.zeros((len(usual), len(prepared.signals), len(courses)))
        size = tried[UNITS[name]]
        for k, course in enumerate(courses):
            if np.any(course.values):
                changes[:, : usual.shape[1], k] = (run(course.place, size * course.values) - usual) / size
        found[name] = ErrorAnswers.of(courses, changes)
    return found | {ALIKE: _alike([found[f"wheel torque {wheel}"] for wheel in WHEELS])}


def _alike(wheels: Sequence[ErrorAnswers]) -> ErrorAnswers:
    """Answers to errors at both wheels of an axle, of one size or share, made of those of each wheel."""
    axles = []
    for left, right in ((wheels[i], wheels[j]) for i, j in _AXLES):
        levels = np.hypot(left.levels, right.levels) / np.sqrt(2.0)
        both = left.levels * left.changes + right.levels * right.changes
        axles.append(ErrorAnswers(left.kinds, levels, both / np.where(levels > 0.0, levels, 1.0)))
    front, rear = axles
    return ErrorAnswers(
        front.kinds + rear.kinds,
        np.concatenate([front.levels, rear.levels]),
        np.concatenate([front.changes, rear.changes], axis=2),
    )


def _pressure_answers(replay: Replay, deviations: Mapping[str, float], prepared: Prepared) -> dict[str, ErrorAnswers]:
    """Answers of the wheel pressures to a rate [Pa/s] that the hydraulic unit lacks: a constant, a share of its own.

    A small shift of all measured pressures tells by which factor the unit hands on a pressure from sample to sample.
    """
    assert prepared.hydraulics is not None
    valid = prepared.pressure_valid
    measured = np.ascontiguousarray(replay.inputs_at(deviations, prepared, None)[:, :4])
    true = without_lag(deviations)
    usual, shifted = (
        replay.pressures.unit.wheels(true, prepared.hydraulics, measured + shift, valid)[0]
        for shift in (0.0, _TRIED_PA)
    )
    kept, samples = (shifted - usual) / _TRIED_PA, prepared.manoeuvre.samples
    found = {}
    for i, name in enumerate(PRESSURES):
        gain = PRESSURE_GAIN * valid[:, i]
        factor = np.clip(kept[1:, i] / np.maximum((1.0 - gain[:-1]) * kept[:-1, i] + gain[:-1], 1e-3), 0.0, 1.0)
        rate = np.diff(usual[:, i]) / SAMPLE_TIME_S
        courses = [_constant(samples - 1), _share("rate", rate, _TRIED_PA)]
        changes = np.zeros((samples, len(prepared.signals), len(courses)))
        place = prepared.signals.index(name)
        for k, course in enumerate(courses):
            pressure = 0.0
            for row in range(samples - 1):
                pressure = factor[row] * (1.0 - gain[row]) * pressure + SAMPLE_TIME_S * course.values[row]
                changes[row + 1, place, k] = pressure
        found[f"hydraulics {WHEELS[i]}"] = ErrorAnswers.of(courses, changes)
    return found


def _sensor_answers(replay: Replay, deviations: Mapping[str, float], prepared: Prepared) -> dict[str, ErrorAnswers]:
    """Answers to an offset and a share of each sensor's signal.

    The signal is the predicted one: the measured one holds the noise that the residual consists of.
    """
    pressures = replay.pressures.at(deviations, prepared)
    predicted = replay.car_outputs(deviations, prepared, pressures, replay.gains, 0, prepared.chosen)
    found = {}
    for name in (*_SENSORS, *_SCALED):
        if name not in prepared.signals:
            continue
        place = prepared.signals.index(name)
        share = _share("signal", predicted[:, place], 0.0)
        courses = [share] if name in _SCALED else [_constant(len(predicted)), share]
        size = _TRIED_SHARE * (share.level or 1.0)
        changes = np.zeros((len(predicted), len(prepared.signals), len(courses)))
        for k, course in enumerate(courses):
            changes[:, place, k] = course.values
            if name in CORRECTED:
                read = prepared.corrected.copy()
                read[:, CORRECTED.index(name)] += size * course.values
                misled = replace(prepared, corrected=read)
                moved = replay.car_outputs(deviations, misled, pressures, replay.gains, 0, prepared.chosen)
                changes[:, : len(prepared.chosen), k] -= (moved - predicted) / size
        found[f"sensor {name}"] = ErrorAnswers.of(courses, changes)
    return found
