"""Conservation and convergence of the MuJoCo car with every part of its suspension at work."""

import math

import numpy as np
import pytest
from plant_cases import without_losses
from test_suspension import EVERYTHING, both_axles

from vehicle_model.plant import Plant
from vehicle_model.vehicle_file import VehicleFile, load_vehicle, set_parameter

CARS = ("ekf_car", "commonroad_bmw_320i")


def busy_car(name: str, **more: float) -> VehicleFile:
    """A car whose dampers adapt, whose stops touch, with guided wheels, lift and tyres that lag."""
    vehicle = load_vehicle(name)
    changes = both_axles(EVERYTHING) | {
        "suspension.adaptive.mode": 1.0,
        "aerodynamics.drag_coefficient": 0.3,
        "aerodynamics.lift_coefficient_rear": 0.1,
        "aerodynamics.side_force_coefficient": 1.5,
        "tyres.front.relaxation_length_lateral": 0.4,
        "tyres.rear.relaxation_length_lateral": 0.4,
    }
    for path, value in (changes | more).items():
        set_parameter(vehicle, path, value)
    return vehicle


@pytest.mark.parametrize("name", CARS)
def test_no_energy_is_created_in_ten_minutes_of_random_driving(name: str) -> None:
    """Engine and brakes off; hills keep the car rolling, the steering and the grip are random."""
    car, random = Plant(busy_car(name)), np.random.default_rng(4)
    car.reset(speed_m_s=40.0)
    start = car.state()["mechanical_energy"]
    steer, speeds, excess = 0.0, [], []
    lost, lifted, largest_step = 0.0, start, 0.0
    for tenth in range(6000):
        if tenth % 10 == 0:
            steer = float(random.uniform(-1.5, 1.5)) * min(1.0, 15.0 / max(abs(car.outputs[0]), 5.0))
            car.set("road.friction", float(random.uniform(0.3, 1.0)))
        if tenth % 200 == 0:  # down where the car points, so that it goes on rolling
            heading = car.state()["yaw_angle"]
            car.set("road.grade", -0.08 * math.cos(heading))
            car.set("road.bank", -0.08 * math.sin(heading))
        car.step(100, steer=steer)
        state = car.state()
        excess.append((state["mechanical_energy"] + state["dissipated_energy"] - start) / start)
        speeds.append(abs(state["speed"]))
        # what was lost never comes back: only the springs of the contact hold some of it for a while
        largest_step = min(largest_step, state["dissipated_energy"] - lost)
        lost, lifted = state["dissipated_energy"], max(lifted, state["mechanical_energy"])
    assert np.mean(np.array(speeds) > 2.0) > 0.8  # it drove
    assert lost > 2.0 * start
    assert np.max(excess) < 1e-3
    assert lifted < start * (1.0 + 1e-3)
    assert largest_step > -1e-3 * start


@pytest.mark.parametrize("name", CARS)
@pytest.mark.parametrize("drive", [0.0, 250.0], ids=["coasting", "driving"])
def test_a_symmetric_car_goes_straight_for_a_minute(name: str, drive: float) -> None:
    car = Plant(busy_car(name))
    car.reset(speed_m_s=40.0)
    torque = [0.0, 0.0, drive, drive]
    for _ in range(60):
        car.step(1000, drive_torque=torque)
        assert abs(car.state()["position_y"]) < 1e-3
    assert car.state()["distance"] > 700.0


def test_the_integration_converges_with_first_order() -> None:
    """Steps of 1, 1/2, 1/4 ms against 1/32 ms in a smooth manoeuvre; all steps are of first order."""

    def state_after(steps: int) -> np.ndarray:
        car = Plant(without_losses({"suspension.front.roll_centre_height": 0.05}), steps_per_tick=steps)
        car.reset(speed_m_s=25.0)
        for tick in range(1500):
            swing = math.sin(2.0 * math.pi * 0.7e-3 * tick)
            car.step(1, steer=0.4 * swing, brake_torque=300.0 * swing**2)
        names = ("speed", "lateral_speed", "true_yaw_rate", "yaw_angle", "roll_angle", "position_y")
        return np.array([car.state()[name] for name in names])

    reference = state_after(32)
    error = np.abs(np.array([state_after(steps) for steps in (1, 2, 4)]) - reference)
    ratios = error[:-1] / error[1:]
    # (1 - 1/32) / (1/2 - 1/32) and (1/2 - 1/32) / (1/4 - 1/32) for an error in proportion to the step
    np.testing.assert_allclose(ratios, [[31.0 / 15.0] * 6, [15.0 / 7.0] * 6], rtol=0.1)
    assert error[0, 0] < 1e-4 * reference[0]
    assert error[0, 5] < 5e-3
