"""Physics of the MuJoCo car that no tuning can fake."""

import math
from collections.abc import Callable

import numpy as np
import pytest
from plant_cases import GRAVITY, car_on, loads, stop, without_losses
from scipy.linalg import expm

from signals.wheels import WHEELS
from vehicle_model.plant import Plant
from vehicle_model.rigid_bodies import rigid_bodies
from vehicle_model.road_file import RoadFile
from vehicle_model.vehicle_file import load_vehicle

Record = Callable[..., None]

MASS, WHEELBASE, TO_FRONT, HEIGHT = 1296.0, 2.57, 1.25, 0.535  # Table 8


@pytest.mark.acceptance("F-4")
@pytest.mark.parametrize(
    ("speed", "brake", "steer"),
    [(26.4, [1500.0, 1500.0, 700.0, 700.0], 0.0), (26.4, 1e5, 0.0), (20.0, [900.0, 900.0, 400.0, 400.0], 0.4)],
    ids=["near the limit", "locked", "in a turn"],
)
def test_energy_balance_of_a_stop(speed: float, brake: list[float], steer: float, record: Record) -> None:
    car = car_on()
    car.reset(speed_m_s=speed)
    start = car.state()["mechanical_energy"]
    stop(car, brake, steer)
    state = car.state()
    residual = (start + state["drive_energy"] - state["dissipated_energy"] - state["mechanical_energy"]) / start
    assert abs(residual) < 1e-3  # the requirement is 0.5 %
    record("energy residual of the MuJoCo car", residual, "0.5 %")


def test_energy_balance_while_driving_and_climbing() -> None:
    car = car_on(RoadFile(grade=0.08, wind_speed_x=-5.0))
    car.reset(speed_m_s=10.0)
    start = car.state()["mechanical_energy"]
    car.step(5000, drive_torque=[0.0, 0.0, 500.0, 500.0])
    state = car.state()
    assert state["speed"] > 12.0
    residual = start + state["drive_energy"] - state["dissipated_energy"] - state["mechanical_energy"]
    assert abs(residual) < 1e-3 * state["drive_energy"]


def test_every_kind_of_loss_is_accounted() -> None:
    car = car_on()
    car.reset(speed_m_s=30.0)
    car.step(2000, brake_torque=[900.0, 900.0, 400.0, 400.0], steer=0.2)
    account = car.energy_account()
    assert account.pop("drive_energy") == 0.0
    assert all(value > 0.0 for value in account.values()), account
    assert sum(account.values()) == pytest.approx(car.state()["dissipated_energy"])


@pytest.mark.acceptance("F-4")
@pytest.mark.parametrize(("grade", "bank"), [(0.0, 0.0), (0.1, 0.0), (-0.25, 0.0), (0.0, 0.08), (0.12, -0.05)])
@pytest.mark.parametrize("name", ["ekf_car", "baseline_car", "asphalt_car"])
def test_sum_of_loads_is_the_weight(name: str, grade: float, bank: float, record: Record) -> None:
    vehicle = load_vehicle(name)
    car = Plant(vehicle, RoadFile(grade=grade, bank=bank))
    for speed in (0.0, 30.0):
        car.reset(speed_m_s=speed)
        expected = vehicle.body.mass * GRAVITY / math.sqrt(1.0 + grade**2 + bank**2)  # m g cos(gamma)
        error = loads(car).sum() / expected - 1.0
        assert abs(error) < 1e-9
        record("sum of loads of the MuJoCo car over m g cos(gamma) less 1", float(error), "1e-6")


def test_static_loads_follow_the_place_of_the_centre_of_gravity() -> None:
    car = car_on()
    front = MASS * GRAVITY * (WHEELBASE - TO_FRONT) / WHEELBASE / 2.0
    rear = MASS * GRAVITY * TO_FRONT / WHEELBASE / 2.0
    np.testing.assert_allclose(loads(car), [front, front, rear, rear], rtol=1e-9)
    car.set("body.mass", 1500.0)
    car.set("body.centre_of_gravity_to_front_axle", 1.4)
    car.reset(speed_m_s=0.0)
    front = 1500.0 * GRAVITY * (WHEELBASE - 1.4) / WHEELBASE / 2.0
    assert loads(car)[0] == pytest.approx(front, rel=5e-3)  # the body pitches: the arms change by millimetres
    assert loads(car).sum() == pytest.approx(1500.0 * GRAVITY, rel=1e-9)


