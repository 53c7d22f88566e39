"""The single-track car against closed forms and the balances of the friction document's sections 2.3 and 2.4."""

import math
from collections.abc import Callable

import numpy as np
import pytest
from numpy.typing import NDArray

from signals.errors import InputError
from vehicle_model.interface import PLANT_OUTPUTS
from vehicle_model.reference.axle_scaling import axle_acceleration, axle_inertia, axle_torque, axle_torque_from_mean
from vehicle_model.reference.single_track import SingleTrack
from vehicle_model.road_file import Jump, RoadFile
from vehicle_model.vehicle_file import VehicleFile, load_vehicle, set_parameter

MASS, WHEELBASE, TO_FRONT, HEIGHT, RADIUS, THETA = 1296.0, 2.57, 1.25, 0.535, 0.278, 0.8
GRAVITY = 9.81
LOCKED_T = math.sin(1.316 * math.atan(14.34))  # of the peak, set T at slip 1
FULL_BRAKE = 3000.0  # N m per wheel, more than the tyres can turn


def car(**changes: float) -> VehicleFile:
    """The car of Table 8 with some parameters changed; paths are written with ``__`` for the dot."""
    vehicle = load_vehicle("ekf_car")
    for path, value in changes.items():
        set_parameter(vehicle, path.replace("__", "."), value)
    return vehicle


def equal_tyres() -> VehicleFile:
    """Both axles with a peak of 1, no air, no rolling resistance."""
    vehicle = car(
        tyres__front__longitudinal__peak_friction=1.0,
        tyres__rear__longitudinal__peak_friction=1.0,
        aerodynamics__drag_coefficient=0.0,
    )
    for wheel in ("fl", "fr", "rl", "rr"):
        set_parameter(vehicle, f"wheels.{wheel}.rolling_resistance", 0.0)
    return vehicle


def stop(plant: SingleTrack, brake: float, longest: int = 20_000) -> dict[str, float]:
    for _ in range(longest):
        plant.step(1, brake_torque=brake)
        if plant.state()["speed"] < 1e-3:
            return plant.state()
    raise AssertionError("the car did not stop")


def of(plant: SingleTrack, name: str) -> NDArray[np.float64]:
    start = PLANT_OUTPUTS.index(f"{name}_fl")
    return plant.outputs[start : start + 4]


@pytest.mark.acceptance("F-4")
def test_static_loads_follow_eq_73(record: Callable[..., None]) -> None:
    plant = SingleTrack(car(), RoadFile(grade=0.1))
    plant.reset(speed_m_s=0.0)
    cosine = 1.0 / math.sqrt(1.01)
    loads = of(plant, "vertical_load").sum()
    record("sum of loads over m g cos(gamma), less 1", loads / (MASS * GRAVITY * cosine) - 1.0, "1e-6")
    assert loads == pytest.approx(MASS * GRAVITY * cosine, rel=1e-12)
    level = SingleTrack(car())
    level.reset(speed_m_s=20.0)
    front, rear = of(level, "vertical_load")[0] * 2, of(level, "vertical_load")[2] * 2
    assert front == pytest.approx(MASS * GRAVITY * (WHEELBASE - TO_FRONT) / WHEELBASE, rel=1e-12)
    assert rear == pytest.approx(MASS * GRAVITY * TO_FRONT / WHEELBASE, rel=1e-12)


@pytest.mark.acceptance("F-4")
@pytest.mark.parametrize("grade", [0.0, 0.08, -0.12])
def test_force_balance_and_sum_of_loads_in_every_tick(grade: float) -> None:
    plant = SingleTrack(car(), RoadFile(grade=grade, wind_speed_x=-3.0))
    plant.reset(speed_m_s=30.0)
    cosine = 1.0 / math.sqrt(1.0 + grade * grade)
    generator = np.random.default_rng(3)
    for _ in range(400):
        before = plant.state()["speed"]
        brake = generator.uniform(0.0, 1200.0)
        plant.step(1, brake_torque=brake, drive_torque=[0.0, 0.0, 150.0, 150.0])
        state = plant.state()
        air = 0.48 * (0.5 * (before + state["speed"]) + 3.0) ** 2
        resistance = air + 0.015 * MASS * GRAVITY * cosine + MASS * GRAVITY * grade * cosine
        expected = (of(plant, "longitudinal_force").sum() - resistance) / MASS
        assert state["true_longitudinal_acceleration"] == pytest.approx(expected, abs=1e-4)
        assert of(plant, "vertical_load").sum() == pytest.approx(MASS * GRAVITY * cosine, rel=1e-12)


