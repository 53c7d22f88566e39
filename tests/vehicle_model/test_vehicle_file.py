"""Vehicle files: the shipped cars, inheritance, tables, faults."""

from pathlib import Path

import pytest

from signals.errors import InputError
from vehicle_model.vehicle_file import (
    load_tyres,
    load_vehicle,
    parameter_table,
    set_parameter,
    vehicle_names,
)


def test_the_car_of_table_8() -> None:
    car = load_vehicle("ekf_car")
    body, wheel = car.body, car.wheels.fl
    assert (body.mass, body.wheelbase, body.centre_of_gravity_to_front_axle) == (1296.0, 2.57, 1.25)
    assert (body.centre_of_gravity_height, body.pitch_inertia) == (0.535, 1520.0)
    assert (wheel.unloaded_radius, wheel.radius, wheel.inertia) == (0.288, 0.278, 0.8)
    assert wheel.rolling_resistance == 0.015
    air = car.aerodynamics
    assert (air.frontal_area, air.drag_coefficient, air.air_density) == (2.0, 0.4, 1.2)
    assert air.drag_height == 0.535
    # derived numbers of the document: D_a = 0.48 kg/m, F_r = 190.7 N
    assert 0.5 * air.air_density * air.drag_coefficient * air.frontal_area == pytest.approx(0.48)
    assert wheel.rolling_resistance * body.mass * 9.81 == pytest.approx(190.7, abs=0.05)
    tyres = car.tyre_pair
    assert tyres.front.longitudinal.peak_friction == 1.12  # type: ignore[union-attr]
    assert tyres.rear.longitudinal.peak_friction == 0.98  # type: ignore[union-attr]
    # 26 and 13 N m/bar for the axles: two brakes, each 2 p A mu R (eq. 78)
    for axle, gain in ((car.brakes.front, 26.0), (car.brakes.rear, 13.0)):
        assert 4.0 * 1e5 * axle.pad_area * axle.pad_friction * axle.effective_radius == pytest.approx(gain)


def test_the_car_of_table_4() -> None:
    car = load_vehicle("baseline_car")
    assert (car.body.mass, car.body.wheelbase) == (1544.0, 3.105)
    assert (car.axles.front.track, car.axles.rear.track) == (1.510, 1.530)
    assert (car.wheels.rr.unloaded_radius, car.wheels.rr.radius, car.wheels.rr.inertia) == (0.288, 0.278, 0.8)
    # eq. 116, not the value of the car that it extends
    assert car.body.pitch_inertia == pytest.approx(0.75 / 12.0 * 1544.0 * (4.9**2 + 1.45**2))


def test_the_car_of_table_11() -> None:
    car = load_vehicle("asphalt_car")
    assert (car.body.mass, car.body.wheelbase) == (1969.0, 3.035)
    assert (car.axles.front.track, car.axles.rear.track) == (1.6, 1.606)
    assert (car.wheels.fl.radius, car.wheels.fl.unloaded_radius, car.wheels.fl.inertia) == (0.333, 0.345, 1.5)
    assert car.wheels.fl.rolling_resistance == 0.0145
    assert car.aerodynamics.drag_coefficient * car.aerodynamics.frontal_area == pytest.approx(0.619, abs=1e-3)
    assert car.body.yaw_inertia == pytest.approx(0.1269 * 1969.0 * 3.035 * 5.076)


def test_the_yaw_inertia_as_printed_is_selectable(tmp_path: Path) -> None:
    file = tmp_path / "car.yaml"
    file.write_text(
        "format: 1\nname: printed\nextends: ekf_car\nbody: {yaw_inertia_rule: wheelbase_squared, yaw_inertia: null}\n"
    )
    assert load_vehicle(file).body.yaw_inertia == pytest.approx(0.1269 * 1296.0 * 2.57**2)


@pytest.mark.acceptance("F-41")
@pytest.mark.parametrize("name", ["ekf_car", "baseline_car", "asphalt_car"])
def test_every_number_of_a_shipped_car_has_a_source(name: str) -> None:
    assert set(vehicle_names()) >= {name}
    bare = [info.path for info in parameter_table(load_vehicle(name)) if not info.source and info.neutral is None]
    assert bare == []


def test_a_value_that_a_file_changes_loses_the_source_of_its_base(tmp_path: Path) -> None:
    file = tmp_path / "car.yaml"
    file.write_text(
        "format: 1\nname: heavy\nextends: ekf_car\nbody: {mass: 1.5 t}\nsuspension: {front: {spring_rate: 21 kN/m}}\n"
    )
    table = {info.path: info for info in parameter_table(load_vehicle(file))}
    assert table["body.mass"].value == 1500.0
    assert table["body.mass"].source == ""
    assert table["body.wheelbase"].source == "Table 8, l. 1354"
    assert table["suspension.front.spring_rate"].source == ""


def test_table_and_flat_numbers_agree_and_know_units() -> None:
    car = load_vehicle("ekf_car")
    table = {info.path: info for info in parameter_table(car)}
    assert {path: info.value for path, info in table.items()} == car.numbers()
    assert car.numbers("brakes").keys() == {path for path in table if path.startswith("brakes.")}
    entry = table["brakes.front.pad_friction"]
    assert (entry.unit, entry.value, entry.low, entry.high) == ("1", 0.4, 0.0, 2.0)
    assert table["wheels.fl.toe"].neutral == 0.0
    assert table["driveline.gear_ratios.1"].value == 2.1
    assert table["driveline.engine.speed_points.1"].value == pytest.approx(1000.0 * 3.141592653589793 / 30.0)