def test_a_car_at_rest_stays_in_its_equilibrium() -> None:
    car = car_on(RoadFile(bank=0.05))
    car.reset(speed_m_s=0.0)
    before = loads(car)
    car.step(8000, brake_torque=2000.0)
    state = car.state()
    assert abs(state["speed"]) < 1e-9
    assert loads(car).sum() == pytest.approx(before.sum(), rel=1e-6)


@pytest.mark.parametrize("speed", [10.0, 25.0, 40.0])
def test_locked_stop_takes_v2_over_2_mu_g(speed: float) -> None:
    peak = 0.8
    car = Plant(without_losses({f"tyres.{axle}.longitudinal.peak_friction": peak for axle in ("front", "rear")}))
    car.reset(speed_m_s=speed)
    stop(car, 1e5)
    locked = peak * math.sin(1.316 * math.atan(14.34))  # eq. 88 with set T at slip -1
    distance = speed**2 / (2.0 * locked * GRAVITY)
    assert car.state()["distance"] == pytest.approx(distance, rel=5e-3)


def test_locked_stop_on_a_grade() -> None:
    grade = 0.1
    car = Plant(without_losses(), RoadFile(grade=grade, friction=0.5))
    car.reset(speed_m_s=20.0)
    stop(car, 1e5)
    shape = math.sin(1.316 * math.atan(14.34))
    along, across = grade / math.sqrt(1 + grade**2), 1.0 / math.sqrt(1 + grade**2)
    mu_f, mu_r = 0.5 * 1.12 * shape, 0.5 * 0.98 * shape
    # axle loads under deceleration a (eq. 73): F_zf = m (g L_r + a h) / L, F_zr = m (g L_f - a h) / L
    to_rear = WHEELBASE - TO_FRONT
    a = (mu_f * to_rear + mu_r * TO_FRONT) * GRAVITY * across / (WHEELBASE - (mu_f - mu_r) * HEIGHT)
    # on a grade the tyre force is m (a_total - g sin): loads shift with the tyre force alone
    assert car.state()["distance"] == pytest.approx(20.0**2 / (2.0 * (a + GRAVITY * along)), rel=1e-2)


def test_locked_wheels_stand_exactly_still() -> None:
    car = car_on()
    car.reset(speed_m_s=20.0)
    car.step(500, brake_torque=1e5)
    state = car.state()
    assert state["speed"] > 10.0
    assert [state[f"true_wheel_speed_{wheel}"] for wheel in WHEELS] == [0.0] * 4
    assert [state[f"slip_ratio_{wheel}"] for wheel in WHEELS] == [-1.0] * 4
    for wheel in WHEELS:  # the brake gives what holds the wheel, not what it could give
        held = -state[f"longitudinal_force_{wheel}"] * 0.278
        assert state[f"true_brake_torque_{wheel}"] == pytest.approx(held, rel=0.03)


@pytest.mark.parametrize("grade", [0.1, -0.1])
def test_a_stopped_car_stays_on_a_grade(grade: float) -> None:
    car = car_on(RoadFile(grade=grade))
    car.reset(speed_m_s=8.0)
    car.step(8000, brake_torque=800.0)
    places, forces = [], []
    for _ in range(50):
        car.step(100, brake_torque=800.0)
        state = car.state()
        places.append((state["position_x"], state["position_y"]))
        forces.append([state[f"longitudinal_force_{wheel}"] for wheel in WHEELS])
        assert [state[f"true_wheel_speed_{wheel}"] for wheel in WHEELS] == [0.0] * 4
    creep = np.ptp(np.array(places), axis=0)
    assert creep[0] < 1e-6
    assert creep[1] < 1e-6
    assert np.ptp(np.array(forces), axis=0).max() < 1.0  # no chatter
    weight = MASS * GRAVITY * grade / math.sqrt(1 + grade**2)
    assert sum(forces[-1]) == pytest.approx(weight, rel=1e-4)
    car.step(1000, brake_torque=0.0)
    assert car.state()["speed"] * -grade > 0.0  # and rolls away when released
    assert abs(car.state()["speed"]) > 0.5


def test_rolling_resistance_holds_a_car_on_a_slight_grade_without_brakes() -> None:
    car = car_on(RoadFile(grade=0.01))  # rolling resistance is 0.015 of the weight
    car.reset(speed_m_s=0.0)
    car.step(5000)
    assert abs(car.state()["speed"]) < 1e-6
    assert abs(car.state()["position_x"]) < 0.01


