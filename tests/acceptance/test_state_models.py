"""Models of the vehicle-state document (AC-01 to AC-15): the plant's and the observers' own, against its figures."""

import math
from collections.abc import Callable

import numpy as np
import pytest

from estimators.vehicle_state_axes import BENCH_INDEX, bench_slip, document_slip
from estimators.vehicle_state_car import GRAVITY, document_car
from estimators.vehicle_state_model import (
    air_drag,
    axle_torque,
    magic_formula,
    magic_formula_full,
    pitch_step,
    road_wheel_angle,
    roll_step,
    rolling_coefficient,
    rolling_loads,
    slip,
    slip_angle,
    static_loads,
    wheel_speeds,
)
from estimators.wheel_sliding_mode_step import turn_wheel
from signals.errors import InputError
from vehicle_model.reference import Planar
from vehicle_model.road_file import RoadFile
from vehicle_model.vehicle_file import load_vehicle

VESTA = "lada_vesta_assumed_steering"
WHEELS = ("fl", "fr", "rl", "rr")
DOCUMENT_ROAD = RoadFile(gravity=GRAVITY)


@pytest.fixture
def numbers() -> dict[str, float]:
    return load_vehicle(VESTA).numbers()


@pytest.fixture
def car(numbers: dict[str, float]) -> np.void:
    return document_car(numbers).record[0]


def plant(**options: int) -> Planar:
    return Planar(load_vehicle(VESTA), DOCUMENT_ROAD, **options)


def loads(state: dict[str, float]) -> np.ndarray:
    return np.array([state[f"vertical_load_{wheel}"] for wheel in WHEELS])


@pytest.mark.acceptance("V-1", "V-12")
def test_wheel_order_and_signs(car: np.void) -> None:
    """0.3: FR, FL, RR, RL; a turn to the right is positive and speeds up the left wheels."""
    assert [WHEELS[k] for k in BENCH_INDEX] == ["fr", "fl", "rr", "rl"]
    speeds = [wheel_speeds(10.0, 0.0, 0.5, car, i) for i in range(4)]
    assert speeds[1][0] == pytest.approx(10.0 + 0.5 * 0.755)
    assert speeds[0][0] == pytest.approx(10.0 - 0.5 * 0.755)
    assert speeds[0][1] == pytest.approx(0.5 * 1.14)
    assert speeds[2][1] == pytest.approx(-0.5 * 1.495)
    # positive steer, to the right: positive slip angle, force to the right, turn to the right
    assert slip_angle(10.0, 0.0, 0.0, 0.05, car, 0) == pytest.approx(0.05)
    car_left = plant()
    car_left.reset(speed_m_s=10.0)
    car_left.step(500, steer=-0.5)
    state = car_left.state()
    assert state["slip_angle_fl"] > 0.0  # the same number in both conventions
    assert state["lateral_force_fl"] < 0.0  # to the right, y points left here
    assert state["true_yaw_rate"] < 0.0
    # no second minus: a car that slides to the right, without steer, is pushed to the left
    assert slip_angle(10.0, 1.0, 0.0, 0.0, car, 2) < 0.0
    assert document_slip(bench_slip(0.7)) == pytest.approx(0.7)


@pytest.mark.acceptance("V-2")
def test_loads_add_up_to_the_weight(record: Callable[..., None]) -> None:
    worst = 0.0
    for roll_dynamics in (0, 1):
        vehicle = plant(roll_dynamics=roll_dynamics)
        vehicle.set("road.grade", 0.1)
        vehicle.reset(speed_m_s=15.0)
        for steer, torque in ((1.0, 200.0), (-1.5, -100.0), (0.3, 400.0)):
            for _ in range(20):
                vehicle.step(25, steer=steer, drive_torque=[torque, torque, 0.0, 0.0])
                state = vehicle.state()
                # the wheels' mean over a tick, beside the grade that the car feels at its heading
                weight = 1559.0 * GRAVITY / math.sqrt(1.0 + 0.1**2)
                worst = max(worst, abs(loads(state).sum() / weight - 1.0))
    record("sum of the loads over m g cos(theta) - 1", worst, "<= 1e-9")
    assert worst <= 1e-9


@pytest.mark.acceptance("V-3")
def test_static_loads(record: Callable[..., None]) -> None:
    found = loads(plant().state())
    record("front N", found[0], "4337.1 +- 0.1")
    record("rear N", found[2], "3307.2 +- 0.1")
    assert found[:2] == pytest.approx([4337.1, 4337.1], abs=0.1)
    assert found[2:] == pytest.approx([3307.2, 3307.2], abs=0.1)
    # below its speed gate the listing returns the statics of another car (l. 6188-6194)
    assert not np.allclose(found, [4249.0, 4249.0, 3395.0, 3395.0], atol=10.0)


