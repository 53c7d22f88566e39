"""Air forces of the MuJoCo car: lift, side force, wind and gusts, against their formulas and the energy account."""

import math

import numpy as np
import pytest
from plant_cases import loads, without_losses

from vehicle_model.plant import Plant
from vehicle_model.road import RoadTables
from vehicle_model.road_file import Gust, RoadFile
from vehicle_model.wind import wind_at

MASS = 1296.0
PRESSURE_AREA = 0.5 * 1.2 * 2.0  # of the car of Table 8, over speed squared


def test_lift_takes_load_from_its_axle() -> None:
    lift = {"aerodynamics.lift_coefficient_front": 0.1, "aerodynamics.lift_coefficient_rear": -0.2}
    hard = {  # a pitch would move the weight
        f"suspension.{axle}.{name}": value
        for axle in ("front", "rear")
        for name, value in (("spring_rate", 4e5), ("compression_damping", 8e3), ("rebound_damping", 8e3))
    }
    car = Plant(without_losses(lift | hard))
    car.reset(speed_m_s=50.0)
    before = loads(car)
    car.step(3000)
    speed = car.state()["speed"]
    moved = loads(car) - before
    assert moved[:2].sum() == pytest.approx(-0.1 * PRESSURE_AREA * speed**2, rel=1e-2)
    assert moved[2:].sum() == pytest.approx(0.2 * PRESSURE_AREA * speed**2, rel=1e-2)


def test_side_wind_pushes_with_its_coefficient_and_turns_with_its_arm() -> None:
    """Force c_y q A beta, beta the angle of the air; its arm gives the moment, whose power is accounted."""
    changes = {"aerodynamics.side_force_coefficient": 2.0, "aerodynamics.side_force_position": 0.4}
    wind = -8.0
    car = Plant(without_losses(changes), RoadFile(friction=0.0, wind_speed_y=wind))  # nothing but air acts
    car.reset(speed_m_s=30.0)
    start = car.state()["mechanical_energy"]
    car.step(10)
    state = car.state()
    air_speed = math.hypot(30.0, wind)
    side_force = 2.0 * PRESSURE_AREA * air_speed * wind  # sine of the air's angle times the pressure
    assert state["true_lateral_acceleration"] == pytest.approx(side_force / MASS, rel=1e-2)
    yaw_inertia = 0.1269 * MASS * 2.57 * 4.3
    assert state["true_yaw_rate"] == pytest.approx(0.01 * 0.4 * side_force / yaw_inertia, rel=2e-2)
    assert state["mechanical_energy"] + state["dissipated_energy"] == pytest.approx(start, rel=1e-7)


def test_a_gust_rises_to_its_peak_and_comes_again() -> None:
    road = RoadTables(RoadFile(wind_speed_x=-2.0, gust=Gust(speed_x=5.0, speed_y=12.0, start=1.0, duration=2.0)))
    [record] = road.record
    assert wind_at(record, 0.9) == (-2.0, 0.0)
    assert wind_at(record, 2.0) == pytest.approx((3.0, 12.0))
    assert wind_at(record, 1.5) == pytest.approx((0.5, 6.0))
    assert wind_at(record, 3.0) == (-2.0, 0.0)
    road.set("road.gust.period", 10.0)
    [record] = road.record
    assert wind_at(record, 32.0) == pytest.approx((3.0, 12.0))
    assert wind_at(record, 34.0) == (-2.0, 0.0)


def test_a_gust_moves_the_car_and_no_gust_changes_no_bit() -> None:
    side = {"aerodynamics.side_force_coefficient": 2.0}
    calm, silent, windy = (
        Plant(without_losses(side), RoadFile(gust=gust))
        for gust in (Gust(), Gust(start=1.0, duration=0.5, period=3.0), Gust(speed_y=15.0, duration=1.0))
    )
    for car in (calm, silent, windy):
        car.reset(speed_m_s=35.0)
        car.step(2000)
    assert np.array_equal(calm.outputs, silent.outputs)
    assert windy.state()["position_y"] > 0.05
    calm.set("road.gust.speed_y", 15.0)
    calm.step(3000)
    assert calm.state()["position_y"] == pytest.approx(silent.state()["position_y"], abs=1e-9)  # it is over
