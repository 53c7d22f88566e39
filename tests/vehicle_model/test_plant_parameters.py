"""Parameters of the MuJoCo car by name, while it drives."""

import numpy as np
import pytest
from numpy.typing import NDArray
from plant_cases import car_on

from signals.errors import InputError
from signals.vector import SignalVector
from vehicle_model.extension_terms_file import Term
from vehicle_model.interface import PLANT_OUTPUTS
from vehicle_model.plant import Plant
from vehicle_model.road_file import Gust, Jump, Patch, ProfilePoint, RoadFile, Roughness, Side, Water
from vehicle_model.vehicle_file import load_vehicle, set_parameter

RICH_ROAD = RoadFile(
    friction=0.9,
    left=Side(friction=0.9),
    right=Side(friction=0.8),
    jumps=[
        Jump(position=3.0, friction=0.9, transition_length=40.0),
        Jump(time=0.05, friction=0.95, transition_time=2.0),
    ],
    patches=[Patch(x_from=2.0, x_to=5.0, y_from=-0.9, y_to=0.7, friction=0.7)],
    grade=0.01,
    bank=0.01,
    profile=[ProfilePoint(position=0.0, grade=0.0, bank=0.0), ProfilePoint(position=60.0, grade=0.02, bank=0.01)],
    wind_speed_x=-3.0,
    wind_speed_y=2.0,
    gust=Gust(speed_x=3.0, speed_y=4.0, start=0.1, duration=0.3, period=0.4),
    roughness=Roughness(level=4e-6),
    water=Water(film=5e-5, tread_wear=0.2),
)
WORKING_SUSPENSION = {
    "bump_stop_clearance": 0.002,
    "bump_stop_rate": 1e4,
    "bump_stop_progression": 1e5,
    "rebound_stop_clearance": 0.002,
    "rebound_stop_rate": 1e4,
}
CAMBER = {f"suspension.{axle}.{name}" for axle in ("front", "rear") for name in ("camber", "camber_gain")}
"""Curve tyres do not feel it; ``test_plant_tir`` shows what it does."""

TERMS = [
    {"target": "tyre_friction_factor", "coefficient": -1e-3, "factors": [{"variable": "tyre_heating"}]},
    {
        "target": "brake_torque_factor",
        "coefficient": 0.05,
        "factors": [
            {"variable": "speed", "function": "above", "at": 2.0, "exponent": 1.5},
            {"variable": "wheel_angle", "function": "sine", "wave_number": 2.0, "phase": 0.3},
        ],
    },
    {
        "target": "yaw_moment",
        "coefficient": -40.0,
        "factors": [
            {"variable": "yaw_rate", "function": "relay", "at": 0.01, "width": 0.02},
            {"variable": "lateral_acceleration", "function": "limited", "at": 0.1, "width": 5.0},
        ],
    },
    {
        "target": "drive_torque",
        "coefficient": -10.0,
        "factors": [{"variable": "steering_wheel_angle", "function": "direction", "width": 0.3}],
    },
]

AT_SPEED = {"road.water.speed_dependence"}  # Table 1 begins at 50 km/h


def _vehicle() -> Plant:
    vehicle = load_vehicle("ekf_car")
    for axle in ("front", "rear"):
        set_parameter(vehicle, f"tyres.{axle}.load_sensitivity", 0.1)
        for name, value in WORKING_SUSPENSION.items():
            set_parameter(vehicle, f"suspension.{axle}.{name}", value)
    set_parameter(vehicle, "suspension.adaptive.mode", 1.0)
    set_parameter(vehicle, "aerodynamics.side_force_coefficient", 1.0)
    vehicle.terms.stack.extend(Term.model_validate(term) for term in TERMS)
    return Plant(vehicle, RICH_ROAD)


def _drive(car: Plant, ticks: int = 1500) -> NDArray[np.float64]:
    """Curve, brake to below walking speed, roll on: every part of the model acts."""
    car.reset(speed_m_s=8.0)
    rows = []
    brake, drive = np.array([900.0, 920.0, 400.0, 2500.0]), np.array([0.0, 0.0, 120.0, 120.0])
    for tick in range(ticks):
        on = 1.0 if tick > 300 else 0.0
        car.tick(on * brake, (1.0 - on) * drive, 1.0 * np.sin(tick * 4e-3), tick * 1e-3)
        rows.append(car.outputs.copy())
    return np.array(rows)