@pytest.mark.acceptance("V-4", "V-5")
def test_load_transfer(car: np.void, record: Callable[..., None]) -> None:
    rest, found = np.zeros(4), np.zeros(4)
    static_loads(0.0, 0.0, 0.0, 0.0, 0.0, car, rest)
    static_loads(3.0, 0.0, 0.0, 0.0, 0.0, car, found)
    record("per wheel at 3 m/s^2, N", found[2] - rest[2], "532.5 +- 0.5", id="V-4")
    assert found - rest == pytest.approx([-532.5, -532.5, 532.5, 532.5], abs=0.5)
    static_loads(0.0, 5.0, 0.0, 0.0, 0.0, car, found)
    record("per wheel at 5 m/s^2 to the right, N", found[1] - rest[1], "1548.7 +- 0.5", id="V-5")
    assert found - rest == pytest.approx([-1548.7, 1548.7, -1548.7, 1548.7], abs=0.5)


@pytest.mark.acceptance("V-5")
def test_plant_and_observers_agree_on_the_static_transfer(car: np.void) -> None:
    """Two codes, one equation: the plant's left turn loads the right wheels as the observers' right turn the left."""
    vehicle = plant(roll_dynamics=0)
    vehicle.reset(speed_m_s=15.0)
    vehicle.step(1500, steer=0.8)
    state, found = vehicle.state(), np.zeros(4)
    drag = 0.45 * state["speed"] ** 2
    rolling = sum((0.009 + 4e-6 * state["speed"] ** 2) * loads(state)) * 0.302
    a_x, a_y = state["true_longitudinal_acceleration"], -state["true_lateral_acceleration"]
    static_loads(a_x, a_y, 0.0, drag, rolling, car, found)
    assert found[list(BENCH_INDEX)] == pytest.approx(loads(state), rel=2e-3)


@pytest.mark.acceptance("V-6")
def test_roll_variant_converges_to_the_static_loads(car: np.void, record: Callable[..., None]) -> None:
    roll = rate = 0.0
    for _ in range(2000):
        roll, rate = roll_step(roll, rate, 1559.0 * 4.0, 0.005, car)
    static, rolled = np.zeros(4), np.zeros(4)
    static_loads(0.0, 4.0, 0.0, 0.0, 0.0, car, static)
    rolling_loads(0.0, roll, rate, 0.0, 0.0, 0.0, car, rolled)
    worst = float(np.max(np.abs(rolled / static - 1.0)))
    record("largest deviation", worst, "<= 0.001")
    assert worst <= 1e-3


@pytest.mark.acceptance("V-7", "V-8")
def test_resistances(car: np.void, record: Callable[..., None]) -> None:
    record("F_wx / v^2", air_drag(20.0, car) / 400.0, "0.45", id="V-7")
    assert air_drag(20.0, car) == pytest.approx(0.45 * 400.0, rel=1e-4)
    assert rolling_coefficient(20.0, car) == pytest.approx(0.009 + 4e-6 * 400.0)
    # the plant coasts under both alone: m dv/dt = -F_wx - sum R_z f of its wheels, spinning masses included
    vehicle = plant()
    vehicle.reset(speed_m_s=30.0)
    vehicle.step(2000)
    state = vehicle.state()
    speed = state["speed"]
    spinning = 2 * 1.2 / 0.3015**2 + 2 * 1.2 / 0.3023**2
    force = 0.45 * speed**2 + (0.009 + 4e-6 * speed**2) * 1559.0 * GRAVITY
    assert -state["true_longitudinal_acceleration"] == pytest.approx(force / (1559.0 + spinning), rel=5e-3)


@pytest.mark.acceptance("V-9")
def test_steady_pitch(car: np.void, record: Callable[..., None]) -> None:
    pitch = rate = 0.0
    for _ in range(5000):
        pitch, rate = pitch_step(pitch, rate, 1559.0, 0.001, car)
    record("nose up at 1 m/s^2, rad", pitch, "0.0117 +- 1 %")
    assert pitch == pytest.approx(0.0117, rel=0.01)
    printed = document_car(load_vehicle("lada_vesta_printed").numbers()).record[0]
    assert printed["pitch_stiffness"] == pytest.approx(0.5 * car["pitch_stiffness"])


