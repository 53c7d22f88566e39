"""Numerics of the MuJoCo car: step sizes, left and right, repetition, two processes, neutral values."""

from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray
from plant_cases import car_on, without_losses

from signals.wheels import WHEELS
from vehicle_model.interface import PLANT_OUTPUTS
from vehicle_model.plant import Plant
from vehicle_model.road_file import Patch, RoadFile, Side
from vehicle_model.vehicle_file import load_vehicle

STOPS: dict[str, dict[str, Any]] = {
    "locked": {"brake": [2500.0, 2500.0, 1500.0, 1500.0]},
    "near the limit": {"brake": [1400.0, 1400.0, 500.0, 500.0]},
    "turn": {"brake": [900.0, 900.0, 300.0, 300.0], "steer": 0.5},
    "split": {"brake": [700.0, 700.0, 350.0, 350.0], "right": 0.3},
}


def _stop(substeps: int, steps: int, brake: list[float], steer: float = 0.0, right: float = 1.0) -> dict[str, float]:
    road = RoadFile(right=Side(friction=right))
    car = Plant(load_vehicle("ekf_car"), road, wheel_substeps=substeps, steps_per_tick=steps)
    car.reset(speed_m_s=25.0)
    ticks, peak_yaw_rate = 0, 0.0
    while car.outputs[0] > 0.05:
        car.step(
            1,
            brake_torque=min(1.0, ticks / 200.0) * np.array(brake),
            steer=steer * min(1.0, ticks / 500.0),
        )
        ticks += 1
        peak_yaw_rate = max(peak_yaw_rate, abs(car.state()["true_yaw_rate"]))
    state = car.state()
    return {
        "distance": state["distance"],
        "deceleration": 25.0 / (ticks * 1e-3),
        "yaw_rate": peak_yaw_rate,
        "x": state["position_x"],
        "y": state["position_y"],
    }


@pytest.mark.parametrize("case", STOPS)
def test_twice_the_steps_change_a_stop_by_less_than_half_a_percent(case: str) -> None:
    base = _stop(5, 1, **STOPS[case])
    for substeps, steps in ((10, 1), (5, 2)):
        finer = _stop(substeps, steps, **STOPS[case])
        for name in ("distance", "deceleration"):
            assert finer[name] == pytest.approx(base[name], rel=5e-3), (name, substeps, steps)
        if "steer" in STOPS[case] or "right" in STOPS[case]:
            assert finer["yaw_rate"] == pytest.approx(base["yaw_rate"], rel=5e-3)
        moved = np.hypot(finer["x"] - base["x"], finer["y"] - base["y"])
        assert moved < 5e-3 * base["distance"]


def _history(car: Plant, steer: float, brake: NDArray[np.float64], ticks: int) -> NDArray[np.float64]:
    rows = np.empty((ticks, len(PLANT_OUTPUTS)))
    drive = np.zeros(4)
    for tick in range(ticks):
        on = 1.0 if tick > 1000 else 0.0
        angle = steer * np.sin(2.0 * np.pi * 0.5 * tick * 1e-3)
        car.tick(on * brake, drive, float(angle), tick * 1e-3)
        rows[tick] = car.outputs
    return rows


_SIGN_OF_MIRROR = {
    "lateral_speed": -1.0,
    "position_y": -1.0,
    "yaw_angle": -1.0,
    "roll_angle": -1.0,
    "true_yaw_rate": -1.0,
    "true_roll_rate": -1.0,
    "true_lateral_acceleration": -1.0,
    "side_slip_angle": -1.0,
    "road_bank": -1.0,
}
_MIRRORED_PER_WHEEL = {"slip_angle": -1.0, "lateral_force": -1.0, "true_road_wheel_angle": -1.0}


def _mirrored(rows: NDArray[np.float64]) -> NDArray[np.float64]:
    place = {name: column for column, name in enumerate(PLANT_OUTPUTS)}
    result = np.empty_like(rows)
    for name, column in place.items():
        stem, _, wheel = name.rpartition("_")
        if wheel in WHEELS:
            other = place[f"{stem}_{wheel[0]}{'r' if wheel[1] == 'l' else 'l'}"]
            result[:, column] = _MIRRORED_PER_WHEEL.get(stem, 1.0) * rows[:, other]
        else:
            result[:, column] = _SIGN_OF_MIRROR.get(name, 1.0) * rows[:, column]
    return result


