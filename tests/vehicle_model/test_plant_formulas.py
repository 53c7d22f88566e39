"""The car on each tyre formula: stops in both directions of travel, standstill, energy, relaxation."""

import math
from pathlib import Path

import numpy as np
import pytest
from plant_cases import GRAVITY, without_losses
from test_tir_tyres import write

from vehicle_model.plant import Plant
from vehicle_model.road_file import RoadFile
from vehicle_model.tyres import read_tir
from vehicle_model.tyres.relaxation import fill_in
from vehicle_model.tyres.tyre_file import TirTyre, TyrePair
from vehicle_model.vehicle_file import VehicleFile, load_tyres

FORMULAS = ("pacejka_1987", "burckhardt_dry_asphalt", "tmeasy", "dugoff", "fiala", "lugre", "dahl")


TIR_FILES = ("tir 52", "tir 61", "tir 62")
"""Magic Formula 5.2, 6.1 and 6.2 from a file."""


@pytest.fixture
def pair(name: str, tmp_path: Path) -> TyrePair:
    """Tyres of a shipped formula, or from a file of the version that the name ends with."""
    if name not in TIR_FILES:
        return load_tyres(name)
    tyre = TirTyre(tir=str(write(tmp_path, name.removeprefix("tir "))))
    fill_in(tyre)
    return TyrePair(front=tyre, rear=tyre.model_copy(deep=True))


def car_with(tyres: TyrePair) -> VehicleFile:
    vehicle = without_losses()
    object.__setattr__(vehicle, "tyres", tyres)
    return vehicle


def stopped(car: Plant, speed: float, brake: float) -> int:
    """Ticks until a car that began at a speed of either sign stands."""
    car.reset(speed_m_s=speed)
    for tick in range(20000):
        if car.outputs[0] * math.copysign(1.0, speed) <= 1e-3:
            return tick
        car.step(1, brake_torque=brake)
    raise AssertionError("the car does not stop")


@pytest.mark.parametrize("name", FORMULAS + TIR_FILES)
@pytest.mark.parametrize("direction", [1.0, -1.0], ids=["forwards", "backwards"])
def test_a_stop_ends_at_rest(pair: TyrePair, direction: float) -> None:
    """Between the distance of the peak and that of the lightest friction; no energy is made; the car then stands."""
    car = Plant(car_with(pair))
    speed = 15.0 * direction
    car.reset(speed_m_s=speed)
    start = car.state()["mechanical_energy"]
    stopped(car, speed, 900.0)
    distance = car.state()["distance"]
    assert 15.0**2 / (2.0 * 1.25 * GRAVITY) < distance < 15.0**2 / (2.0 * 0.6 * GRAVITY)
    car.step(6000, brake_torque=900.0)  # it rocks on its contact springs first
    state = car.state()
    assert abs(state["speed"]) < 1e-5
    assert abs(start - state["dissipated_energy"] - state["mechanical_energy"]) < 2e-3 * start


@pytest.mark.parametrize("name", FORMULAS + TIR_FILES)
@pytest.mark.parametrize("grade", [0.08, -0.08])
def test_a_braked_car_stands_on_a_grade(pair: TyrePair, grade: float) -> None:
    car = Plant(car_with(pair), RoadFile(grade=grade))
    car.reset(speed_m_s=0.0)
    car.step(4000, brake_torque=900.0)
    place = car.state()["position_x"]
    car.step(3000, brake_torque=900.0)
    assert abs(car.state()["position_x"] - place) < 1e-5


@pytest.mark.parametrize("name", FORMULAS + TIR_FILES)
def test_a_car_rolls_back_and_is_caught(pair: TyrePair) -> None:
    """Let go on 10 % it rolls back by g sin(gamma) t; the brake stops it there too."""
    car = Plant(car_with(pair), RoadFile(grade=0.1))
    car.reset(speed_m_s=0.0)
    car.step(3000)
    expected = -GRAVITY * 0.1 / math.hypot(1.0, 0.1) * 3.0
    assert car.state()["speed"] == pytest.approx(expected, rel=0.05)  # the wheels' inertia takes some
    car.step(3000, brake_torque=900.0)
    assert abs(car.state()["speed"]) < 1e-3


@pytest.mark.parametrize("name", FORMULAS + TIR_FILES)
def test_slow_driving_through_zero_in_both_directions(pair: TyrePair) -> None:
    """Drive forwards and backwards with a turned wheel at walking pace: forces stay those of a slow car."""
    car = Plant(car_with(pair))
    car.reset(speed_m_s=0.3)
    largest = 0.0
    for torque in (60.0, -60.0, -60.0, 60.0):
        for _ in range(1500):
            car.step(1, drive_torque=[0.0, 0.0, torque, torque], steer=1.0)
            state = car.state()
            largest = max(largest, abs(state["lateral_force_fl"]), abs(state["longitudinal_force_rl"]))
    assert np.isfinite(car.outputs).all()
    assert largest < 1000.0
    assert abs(state["speed"]) < 2.0


@pytest.fixture
def tir(tmp_path: Path) -> TirTyre:
    return TirTyre(tir=str(write(tmp_path)))


def test_a_locked_wheel_of_a_tir_tyre_brakes_alike_in_both_directions(tir: TirTyre) -> None:
    for speed in (15.0, -15.0):
        car = Plant(car_with(TyrePair(front=tir, rear=tir.model_copy(deep=True))))
        car.reset(speed_m_s=speed)
        car.step(400, brake_torque=1e5)
        state = car.state()
        assert abs(state["slip_ratio_fl"]) == 1.0
        expected = read_tir(tir.tir).forces(-1.0, 0.0, 0.0, state["vertical_load_fl"]).fx
        assert state["longitudinal_force_fl"] == pytest.approx(math.copysign(expected, -speed), rel=0.02)


def test_relaxation_lengths_of_a_tir_tyre_are_those_of_its_file(tmp_path: Path) -> None:
    carcass = "[STRUCTURAL]\nLONGITUDINAL_STIFFNESS = 250000\nLATERAL_STIFFNESS = 120000\n"
    from test_tir_tyres import COEFFICIENTS

    tyre = TirTyre(tir=str(write(tmp_path, coefficients=COEFFICIENTS + carcass)), relaxation_length_lateral=0.7)
    fill_in(tyre)
    along, _ = read_tir(tyre.tir).relaxation_lengths(4000.0)
    assert tyre.relaxation_length_longitudinal == pytest.approx(along) == pytest.approx(4000.0 * 22.0 / 250e3)
    assert tyre.relaxation_length_lateral == 0.7
    bare = TirTyre(tir=str(write(tmp_path)))
    fill_in(bare)
    assert bare.relaxation_length_longitudinal == pytest.approx(4000.0 * 22.0 / 3e5)  # the standing tyre's stiffness
    cornering = 20.0 * 4000.0 * math.sin(2.0 * math.atan(1.0 / 1.9))
    assert bare.relaxation_length_lateral == pytest.approx(cornering / 2e5)
