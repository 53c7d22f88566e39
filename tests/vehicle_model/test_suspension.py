"""Suspension of the MuJoCo car: dampers, stops, bars, guidance of the wheels, against closed forms and energy."""

import math
from pathlib import Path

import numpy as np
import pytest
from numpy.typing import NDArray
from plant_cases import GRAVITY, loads, without_losses

from signals.errors import InputError
from vehicle_model.plant import Plant
from vehicle_model.plant_record import PARAMETER_RECORD
from vehicle_model.road_file import RoadFile
from vehicle_model.suspension_forces import damper_force, stop_energy, stop_force
from vehicle_model.vehicle_file import VehicleFile, load_vehicle

MASS, WHEELBASE, HEIGHT, RADIUS, TRACK = 1296.0, 2.57, 0.535, 0.278, 1.46  # Table 8
LIGHT = 8.0  # kg, a wheel
AXLES = ("front", "rear")
EVERYTHING = {
    "damping_scale": 0.7,
    "bump_stop_rate": 5e4,
    "bump_stop_progression": 5e5,
    "bump_stop_clearance": 0.02,
    "rebound_stop_rate": 5e4,
    "rebound_stop_clearance": 0.02,
    "roll_centre_height": 0.1,
    "brake_support_angle": 0.15,
    "drive_support_angle": 0.25,
}


def both_axles(values: dict[str, float]) -> dict[str, float]:
    return {f"suspension.{axle}.{name}": value for axle in AXLES for name, value in values.items()}


def lively_drive(car: Plant, ticks: int = 4000) -> NDArray[np.float64]:
    """Drive, brake and steer at once; rows of outputs."""
    car.reset(speed_m_s=25.0)
    rows = np.empty((ticks, len(car.outputs)))
    brake, drive = np.array([1100.0, 1100.0, 450.0, 450.0]), np.array([0.0, 0.0, 600.0, 600.0])
    for tick in range(ticks):
        braking = 1.0 if tick > ticks // 2 else 0.0
        car.tick(braking * brake, (1.0 - braking) * drive, 0.7 * math.sin(tick * 4e-3), tick * 1e-3)
        rows[tick] = car.outputs
    return rows


@pytest.mark.parametrize("mode", [0.0, 1.0], ids=["passive", "skyhook"])
def test_the_energy_account_closes_with_every_part_at_work(mode: float) -> None:
    car = Plant(without_losses(both_axles(EVERYTHING) | {"suspension.adaptive.mode": mode}))
    car.reset(speed_m_s=25.0)
    start = car.state()["mechanical_energy"]
    rows = lively_drive(car)
    state = car.state()
    assert np.ptp(rows[:, 0]) > 5.0
    residual = start + state["drive_energy"] - state["dissipated_energy"] - state["mechanical_energy"]
    # a support angle or a pitching carrier that is missing in one of the equations leaves kilojoules
    assert abs(residual) < 1e-5 * start


def write_car(folder: Path, suspension: str) -> VehicleFile:
    (folder / "car.yaml").write_text(f"format: 1\nname: car\nextends: ekf_car\nsuspension: {suspension}\n")
    return load_vehicle(folder / "car.yaml")


def test_neutral_values_and_what_they_switch_off_change_no_bit(tmp_path: Path) -> None:
    """Also with other clearances and laws: they belong to stops and valves that are switched off."""
    neutral = (
        "damping_scale: 1, bump_stop_rate: 0, bump_stop_progression: 0, rebound_stop_rate: 0, "
        "bump_stop_clearance: 0.0, rebound_stop_clearance: 1 mm, roll_centre_height: 0, brake_support_angle: 0, "
        "drive_support_angle: 0, camber: 0, camber_gain: 0, damper_speeds: [], damper_forces: []"
    )
    adaptive = "{mode: 0, skyhook_damping: 9000, soft_scale: 0.1, firm_scale: 5, time_constant: 0.5}"
    vehicle = write_car(tmp_path, f"{{front: {{{neutral}}}, rear: {{{neutral}}}, adaptive: {adaptive}}}")
    assert np.array_equal(lively_drive(Plant(vehicle)), lively_drive(Plant(load_vehicle("ekf_car"))))


