"""The MuJoCo car on tyres from ``.tir`` files."""

import math
from pathlib import Path

import numpy as np
import pytest
from test_tir_tyres import COEFFICIENTS, write

from signals.errors import InputError
from signals.wheels import WHEELS
from vehicle_model.plant import Plant
from vehicle_model.road import RoadTables
from vehicle_model.road_file import RoadFile
from vehicle_model.tyres import read_tir
from vehicle_model.tyres.coefficients import TYRE_SIZE, write_tyre
from vehicle_model.tyres.kernel import PEAK_FORCE_X, PREPARED_SIZE, across, along, peak_slips, prepare
from vehicle_model.tyres.tyre_file import TirTyre
from vehicle_model.vehicle_file import VehicleFile, load_tyres, load_vehicle, parameter_table, set_parameter
from vehicle_model.wheel_step import NEAR_X, NEAR_Y


def vehicle_on(folder: Path, coefficients: str = COEFFICIENTS, **options: str) -> VehicleFile:
    write(folder, coefficients=coefficients)
    extra = "".join(f", {name}: {value}" for name, value in options.items())
    tyres = f"{{front: {{tir: tyre.tir{extra}}}, rear: {{tir: tyre.tir{extra}}}}}"
    (folder / "car.yaml").write_text(f"format: 1\nname: car\nextends: ekf_car\ntyres: {tyres}\n")
    return load_vehicle(folder / "car.yaml")


@pytest.fixture
def vehicle(tmp_path: Path) -> VehicleFile:
    return vehicle_on(tmp_path)


@pytest.mark.parametrize("weights", ["auto", "ellipse"])
@pytest.mark.parametrize("right", [False, True])
def test_the_plant_evaluates_the_same_formula(tmp_path: Path, weights: str, right: bool) -> None:
    tyre = read_tir(write(tmp_path), combined_slip=weights)  # type: ignore[arg-type]
    row, prepared = np.zeros(TYRE_SIZE), np.zeros(PREPARED_SIZE)
    write_tyre(TirTyre(tir=str(tmp_path / "tyre.tir"), combined_slip=weights), row, right=right)  # type: ignore[arg-type]
    surface = RoadTables(RoadFile()).surfaces[0]
    random = np.random.default_rng(4)
    for _ in range(300):
        kappa, angle, camber = random.uniform(-1.0, 1.0), random.uniform(-0.4, 0.4), random.uniform(-0.1, 0.1)
        load, friction = random.uniform(300.0, 9000.0), random.uniform(0.1, 1.2)
        prepare(row, surface, friction, load, 20.0, camber, prepared)
        # slip S5 refers to the faster of rolling and travelling
        slip_x = kappa if kappa <= 0.0 else kappa / (1.0 + kappa)
        slip_y = -math.tan(angle) * (1.0 - max(slip_x, 0.0))
        force_x, slope = along(row, prepared, slip_x, slip_y)
        force_y, moment = across(row, prepared, slip_x, slip_y, force_x)
        expected = tyre.forces(kappa, angle, camber, load, friction=friction, mirrored=right)
        assert force_x == pytest.approx(expected.fx, rel=1e-9, abs=1e-6)
        assert force_y == pytest.approx(expected.fy, rel=1e-9, abs=1e-6)
        assert moment == pytest.approx(expected.mz, rel=1e-9, abs=1e-6)
        assert math.isfinite(slope)


def test_the_tangent_that_saves_evaluations_is_not_felt(tmp_path: Path) -> None:
    write(tmp_path)
    row, prepared = np.zeros(TYRE_SIZE), np.zeros(PREPARED_SIZE)
    write_tyre(TirTyre(tir=str(tmp_path / "tyre.tir")), row, right=False)
    surface = RoadTables(RoadFile()).surfaces[0]
    random = np.random.default_rng(2)
    for _ in range(300):
        load = random.uniform(500.0, 8000.0)
        prepare(row, surface, random.uniform(0.2, 1.0), load, 20.0, 0.02, prepared)
        slip_x, slip_y = random.uniform(-1.0, 0.5), random.uniform(-0.3, 0.3)
        if abs(slip_x) < NEAR_X:  # driving and braking have a slope each
            continue
        force, slope = along(row, prepared, slip_x, slip_y)
        for sign_x, sign_y in ((1.0, 1.0), (1.0, -1.0), (-1.0, 1.0), (-1.0, -1.0)):
            moved = along(row, prepared, slip_x + sign_x * NEAR_X, slip_y + sign_y * NEAR_Y)[0]
            assert abs(force + slope * sign_x * NEAR_X - moved) < 3e-5 * load