@pytest.mark.acceptance("F-4")
def test_loads_move_with_the_acceleration_as_eq_124() -> None:
    # steady sliding on a rising road with air: loads of the closed form against the moment balance
    vehicle = car(aerodynamics__drag_height=0.7)
    plant = SingleTrack(vehicle, RoadFile(grade=0.05))
    plant.reset(speed_m_s=40.0)
    plant.step(400, brake_torque=FULL_BRAKE)
    state = plant.state()
    cosine, sine = 1.0 / math.sqrt(1.0025), 0.05 / math.sqrt(1.0025)
    air = 0.48 * state["speed"] ** 2
    acceleration = state["true_longitudinal_acceleration"]
    front = (
        -air * 0.7 - MASS * acceleration * HEIGHT - MASS * GRAVITY * HEIGHT * sine
        + MASS * GRAVITY * (WHEELBASE - TO_FRONT) * cosine
    ) / WHEELBASE  # fmt: skip
    assert 2.0 * of(plant, "vertical_load")[0] == pytest.approx(front, rel=1e-4)


@pytest.mark.acceptance("F-4")
def test_locked_deceleration_is_that_of_eq_76() -> None:
    plant = SingleTrack(car(aerodynamics__drag_coefficient=0.0))
    plant.reset(speed_m_s=26.4)
    plant.step(500, brake_torque=FULL_BRAKE)
    front, rear = -1.12 * LOCKED_T, -0.98 * LOCKED_T
    divisor = WHEELBASE - (rear - front) * HEIGHT
    tyres = GRAVITY * (front * WHEELBASE + (rear - front) * TO_FRONT) / divisor
    # rolling resistance adds its own pull, and moves load by its height over the road through the tyres
    rolling = 0.015 * GRAVITY
    shifted = (front - rear) * HEIGHT * rolling / divisor
    expected = tyres - rolling + shifted
    assert plant.state()["true_longitudinal_acceleration"] == pytest.approx(expected, rel=1e-9)
    assert of(plant, "slip_ratio") == pytest.approx([-1.0] * 4)


@pytest.mark.acceptance("F-4")
@pytest.mark.parametrize("speed", [15.0, 26.4, 40.0])
def test_locked_stop_takes_v_squared_over_two_mu_g(speed: float, record: Callable[..., None]) -> None:
    plant = SingleTrack(equal_tyres())
    plant.reset(speed_m_s=speed)
    plant._state[0]["omega"] = 0.0  # locked from the start
    end = stop(plant, FULL_BRAKE)
    ratio = end["distance"] / (speed**2 / (2.0 * LOCKED_T * GRAVITY))
    record("locked stop over v^2/(2 mu g)", ratio, "0.995 ... 1.005")
    assert ratio == pytest.approx(1.0, abs=0.005)


@pytest.mark.acceptance("F-4")
@pytest.mark.parametrize("grade", [0.0, 0.06])
def test_energy_balance_of_a_stop(grade: float, record: Callable[..., None]) -> None:
    plant = SingleTrack(car(), RoadFile(grade=grade))
    plant.reset(speed_m_s=30.0)
    start = plant.state()["mechanical_energy"]
    plant.step(800, drive_torque=[0.0, 0.0, 900.0, 900.0])
    for _ in range(3000):
        plant.step(1, brake_torque=[900.0, 900.0, 450.0, 450.0])
    state = plant.state()
    balance = state["mechanical_energy"] + state["dissipated_energy"] - state["drive_energy"] - start
    record("energy balance over energy at the start", balance / start, "0.005")
    assert abs(balance) < 1e-9 * start
    account = plant.energy_account()
    assert account["drive_energy"] > 1e4
    assert account["brake_energy"] > 0.5 * start
    assert min(account.values()) > 0.0


