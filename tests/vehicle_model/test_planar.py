"""The planar reference car: conservation, convergence, interface. Its document's figures: tests/acceptance."""

import numpy as np
import pytest

from vehicle_model.interface import PLANT_OUTPUTS
from vehicle_model.reference import Planar
from vehicle_model.road_file import RoadFile
from vehicle_model.vehicle_file import load_vehicle

CAR = "lada_vesta_assumed_steering"
TURN = {"steer": 1.0, "drive_torque": [200.0, 200.0, 0.0, 0.0]}


def car(**options) -> Planar:
    built = Planar(load_vehicle(CAR), **options)
    built.reset(speed_m_s=20.0)
    return built


def test_energy_is_conserved_in_a_turn_under_power():
    plant = car()
    before = plant.state()["mechanical_energy"]
    plant.step(3000, **TURN)
    state = plant.state()
    after = state["mechanical_energy"] + state["dissipated_energy"] - state["drive_energy"]
    assert after == pytest.approx(before, rel=1e-5)
    assert all(value >= 0.0 for kind, value in plant.energy_account().items() if kind != "drive_energy")


def test_half_the_step_changes_little():
    coarse, fine = car(), car(substeps=20)
    for plant in (coarse, fine):
        plant.step(3000, **TURN)
    a, b = coarse.state(), fine.state()
    assert a["lateral_speed"] == pytest.approx(b["lateral_speed"], abs=2e-4)
    assert a["position_y"] == pytest.approx(b["position_y"], rel=1e-3)


def test_left_and_right_are_mirrored():
    left, right = car(), car()
    left.step(1500, steer=0.8)
    right.step(1500, steer=-0.8)
    a, b = left.state(), right.state()
    assert a["true_yaw_rate"] == pytest.approx(-b["true_yaw_rate"], rel=1e-12)
    assert a["vertical_load_fl"] == pytest.approx(b["vertical_load_fr"], rel=1e-12)
    assert a["lateral_force_rl"] == pytest.approx(-b["lateral_force_rr"], rel=1e-12)


def test_locked_stop_uses_the_sliding_friction():
    """Locked wheels slide at s = -1: D sin(C arctan(B)) of the tyre, with drag; a stop then is that deceleration."""
    plant = car()
    plant.step(500, brake_torque=4000.0)
    state = plant.state()
    assert state["true_wheel_speed_fl"] == 0.0
    friction = 0.95 * np.sin(1.5 * np.arctan(10.0))
    expected = friction * 9.81 + 0.45 * state["speed"] ** 2 / 1559.0
    assert -state["true_longitudinal_acceleration"] == pytest.approx(expected, rel=2e-3)


def test_parked_on_a_hill_it_hardly_creeps():
    plant = Planar(load_vehicle(CAR), RoadFile(grade=0.10))
    plant.reset(speed_m_s=0.0)
    plant.step(3000, brake_torque=1500.0)
    assert abs(plant.state()["speed"]) < 3e-3


def test_same_inputs_same_bits_and_a_bound_view():
    first, second = car(), car()
    view = np.zeros(len(PLANT_OUTPUTS))
    second.bind(view)
    for plant in (first, second):
        plant.step(700, **TURN)
    assert first.outputs.tobytes() == view.tobytes()
    with pytest.raises(ValueError, match="found a view"):
        second.bind(np.zeros(3))


def test_parameters_change_while_it_drives():
    plant = car()
    plant.set("planar.roll_stiffness", 45000.0)
    plant.step(2000, steer=0.5)
    soft = plant.state()["roll_angle"]
    stiff = car()
    stiff.step(2000, steer=0.5)
    assert soft == pytest.approx(2.0 * stiff.state()["roll_angle"], rel=0.03)
    assert plant.get("planar.roll_stiffness") == 45000.0
    assert "steering.map.left.0" in plant.names()
