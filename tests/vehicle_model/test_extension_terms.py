"""Added terms of the car: without them not a bit changes, each target does what it says."""

import numpy as np
import pytest
from plant_cases import GRAVITY, without_losses

from signals.errors import InputError
from vehicle_model.extension_terms_file import CAR_VARIABLES, TARGET_UNITS, TARGETS, VARIABLE_UNITS, VARIABLES, Term
from vehicle_model.plant import Plant
from vehicle_model.vehicle_file import VehicleFile, load_vehicle, parameter_table, set_parameter

MASS = 1296.0


def _with(*terms: dict[str, object], vehicle: VehicleFile | None = None) -> VehicleFile:
    changed = vehicle or without_losses()
    changed.terms.stack.extend(Term.model_validate(term) for term in terms)
    return changed


def _driven(vehicle: VehicleFile, ticks: int = 500) -> np.ndarray:
    car = Plant(vehicle)
    car.reset(speed_m_s=22.0)
    rows = []
    for tick in range(ticks):
        car.tick(np.array([600.0, 600.0, 250.0, 250.0]), np.full(4, 40.0), 0.6 * np.sin(5e-3 * tick), tick * 1e-3)
        rows.append(car.outputs.copy())
    return np.array(rows)


@pytest.mark.parametrize("target", TARGETS)
def test_a_term_with_a_coefficient_of_zero_changes_no_bit(target: str) -> None:
    terms = [{"target": target, "coefficient": 0.0, "factors": [{"variable": name}]} for name in VARIABLES]
    assert np.array_equal(_driven(without_losses()), _driven(_with(*terms)))


def test_every_variable_and_target_has_a_unit() -> None:
    assert set(VARIABLE_UNITS) == set(VARIABLES)
    assert set(TARGET_UNITS) == set(TARGETS)
    assert set(CAR_VARIABLES) < set(VARIABLES)


def test_a_force_on_the_body_is_newtons_second_law_and_the_energy_account_closes() -> None:
    """-500 N on a rolling car without losses, its wheels' inertia counted: m + 4 J/r² with J 0.8 kg m², r 0.278 m."""
    term = {"target": "body_longitudinal_force", "coefficient": -20.0, "factors": [{"variable": "speed"}]}
    car = Plant(_with(term))
    car.reset(speed_m_s=25.0)
    start = car.state()["mechanical_energy"]
    car.step(2000)
    state = car.state()
    inertia = MASS + 4.0 * 0.8 / 0.278**2
    assert state["speed"] == pytest.approx(25.0 * np.exp(-20.0 / inertia * 2.0), rel=2e-3)
    lost = start - state["mechanical_energy"]
    assert state["dissipated_energy"] == pytest.approx(lost, rel=2e-3)


def test_a_yaw_moment_turns_the_car_by_its_inertia() -> None:
    """In the first instants, before the tyres answer: yaw acceleration M / I_z."""
    car = Plant(_with({"target": "yaw_moment", "coefficient": 2000.0}))
    car.reset(speed_m_s=25.0)
    car.step(5)
    assert car.state()["true_yaw_rate"] == pytest.approx(2000.0 / 1817.47 * 5e-3, rel=0.03)


def test_wheel_radius_and_friction_follow_their_factors() -> None:
    """1 % more radius turns a rolling wheel 1 % slower; half the friction halves the deceleration of locked wheels."""
    car = Plant(_with({"target": "wheel_radius_factor", "coefficient": 0.01, "wheels": "fl"}))
    car.reset(speed_m_s=20.0)
    car.step(1500)
    state = car.state()
    assert state["true_wheel_speed_fl"] / state["true_wheel_speed_fr"] == pytest.approx(1.0 / 1.01, rel=2e-4)
    slippery = Plant(_with({"target": "tyre_friction_factor", "coefficient": -0.5}))
    for plant in (slippery, gripping := Plant(without_losses())):
        plant.reset(speed_m_s=25.0)
        plant.step(600, brake_torque=1e5)
    ratio = slippery.state()["true_longitudinal_acceleration"] / gripping.state()["true_longitudinal_acceleration"]
    assert ratio == pytest.approx(0.5, rel=0.02)