def test_every_part_can_be_switched_on_and_off_while_the_car_drives() -> None:
    car = Plant(without_losses())
    switched = both_axles(EVERYTHING) | {"suspension.adaptive.mode": 1.0}
    neutral = {path: car.get(path) for path in switched}
    straight = Plant(without_losses())
    for plant in (car, straight):
        plant.reset(speed_m_s=25.0)
    for path, value in switched.items():
        car.set(path, value)
    for plant in (car, straight):
        plant.step(1500, steer=0.6)
    assert abs(car.state()["roll_angle"]) < 0.8 * abs(straight.state()["roll_angle"])
    for path, value in neutral.items():
        car.set(path, value)
    for plant in (car, straight):
        plant.step(6000, steer=0.6)
    assert car.state()["roll_angle"] == pytest.approx(straight.state()["roll_angle"], rel=2e-2)


def parameters_with(speeds: list[float], forces: list[float]) -> NDArray[np.void]:
    record = np.zeros(1, PARAMETER_RECORD)
    record["damper_points"] = len(speeds)
    record["damper_speeds"][0, :, : len(speeds)], record["damper_forces"][0, :, : len(forces)] = speeds, forces
    return record


def test_the_damper_follows_its_curve() -> None:
    speeds, forces = [-1.0, -0.2, 0.0, 0.1, 0.6], [-1800.0, -900.0, 0.0, 300.0, 650.0]
    [p] = parameters_with(speeds, forces)
    for rate in np.linspace(-1.0, 0.6, 41):
        assert damper_force(p, 2, rate) == pytest.approx(np.interp(rate, speeds, forces), abs=1e-9)
    # beyond the ends with the last slope
    assert damper_force(p, 0, 1.1) == pytest.approx(650.0 + 0.5 * 700.0)
    assert damper_force(p, 0, -1.8) == pytest.approx(-1800.0 - 0.8 * 1125.0)
    [falling] = parameters_with([-1.0, 0.0, 1.0, 2.0], [-500.0, 0.0, 500.0, 100.0])
    assert damper_force(falling, 0, 9.0) == 0.0  # never drives


def test_a_curve_of_two_straight_pieces_is_the_damper_with_two_rates(tmp_path: Path) -> None:
    plain = load_vehicle("ekf_car").suspension
    parts = ", ".join(
        f"{axle}: {{damper_speeds: [-1, 0, 1], "
        f"damper_forces: [{-rates.rebound_damping}, 0, {rates.compression_damping}]}}"
        for axle, rates in (("front", plain.front), ("rear", plain.rear))
    )
    curve = lively_drive(Plant(write_car(tmp_path, f"{{{parts}}}")), 1500)
    rates = lively_drive(Plant(load_vehicle("ekf_car")), 1500)
    np.testing.assert_allclose(curve, rates, rtol=1e-7, atol=1e-6)


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("damper_speeds: [0, 1], damper_forces: [0]", "as many forces as speeds"),
        ("damper_speeds: [0, -1], damper_forces: [0, -5]", "speeds that do not rise"),
        ("damper_speeds: [-1, 0, 1], damper_forces: [-300, 0, -5]", "a damper that drives"),
        ("damper_speeds: [1, 2], damper_forces: [300, 400]", "a curve without its zero"),
        ("spring_rate: -20 kN/m", "out of range"),
        ("roll_centre_height: 3 m", "out of range"),
        ("damper_speeds: [0 m/s, 1 N], damper_forces: [0, 100]", "wrong dimension"),
    ],
)
def test_bad_suspensions_are_refused_with_their_place(tmp_path: Path, text: str, message: str) -> None:
    with pytest.raises(InputError, match=message) as caught:
        write_car(tmp_path, f"{{front: {{{text}}}}}")
    assert "car.yaml:4:" in str(caught.value)


def test_a_curve_that_would_drive_is_refused_on_line(tmp_path: Path) -> None:
    vehicle = write_car(tmp_path, "{front: {damper_speeds: [-1, 0, 1], damper_forces: [-2000, 0, 1500]}}")
    car = Plant(vehicle)
    car.set("suspension.front.damper_forces.2", 900.0)
    assert car.get("suspension.front.damper_forces.2") == 900.0
    with pytest.raises(InputError, match="a damper that drives"):
        car.set("suspension.front.damper_forces.2", -900.0)
    assert car.get("suspension.front.damper_forces.2") == 900.0


