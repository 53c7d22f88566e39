"""The generator as the challenge runs it: data sheet, files that the bench reads, look-alikes, further data."""

import json
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

from bench.challenge.generator import generate, generator_program, record_further, separate
from bench.challenge.parameters import estimate_of
from model_diagnosis.data import suggest_channels
from model_diagnosis.effects.catalogue import effect as find_effect
from model_diagnosis.replay.parameters import nominal_value, values_of
from signals.errors import BenchError
from signals.measured.channel_map import load_channel_map
from signals.measured.measured_log import read_log
from vehicle_model import load_vehicle

DATA_SHEET = {
    "body.mass": 1296.0,
    "body.centre_of_gravity_height": 0.535,
    "body.yaw_inertia": 1817.473,
    "brakes.booster_gain": 3e4,
    "hydraulics.increase_time_constant": 0.05,
    "steering.stiffness": 2e4,
    "suspension.rear.spring_rate": 22e3,
    "tyres.front.longitudinal.stiffness": 14.34,
    "tyres.rear.relaxation_length_lateral": 0.2,
    "wheels.rl.inertia": 0.8,
}
"""Numbers of the generator's car by their paths in the vehicle file that comes with every case."""

PAD_AGAINST_SCALE = 0
"""Look-alike of seed 10 000 with pad friction hidden and the scale of the pressure sensors as its twin."""


@pytest.fixture(scope="module")
def cases(tmp_path_factory: pytest.TempPathFactory) -> list[Path]:
    folder = tmp_path_factory.mktemp("cases")
    return generate(folder / "cases", folder / "sealed", seed=10_000, count=5, family="clean", generator="first")


def test_the_program_is_found_beside_the_tests() -> None:
    assert generator_program().name == "generate.py"
    assert generator_program().is_file()


def test_the_vehicle_file_of_a_case_is_the_generators_data_sheet(cases: list[Path]) -> None:
    vehicle = load_vehicle(cases[0] / "vehicle.yaml")
    numbers = vehicle.numbers()
    assert {path: numbers[path] for path in DATA_SHEET} == pytest.approx(DATA_SHEET, rel=1e-6)
    torque = 2.0 * numbers["brakes.front.pad_area"] * numbers["brakes.front.pad_friction"]
    assert torque * numbers["brakes.front.effective_radius"] == pytest.approx(13e-5)
    assert numbers["aerodynamics.drag_coefficient"] * numbers["aerodynamics.frontal_area"] == pytest.approx(0.8)


def test_values_of_hidden_effects_are_in_the_units_of_the_catalogues(cases: list[Path]) -> None:
    """``estimate_of`` raises where a label's value and a cause's have not the same unit.

    A disc's thickness has an amplitude for its sine and cosine parts, and takes the way of its own.
    """
    known = values_of(load_vehicle(cases[0] / "vehicle.yaml"))
    printed = subprocess.run([sys.executable, str(generator_program()), "effects"], capture_output=True, check=True)
    hidden = json.loads(printed.stdout)
    scored = set()
    for one in hidden:
        parameters = {}
        for parameter in find_effect(one["name"]).parameters:
            nominal, unit = nominal_value(parameter, known)
            parameters[parameter.name] = {"value": 1.0, "low": 0.0, "high": 2.0, "unit": unit, "nominal": nominal}
        place = next(iter(parameters)) if one["places"] else ""
        if estimate_of({**one, "place": place}, parameters) is not None:
            scored.add(one["name"])
    assert len(hidden) == 60
    assert {one["name"] for one in hidden} - scored == {"disc_thickness_variation"}


def test_the_catalogues_bounds_hold_what_is_hidden() -> None:
    """A cause at the end of its range leaves a rest that another one beside it explains."""
    printed = subprocess.run([sys.executable, str(generator_program()), "effects"], capture_output=True, check=True)
    factors = [one for one in json.loads(printed.stdout) if one["relative"]]
    outside = [
        (one["name"], extreme)
        for one in factors
        for parameter in find_effect(one["name"]).parameters
        for extreme in one["extremes"]
        if parameter.relative and not parameter.low < extreme < parameter.high
    ]
    assert len(factors) > 15
    assert outside == []


def test_every_stated_scatter_belongs_to_a_number_of_the_file(cases: list[Path]) -> None:
    vehicle = load_vehicle(cases[0] / "vehicle.yaml")
    assert set(vehicle.scatter) <= set(vehicle.numbers())
    assert vehicle.scatter["body.mass"].std == 0.03


def test_every_log_is_read_through_its_map_with_the_speeds_that_belong_together(cases: list[Path]) -> None:
    formats = set()
    for case in cases:
        channel_map = load_channel_map(case / "channels.yaml")
        for path in sorted((case / "logs").iterdir()):
            formats.add(path.suffix)
            _, channels = read_log(path, channel_map).resample(0.01)
            assert set(channels) == set(channel_map.channels)
            if "speed" in channels and path.stem == "coast":
                rolling = 0.278 * np.median(channels["wheel_speed_rl"]) / np.median(channels["speed"])
                assert rolling == pytest.approx(1.0, abs=0.015)
    assert ".csv" in formats


def test_the_suggested_map_of_a_log_is_the_one_that_the_generator_wrote(cases: list[Path]) -> None:
    """Of every kind of file; a gentle drive tells no unit of what does not move, so that the log's own ones stand."""
    for case in {next((case / "logs").iterdir()).suffix: case for case in cases}.values():
        by_generator = load_channel_map(case / "channels.yaml")
        log = next((case / "logs").glob("brake_in_turn.*"))
        suggested = suggest_channels([log], load_vehicle(case / "vehicle.yaml"), by_generator.dbc).channel_map()
        assert suggested.channels == by_generator.channels, case.name


def test_equal_terms_cannot_be_told_apart_and_different_ones_can() -> None:
    """Pad friction and the scale of all pressure sensors are the same factor without a master pressure."""
    (evidence,) = separate(
        ["pressure_sensor_scale", "yaw_inertia", "no_such_effect"],
        seed=10_000, index=PAD_AGAINST_SCALE, family="confounded", generator="first",
    )  # fmt: skip
    assert evidence["pressure_sensor_scale"] == pytest.approx(0.0, abs=0.5)
    assert (evidence["yaw_inertia"] or 0.0) > 3.0
    assert evidence["no_such_effect"] is None


def test_further_data_has_the_planned_manoeuvre_and_the_channel_that_was_missing(tmp_path: Path) -> None:
    script = tmp_path / "script.json"
    table = {"name": "push", "speed": 12.0, "time": [0.0, 4.0], "pedal": [0.0, 0.0], "steering_wheel": [0.0, 0.0]}
    script.write_text(json.dumps(table | {"drive_torque": [0.0, 1500.0]}))
    record_further(
        tmp_path / "case", seed=10_000, index=0, family="confounded", generator="first", script=script,
        channel="master_pressure",
    )  # fmt: skip
    channel_map = load_channel_map(tmp_path / "case" / "channels.yaml")
    (log,) = (tmp_path / "case" / "logs").glob("push.*")
    _, channels = read_log(log, channel_map).resample(0.01)
    assert "master_pressure" in channels
    assert "pedal_force" not in channels
    assert channels["drive_torque_r"][-1] > 1400.0
    assert channels["wheel_speed_rl"][-1] > 1.1 * channels["wheel_speed_rl"][0]


def test_a_generator_that_fails_is_told_in_one_line(tmp_path: Path) -> None:
    with pytest.raises(BenchError, match="the generator ended with code"):
        generate(tmp_path, tmp_path, seed=1, count=1, family="no_such_family", generator="first")