@pytest.mark.acceptance("V-10")
def test_torque_path(car: np.void) -> None:
    """T_k = 0.5 (T_e - J_e dw_e/dt) i eta; gear 3 is 1.357, printed 0.357."""
    expected = (100.0 - 0.15 * 50.0) * 1.357 * 3.938 * 0.975 * 0.975
    assert axle_torque(100.0, 50.0, 3, car) == pytest.approx(expected)
    assert 0.5 * axle_torque(100.0, 50.0, 3, car) == pytest.approx(0.5 * expected)
    assert axle_torque(100.0, 0.0, 0, car) == 0.0
    printed = document_car(load_vehicle("lada_vesta_printed").numbers()).record[0]
    assert printed["ratio"][3] == pytest.approx(0.357 * 3.938)
    ratios = car["ratio"][1:6]
    assert all(np.diff(ratios) < 0.0)
    assert not all(np.diff(printed["ratio"][1:6]) < 0.0)


@pytest.mark.acceptance("V-11")
def test_magic_formula(record: Callable[..., None]) -> None:
    b, c, d = 8.0, 1.5, 0.95
    x = np.linspace(0.0, 1.0, 200001)
    y = np.array([magic_formula(value, b, c, d) for value in x[::100]])
    peak = float(x[::100][np.argmax(y)])
    record("peak over D - 1", magic_formula(math.tan(math.pi / (2 * c)) / b, b, c, d) / d - 1.0, "<= 1e-6")
    assert peak == pytest.approx(math.sqrt(3.0) / b, abs=6e-4)
    assert y.max() == pytest.approx(d, abs=1e-6)
    assert magic_formula(1e-7, b, c, d) / 1e-7 == pytest.approx(b * c * d, rel=1e-6)
    assert magic_formula(-0.1, b, c, d) == -magic_formula(0.1, b, c, d)
    assert magic_formula_full(0.1, b, c, d, 0.0) == magic_formula(0.1, b, c, d)
    assert magic_formula_full(0.1, b, c, d, -2.0) > magic_formula(0.1, b, c, d)
    # with C = 1.5 the branch behind the peak falls to 0.707 D (2.4 [X])
    assert magic_formula(1e6, b, c, d) == pytest.approx(math.sin(0.75 * math.pi) * d, rel=1e-5)


@pytest.mark.acceptance("V-13")
def test_slip() -> None:
    assert slip(10.0, 10.0 / 0.3, 0.3) == pytest.approx(0.0)
    assert slip(10.0, 0.0, 0.3) == -1.0
    assert slip(1.0, 100.0, 0.3) == 1.0


@pytest.mark.acceptance("V-14")
def test_wheel_model_is_stable_at_two_metres_per_second(car: np.void) -> None:
    """An explicit step of 10 ms diverges there (2.5 [E]); the implicit one does not, at 1 ms and at 10 ms."""
    load, k_x, v = 4337.0, 12.0, 2.0
    for dt in (0.001, 0.01):
        omega = 1.2 * v / 0.3015
        for _ in range(1000):
            omega = turn_wheel(omega, 0.0, load * k_x, v, load, 0, dt, car)
        assert omega * 0.3015 == pytest.approx(v, rel=2e-3)
    omega = 1.2 * v / 0.3015
    for _ in range(20):
        omega += 0.01 * (-load * k_x * (omega * 0.3015 / v - 1.0) * 0.3015) / 1.2
    assert abs(omega) > 1e3
    # and the plant, in its steps of 0.1 ms, from the same spin
    vehicle = plant()
    vehicle.reset(speed_m_s=v)
    vehicle.step(200, drive_torque=[100.0, 100.0, 0.0, 0.0])
    vehicle.step(500)
    assert abs(vehicle.state()["slip_ratio_fl"]) < 0.01


@pytest.mark.acceptance("V-15")
def test_missing_steering_map_is_an_error() -> None:
    with pytest.raises(InputError, match=r"steering\.map: missing"):
        Planar(load_vehicle("lada_vesta"))
    with pytest.raises(InputError, match=r"steering\.map"):
        document_car(load_vehicle("lada_vesta").numbers())


@pytest.mark.acceptance("V-15")
def test_steering_map_is_a_table() -> None:
    steering = np.array([[-2.0, 0.0, 1.0], [-0.2, 0.0, 0.05], [-0.15, 0.0, 0.06]])
    assert road_wheel_angle(0.5, steering, 1) == pytest.approx(0.025)
    assert road_wheel_angle(-1.0, steering, 2) == pytest.approx(-0.075)
    vehicle = load_vehicle(VESTA)
    vehicle.steering.map.left[3] = 0.20  # at 240 deg
    bent = Planar(vehicle, DOCUMENT_ROAD)
    bent.reset(speed_m_s=5.0)
    bent.step(10, steer=math.radians(120.0))
    state = bent.state()
    assert state["true_road_wheel_angle_fl"] == pytest.approx(0.10)
    assert state["true_road_wheel_angle_fr"] == pytest.approx(math.radians(7.5))