@pytest.mark.acceptance("F-5")
def test_axles_scale_consistently() -> None:
    # no grip at all: a wheel is a free inertia, and torques of the two wheels add up
    plant = SingleTrack(car(), RoadFile(friction=0.0))
    plant.reset(speed_m_s=10.0)
    left, right = 30.0, 10.0
    plant.step(100, drive_torque=[0.0, 0.0, left, right])
    inertia = axle_inertia(THETA, THETA)
    assert inertia == 1.6  # friction document 6.1.1, derived
    expected = 10.0 / RADIUS + 0.1 * axle_acceleration(axle_torque(left, right), 0.0, RADIUS, inertia)
    assert of(plant, "true_wheel_speed")[2:] == pytest.approx([expected] * 2, rel=1e-12)
    assert of(plant, "true_wheel_speed")[:2] == pytest.approx([10.0 / RADIUS] * 2, rel=1e-12)


@pytest.mark.acceptance("F-5")
def test_mean_torque_has_to_be_converted(record: Callable[..., None]) -> None:
    # the source's figures show the mean of an axle's two wheels: as axle torque it is off by a factor of two
    mean = 20.0
    plant = SingleTrack(car(), RoadFile(friction=0.0))
    plant.reset(speed_m_s=10.0)
    plant.step(100, drive_torque=[0.0, 0.0, mean, mean])
    gained = of(plant, "true_wheel_speed")[2] - 10.0 / RADIUS
    inertia = axle_inertia(THETA, THETA)
    unconverted = 0.1 * axle_acceleration(mean, 0.0, RADIUS, inertia)
    record("plant's gain of speed over that of the mean torque unconverted", gained / unconverted, "2")
    assert gained == pytest.approx(0.1 * axle_acceleration(axle_torque_from_mean(mean), 0.0, RADIUS, inertia))
    assert gained == pytest.approx(2.0 * unconverted)


@pytest.mark.acceptance("F-4")
def test_brake_holds_until_more_than_its_torque_turns_the_wheel() -> None:
    plant = SingleTrack(car(), RoadFile(friction=0.0))
    plant.reset(speed_m_s=0.0)
    plant.step(50, brake_torque=100.0, drive_torque=[0.0, 0.0, 99.9, 99.9])
    assert of(plant, "true_wheel_speed").tolist() == [0.0] * 4
    assert of(plant, "true_brake_torque")[2] == pytest.approx(99.9)
    plant.step(50, brake_torque=100.0, drive_torque=[0.0, 0.0, 101.0, 101.0])
    assert of(plant, "true_wheel_speed")[2] == pytest.approx(0.05 * 2.0 / 1.6, rel=1e-9)


@pytest.mark.acceptance("F-4")
def test_wheel_stays_locked_at_speed_and_breaks_away_when_released() -> None:
    plant = SingleTrack(car())
    plant.reset(speed_m_s=25.0)
    plant.step(300, brake_torque=FULL_BRAKE)
    assert of(plant, "true_wheel_speed").tolist() == [0.0] * 4
    # the tyre turns a locked wheel with F R: a little more brake than that holds it
    force = -2.0 * of(plant, "longitudinal_force")[0]
    hold = 0.5 * force * RADIUS
    plant.step(20, brake_torque=[1.01 * hold, 1.01 * hold, FULL_BRAKE, FULL_BRAKE])
    assert of(plant, "true_wheel_speed")[0] == 0.0
    plant.step(20, brake_torque=[0.99 * hold, 0.99 * hold, FULL_BRAKE, FULL_BRAKE])
    assert of(plant, "true_wheel_speed")[0] > 0.0
    plant.step(200)
    assert of(plant, "slip_ratio") == pytest.approx([0.0] * 4, abs=0.01)


def test_a_stopped_car_stays_stopped() -> None:
    for grade in (0.0, 0.1, -0.1):
        plant = SingleTrack(car(), RoadFile(grade=grade))
        plant.reset(speed_m_s=5.0)
        end = stop(plant, 1500.0)
        plant.step(500, brake_torque=1500.0)
        place = plant.state()["position_x"]
        # the tyres spring back by what they carried over their stiffness: 13 kN over four times 300 kN/m
        assert place == pytest.approx(end["position_x"], abs=0.011)
        for _ in range(50):
            plant.step(100, brake_torque=1500.0)
            assert plant.state()["speed"] == 0.0
        assert plant.state()["position_x"] == place
        assert of(plant, "true_wheel_speed").tolist() == [0.0] * 4


