"""From a hidden term in the MuJoCo car to its formula, its gain and an extended car that drives like the hidden one."""

import importlib.util
import sys
from collections.abc import Callable
from dataclasses import dataclass, replace
from pathlib import Path
from types import ModuleType

import numpy as np
import pytest

from model_diagnosis.discovery.balances import LONGITUDINAL, problems_of
from model_diagnosis.discovery.unknown import discover_unknown, with_unknown
from model_diagnosis.extension.extended_vehicle import FoundTerm, extensions_of, write_extended_vehicle
from model_diagnosis.gain import is_proven
from model_diagnosis.manoeuvre import Manoeuvre
from model_diagnosis.replay import Replay
from model_diagnosis.result import Diagnosis
from vehicle_model.extension_terms_file import Term
from vehicle_model.plant import Plant
from vehicle_model.vehicle_file import VehicleFile, load_vehicle


def _plant_log() -> ModuleType:
    file = Path(__file__).parent / "replay" / "plant_log.py"
    spec = importlib.util.spec_from_file_location("plant_log_of_terms", file)
    assert spec is not None
    assert spec.loader is not None
    module = importlib.util.module_from_spec(spec)
    sys.modules["plant_log_of_terms"] = module
    spec.loader.exec_module(module)
    return module


plant_log = _plant_log()
HIDDEN = {
    "target": "brake_torque_factor",
    "coefficient": -3e-4,
    "factors": [{"variable": "speed", "exponent": 2.0}],
}
NOISE = {"longitudinal_acceleration": 0.05, "lateral_acceleration": 0.05, "yaw_rate": 2e-3, "speed": 0.02} | {
    f"{name}_{wheel}": std
    for name, std in (("wheel_speed", 0.05), ("brake_pressure", 2e4))
    for wheel in ("fl", "fr", "rl", "rr")
}
INPUTS = ("steering_wheel_angle", "drive_torque_f", "drive_torque_r")
Drive = tuple[Callable[[float], object], float, float]


def _cars() -> tuple[VehicleFile, VehicleFile]:
    """The vehicle file, and the car that was measured: 1 % heavier, pads 2 % weaker, one term that nobody knows."""
    nominal = plant_log.ideal_sensors(load_vehicle("asphalt_car"))
    hidden = nominal.model_copy(deep=True)
    hidden.terms.stack.append(Term.model_validate(HIDDEN))
    hidden.body.mass *= 1.01
    hidden.brakes.front.pad_friction *= 0.98
    return nominal, hidden


def _measured(car: VehicleFile, drives: list[Drive], seed: int) -> list[Manoeuvre]:
    random, logs = np.random.default_rng(seed), []
    for number, (course, seconds, speed) in enumerate(drives):
        log = plant_log.drive(car, course, seconds, speed, name=f"drive {number}")
        channels = {name: log.channels[name] for name in (*NOISE, *INPUTS)}
        noisy = {
            name: values + random.normal(size=len(values)) * NOISE.get(name, 0.0) for name, values in channels.items()
        }
        logs.append(replace(log, channels=noisy, weights={name: log.weights[name] for name in noisy}))
    return logs


@dataclass(frozen=True)
class _Found:
    nominal: VehicleFile
    hidden: VehicleFile
    answer: Diagnosis
    terms: list[FoundTerm]


@pytest.fixture(scope="module")
def found() -> _Found:
    nominal, hidden = _cars()
    stop, turn, coast = plant_log.gentle_stop, plant_log.brake_in_turn, plant_log.coast_and_drive
    known = _measured(hidden, [(stop, 4.5, 33.0), (stop, 3.5, 20.0), (turn, 4.0, 20.0), (coast, 8.0, 26.0)], 1)
    unseen = _measured(hidden, [(stop, 4.5, 29.0), (coast, 8.0, 34.0)], 2)
    replay, held_out = Replay(nominal, known), Replay(nominal, unseen)
    before = Diagnosis(verdict="nothing_found", guilty_equations={LONGITUDINAL: 100.0})
    answer, terms = with_unknown(before, replay, np.zeros(len(replay.columns)), held_out)
    return _Found(nominal, hidden, answer, terms)


def test_a_term_in_the_plant_is_found_by_its_variables_and_proven_on_unseen_drives(found: _Found) -> None:
    answer = found.answer
    assert answer.verdict == "effect_found"
    formula = answer.discovered_terms[0].formula
    assert "speed" in formula
    assert "brake" in formula
    assert "acceleration" not in formula
    assert answer.gain is not None
    assert is_proven(answer.gain)
    signal = answer.gain.held_out["longitudinal_acceleration"]
    # the goal for unknown terms: four fifths of what is possible
    assert signal.share is not None
    assert signal.share > 0.8
    assert len(found.terms) == len(answer.discovered_terms)


def test_the_extended_car_stops_like_the_measured_one(found: _Found, tmp_path: Path) -> None:
    extensions, remarks = extensions_of(found.nominal, [], found.terms)
    assert remarks == []
    file = write_extended_vehicle(tmp_path / "extended_vehicle.yaml", "asphalt_car", found.nominal, extensions)
    speeds = []
    for car in (found.nominal, found.hidden, load_vehicle(file)):
        plant = Plant(car)
        plant.reset(speed_m_s=33.0)
        plant.step(3000, brake_torque=[1100.0, 1100.0, 450.0, 450.0])
        speeds.append(plant.state()["speed"])
    given, measured, extended = speeds
    assert abs(measured - given) > 1.0
    # the mass and the pads that are off stay off
    assert abs(extended - measured) < 0.4 * abs(given - measured)


def test_a_car_off_its_nominals_has_no_unknown_term() -> None:
    nominal, hidden = _cars()
    hidden.terms.stack.clear()
    drives = [
        (plant_log.gentle_stop, 4.5, 33.0),
        (plant_log.gentle_stop, 3.5, 20.0),
        (plant_log.brake_in_turn, 4.0, 20.0),
    ]
    replay = Replay(nominal, _measured(hidden, drives, 5))
    theta = np.zeros(len(replay.columns))
    assert {problem.balance.name for problem in problems_of(replay, theta)} >= {LONGITUDINAL, "wheel torque"}
    assert discover_unknown(replay, theta, [LONGITUDINAL, "lateral force", "yaw moment"]) == []


def test_a_term_that_looks_like_a_number_which_scatters_is_told_and_not_kept() -> None:
    """Rear tyres 10 % softer: one balance alone shows a term that looks like a weak wheel brake, which nobody named."""
    nominal, hidden = _cars()
    hidden.terms.stack.clear()
    hidden.tyres.rear.lateral.stiffness *= 0.9
    drives = [
        (plant_log.sine_steer, 6.0, 25.0),
        (plant_log.sine_steer, 6.0, 18.0),
        (plant_log.brake_in_turn, 4.0, 20.0),
    ]
    replay = Replay(nominal, _measured(hidden, drives, 5))
    unseen = Replay(nominal, _measured(hidden, [(plant_log.sine_steer, 6.0, 22.0)], 6))
    theta = np.zeros(len(replay.columns))
    found = discover_unknown(replay, theta, ["lateral force"])
    assert any("wheel_brake_weak" in one.same_as for one in found)
    before = Diagnosis(verdict="nothing_found", guilty_equations={"lateral force": 100.0})
    answer, terms = with_unknown(before, replay, theta, unseen)
    assert (answer.verdict, answer.discovered_terms, terms) == ("nothing_found", [], [])
    assert any("is not kept" in remark for remark in answer.remarks)
