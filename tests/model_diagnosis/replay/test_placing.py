"""A step of friction at a place nobody knows: sensitivities at another place say nothing of it."""

from dataclasses import replace

import numpy as np
import pytest
from library_stop import SPEEDS, planned_inputs

from model_diagnosis.evidence.fitting import Problem
from model_diagnosis.evidence.hypotheses import hypotheses_of
from model_diagnosis.evidence.placing import best_places, placed_pair
from model_diagnosis.evidence.priors import Priors
from model_diagnosis.evidence.search import Search
from model_diagnosis.evidence.whitening import sensor_whitener
from model_diagnosis.manoeuvre import Manoeuvre
from model_diagnosis.replay import Replay
from vehicle_model import load_vehicle
from vehicle_model.vehicle_file import VehicleFile

STEPPED, STEP_AT_M, LEVEL = 1, 55.0, -0.2
NOISE = {"speed": 0.02, **dict.fromkeys(SPEEDS, 0.05)}


def _stop(car: VehicleFile, name: str, level: float, place_m: float) -> Manoeuvre:
    """A hard stop from 25 m/s of a car that meets another friction behind a place, as the replay drives it."""
    time, inputs = planned_inputs()
    pressures = {key: 1.7 * values for key, values in inputs.items() if key.startswith("brake_pressure")}
    channels = inputs | pressures | {"speed": np.full_like(time, 25.0)}
    channels |= {one: channels["speed"] / getattr(car.wheels, one[-2:]).radius for one in SPEEDS}
    blank = Manoeuvre(name, time, channels, {one: np.ones_like(time) for one in channels}, "made for a test")
    replay = Replay(car, [blank])
    theta = np.zeros(len(replay.columns))
    theta[replay.columns.index("mu_step.level")] = level
    theta[replay.columns.index("mu_step.place")] = place_m - 30.0  # counted from the catalogue's 30 m
    run = replay.free_run(theta, 0)
    random = np.random.default_rng(3)
    for number, signal in enumerate(replay.signals(0)):
        if signal in NOISE:
            channels[signal] = run[:, number] + random.normal(0.0, NOISE[signal], len(run))
    return replace(blank, channels=channels)


def test_the_place_of_a_step_in_one_manoeuvre_is_found_and_the_other_manoeuvre_is_left_alone() -> None:
    car = load_vehicle("ekf_car")
    replay = Replay(car, [_stop(car, "even", 0.0, 0.0), _stop(car, "stepped", LEVEL, STEP_AT_M)], conditions=True)
    problem = Problem(replay, Priors.of(replay.parameters), sensor_whitener(replay))
    hypotheses = [one for one in hypotheses_of(replay) if replay.effects[one.effect].name == "mu_step"]
    chord = problem.linearise(np.zeros(len(replay.columns)))
    for _ in range(3):  # "nothing" has to be at its minimum: tyres may stand for a friction
        nothing = problem.fit(chord, problem.priors.nuisance, chord.theta)
        chord = problem.linearise(nothing.theta)
    search = Search(problem, hypotheses)
    stage = search.stage([], nothing, chord)
    pairs = {number: pair for number, one in enumerate(hypotheses) if (pair := placed_pair(replay, one)) is not None}
    assert [pair.manoeuvre for pair in pairs.values()] == [None, 0, 1]

    best = best_places(problem, stage, pairs)
    own = next(number for number, pair in pairs.items() if pair.manoeuvre == STEPPED)
    assert max(best, key=lambda number: best[number].evidence) == own
    assert best[own].value + 30.0 == pytest.approx(STEP_AT_M, abs=10.0)  # the places lie 10 m apart

    found = search.refit(stage, search.starts.candidates(stage)).best
    assert found is not None
    assert found.hypothesis == hypotheses[own]
    assert found.fit.theta[pairs[own].place] + 30.0 == pytest.approx(STEP_AT_M, abs=2.0)
    assert found.fit.theta[pairs[own].level] == pytest.approx(LEVEL, abs=0.03)
