"""Resolving scenarios: includes, values from the command line, paths, defaults, the dump that reads back the same."""

from pathlib import Path

import pytest

from bench.scenario import ScenarioFile, dump, resolve
from bench.scenario.locate import scenario_files
from bench.scenario.procedure import is_procedure
from bench.scenario.vehicle_choice import nominal_vehicle, vehicle_as_driven
from signals.errors import FileFaults, InputError

BASE = """\
vehicle: ekf_car
initial_speed: 100 km/h
manoeuvre:
  steps:
    - name: hold
      hold_speed: {speed: 100 km/h}
      until: {distance: 30 m}
    - name: brake
      brake: {pedal_force: 500 N}
      until: {signal: speed, below: 0.1 km/h}
criteria:
  - {id: distance, value: stopping_distance, at_most: 60 m}
"""


@pytest.fixture
def folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    monkeypatch.chdir(tmp_path)
    (tmp_path / "base.yaml").write_text(BASE)
    return tmp_path


def written(folder: Path, text: str, name: str = "case.yaml") -> Path:
    path = folder / name
    path.parent.mkdir(parents=True, exist_ok=True)
    path.write_text(text)
    return path


@pytest.mark.parametrize("name", sorted(name for name in scenario_files() if not name.startswith("campaigns/")))
def test_every_shipped_scenario_resolves_and_reads_back_the_same(name: str, tmp_path: Path) -> None:
    from bench.scenario.procedure import read_procedure

    path = scenario_files()[name]
    if is_procedure(name):
        assert read_procedure(path).title
        return
    scenario = resolve(name)
    assert scenario.title
    assert scenario.criteria
    again = written(tmp_path, dump(scenario))
    assert resolve(again) == scenario
    assert resolve(again).id == name


def test_the_ids_of_the_design_ship() -> None:
    friction = [
        "e4_abs_dry_95",
        "e6_no_abs_high_grip",
        "e7_no_abs_low_grip",
        "e8_abs_high_grip",
        "e9_abs_low_grip",
        "e10_abs_grip_jump",
        "e11_zero_torque_z1",
        "e11_zero_torque_z2",
        *(f"asphalt_site{site}_dry_{kind}" for site in (1, 2) for kind in ("conventional", "rubber")),
        *(f"asphalt_site1_wet_{kind}" for kind in ("conventional", "rubber")),
        *(f"asphalt_sim_{name}" for name in ("dry_mu115", "dry_mu100", "wet_mu100", "wet_mu090")),
    ]
    stops = ["dry", "wet", "snow", "ice", "ice_polished", "mu_split", "mu_jump_up", "mu_jump_down"]
    stops += ["no_ecu", "ecu_silent", "brake_in_turn"]
    wanted = {f"friction/{name}" for name in friction} | {f"stops/{name}" for name in stops}
    assert wanted <= set(scenario_files())


def test_acceptance_targets_stand_in_the_friction_scenarios() -> None:
    """A1 to A13 and A17 of the friction document, 4.8."""
    requirements = {
        criterion.requirement
        for name in scenario_files()
        if name.startswith("friction/") and not is_procedure(name)
        for criterion in resolve(name).criteria
    }
    for number in (*range(1, 14), 17):
        assert any(text.startswith(f"friction document 4.8 A{number}") for text in requirements), number


def test_quantities_are_si_and_defaults_are_there(folder: Path) -> None:
    scenario = resolve("base.yaml")
    assert scenario.initial_speed == pytest.approx(100 / 3.6)
    assert scenario.ecu.calibration == "sensitive"
    assert scenario.pacing == "realtime"
    assert scenario.seed == 1
    assert scenario.id == "base"


def test_an_include_is_overlaid_field_by_field(folder: Path) -> None:
    written(folder, "road: {friction: 0.8, grade: 5 %}\nseed: 7\n", "parts/road.yaml")
    scenario = resolve(written(folder, "include: [base.yaml, parts/road.yaml]\nroad: {friction: 0.5}\n"))
    assert (scenario.road.friction, scenario.road.grade, scenario.seed) == (0.5, 0.05, 7)
    assert scenario.include == []