def test_rolling_resistance_by_speed_takes_its_share_of_the_weight() -> None:
    term = {"target": "rolling_resistance", "coefficient": 5e-4, "factors": [{"variable": "speed"}]}
    car = Plant(_with(term))
    car.reset(speed_m_s=30.0)
    car.step(100)
    before = car.state()["speed"]
    car.step(500)
    inertia = MASS + 4.0 * 0.8 / 0.278**2
    # f m g at the mean speed
    mean = 0.5 * (before + car.state()["speed"])
    assert (before - car.state()["speed"]) / 0.5 == pytest.approx(5e-4 * mean * MASS * GRAVITY / inertia, rel=0.02)


def test_a_locking_differential_brings_the_wheels_of_an_axle_together() -> None:
    """In a circle the outer wheel turns faster; a viscous coupling hands torque from it to the inner one."""
    term = {
        "target": "drive_torque",
        "coefficient": -30.0,
        "wheels": "rear",
        "factors": [{"variable": "axle_speed_difference"}],
    }
    differences = []
    for vehicle in (without_losses(), _with(term)):
        car = Plant(vehicle)
        car.reset(speed_m_s=10.0)
        car.step(2000, steer=2.0)
        state = car.state()
        differences.append(state["true_wheel_speed_rr"] - state["true_wheel_speed_rl"])
        torques = state["true_drive_torque_rl"] + state["true_drive_torque_rr"]
    assert 0.0 < differences[1] < differences[0]
    assert torques == pytest.approx(0.0, abs=1e-9)


def test_terms_are_parameters_of_the_file_and_of_the_running_car() -> None:
    vehicle = _with({"target": "yaw_moment", "coefficient": 0.0})
    assert "terms.stack.0.coefficient" in {info.path for info in parameter_table(vehicle)}
    set_parameter(vehicle, "terms.stack.0.coefficient", 100.0)
    car = Plant(vehicle)
    car.reset(speed_m_s=20.0)
    car.step(100)
    first = car.state()["true_yaw_rate"]
    car.set("terms.stack.0.coefficient", -100.0)
    car.step(400)
    assert first > 0.0 > car.state()["true_yaw_rate"]


def test_a_reset_forgets_what_a_relay_remembered() -> None:
    term = {
        "target": "body_longitudinal_force",
        "coefficient": 1000.0,
        "factors": [{"variable": "steering_wheel_angle", "function": "relay", "at": 0.0, "width": 0.5}],
    }
    car = Plant(_with(term))
    ends = []
    for _ in range(2):
        car.reset(speed_m_s=20.0)
        car.step(100)
        ends.append(car.state()["speed"])
        car.step(50, steer=1.0)
    assert ends[0] == ends[1]


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("{target: yaw_momen, coefficient: 1}", "yaw_moment"),
        ("{target: yaw_moment, coefficient: 1, factors: [{variable: spead}]}", "speed"),
        ("{target: yaw_moment, coefficient: 1, factors: [{variable: speed, function: sinus}]}", "sine"),
        ("{target: yaw_moment, coefficient: 1, factors: [{variable: speed, function: step, width: 3}]}", "width"),
        ("{target: yaw_moment, coefficient: .nan}", "finite"),
    ],
)
def test_faulty_terms_are_named(tmp_path, text: str, message: str) -> None:  # type: ignore[no-untyped-def]
    file = tmp_path / "car.yaml"
    file.write_text(f"format: 1\nname: x\nextends: ekf_car\nterms: {{stack: [{text}]}}\n")
    with pytest.raises(InputError) as caught:
        load_vehicle(file)
    assert "car.yaml:4" in str(caught.value)
    assert message in str(caught.value)