def test_stops_carry_what_the_spring_leaves_and_keep_their_energy() -> None:
    """A load of 900 kg compresses the springs by 11 cm or, against the stops, as far as both together give way."""
    rate, progression, clearance = 1e5, 2e6, 0.03
    stops = {"bump_stop_rate": rate, "bump_stop_progression": progression, "bump_stop_clearance": clearance}
    car = Plant(without_losses(both_axles(stops)))
    before = loads(car)
    car.set("body.mass", MASS + 900.0)
    car.reset(speed_m_s=0.0)
    state, more = car.state(), loads(car) - before
    for wheel, place, spring in (("fl", 0, 2e4), ("rr", 3, 2.2e4)):
        travel = state[f"suspension_travel_{wheel}"]
        deep = travel - clearance
        assert 0.0 < deep < 0.05
        carried = spring * travel + (rate + progression * deep) * deep
        assert carried == pytest.approx(more[place], rel=2e-3)  # the body leans a little: cosines
    p = car._parameters[0]
    for travel in (-0.2, 0.02, 0.031, 0.08):
        slope = (stop_energy(p, 0, travel + 1e-6) - stop_energy(p, 0, travel - 1e-6)) / 2e-6
        assert slope == pytest.approx(stop_force(p, 0, travel), rel=1e-6, abs=1e-6)


def light_wheels(changes: dict[str, float]) -> Plant:
    """The limit in which closed forms hold: light wheels that hardly spin anything up, hard tyres."""
    limit = {
        f"wheels.{wheel}.{name}": value
        for wheel in ("fl", "fr", "rl", "rr")
        for name, value in (("vertical_stiffness", 5e6), ("unsprung_mass", LIGHT), ("inertia", 0.1))
    }
    return Plant(without_losses(limit | {"steering.damping": 20.0} | changes), steps_per_tick=2)


@pytest.mark.parametrize("height", [-0.05, 0.0, 0.1, 0.3])
def test_roll_angle_is_that_of_the_closed_form(height: float) -> None:
    """Virtual work of a roll with the hubs level, the wheels leaning with the body, and the tyres' own roll."""
    car = light_wheels(both_axles({"roll_centre_height": height}))
    car.reset(speed_m_s=20.0)
    car.step(5000, steer=0.1)
    state = car.state()
    vehicle = load_vehicle("ekf_car")
    stiffness = sum(
        0.5 * TRACK**2 * (axle.spring_rate + 2.0 * axle.anti_roll_rate)
        for axle in (vehicle.suspension.front, vehicle.suspension.rear)
    )
    acceleration = state["true_lateral_acceleration"]
    assert acceleration > 0.8
    sprung = MASS - 4.0 * LIGHT
    centre = (MASS * HEIGHT - 4.0 * LIGHT * RADIUS) / sprung
    moment = (sprung * (centre - height) + 4.0 * LIGHT * RADIUS) * acceleration
    on_springs = moment / (stiffness - sprung * GRAVITY * (centre - RADIUS - 2.0 * height))
    on_tyres = MASS * HEIGHT * acceleration / (0.5 * TRACK**2 * 2.0 * 5e6)
    assert state["roll_angle"] == pytest.approx(on_springs + on_tyres, rel=1e-2)


@pytest.mark.parametrize("angle", [0.0, 0.1, 0.2])
def test_brake_support_takes_its_share_of_the_load_from_the_springs(angle: float) -> None:
    """Travel = (load transfer - brake force x slope) / spring rate.

    The slope is that of the contact's path: tan(angle), and the pitch, with which the slides lean.
    """
    car = light_wheels(both_axles({"brake_support_angle": angle, "drive_support_angle": angle}))
    car.reset(speed_m_s=30.0)
    before = loads(car)
    car.step(2500, brake_torque=[700.0, 700.0, 350.0, 350.0])
    state, transfer = car.state(), loads(car) - before
    assert state["true_longitudinal_acceleration"] < -4.0
    for wheel, place, rate, side in (("fl", 0, 2e4, 1.0), ("rl", 2, 2.2e4, -1.0)):
        force = -state[f"longitudinal_force_{wheel}"]
        expected = (transfer[place] - force * (side * math.tan(angle) + state["pitch_angle"])) / rate
        assert state[f"suspension_travel_{wheel}"] == pytest.approx(expected, rel=1e-2, abs=1e-4)


