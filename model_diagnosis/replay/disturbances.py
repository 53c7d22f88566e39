"""Answers of the observer replay to an error of its own in each equation: force, torque, moment, pressure rate, sensor.

An equation's error in a manoeuvre is a constant and a share of the force, torque or signal that the equation is about:
what is wrong with a model acts for longer than a noise, and mostly in proportion.
"""

from collections.abc import Iterator, Mapping
from dataclasses import replace

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

UNITS: Mapping[str, str] = {
    "longitudinal force": "N",
    "lateral force": "N",
    "yaw moment": "N m",
    **{f"wheel torque {wheel}": "N m" for wheel in WHEELS},
    "load transfer": "N m",
    **{f"hydraulics {wheel}": "Pa/s" for wheel in WHEELS},
    "sensor longitudinal_acceleration": "m/s^2",
    "sensor lateral_acceleration": "m/s^2",
    "sensor yaw_rate": "rad/s",
    "sensor speed": "m/s",
    **{f"sensor wheel_speed_{wheel}": "rad/s" for wheel in WHEELS},
}
"""Equation -> unit of its error."""


def disturbance_answers(replay: Replay, theta: FloatArray, m: int) -> dict[str, FloatArray]:
    """Answers (n, c, k) of manoeuvre ``m`` at theta to the k unit errors of each equation.

    Parameters
    ----------
    theta : (p,) deviations

    Returns
    -------
    equation of ``UNITS`` -> change of measured minus predicted per unit of the error's root mean square
    """
    prepared, deviations = replay.prepared[m], replay.deviations_at(theta, m)
    found = _moved(replay, theta, m)
    if prepared.replays_pressures:
        found |= _pressure_answers(replay, deviations, prepared)
    return found | _sensor_answers(replay, deviations, prepared)


def equation_forces(replay: Replay, theta: FloatArray, m: int) -> dict[str, list[tuple[int, FloatArray]]]:
    """Equation -> places and courses (n,) [N or N m] of its possible errors, root mean square 1."""
    states, car = replay.states(theta, m), replay.car_at(theta)
    constant = np.ones(replay.manoeuvres[m].samples)
    angles = [states[f"road_wheel_angle_{wheel}"] for wheel in WHEELS]
    along = [states[f"longitudinal_force_{wheel}"] for wheel in WHEELS]
    across = [states[f"lateral_force_{wheel}"] for wheel in WHEELS]
    force_x = sum(x * np.cos(a) - y * np.sin(a) for x, y, a in zip(along, across, angles, strict=True))
    force_y = sum(x * np.sin(a) + y * np.cos(a) for x, y, a in zip(along, across, angles, strict=True))
    height = float(car["height"])
    yaw = float(car["yaw_inertia"]) * states["yaw_acceleration"]
    wished: dict[str, list[tuple[int, FloatArray]]] = {
        "longitudinal force": [(FORCE_X, constant), (SLOPE, constant), (FORCE_X, np.asarray(force_x))],
        "lateral force": [(FORCE_Y, constant), (BANK, constant), (FORCE_Y, np.asarray(force_y))],
        "yaw moment": [(YAW, constant), (YAW, yaw)],
        "load transfer": [(PITCH, height * np.asarray(force_x)), (ROLL, height * np.asarray(force_y))],
    }
    for i, wheel in enumerate(WHEELS):
        torque = states[f"drive_torque_{wheel}"] - states[f"brake_torque_{wheel}"]
        wished[f"wheel torque {wheel}"] = [(WHEEL + i, constant), (WHEEL + i, torque)]
    return {name: list(_of_level_one(courses, _LEAST_LEVEL[UNITS[name]])) for name, courses in wished.items()}


def _of_level_one(courses: list[tuple[int, FloatArray]], least: float) -> Iterator[tuple[int, FloatArray]]:
    for place, course in courses:
        level = float(np.sqrt(np.mean(course**2)))
        if level > least or (level > 0.0 and np.ptp(course) == 0.0):
            yield place, course / level


def _moved(replay: Replay, theta: FloatArray, m: int) -> dict[str, FloatArray]:
    """Answers to forces, torques and moments."""
    prepared, deviations = replay.prepared[m], replay.deviations_at(theta, m)
    driven = replay.run_of(deviations, prepared, replay.pressures.at(deviations, prepared))
    car = driven.cars[0]
    tried = {"N": 0.005 * 9.81 * float(car["mass"]), "N m": 0.01 * float(np.sum(car["static_load"])) * 0.1}

    def run(place: int, disturbance: FloatArray) -> FloatArray:
        return run_one(driven, replay.gains, 0, prepared.chosen, place, disturbance)

    usual = run(NOWHERE, np.zeros(0))
    found = {}
    for name, courses in equation_forces(replay, theta, m).items():
        if not courses:
            continue
        answers = np.zeros((len(usual), len(prepared.signals), len(courses)))
        for k, (place, course) in enumerate(courses):
            size = tried[UNITS[name]]
            answers[:, : usual.shape[1], k] = (run(place, size * course) - usual) / size
        found[name] = answers
    return found


def _pressure_answers(replay: Replay, deviations: Mapping[str, float], prepared: Prepared) -> dict[str, FloatArray]:
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
        level = float(np.sqrt(np.mean(rate**2)))
        courses = [np.ones(samples - 1)] + ([rate / level] if level > _TRIED_PA else [])
        answers = np.zeros((samples, len(prepared.signals), len(courses)))
        place = prepared.signals.index(name)
        for k, course in enumerate(courses):
            pressure = 0.0
            for row in range(samples - 1):
                pressure = factor[row] * (1.0 - gain[row]) * pressure + SAMPLE_TIME_S * course[row]
                answers[row + 1, place, k] = pressure
        found[f"hydraulics {WHEELS[i]}"] = answers
    return found


def _sensor_answers(replay: Replay, deviations: Mapping[str, float], prepared: Prepared) -> dict[str, FloatArray]:
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
        signal = predicted[:, place]
        level = float(np.sqrt(np.mean(signal**2))) or 1.0
        shapes = [signal / level] if name in _SCALED else [np.ones_like(signal), signal / level]
        answers = np.zeros((len(signal), len(prepared.signals), len(shapes)))
        for k, shape in enumerate(shapes):
            answers[:, place, k] = shape
            if name in CORRECTED:
                size = _TRIED_SHARE * level
                read = prepared.corrected.copy()
                read[:, CORRECTED.index(name)] += size * shape
                misled = replace(prepared, corrected=read)
                moved = replay.car_outputs(deviations, misled, pressures, replay.gains, 0, prepared.chosen)
                answers[:, : len(prepared.chosen), k] -= (moved - predicted) / size
        found[f"sensor {name}"] = answers
    return found