@pytest.mark.acceptance("F-4")
def test_car_rolls_back_on_a_grade_and_stands_on_a_slight_one() -> None:
    plant = SingleTrack(car(aerodynamics__drag_coefficient=0.0), RoadFile(grade=0.1))
    plant.reset(speed_m_s=0.0)
    plant.step(3000)
    spinning = 2.0 * 1.6 / RADIUS**2
    expected = -MASS * GRAVITY * (0.1 - 0.015) / math.sqrt(1.01) / (MASS + spinning)
    assert plant.state()["speed"] == pytest.approx(3.0 * expected, rel=0.01)
    # C_roll is larger than the grade: rolling resistance holds the car
    plant = SingleTrack(car(), RoadFile(grade=0.014))
    plant.reset(speed_m_s=0.0)
    plant.step(1000)
    assert plant.state()["speed"] == 0.0


@pytest.mark.acceptance("F-4")
def test_coasting_follows_drag_and_rolling_resistance() -> None:
    plant = SingleTrack(car())
    plant.reset(speed_m_s=40.0)
    plant.step(10_000)
    resistance, drag = 0.015 * MASS * GRAVITY, 0.48
    mass = MASS + 2.0 * 1.6 / RADIUS**2
    phase = math.atan(40.0 * math.sqrt(drag / resistance)) - 10.0 * math.sqrt(drag * resistance) / mass
    assert plant.state()["speed"] == pytest.approx(math.sqrt(resistance / drag) * math.tan(phase), rel=1e-4)


@pytest.mark.acceptance("F-4")
def test_drive_torque_pushes_the_car_and_loads_the_driven_axle() -> None:
    plant = SingleTrack(car(aerodynamics__drag_coefficient=0.0))
    plant.reset(speed_m_s=10.0)
    plant.step(1000, drive_torque=[0.0, 0.0, 500.0, 500.0])
    mass = MASS + 2.0 * 1.6 / RADIUS**2
    expected = (1000.0 / RADIUS - 0.015 * MASS * GRAVITY) / mass
    # less than 1 % is lost to the growing slip of the driven wheels
    assert plant.state()["true_longitudinal_acceleration"] == pytest.approx(expected, rel=0.01)
    assert of(plant, "vertical_load")[2] * 2 > MASS * GRAVITY * TO_FRONT / WHEELBASE + 500.0
    spin = SingleTrack(car())
    spin.reset(speed_m_s=5.0)
    spin.step(500, drive_torque=[0.0, 0.0, 1500.0, 1500.0])
    assert of(spin, "slip_ratio")[2] > 0.5
    assert abs(of(spin, "slip_ratio")[0]) < 0.01


def test_rear_axle_never_pulls() -> None:
    plant = SingleTrack(car(body__centre_of_gravity_height=2.0))
    plant.reset(speed_m_s=20.0)
    plant.step(300, brake_torque=FULL_BRAKE)
    assert of(plant, "vertical_load")[2] == 0.0
    assert of(plant, "vertical_load")[0] * 2 == pytest.approx(MASS * GRAVITY)


def test_tyres_never_carry_more_than_their_peak() -> None:
    plant = SingleTrack(car(), RoadFile(friction=0.4))
    plant.reset(speed_m_s=15.0)
    generator = np.random.default_rng(5)
    for _ in range(1500):
        brake, drive = generator.uniform(0.0, 2500.0, 2) * generator.integers(0, 2, 2)
        plant.step(1, brake_torque=brake, drive_torque=[0.0, 0.0, drive, drive])
        assert np.all(np.abs(of(plant, "friction_used")) <= of(plant, "friction_limit") * (1 + 1e-12))