def test_criteria_of_an_include_are_merged_by_id(folder: Path) -> None:
    text = "include: [base.yaml]\ncriteria:\n- {id: own, value: mfdd}\n- {id: distance, at_most: 40 m}\n"
    criteria = {criterion.id: criterion for criterion in resolve(written(folder, text)).criteria}
    assert list(criteria) == ["distance", "own"]
    assert (criteria["distance"].value, criteria["distance"].at_most) == ("stopping_distance", "40 m")


def test_a_fault_in_an_include_names_that_file(folder: Path) -> None:
    written(folder, "plant: mujocco\n", "part.yaml")
    with pytest.raises(FileFaults) as caught:
        resolve(written(folder, "include: [base.yaml, part.yaml]\nseed: -1\n"))
    places = [(Path(fault.file).name, fault.line, fault.field) for fault in caught.value.faults]
    assert places == [("case.yaml", 2, "seed"), ("part.yaml", 1, "plant")]


def test_merged_lists_keep_their_places(folder: Path) -> None:
    text = "include: [base.yaml]\ncriteria:\n- {id: own, value: mfd}\n"
    with pytest.raises(FileFaults) as caught:
        resolve(written(folder, text))
    assert [(fault.line, fault.column) for fault in caught.value.faults] == [(3, 20)]


def test_set_reaches_fields_lists_and_parameters(folder: Path) -> None:
    scenario = resolve(
        "base.yaml",
        [
            "plant=single_track",
            "ecu.calibration=coarse",
            "manoeuvre.steps.brake.brake.pedal_force=80 N",
            "manoeuvre.steps[0].until.distance=10",
            "criteria.distance.at_most=70 m",
            "brakes.front.pad_friction=0.3",
            "sensors.yaw_rate.noise=0.1 deg/s",
            "road.friction=0.5",
            "estimators.friction_ekf.slip_rate_sign=-1",
            "seed=9",
        ],
    )
    assert (scenario.plant, scenario.ecu.calibration, scenario.seed) == ("single_track", "coarse", 9)
    assert scenario.manoeuvre.steps[1].brake is not None
    assert scenario.manoeuvre.steps[1].brake.model_dump()["pedal_force"] == 80.0
    assert scenario.manoeuvre.steps[0].until is not None
    assert scenario.manoeuvre.steps[0].until.distance == 10.0
    assert scenario.criteria[0].at_most == "70 m"
    assert scenario.overrides["brakes.front.pad_friction"] == 0.3
    assert scenario.overrides["sensors.yaw_rate.noise"] == pytest.approx(0.1 * 0.017453292519943295)
    assert scenario.road.friction == 0.5
    assert scenario.estimators["friction_ekf"]["slip_rate_sign"] == -1


def test_set_on_a_road_that_is_given_by_name(folder: Path) -> None:
    scenario = resolve(written(folder, "include: [base.yaml]\nroad: wet\n"), ["road.friction=0.9"])
    assert (scenario.road.name, scenario.road.friction) == ("wet", 0.9)


def test_options_win_over_the_file(folder: Path) -> None:
    scenario = resolve("base.yaml", seed=5, vehicle="asphalt_car", ecu="none", pacing="lockstep", plant="single_track")
    assert (scenario.seed, scenario.vehicle, scenario.ecu.kind) == (5, "asphalt_car", "none")
    assert (scenario.pacing, scenario.plant) == ("lockstep", "single_track")


def test_overrides_reach_the_car_that_is_driven_but_not_the_nominal_one(folder: Path) -> None:
    text = "include: [base.yaml]\ntyres: reduced_unit_peak\nsensors: {yaw_rate: {offset: 1 deg/s}}\n"
    scenario = resolve(written(folder, text), {"body.mass": "1.4 t"})
    driven, nominal = vehicle_as_driven(scenario), nominal_vehicle(scenario)
    assert (driven.body.mass, nominal.body.mass) == (1400.0, 1296.0)
    assert driven.sensors.yaw_rate.offset == pytest.approx(0.017453292519943295)
    assert driven.numbers("tyres")["tyres.front.longitudinal.peak_friction"] == 1.0
    assert nominal.numbers("tyres")["tyres.front.longitudinal.peak_friction"] == 1.12


