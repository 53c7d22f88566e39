"""Values that are tried of a deviation whose cost has more than one valley."""

import sys
from pathlib import Path

import numpy as np
import pytest

sys.path.insert(0, str(Path(__file__).parents[1] / "data"))

from hidden_car import hidden_logs
from linear_car import LinearCar, effect

from model_diagnosis.data import check_data
from model_diagnosis.evidence.fitting import Problem
from model_diagnosis.evidence.priors import Priors
from model_diagnosis.evidence.trial_values import trial_values
from model_diagnosis.evidence.whitening import sensor_whitener
from model_diagnosis.replay import Replay

REAR_RIGHT = 3


def _problem(folder: Path, seed: int, delay_s: float) -> Problem:
    names = ("abs_stop", "brake_in_turn")
    vehicle, manoeuvres = hidden_logs(folder, seed, names, ("inlet_valve_delay", delay_s, REAR_RIGHT))
    _, repaired = check_data(manoeuvres, vehicle, Replay)
    replay = Replay(vehicle, repaired)
    return Problem(replay, Priors.of(replay.parameters), sensor_whitener(replay))


@pytest.mark.parametrize(("seed", "delay_s"), [(221, 0.012), (222, 0.0195)])
def test_a_valve_that_is_late_by_more_than_a_sample_is_tried_near_its_delay(
    seed: int, delay_s: float, tmp_path: Path
) -> None:
    """The log tells commands every 10 ms, so that half of that is as near as a value can come."""
    problem = _problem(tmp_path, seed, delay_s)
    column = problem.replay.columns.index("inlet_valve_delay.rr")
    (tried,) = trial_values(problem, problem.priors.centre, column, problem.priors.widths((column,)))
    assert tried == pytest.approx(delay_s, abs=0.005)


def test_other_deviations_are_tried_in_widths_of_their_prior_within_their_bounds() -> None:
    car = LinearCar([effect("e", width=0.8)], np.zeros(1), 1)
    problem = Problem(car, Priors.of(car.parameters), sensor_whitener(car))
    assert trial_values(problem, np.zeros(1), 0, np.full(1, 0.8)) == pytest.approx([-0.6, 0.6])