@pytest.mark.acceptance("F-4")
def test_friction_jump_by_place_reaches_the_front_axle_first() -> None:
    road = RoadFile(jumps=[Jump(position=10.0, friction=0.6)])
    plant = SingleTrack(car(), road)
    plant.reset(speed_m_s=20.0)
    plant.step(450)  # centre of gravity at 9 m, front axle beyond 10 m, rear axle before it
    assert of(plant, "friction_limit") == pytest.approx([0.672, 0.672, 0.98, 0.98])
    plant.step(300)
    assert of(plant, "friction_limit") == pytest.approx([0.672, 0.672, 0.588, 0.588])


@pytest.mark.acceptance("F-4")
def test_friction_jump_by_time_and_on_line_change() -> None:
    plant = SingleTrack(car(), RoadFile(jumps=[Jump(time=0.1, friction=0.5)]))
    plant.reset(speed_m_s=20.0)
    plant.step(100)
    assert of(plant, "friction_limit")[0] == pytest.approx(1.12)
    plant.step(2)
    assert of(plant, "friction_limit")[0] == pytest.approx(0.56)
    plant.set("road.friction", 0.8)
    plant.step(1)
    assert of(plant, "friction_limit")[0] == pytest.approx(0.448)
    plant.set("tyres.front.longitudinal.peak_friction", 1.0)
    plant.step(1)
    assert of(plant, "friction_limit")[0] == pytest.approx(0.4)


def test_sides_share_the_force_of_their_axle_by_their_grip() -> None:
    from vehicle_model.road_file import Side

    plant = SingleTrack(equal_tyres(), RoadFile(left=Side(friction=1.0), right=Side(friction=0.3)))
    plant.reset(speed_m_s=20.0)
    plant.step(300, brake_torque=FULL_BRAKE)
    force = of(plant, "longitudinal_force")
    assert force[1] / force[0] == pytest.approx(0.3)
    assert plant.state()["true_longitudinal_acceleration"] == pytest.approx(-0.65 * LOCKED_T * GRAVITY, rel=1e-6)


@pytest.mark.parametrize("brake", [350.0, 900.0, FULL_BRAKE])
def test_finer_sub_steps_change_a_stop_by_little(brake: float) -> None:
    results = []
    for substeps in (5, 10, 80):
        plant = SingleTrack(car(), substeps=substeps)
        plant.reset(speed_m_s=26.4)
        results.append(stop(plant, brake))
    coarse, fine, finest = results
    assert coarse["distance"] == pytest.approx(fine["distance"], rel=0.0005)
    assert coarse["distance"] == pytest.approx(finest["distance"], rel=0.0005)


def test_every_output_belongs_to_four_wheels_and_lateral_ones_are_zero() -> None:
    plant = SingleTrack(car())
    plant.reset(speed_m_s=20.0)
    plant.step(100, brake_torque=500.0)
    for name in ("true_wheel_speed", "slip_ratio", "vertical_load", "longitudinal_force", "friction_used"):
        values = of(plant, name)
        assert values[0] == values[1] != 0.0
        assert values[2] == values[3] != 0.0
    state = plant.state()
    for name in ("lateral_speed", "true_yaw_rate", "side_slip_angle", "lateral_force_fl", "pitch_angle"):
        assert state[name] == 0.0


def test_outputs_go_into_a_bound_view() -> None:
    plant = SingleTrack(car())
    vector = np.zeros(len(PLANT_OUTPUTS) + 5)
    plant.bind(vector[3:-2])
    plant.reset(speed_m_s=12.0)
    assert vector[3 + PLANT_OUTPUTS.index("speed")] == 12.0
    assert vector[:3].tolist() == [0.0] * 3
    with pytest.raises(ValueError, match="shape"):
        plant.bind(np.zeros(3))


def test_parameters_by_name() -> None:
    plant = SingleTrack(car())
    assert plant.get("body.mass") == 1296.0
    plant.set("body.mass", 1500.0)
    plant.reset(speed_m_s=0.0)
    assert of(plant, "vertical_load").sum() == pytest.approx(1500.0 * GRAVITY)
    assert {"road.friction", "plant.substeps", "wheels.fl.inertia", "tyres.front.longitudinal.peak_friction"} <= set(
        plant.names()
    )
    for path, value in (("body.mas", 1.0), ("brakes.front.pad_friction", 0.4), ("body.mass", -5.0)):
        with pytest.raises(InputError):
            plant.set(path, value)
    assert plant.get("body.mass") == 1500.0