def test_slope_and_peak_of_pure_slip(vehicle: VehicleFile) -> None:
    row, prepared = np.zeros(TYRE_SIZE), np.zeros(PREPARED_SIZE)
    write_tyre(vehicle.tyre_pair.front, row, right=False)
    prepare(row, RoadTables(RoadFile()).surfaces[0], 1.0, 3000.0, 5.0, 0.0, prepared)
    for slip in (-0.5, -0.05, -1e-3, 0.02, 0.2):
        ahead, behind = (along(row, prepared, slip + step, 0.0)[0] for step in (1e-6, -1e-6))
        assert along(row, prepared, slip, 0.0)[1] == pytest.approx((ahead - behind) / 2e-6, rel=1e-4)
    slips = np.linspace(-1.0, 0.0, 10001)
    curve = np.array([-along(row, prepared, slip, 0.0)[0] for slip in slips])
    assert prepared[PEAK_FORCE_X] == pytest.approx(curve.max(), rel=1e-6)
    assert peak_slips(prepared)[0] == pytest.approx(-slips[curve.argmax()], abs=1e-3)


def test_forces_while_driving_are_those_of_the_tyre(tmp_path: Path, vehicle: VehicleFile) -> None:
    tyre = read_tir(tmp_path / "tyre.tir")
    car = Plant(vehicle)
    car.reset(speed_m_s=20.0)
    car.step(5000, steer=0.5)
    state = car.state()
    for wheel in WHEELS:
        expected = tyre.forces(
            state[f"slip_ratio_{wheel}"],
            state[f"slip_angle_{wheel}"],
            state["roll_angle"],
            state[f"vertical_load_{wheel}"],
            mirrored=wheel.endswith("r"),
            check=False,
        )
        assert state[f"lateral_force_{wheel}"] == pytest.approx(expected.fy, rel=1e-2)


def test_energy_balance_and_standstill(vehicle: VehicleFile) -> None:
    car = Plant(vehicle, RoadFile(grade=0.1))
    car.reset(speed_m_s=15.0)
    start = car.state()["mechanical_energy"]
    car.step(6000, brake_torque=900.0)
    state = car.state()
    residual = start - state["dissipated_energy"] - state["mechanical_energy"]
    assert abs(residual) < 1e-3 * start
    place = state["position_x"]
    car.step(5000, brake_torque=900.0)
    assert abs(car.state()["position_x"] - place) < 1e-5


def test_a_locked_wheel_brakes_less_than_a_slipping_one(vehicle: VehicleFile) -> None:
    distances = []
    for brake in (1e5, [1250.0, 1250.0, 600.0, 600.0]):
        car = Plant(vehicle)
        car.reset(speed_m_s=25.0)
        while car.outputs[0] > 0.1:
            car.step(1, brake_torque=brake)
        distances.append(car.state()["distance"])
        assert len(distances) > 1 or car.state()["slip_ratio_fl"] == -1.0
    assert distances[1] < 0.9 * distances[0]


def test_left_and_right_mirror_each_other(tmp_path: Path) -> None:
    """A tyre measured on the left has shifts; on the right it is turned round, so a straight car stays straight."""
    shifted = COEFFICIENTS.replace("PKY2 = 1.9", "PKY2 = 1.9\nPHY1 = 0.003\nPVY1 = 0.02").replace(
        "QDZ1 = 0.11", "QDZ1 = 0.11\nQDZ6 = 0.002"
    )
    car = Plant(vehicle_on(tmp_path, shifted))
    car.reset(speed_m_s=30.0)
    car.step(3000, brake_torque=100.0)
    state = car.state()
    assert abs(state["position_y"]) < 1e-9
    assert abs(state["lateral_force_fl"]) > 20.0
    assert state["lateral_force_fl"] == pytest.approx(-state["lateral_force_fr"], rel=1e-9)