def test_load_transfer_is_m_a_h_over_l() -> None:
    """Stiff springs: the formula holds for a body that does not pitch; locked wheels: no spin changes its momentum."""
    stiff = {f"suspension.{axle}.spring_rate": 6e5 for axle in ("front", "rear")}
    stiff |= {f"wheels.{wheel}.vertical_stiffness": 4e6 for wheel in WHEELS}
    stiff |= {
        f"suspension.{axle}.{kind}_damping": 8e3 for axle in ("front", "rear") for kind in ("compression", "rebound")
    }
    car = Plant(without_losses(stiff), RoadFile(friction=0.7))
    car.reset(speed_m_s=25.0)
    at_rest = loads(car)
    car.step(1500, brake_torque=1e5)
    deceleration = -car.state()["true_longitudinal_acceleration"]
    expected = MASS * deceleration * HEIGHT / WHEELBASE
    moved = loads(car) - at_rest
    assert moved[:2].sum() == pytest.approx(expected, rel=5e-3)
    assert moved[2:].sum() == pytest.approx(-expected, rel=5e-3)


def test_load_transfer_of_the_soft_car() -> None:
    """With soft springs the pitching body's centre moves over the wheels, and the slowing wheels add their momentum."""
    car = Plant(without_losses())
    car.reset(speed_m_s=30.0)
    at_rest = loads(car)
    car.step(2000, brake_torque=[800.0, 800.0, 400.0, 400.0])
    before = car.state()
    car.step(1, brake_torque=[800.0, 800.0, 400.0, 400.0])
    state = car.state()
    deceleration = -state["true_longitudinal_acceleration"]
    spin = sum(before[f"true_wheel_speed_{wheel}"] - state[f"true_wheel_speed_{wheel}"] for wheel in WHEELS) / 1e-3
    forward = math.tan(state["pitch_angle"]) * (HEIGHT - 0.278)  # of the centre of gravity over the hubs
    expected = (MASS * (deceleration * HEIGHT + GRAVITY * forward) + 0.8 * spin) / WHEELBASE
    assert (loads(car) - at_rest)[:2].sum() == pytest.approx(expected, rel=5e-3)


def test_lateral_load_transfer_is_m_a_h_over_track() -> None:
    car = car_on()
    car.reset(speed_m_s=20.0)
    car.step(4000, steer=0.3)
    state, load = car.state(), loads(car)
    acceleration = state["true_lateral_acceleration"]
    assert acceleration > 2.0
    moved = (load[1] + load[3] - load[0] - load[2]) / 2.0
    # the centre of gravity moves over the outer wheels as the body rolls
    outward = math.sin(state["roll_angle"]) * (HEIGHT - 0.278)
    expected = MASS * (acceleration * HEIGHT + GRAVITY * outward) / 1.46
    assert moved == pytest.approx(expected, rel=2e-2)


def test_steady_circle_follows_kinematics() -> None:
    car = car_on()
    car.reset(speed_m_s=5.0)
    car.step(3000, steer=0.32)
    state = car.state()
    # at low lateral acceleration the curvature is tan(steer angle) / wheelbase
    assert state["true_yaw_rate"] / state["speed"] == pytest.approx(math.tan(0.32 / 16.0) / WHEELBASE, rel=3e-2)