@pytest.mark.parametrize("steer", [0.0, 0.4])
@pytest.mark.parametrize("brake", [[700.0, 700.0, 300.0, 300.0], [2500.0, 2500.0, 1500.0, 1500.0]])
def test_left_and_right_mirror_each_other(steer: float, brake: list[float]) -> None:
    left_road = RoadFile(
        left=Side(friction=0.8), patches=[Patch(x_from=40.0, x_to=60.0, y_from=0.0, y_to=4.0, friction=0.5)]
    )
    right_road = RoadFile(
        right=Side(friction=0.8), patches=[Patch(x_from=40.0, x_to=60.0, y_from=-4.0, y_to=0.0, friction=0.5)]
    )
    histories = []
    for road, sign in ((left_road, 1.0), (right_road, -1.0)):
        car = car_on(road)
        car.reset(speed_m_s=25.0)
        histories.append(_history(car, sign * steer, np.array(brake), 5000))
    left, right = histories[0], _mirrored(histories[1])
    largest = np.maximum(np.abs(left).max(axis=0), 1e-30)
    scale = dict(zip(PLANT_OUTPUTS, largest, strict=True))
    for column, name in enumerate(PLANT_OUTPUTS):
        error = np.abs(left[:, column] - right[:, column]).max()
        assert error <= 1e-9 * scale[name] + 1e-12, (name, error, scale[name])


def test_a_straight_stop_stays_straight() -> None:
    car = car_on()
    car.reset(speed_m_s=30.0)
    rows = _history(car, 0.0, np.array([2500.0, 2500.0, 1500.0, 1500.0]), 5000)
    place = PLANT_OUTPUTS.index
    for name in ("position_y", "yaw_angle", "true_yaw_rate", "roll_angle", "true_lateral_acceleration"):
        assert np.abs(rows[:, place(name)]).max() < 1e-9, name


def test_runs_repeat_bit_for_bit() -> None:
    brake = np.array([1500.0, 1400.0, 600.0, 500.0])
    cars = [car_on(RoadFile(right=Side(friction=0.6))) for _ in range(2)]
    histories = []
    for car in cars:
        car.reset(speed_m_s=25.0)
        histories.append(_history(car, 0.3, brake, 2000))
    cars[0].reset(speed_m_s=25.0)
    histories.append(_history(cars[0], 0.3, brake, 2000))
    assert np.array_equal(histories[0], histories[1])
    assert np.array_equal(histories[0], histories[2])


def test_ticks_and_steps_give_the_same() -> None:
    one, many = car_on(), car_on()
    brake, drive = np.full(4, 700.0), np.array([0.0, 0.0, 100.0, 100.0])
    for car in (one, many):
        car.reset(speed_m_s=20.0)
    for tick in range(500):
        one.tick(brake, drive, 0.1, tick * 1e-3)
    many.step(500, brake_torque=brake, drive_torque=drive, steer=0.1)
    assert np.array_equal(one.outputs, many.outputs)


def test_standstill_gives_numbers() -> None:
    for speed in (0.0, 1e-4, 0.3):
        car = car_on()
        car.reset(speed_m_s=speed)
        car.step(2000, brake_torque=[0.0, 500.0, 0.0, 500.0], drive_torque=[10.0, 0.0, 50.0, 0.0], steer=5.0)
        assert np.isfinite(car.outputs).all()


def test_driving_backwards_works() -> None:
    car = Plant(without_losses())
    car.reset(speed_m_s=-5.0)
    car.step(2000)
    assert car.state()["speed"] == pytest.approx(-5.0, rel=1e-3)
    car.step(3000, brake_torque=500.0)
    assert abs(car.state()["speed"]) < 1e-3


def test_extreme_inputs_stay_finite() -> None:
    car = car_on(RoadFile(friction=0.0))
    car.reset(speed_m_s=30.0)
    car.step(1000, brake_torque=1e5, drive_torque=[0.0, 0.0, 5000.0, 5000.0], steer=8.0)
    assert np.isfinite(car.outputs).all()
    car.set("road.friction", 3.0)
    car.step(3000, brake_torque=[1e5, 0.0, 0.0, 1e5], steer=-8.0)
    assert np.isfinite(car.outputs).all()
