"""From a hidden term in the MuJoCo car to its formula, its gain and an extended car that drives like the hidden one."""

import importlib.util
import sys
from collections.abc import Callable
from dataclasses import dataclass, replace
from pathlib import Path
from types import ModuleType

import numpy as np
import pytest

from model_diagnosis.discovery.unknown import FoundUnknown, weigh_unknown
from model_diagnosis.evidence.base import fit_base
from model_diagnosis.evidence.priors import Priors
from model_diagnosis.extension.extended_vehicle import extensions_of, write_extended_vehicle
from model_diagnosis.held_out import gain_of
from model_diagnosis.manoeuvre import Manoeuvre
from model_diagnosis.replay import Replay
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


def _weighed(replay: Replay) -> FoundUnknown | None:
    base = fit_base(replay, Priors.of(replay.parameters))
    return weigh_unknown(base.problem, replay, base.nothing, base.at_nothing, needed=10.0)


@dataclass(frozen=True)
class _Found:
    nominal: VehicleFile
    hidden: VehicleFile
    unknown: FoundUnknown
    unseen: Replay


@pytest.fixture(scope="module")
def found() -> _Found:
    nominal, hidden = _cars()
    stop, turn, coast = plant_log.gentle_stop, plant_log.brake_in_turn, plant_log.coast_and_drive
    known = _measured(hidden, [(stop, 4.5, 33.0), (stop, 3.5, 20.0), (turn, 4.0, 20.0), (coast, 8.0, 26.0)], 1)
    unseen = _measured(hidden, [(stop, 4.5, 29.0), (coast, 8.0, 34.0)], 2)
    unknown = _weighed(Replay(nominal, known))
    assert unknown is not None
    return _Found(nominal, hidden, unknown, Replay(nominal, unseen))


def test_a_term_in_the_plant_is_found_with_its_law_and_size(found: _Found) -> None:
    """The hidden law is T_b (1 - 3e-4 s²/m² v²)."""
    term = found.unknown.term
    assert found.unknown.weighed.target == HIDDEN["target"]
    assert term.candidate.variables == ("speed",)
    shape = term.candidate.shapes[0]
    assert (shape.function, shape.exponent) == ("power", 2.0)
    assert term.amplitude == pytest.approx(HIDDEN["coefficient"], rel=0.1)
    assert term.low[0] < HIDDEN["coefficient"] < term.high[0]
    assert term.inclusion >= 0.8


def test_it_predicts_drives_that_it_was_not_fitted_to(found: _Found) -> None:
    """The goal for unknown terms: four fifths of what is possible."""
    unknown = found.unknown
    gain = gain_of(unknown.problem, unknown.selection, unknown.on(found.unseen), 0, unknown.theta_on)
    signal = gain.held_out["longitudinal_acceleration"]
    assert signal.share is not None
    assert signal.share > 0.8


def test_the_extended_car_stops_like_the_measured_one(found: _Found, tmp_path: Path) -> None:
    extensions, remarks = extensions_of(found.nominal, [], [found.unknown.for_the_car])
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


@pytest.mark.nightly
def test_a_car_off_its_nominals_has_no_unknown_term() -> None:
    """Rear tyres 10 % softer besides: a number that scatters is no term."""
    nominal, hidden = _cars()
    hidden.terms.stack.clear()
    hidden.tyres.rear.lateral.stiffness *= 0.9
    drives = [
        (plant_log.gentle_stop, 4.5, 33.0),
        (plant_log.sine_steer, 6.0, 25.0),
        (plant_log.brake_in_turn, 4.0, 20.0),
    ]
    assert _weighed(Replay(nominal, _measured(hidden, drives, 5))) is None