def test_heave_pitch_and_axle_hop_follow_the_linear_model() -> None:
    """Free vibration after a change of gravity, against the matrix exponential of the undamped half-car model."""
    quiet = {f"wheels.{wheel}.vertical_damping": 0.0 for wheel in WHEELS}
    quiet |= {
        f"suspension.{axle}.{kind}_damping": 0.0 for axle in ("front", "rear") for kind in ("compression", "rebound")
    }
    vehicle = without_losses(quiet)
    car = Plant(vehicle)
    change = -0.5
    car.reset(speed_m_s=0.0)
    car.set("road.gravity", GRAVITY + change)
    bodies = rigid_bodies(vehicle.numbers(), vehicle.numbers())
    arms = bodies.wheel_positions[[0, 2], 0] - bodies.sprung_centre[0]
    # the pitching body swings the freely rolling wheels below it to and fro, and stands on its springs like a pendulum
    # on its head
    below = bodies.sprung_centre[2] - bodies.wheel_positions[0, 2]
    swung = 4.0 * (38.0 + 0.8 / 0.278**2)
    pitch_inertia = bodies.sprung_inertia[1, 1] + swung * below**2 * bodies.sprung_mass / (bodies.sprung_mass + swung)
    mass = np.diag([bodies.sprung_mass, pitch_inertia, 76.0, 76.0])
    springs = [2.0 * vehicle.suspension.front.spring_rate, 2.0 * vehicle.suspension.rear.spring_rate]
    tyres = [2.0 * (vehicle.wheels.fl.vertical_stiffness or 0.0), 2.0 * (vehicle.wheels.rl.vertical_stiffness or 0.0)]
    stiffness = np.zeros((4, 4))
    for axle, (arm, spring, tyre) in enumerate(zip(arms, springs, tyres, strict=True)):
        row = np.zeros(4)
        row[[0, 1, 2 + axle]] = 1.0, -arm, -1.0  # travel = wheel - (body - arm pitch), pitch nose down
        stiffness += spring * np.outer(row, row)
        stiffness[2 + axle, 2 + axle] += tyre
    stiffness[1, 1] -= bodies.sprung_mass * GRAVITY * below
    force = -change * np.array([bodies.sprung_mass, 0.0, 76.0, 76.0])
    generator = np.zeros((9, 9))
    generator[:4, 4:8] = np.eye(4)
    generator[4:8, :4] = -np.linalg.solve(mass, stiffness)
    generator[4:8, 8] = np.linalg.solve(mass, force)
    step = expm(generator * 1e-3)
    linear, simulated, exact = np.r_[np.zeros(8), 1.0], [], []
    for _ in range(1000):
        car.step(1)
        linear = step @ linear
        state = car.state()
        simulated.append([state["suspension_travel_fl"], state["suspension_travel_rl"], state["pitch_angle"]])
        body = linear[0]
        exact.append([linear[2] - body + arms[0] * linear[1], linear[3] - body + arms[1] * linear[1], linear[1]])
    error = np.abs(np.array(simulated) - np.array(exact)).max(axis=0) / np.abs(np.array(exact)).max(axis=0)
    assert np.all(error < 0.03), error


def test_drag_has_the_size_and_height_of_the_file() -> None:
    vehicle = without_losses()
    free = Plant(vehicle)
    car = Plant(load_vehicle("ekf_car"))
    for plant in (free, car):
        for wheel in WHEELS:
            plant.set(f"wheels.{wheel}.rolling_resistance", 0.0)
        plant.reset(speed_m_s=40.0)
        plant.step(1)
    difference = free.outputs[0] - car.outputs[0]
    # D_a v^2 = 0.48 * 1600 N on the mass of the car and of its wheels' spin
    force = 0.5 * 1.2 * 0.4 * 2.0 * 40.0**2
    assert difference == pytest.approx(force / MASS * 1e-3, rel=1e-2)


def test_coast_down_loses_rolling_resistance() -> None:
    car = car_on()
    car.set("aerodynamics.drag_coefficient", 0.0)
    car.reset(speed_m_s=15.0)
    car.step(2000)
    state = car.state()
    rolling_mass = MASS + 4.0 * 0.8 / 0.278**2
    assert (15.0 - state["speed"]) / 2.0 == pytest.approx(0.015 * MASS * GRAVITY / rolling_mass, rel=5e-3)


def test_drive_torque_accelerates_and_spins_the_driven_wheels() -> None:
    car = car_on(RoadFile(friction=0.3))
    car.reset(speed_m_s=3.0)
    car.step(500, drive_torque=[0.0, 0.0, 900.0, 900.0])
    state = car.state()
    assert state["slip_ratio_rl"] > 0.3
    assert abs(state["slip_ratio_fl"]) < 0.01
    assert state["drive_energy"] > 0.0


def test_wind_changes_drag_only() -> None:
    still, windy = car_on(), car_on(RoadFile(wind_speed_x=-10.0))
    for car in (still, windy):
        car.reset(speed_m_s=30.0)
        car.step(1000)
    assert windy.outputs[0] < still.outputs[0]
    lost = car_on(RoadFile(wind_speed_x=30.0))
    lost.reset(speed_m_s=30.0)
    lost.step(10)
    assert abs(lost.energy_account()["air_energy"]) < 1.0
