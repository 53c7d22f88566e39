"""Equation errors: which balance a hidden change violates."""

import numpy as np
import pytest
from plant_log import coast_and_drive, drive, gentle_stop, sine_steer

from model_diagnosis.replay import Replay, equation_errors
from model_diagnosis.replay.equations import UNITS
from vehicle_model.vehicle_file import VehicleFile, set_parameter

GENTLE, PULSED, SINE, TURN, COAST = range(5)


def _rms(values: np.ndarray) -> float:
    return float(np.sqrt(np.nanmean(values[30:] ** 2)))


def _errors(car: VehicleFile, manoeuvre: object) -> dict[str, float]:
    theta = np.zeros(len(Replay(car, []).columns))
    return {name: _rms(values) for name, values in equation_errors(car, manoeuvre, theta).items()}  # type: ignore[arg-type]


def test_balances_of_the_same_car_are_met(replay: Replay, car: VehicleFile) -> None:
    """Within a percent of the forces at work: 30 bar brake with 5 m/s^2, the sine reaches 7 m/s^2."""
    gentle, sine = _errors(car, replay.manoeuvres[GENTLE]), _errors(car, replay.manoeuvres[SINE])
    assert gentle["longitudinal force"] < 0.01 * car.body.mass * 5.0
    assert gentle["wheel torque fl"] < 0.01 * 670.0
    assert gentle["speed and acceleration"] < 0.05
    assert sine["lateral force"] < 0.01 * car.body.mass * 7.0
    assert sine["yaw moment"] < 0.02 * car.body.yaw_inertia * 1.2
    assert set(gentle) <= set(UNITS)


def test_a_weak_wheel_brake_violates_that_wheels_balance(replay: Replay, car: VehicleFile) -> None:
    changed = car.model_copy(deep=True)
    set_parameter(changed, "brakes.pad_glazing_rl", 0.3)
    weak = _errors(car, drive(changed, gentle_stop, 4.0, 30.0))
    usual = _errors(car, replay.manoeuvres[GENTLE])
    growth = {
        wheel: weak[f"wheel torque {wheel}"] / usual[f"wheel torque {wheel}"] for wheel in ("fl", "fr", "rl", "rr")
    }
    assert max(growth, key=lambda wheel: growth[wheel]) == "rl"
    assert growth["rl"] > 3.0 * max(growth[wheel] for wheel in ("fl", "fr", "rr"))


def test_a_heavier_car_violates_the_longitudinal_balance_by_its_inertia(replay: Replay, car: VehicleFile) -> None:
    changed = car.model_copy(deep=True)
    set_parameter(changed, "body.mass", car.body.mass * 1.2)
    manoeuvre = drive(changed, coast_and_drive, 8.0, 25.0)
    theta = np.zeros(len(Replay(car, []).columns))
    error = equation_errors(car, manoeuvre, theta)["longitudinal force"]
    driven = (manoeuvre.time > 3.0) & (manoeuvre.time < 4.8)
    felt = manoeuvre.channels["longitudinal_acceleration"][driven]
    # the tyres' forces follow from the torques: what is lacking is the added mass times its acceleration
    assert np.nanmean(error[driven]) == pytest.approx(-0.2 * car.body.mass * np.mean(felt), rel=0.15)


def test_yaw_inertia_violates_the_yaw_balance_most(replay: Replay, car: VehicleFile) -> None:
    changed = car.model_copy(deep=True)
    set_parameter(changed, "body.yaw_inertia", car.body.yaw_inertia * 1.4)
    wrong, usual = _errors(car, drive(changed, sine_steer, 5.0, 25.0)), _errors(car, replay.manoeuvres[SINE])
    # by what is at work in them: the sine reaches 7 m/s^2 and turns the car by 1.2 rad/s^2
    at_work = {"yaw moment": car.body.yaw_inertia * 1.2, "lateral force": car.body.mass * 7.0}
    share = {name: (wrong[name] - usual[name]) / size for name, size in at_work.items()}
    assert share["yaw moment"] > 3.0 * share["lateral force"]
    assert wrong["yaw moment"] > 10.0 * usual["yaw moment"]