def test_paths_start_from_the_file_that_names_them(folder: Path) -> None:
    written(folder, "format: 1\nname: mine\nextends: ekf_car\nbody: {mass: 1500 kg}\n", "parts/car.yaml")
    written(folder, "vehicle: car.yaml\n", "parts/part.yaml")
    scenario = resolve(written(folder, "include: [base.yaml, parts/part.yaml]\n"))
    assert scenario.vehicle == str((folder / "parts/car.yaml").resolve())
    assert vehicle_as_driven(scenario).body.mass == 1500.0


def test_stimuli_are_si_with_their_table(folder: Path) -> None:
    written(folder, "t,force\n0,0\n1,250\n", "pedal.csv")
    text = """include: [base.yaml]
stimuli:
- {target: true_master_pressure, ramp: {to: 50 bar, over: 1 s}, when: {phase: brake}}
- {target: driver_pedal_force, table: {file: pedal.csv, time_column: t, value_column: force}}
- {target: brakes.front.pad_friction, sine: {amplitude: 10 %, frequency: 2 Hz}}
"""
    ramp, table, sine = resolve(written(folder, text)).stimuli
    assert ramp.ramp is not None
    assert ramp.ramp.to == 5e6
    assert table.table is not None
    assert (table.table.times, table.table.values, table.table.file) == ([0.0, 1.0], [0.0, 250.0], None)
    assert sine.sine is not None
    assert sine.sine.amplitude == pytest.approx(0.1)


def test_settings_of_estimators_are_complete(folder: Path) -> None:
    text = "include: [base.yaml]\nestimators: {friction_ekf: , friction_ekf_other: {slip_rate_sign: -1}}\n"
    estimators = resolve(written(folder, text)).estimators
    assert estimators["friction_ekf"]["slip_rate_sign"] == 1
    assert estimators["friction_ekf_other"]["slip_rate_sign"] == -1
    assert "torque_mode" in estimators["friction_ekf_other"]


def test_outputs_of_estimators_are_signals(folder: Path) -> None:
    text = """include: [base.yaml]
estimators: [friction_ekf]
ecu: {expect: lost, kill: {signal: friction_ekf.speed, below: 36 km/h}}
criteria:
- {id: error, value: estimator_error(friction_ekf.speed), at_most: 1 km/h}
"""
    assert resolve(written(folder, text)).ecu.kill is not None
    with pytest.raises(FileFaults, match=r"unknown signal"):
        resolve(written(folder, text.replace("friction_ekf.speed, below", "friction_ekf.sped, below")))


def test_faults_of_schema_and_of_meaning_come_together(folder: Path) -> None:
    text = """include: [base.yaml]
plant: mujocco
vehicle: ekf_cra
overrides: {brakes.front.pad_friction: 30}
ecu: {calibration: sensitiv}
criteria:
- {id: own, value: mfd}
"""
    with pytest.raises(FileFaults) as caught:
        resolve(written(folder, text))
    assert [fault.line for fault in caught.value.faults] == [2, 3, 5, 7]
    assert len(str(caught.value).splitlines()) <= 6


def test_own_scenarios_come_before_shipped_ones(folder: Path) -> None:
    written(folder, f"title: mine\n{BASE}", "scenarios/stops/dry.yaml")
    assert resolve("stops/dry").title == "mine"
    assert resolve("stops/wet").title != "mine"


def test_an_unknown_id_names_the_nearest() -> None:
    with pytest.raises(InputError) as caught:
        resolve("mu_split")
    assert caught.value.nearest == "stops/mu_split"


def test_a_dump_is_complete(folder: Path) -> None:
    text = dump(resolve("base.yaml"))
    for field in ("initial_speed: 27.7", "wheel_substeps: 5", "first_answer: 5.0", "wind_speed_x: 0.0", "ramp: 4000.0"):
        assert field in text
    assert isinstance(resolve(written(folder, text)), ScenarioFile)