def test_set_parameter_takes_units_and_refuses_nonsense() -> None:
    car = load_vehicle("ekf_car")
    set_parameter(car, "brakes.front.pad_area", "20 cm^2")
    assert car.brakes.front.pad_area == pytest.approx(2e-3)
    set_parameter(car, "driveline.gear_ratios.0", 4.0)
    assert car.driveline.gear_ratios[0] == 4.0
    for path, value, message in (
        ("brakes.front.pad_aria", 1.0, "did you mean brakes.front.pad_area"),
        ("breaks.front.pad_area", 1.0, "did you mean brakes"),
        ("body.mass", "3 m", "body.mass"),
        ("body.mass", 1e9, "allowed: 100…10000 kg"),
        ("body.mass", float("nan"), "out of range"),
    ):
        with pytest.raises(InputError) as caught:
            set_parameter(car, path, value)
        assert message in str(caught.value)
    assert car.body.mass == 1296.0


def test_extensions_change_the_car_that_they_extend(tmp_path: Path) -> None:
    file = tmp_path / "extended.yaml"
    file.write_text(
        "format: 1\nname: extended\nextends: ekf_car\n"
        "extensions:\n  - {effect: wheel_radius_change, parameters: {wheels.fl.radius: 0.27 m}, evidence: run 12}\n"
        "scatter: {body.mass: {std: 2 %, kind: relative}}\n"
    )
    car = load_vehicle(file)
    assert car.wheels.fl.radius == 0.27
    assert car.scatter["body.mass"].std == pytest.approx(0.02)


def test_a_tyre_file_beside_the_vehicle_is_found(tmp_path: Path) -> None:
    (tmp_path / "mine.yaml").write_text(
        "format: 1\nname: mine\n"
        "front: &tyre\n  longitudinal: {c1: 1.2801, c2: 23.99, c3: 0.52}\n"
        "  lateral: {peak_friction: 1.0, shape: 1.4, stiffness: 13}\nrear: *tyre\n"
    )
    file = tmp_path / "car.yaml"
    file.write_text("format: 1\nname: car\nextends: ekf_car\ntyres: mine.yaml\n")
    assert load_vehicle(file).tyre_pair.rear.longitudinal.c2 == 23.99  # type: ignore[union-attr]
    assert load_tyres("reduced_set_a").front.longitudinal.shape == 1.25  # type: ignore[union-attr]


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("format: 1\nname: x\nextends: ekf_kar\n", "did you mean ekf_car"),
        ("format: 1\nname: x\nextends: car.yaml\n", "extends itself"),
        ("format: 1\nname: x\nextends: ekf_car\ntyres: none.yaml\n", "car.yaml:4:8"),
        ("format: 1\nname: x\nextends: ekf_car\nwheels: {fl: {unloaded_radius: 0.2}}\n", "car.yaml:4:32"),
        ("format: 1\nname: x\nextends: ekf_car\nbody: {centre_of_gravity_to_front_axle: 4}\n", "wheelbase of 2.57"),
        ("format: 1\nname: x\nextends: ekf_car\nbody: {mass: 12 m}\n", "car.yaml:4:14"),
        ("format: 1\nname: x\nextends: ekf_car\nbody: {mas: 12}\n", "car.yaml:4:8"),
        ("format: 2\nname: x\nextends: ekf_car\n", "format"),
        ("format: 1\nname: x\nextends: ekf_car\nbody: {yaw_inertia: -5}\n", "allowed: 1…100000 kg m^2"),
        ("format: 1\nname: x\nextends: ekf_car\nbody: {pitch_inertia: 100}\n", "body.pitch_inertia: not more than"),
        ("format: 1\nname: x\nextends: ekf_car\nbody: {roll_inertia: 80}\n", "car.yaml:4:22"),
        ("format: 1\nname: x\nextends: ekf_car\nbody: {mass: 140}\n", "allowed: more than 152 kg"),
        ("format: 1\nname: x\nextends: ekf_car\nwheels: {fl: {inertia: -1}}\n", "allowed: 0.01…100 kg m^2"),
        ("format: 1\nname: x\nextends: ekf_car\ndriveline: {gear_ratios: [3, -2]}\n", "car.yaml:4:30"),
        ("format: 1\nname: x\nextends: ekf_car\ndriveline: {drive: fourth}\n", "allowed: front, rear, all"),
        ("format: 1\nname: x\nextends: ekf_car\nsteering: {ratio: 0}\n", "allowed: 1…50"),
        ("format: 1\nname: x\nextends: ekf_car\naerodynamics: {air_density: .nan}\n", "not a finite number"),
    ],
)
def test_faults_name_the_place(tmp_path: Path, text: str, message: str) -> None:
    file = tmp_path / "car.yaml"
    file.write_text(text)
    with pytest.raises(InputError) as caught:
        load_vehicle(file)
    assert message in str(caught.value)
