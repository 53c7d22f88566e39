"""The two-track car of the vertical-load document and the four-state car of the force document, as plants."""

import numpy as np
import pytest

from vehicle_model.interface import PLANT_OUTPUTS
from vehicle_model.reference.steered_track import SteeredTrack
from vehicle_model.reference.two_track import TwoTrack
from vehicle_model.road_file import RoadFile
from vehicle_model.vehicle_file import load_vehicle

WHEELS = ("fl", "fr", "rl", "rr")


def test_steady_turn_of_the_two_track_car() -> None:
    """Closed form of the linear single track: r = V delta / (L + K V^2), K from 2 C per axle (Mitschke, 22.4)."""
    car = TwoTrack(load_vehicle("e_class_suv"))
    car.reset(speed_m_s=15.0)
    angle = 0.002  # small enough for the linear part of the tyre
    for _ in range(6000):
        force = 5000.0 * (15.0 - car.state()["speed"])
        car.step(1, drive_torque=0.25 * force * 0.347, steer=17.0 * angle)
    state = car.state()
    gradient = 1862.0 / 2.95 * (1.77 / (2 * 129487.0) - 1.18 / (2 * 129487.0))
    speed = state["speed"]
    assert state["true_yaw_rate"] == pytest.approx(speed * angle / (2.95 + gradient * speed**2), rel=0.005)
    assert state["true_lateral_acceleration"] == pytest.approx(speed * state["true_yaw_rate"], rel=0.002)
    # 1604 N per m/s^2 from left to right (vertical-load document 2.3) and 4.744e-3 rad (2.2)
    loads = np.array([state[f"vertical_load_{wheel}"] for wheel in WHEELS])
    acceleration = state["true_lateral_acceleration"]
    assert loads[1] + loads[3] - loads[0] - loads[2] == pytest.approx(1604.0 * acceleration, rel=0.002)
    assert state["roll_angle"] == pytest.approx(4.744e-3 * acceleration, rel=0.002)
    assert loads.sum() == pytest.approx(1862.0 * 9.81, rel=1e-12)


def test_grip_bounds_the_two_track_car() -> None:
    car = TwoTrack(load_vehicle("e_class_suv"), RoadFile(friction=0.2))
    car.reset(speed_m_s=20.0)
    car.step(2000, steer=17.0 * 0.2)
    state = car.state()
    for wheel in WHEELS:
        assert abs(state[f"lateral_force_{wheel}"]) <= 0.2 * state[f"vertical_load_{wheel}"] + 1e-9
    car.reset(speed_m_s=20.0)
    car.step(1000, brake_torque=1e5)
    # every wheel at its grip: v falls by mu g t
    assert car.state()["speed"] == pytest.approx(20.0 - 0.2 * 9.81, rel=1e-3)


def test_brakes_hold_the_two_track_car_still() -> None:
    car = TwoTrack(load_vehicle("e_class_suv"))
    car.reset(speed_m_s=1.0)
    car.step(2000, brake_torque=2000.0)
    assert abs(car.state()["speed"]) < 1e-6


def test_energy_of_the_four_state_car() -> None:
    """Drive work is motion gained and what brakes and tyres take; explicit sums of a 1 ms step keep it to 0.5 %."""
    car = SteeredTrack(load_vehicle("neural_700kg"))
    car.reset(speed_m_s=8.0)
    start = car.state()["mechanical_energy"]
    for k in range(10_000):
        car.step(1, drive_torque=[0, 0, 60.0, 60.0], steer=11.2 * np.sin(2.0 * np.pi * 0.2 * k * 1e-3))
    state = car.state()
    assert start == pytest.approx(0.5 * 700.0 * 64.0)
    gained = state["mechanical_energy"] - start
    assert gained == pytest.approx(state["drive_energy"] - state["dissipated_energy"], rel=0.005)


def test_the_steering_actuator_lags() -> None:
    car = SteeredTrack(load_vehicle("neural_700kg"))
    car.reset(speed_m_s=8.0)
    car.step(100, steer=16.0 * 0.3)
    assert car.state()["true_road_wheel_angle_fl"] == pytest.approx(0.3 * (1.0 - np.exp(-1.0)), rel=1e-6)


@pytest.mark.parametrize(("plant", "vehicle"), [(TwoTrack, "ekf_car"), (SteeredTrack, "asphalt_car")])
def test_any_car_can_be_driven(plant: type[TwoTrack] | type[SteeredTrack], vehicle: str) -> None:
    """Sections that a file leaves out follow from its body, suspension and tyres."""
    car = plant(load_vehicle(vehicle))
    view = np.zeros(len(PLANT_OUTPUTS))
    car.bind(view)
    car.reset(speed_m_s=20.0)
    car.step(3000, steer=0.2)
    assert np.isfinite(view).all()
    assert car.state()["true_yaw_rate"] > 0.02
    car.set("body.mass", 1.5 * car.get("body.mass"))
    before = car.state()["true_yaw_rate"]
    car.step(1000, steer=0.2)
    assert car.state()["true_yaw_rate"] != before