def test_setting_every_parameter_to_its_own_value_changes_no_bit() -> None:
    untouched, touched = _vehicle(), _vehicle()
    for path in touched.names():
        touched.set(path, touched.get(path))
    assert np.array_equal(_drive(untouched, 800), _drive(touched, 800))


def test_every_parameter_does_something() -> None:
    base = _drive(_vehicle())
    idle = []
    for info in _vehicle().parameter_table():
        car = _vehicle()
        step = 0.05 * abs(info.value) if info.value else 0.02
        if info.path.startswith("road.") and info.unit == "m":
            step = 0.8 if info.high is None else 0.02 * info.high
        changed = info.value + step
        if info.high is not None and changed > info.high:
            changed = info.value - step
        if info.path.startswith("plant."):
            changed = info.value + 1
        if info.path == "suspension.adaptive.mode":
            changed = 0.0
        car.set(info.path, changed)
        if np.array_equal(_drive(car), base):
            idle.append(info.path)
    assert set(idle) == CAMBER | AT_SPEED


def test_a_change_writes_all_that_follows_from_it() -> None:
    car = _vehicle()
    model = car._model

    def memory() -> list[bytes]:
        bodies = (model.body_mass, model.body_inertia, model.body_ipos, model.body_pos, model.jnt_axis)
        return [car._parameters.tobytes(), car._tyres.tobytes(), *(array.tobytes() for array in bodies)]

    for info in car.parameter_table():
        if info.path.startswith(("road.", "plant.")):
            continue
        changed = info.value + (0.01 * abs(info.value) if info.value else 0.01)
        car.set(info.path, changed if info.high is None or changed <= info.high else 0.99 * info.value)
        after = memory()
        for section in Plant.sections:
            car._write(section)
        assert memory() == after, info.path


def test_a_parameter_changes_the_car_while_it_drives() -> None:
    car = car_on()
    car.reset(speed_m_s=25.0)
    car.step(300, brake_torque=1e5)
    before = car.state()["true_longitudinal_acceleration"]
    car.set("road.friction", 0.5)
    car.step(300, brake_torque=1e5)
    assert car.state()["true_longitudinal_acceleration"] == pytest.approx(0.5 * before, rel=0.05)
    assert car.get("road.friction") == 0.5
    assert car.state()["friction_limit_fl"] == pytest.approx(0.56)


def test_a_load_that_comes_on_board_lowers_the_car_and_keeps_the_weight() -> None:
    car = car_on()
    car.reset(speed_m_s=20.0)
    car.set("body.mass", 1496.0)
    car.step(4000)
    state = car.state()
    weight = sum(state[f"vertical_load_{wheel}"] for wheel in ("fl", "fr", "rl", "rr"))
    assert weight == pytest.approx(1496.0 * 9.81, rel=1e-3)
    assert state["suspension_travel_fl"] > 0.005


def test_a_refused_value_leaves_the_car_as_it_was() -> None:
    car = _vehicle()
    for path, value in (("body.mass", 150.0), ("body.pitch_inertia", 100.0), ("wheels.fl.radius", -1.0)):
        before = car.get(path)
        with pytest.raises(InputError):
            car.set(path, value)
        assert car.get(path) == before
    assert np.array_equal(_drive(car, 300), _drive(_vehicle(), 300))


def test_units_and_wrong_names() -> None:
    car = car_on(RoadFile(patches=[Patch(x_from=0.0, x_to=10.0)]))
    car.set("body.mass", "1.4 t")
    assert car.get("body.mass") == 1400.0
    car.set("road.patches.0.friction", "40 %")
    assert car.get("road.patches.0.friction") == pytest.approx(0.4)
    with pytest.raises(InputError, match=r"body\.mass"):
        car.set("body.mas", 1.0)
    with pytest.raises(InputError, match="section"):
        car.get("brakes.front.pad_area")
    with pytest.raises(InputError, match="only used when the car is built"):
        car.set("body.length", 4.0)
    assert "body.length" not in car.names()


def test_outputs_go_into_the_signal_vector() -> None:
    vector, car = SignalVector(), car_on()
    car.bind(vector.block("plant"))
    car.reset(speed_m_s=20.0)
    car.step(100, brake_torque=500.0)
    assert vector["speed"] == car.state()["speed"] < 20.0
    assert vector["vertical_load_rr"] > 1000.0
    assert tuple(car.state()) == PLANT_OUTPUTS
    with pytest.raises(ValueError, match="consecutive"):
        car.bind(np.zeros(5))
