"""Behind a gap of the inputs the observer begins anew, and what it begins with is no evidence."""

from dataclasses import replace

import numpy as np
import pytest
from library_stop import driven, planned_inputs

from model_diagnosis.evidence.whitening import rows_of
from model_diagnosis.manoeuvre import Manoeuvre
from model_diagnosis.replay import Replay
from model_diagnosis.replay.gaps import BEGINNING, ends_of_gaps, least_gains, pieces_of
from signals.wheels import WHEELS
from vehicle_model import load_vehicle
from vehicle_model.vehicle_file import VehicleFile

BEGIN, END = 150, 180
"""Samples of the gap."""

PRESSURES = tuple(f"brake_pressure_{wheel}" for wheel in WHEELS)

OPEN = 15
"""Samples of the gap in which the brake is let go, before it is taken again."""


@pytest.fixture(scope="module")
def car() -> VehicleFile:
    return load_vehicle("ekf_car")


@pytest.fixture(scope="module")
def torn(car: VehicleFile) -> Manoeuvre:
    """A stop as the replay drives it, 0.3 s of it missing; the logged pressures are laid straight across them."""
    time, inputs = planned_inputs()
    true = inputs | {name: inputs[name].copy() for name in PRESSURES}
    for name in PRESSURES:
        true[name][BEGIN : BEGIN + OPEN] = 0.0
    stop = driven(car, time, true)
    logged, gap = dict(stop.channels), slice(BEGIN, END)
    for name in logged:
        logged[name] = logged[name].copy()
        logged[name][gap] = np.interp(time[gap], time[[BEGIN - 1, END]], logged[name][[BEGIN - 1, END]])
    weights = {name: np.ones_like(time) for name in logged}
    for name in logged:
        weights[name][gap] = 0.0
    return replace(stop, channels=logged, weights=weights)


def test_samples_behind_a_gap_have_no_history() -> None:
    samples = np.concatenate((np.arange(10), np.arange(30, 40)))
    np.testing.assert_array_equal(pieces_of(samples), np.repeat([0, 1], 10))
    np.testing.assert_array_equal(rows_of(samples), [*range(4, 10), *range(14, 20)])


def test_the_usual_distance_of_a_slow_channel_and_a_lost_frame_are_no_gaps() -> None:
    slow = np.arange(0, 400, 10)
    assert pieces_of(slow).max() == 0
    assert pieces_of(np.delete(slow, 7)).max() == 0


def test_gains_fall_as_those_of_a_mean_of_all_samples_since_the_gap() -> None:
    valid = np.ones((6, 2))
    valid[3, 1] = 0.0
    expected = [[0, 0], [0, 0], [1, 1], [1 / 2, 0], [1 / 3, 1 / 2], [1 / 4, 1 / 3]]
    np.testing.assert_allclose(least_gains(valid, np.array([2])), expected)
    assert not least_gains(valid, np.zeros(0, dtype=np.int64)).any()


def test_a_car_that_drove_on_unseen_is_met_again_where_it_is(car: VehicleFile, torn: Manoeuvre) -> None:
    """The brake was open in the gap, the replay brakes on: it comes out slower, by a multiple of the sensor's noise.

    When samples count again it is where the car is; by the usual gains it would not be.
    """
    np.testing.assert_array_equal(ends_of_gaps(torn), [END])
    replay, usual = Replay(car, [torn]), Replay(car, [torn])
    usual.prepared = [replace(usual.prepared[0], least=np.zeros_like(usual.prepared[0].least))]
    place, std = replay.signals(0).index("wheel_speed_fl"), replay.sensor_std("wheel_speed_fl")
    met, missed = ((one.measured(0) - one.predict(np.zeros(len(one.columns)), 0))[:, place] for one in (replay, usual))
    assert abs(met[END]) > 5.0 * std
    again = END + BEGINNING
    counted = np.flatnonzero(replay.weights()[0][:, place])
    assert counted[0] == BEGINNING
    assert counted[BEGIN - BEGINNING] == again
    assert np.abs(met[again : again + 40]).max() < 2.0 * std < np.abs(missed[again : again + 40]).max()
