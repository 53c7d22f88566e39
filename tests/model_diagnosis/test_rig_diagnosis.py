"""The diagnosis of one wheel on a rig, on logs that numpy made without the replay's code."""

import sys
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

sys.path.insert(0, str(Path(__file__).parent))

from rig_bench import NOISE, STRAY_N, programme, rig_car

from bench.diagnosis.diagnosing import Found, write
from model_diagnosis.diagnosis import diagnose
from model_diagnosis.findings import Findings
from model_diagnosis.manoeuvre import Manoeuvre
from model_diagnosis.vehicle_fit import fit_vehicle
from signals.errors import InputError
from vehicle_model.vehicle_file import VehicleFile, load_vehicle


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return tmp_path_factory.mktemp("rig")


@pytest.fixture(scope="module")
def car(folder: Path) -> VehicleFile:
    return rig_car(folder)


@pytest.fixture(scope="module")
def stiffer(car: VehicleFile) -> Findings:
    return diagnose(programme(cornering=1.2), car, hold_out=programme(seed=20, cornering=1.2)[1:3])


def without(manoeuvres: list[Manoeuvre], name: str) -> list[Manoeuvre]:
    return [replace(one, channels={k: v for k, v in one.channels.items() if k != name}) for one in manoeuvres]


def test_a_stiffer_tyre_is_named_with_its_stiffness(stiffer: Findings) -> None:
    [cause] = stiffer.diagnosis.causes
    assert cause.effect == "tyre_cornering_stiffness"
    assert cause.parameters["front"].value == pytest.approx(1.2 * 13.0, rel=0.03)
    assert list(cause.parameters) == ["front"]  # the other axle's tyre was not on the rig


def test_its_extended_vehicle_gains_and_is_written(stiffer: Findings, car: VehicleFile, folder: Path) -> None:
    gain = stiffer.diagnosis.gain
    assert gain is not None
    assert gain.overall.high < 1.0
    written = write(Found(stiffer, car, str(folder / "rig_car.yaml")), folder / "out")
    assert written.diagnosis.extension_file == "extended_vehicle.yaml"
    tyre = load_vehicle(folder / "out" / "extended_vehicle.yaml").tyre_pair.front
    assert tyre.lateral.stiffness == pytest.approx(1.2 * 13.0, rel=0.03)
    assert (folder / "out" / "diagnosis.html").is_file()


def test_what_is_of_a_car_only_is_told_as_left_out(stiffer: Findings) -> None:
    assert stiffer.diagnosis.subject == "wheel_on_rig"
    assert any("not for a wheel on a rig" in remark for remark in stiffer.diagnosis.remarks)
    assert not stiffer.diagnosis.guilty_equations


def test_a_slippery_belt_is_named_with_its_friction(car: VehicleFile) -> None:
    [cause] = diagnose(programme(friction=0.8), car).diagnosis.causes
    assert cause.effect == "tyre_friction"
    assert cause.parameters["front"].value == pytest.approx(0.8, rel=0.03)


def test_a_tyre_that_follows_later_is_named_with_its_relaxation_length(car: VehicleFile) -> None:
    [cause] = diagnose(programme(relaxation=0.6), car).diagnosis.causes
    assert cause.effect == "tyre_relaxation_length"
    assert cause.parameters["length"].value == pytest.approx(0.6, rel=0.1)


def test_two_things_of_a_tyre_are_named_as_two(car: VehicleFile) -> None:
    causes = {cause.effect: cause for cause in diagnose(programme(friction=0.85, cornering=1.25), car).diagnosis.causes}
    assert set(causes) == {"tyre_friction", "tyre_cornering_stiffness"}
    assert causes["tyre_friction"].parameters["front"].value == pytest.approx(0.85, rel=0.03)
    assert causes["tyre_cornering_stiffness"].parameters["front"].value == pytest.approx(1.25 * 13.0, rel=0.05)


def test_another_tyre_is_a_wrong_vehicle_with_the_numbers_that_the_rig_says(car: VehicleFile) -> None:
    other = {"friction": 0.6, "cornering": 0.9, "slip": 0.6}
    answer = diagnose(programme(**other), car, hold_out=programme(seed=20, **other)[1:3]).diagnosis
    assert answer.verdict == "wrong_vehicle"
    assert not answer.causes
    assert answer.gain is not None
    # the forces' own noise is all that another tyre's numbers may leave
    noise = np.hypot(NOISE["lateral_force_fl"], STRAY_N)
    least = np.mean([noise / force.before for force in answer.gain.held_out.values()])
    assert answer.gain.overall.high < 1.2 * least


@pytest.mark.parametrize(("seed", "friction", "cornering"), [(0, 1.0, 1.0), (40, 0.97, 0.97), (60, 1.03, 0.98)])
def test_of_a_tyre_within_the_files_scatter_nothing_is_named(
    car: VehicleFile, seed: int, friction: float, cornering: float
) -> None:
    diagnosis = diagnose(programme(seed, friction=friction, cornering=cornering), car).diagnosis
    assert diagnosis.verdict == "nothing_found"
    assert not diagnosis.causes


def test_a_vehicle_is_calibrated_on_a_rigs_log(car: VehicleFile) -> None:
    fitted = fit_vehicle(programme(cornering=1.05), car).calibrated
    stiffness = next(one for one in fitted if one.effect == "tyre_cornering_stiffness")
    assert stiffness.values == {"tyres.front.lateral.stiffness": pytest.approx(1.05 * 13.0, rel=0.01)}


def test_a_rig_without_load_or_speed_is_told_what_is_missing(car: VehicleFile) -> None:
    with pytest.raises(InputError, match="cannot be replayed without vertical_load_fl"):
        diagnose(without(programme(), "vertical_load_fl"), car)
    with pytest.raises(InputError, match="cannot be replayed without speed"):
        diagnose(without(programme(), "speed"), car)


def test_a_car_cannot_be_held_out_of_a_rigs_diagnosis(car: VehicleFile) -> None:
    moving = [
        replace(one, channels=dict(one.channels) | {"yaw_rate": np.zeros(one.samples)}) for one in programme(seed=9)
    ]
    with pytest.raises(InputError, match="a car and of a wheel on a rig"):
        diagnose(programme(), car, hold_out=moving)
