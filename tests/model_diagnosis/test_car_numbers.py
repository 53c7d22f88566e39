"""A wrong vehicle's numbers as a vehicle file: mass and pads of another car, with the intervals of the fit."""

from pathlib import Path

import numpy as np
import pytest

from model_diagnosis.evidence.car_numbers import CarNumbers
from model_diagnosis.extension.car_numbers import numbers_of
from model_diagnosis.extension.extended_vehicle import extensions_of, write_extended_vehicle
from model_diagnosis.manoeuvre import Manoeuvre
from model_diagnosis.replay import Replay
from vehicle_model import load_vehicle

CAR = "ekf_car"


def _replay() -> Replay:
    time = np.arange(0.0, 2.0, 0.01)
    channels = {"speed": np.full_like(time, 20.0)}
    weights = {name: np.ones_like(time) for name in channels}
    return Replay(load_vehicle(CAR), [Manoeuvre("steady", time, channels, weights, "made for a test")])


def test_the_other_cars_numbers_stand_in_the_file_with_their_intervals(tmp_path: Path) -> None:
    """20 % more mass ± 1 % and pads 30 % weaker ± 2 % standard deviation; 90 % of a normal lies within 1.645 of it."""
    replay = _replay()
    vehicle = load_vehicle(CAR)
    columns = ("mass_change.factor", "brake_pad_friction.factor")
    numbers = tuple(replay.columns.index(name) for name in columns)
    theta = np.zeros(len(replay.columns))
    theta[list(numbers)] = 0.2, -0.3
    found = numbers_of(replay, CarNumbers(theta, numbers, (0.01, 0.02)), None)
    deviations = {f"{one.effect.name}.{name}": interval for one in found for name, interval in one.deviations.items()}
    assert set(deviations) == set(columns)
    assert deviations["mass_change.factor"] == pytest.approx((0.2, 0.2 - 0.01645, 0.2 + 0.01645), rel=1e-3)
    extensions, remarks = extensions_of(vehicle, found)
    assert remarks == []
    other = load_vehicle(write_extended_vehicle(tmp_path / "extended_vehicle.yaml", CAR, vehicle, extensions))
    assert other.body.mass == pytest.approx(1.2 * vehicle.body.mass)
    assert other.brakes.front.pad_friction == pytest.approx(0.7 * vehicle.brakes.front.pad_friction)


def test_a_car_without_nominal_numbers_has_none() -> None:
    assert numbers_of(_replay(), None, None) == []