@pytest.mark.parametrize("angle", [0.0, 0.1, 0.2])
def test_drive_support_takes_its_share_of_the_squat(angle: float) -> None:
    car = light_wheels(both_axles({"drive_support_angle": angle, "brake_support_angle": angle}))
    car.reset(speed_m_s=10.0)
    before = loads(car)
    car.step(2500, drive_torque=[0.0, 0.0, 600.0, 600.0])
    state, transfer = car.state(), loads(car) - before
    force = state["longitudinal_force_rl"]
    assert force > 2000.0
    expected = (transfer[2] - force * (math.tan(angle) - state["pitch_angle"])) / 2.2e4
    assert state["suspension_travel_rl"] == pytest.approx(expected, rel=1e-2, abs=1e-4)


def test_each_support_acts_on_its_own_torque() -> None:
    """A brake is held by the carrier, a half shaft by the body."""
    drive = {"drive_torque": [0.0, 0.0, 600.0, 600.0]}
    brake = {"brake_torque": [700.0, 700.0, 350.0, 350.0]}
    for other, torque in (("brake", drive), ("drive", brake)):
        travel = []
        for changes in ({}, {f"{other}_support_angle": 0.3}):
            car = light_wheels(both_axles(changes))
            car.reset(speed_m_s=25.0)
            car.step(2500, **torque)
            travel.append(car.state()["suspension_travel_rl"])
        # what is left is the lean of the slides with the pitching body
        assert travel[1] == pytest.approx(travel[0], rel=0.06)


def test_full_anti_dive_keeps_the_nose_up() -> None:
    """tan(angle) = load transfer over brake force of the axle: the springs of both axles feel nothing."""
    plain, supported = light_wheels({}), light_wheels({})
    front_share = 700.0 / 1050.0
    for axle, share in (("front", front_share), ("rear", 1.0 - front_share)):
        supported.set(f"suspension.{axle}.brake_support_angle", math.atan(HEIGHT / WHEELBASE / share))
    for car in (plain, supported):
        car.reset(speed_m_s=30.0)
        car.step(2500, brake_torque=[700.0, 700.0, 350.0, 350.0])
    assert plain.state()["pitch_angle"] > 0.015
    assert abs(supported.state()["pitch_angle"]) < 0.03 * plain.state()["pitch_angle"]


def test_skyhook_dampers_calm_the_body_and_only_take_energy() -> None:
    """Heave after a step of gravity: the skyhook law takes more of it than passive dampers of half the rate."""
    left = {}
    for mode in (0.0, 1.0):
        half = both_axles({"damping_scale": 0.5}) | {"suspension.adaptive.firm_scale": 10.0}
        car = Plant(without_losses(half | {"suspension.adaptive.mode": mode}))
        car.reset(speed_m_s=0.0)
        car.set("road.gravity", GRAVITY - 1.0)
        swing, lost = [], [0.0]
        for _ in range(1500):
            car.step(1)
            swing.append(car.state()["suspension_travel_fl"])
            lost.append(car.energy_account()["damper_energy"])
        left[mode] = np.ptp(swing[700:])
        assert np.min(np.diff(lost)) > -1e-9
    assert left[1.0] < 0.3 * left[0.0]


def test_an_adaptive_damper_stays_within_its_valves() -> None:
    car = Plant(without_losses({"suspension.adaptive.mode": 1.0}), RoadFile(friction=0.9))
    car.reset(speed_m_s=25.0)
    factors = []
    for tick in range(2500):
        car.step(1, steer=0.8 * math.sin(tick * 6e-3), brake_torque=600.0 if tick % 800 > 500 else 0.0)
        factors.append(car._state["valve"][0].copy())
    factors = np.array(factors)
    # the lag moves between the ends, never beyond them
    assert factors.min() >= 0.5
    assert factors.max() <= 2.0
    assert np.ptp(factors) > 1.0