def test_scales_and_pressure_act_while_driving(vehicle: VehicleFile) -> None:
    car = Plant(vehicle)
    assert "tyres.front.longitudinal_friction_scale" in car.names()
    car.reset(speed_m_s=25.0)
    car.step(200, brake_torque=1e5)
    before = car.state()["longitudinal_force_fl"] / car.state()["vertical_load_fl"]
    car.set("tyres.front.longitudinal_friction_scale", 0.5)
    car.step(200, brake_torque=1e5)
    after = car.state()["longitudinal_force_fl"] / car.state()["vertical_load_fl"]
    assert after == pytest.approx(0.5 * before, rel=0.1)
    car.set("road.friction", 0.5)
    car.step(1, brake_torque=1e5)
    assert car.state()["friction_limit_fl"] == pytest.approx(1.1 * 0.25, rel=0.1)


def test_a_surface_curve_replaces_the_tyre(vehicle: VehicleFile) -> None:
    car = Plant(vehicle, RoadFile(surface="polished_ice"))
    car.reset(speed_m_s=10.0)
    car.step(100, brake_torque=1e5)
    assert car.state()["friction_limit_fl"] == pytest.approx(0.1)
    assert car.state()["friction_used_fl"] == pytest.approx(-0.07, abs=1e-3)


def test_every_number_of_the_tyre_is_in_the_table(vehicle: VehicleFile) -> None:
    paths = {info.path for info in parameter_table(vehicle)}
    assert {"tyres.front.cornering_stiffness_scale", "tyres.rear.contact.damping"} <= paths
    set_parameter(vehicle, "tyres.front.lateral_friction_scale", 0.9)
    assert np.isfinite(Plant(vehicle).outputs).all()


def test_tyre_files_name_tir_files_from_their_own_folder(tmp_path: Path) -> None:
    (tmp_path / "tyres").mkdir()
    write(tmp_path / "tyres")
    (tmp_path / "tyres" / "pair.yaml").write_text("format: 1\nname: pair\nfront: &t {tir: tyre.tir}\nrear: *t\n")
    (tmp_path / "car.yaml").write_text("format: 1\nname: car\nextends: ekf_car\ntyres: tyres/pair.yaml\n")
    assert Path(load_vehicle(tmp_path / "car.yaml").tyre_pair.rear.tir).exists()  # type: ignore[union-attr]
    assert Path(load_tyres(tmp_path / "tyres" / "pair.yaml").front.tir).exists()  # type: ignore[union-attr]


def test_faults_of_tir_files_show_when_the_vehicle_is_read(tmp_path: Path) -> None:
    file = tmp_path / "car.yaml"
    file.write_text("format: 1\nname: car\nextends: ekf_car\ntyres: {front: {tir: none.tir}, rear: {tir: none.tir}}\n")
    with pytest.raises(InputError) as caught:
        load_vehicle(file)
    assert "car.yaml:4:22" in str(caught.value)
    assert "no such .tir file" in str(caught.value)
    vehicle_on(tmp_path)
    (tmp_path / "tyre.tir").write_text("[MODEL]\nFITTYP = 61\n")
    with pytest.raises(InputError, match=r"\[VERTICAL\]: section is missing"):
        load_vehicle(file.with_name("car.yaml"))


@pytest.mark.parametrize("name", ["camber", "camber_gain"])
def test_camber_leans_the_outer_wheel_against_the_bend(vehicle: VehicleFile, name: str) -> None:
    """Top inwards is negative: the loaded outer tyre then pushes into the bend, and the car turns in more."""
    plain, leaned = Plant(vehicle), Plant(vehicle)
    leaned.set(f"suspension.front.{name}", -0.05 if name == "camber" else -2.0)
    for car in (plain, leaned):
        car.reset(speed_m_s=20.0)
        car.step(3000, steer=0.4)
    assert leaned.state()["true_yaw_rate"] > 1.01 * plain.state()["true_yaw_rate"]
