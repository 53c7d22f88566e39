"""Several cars side by side: operations of lanes against numpy's, and each car against its own run alone."""

import math

import numpy as np
import pytest
from numba import njit

from model_diagnosis.replay import Replay, lane_math  # noqa: F401  teaches the compiler what is tested here
from model_diagnosis.replay.lane_memory import LANE_AXES, at, put
from model_diagnosis.replay.lanes import cell_of, some, where
from model_diagnosis.replay.side_by_side_cars import run_eight, run_one


@njit(error_model="numpy")
def _functions(values: np.ndarray, out: np.ndarray) -> None:
    x, y = at(values, 0, 0), at(values, 0, 1)
    put(out, 0, 0, math.log(x))
    put(out, 0, 1, math.exp(y))
    put(out, 0, 2, math.sin(y))
    put(out, 0, 3, math.cos(y))
    put(out, 0, 4, x**y)
    put(out, 0, 5, math.tan(y))
    put(out, 0, 6, math.atan(y))
    put(out, 0, 7, math.atan2(y, x))
    put(out, 0, 8, math.tanh(y))


@pytest.mark.parametrize("count", LANE_AXES)
def test_functions_are_numpys_to_the_last_digits(count: int) -> None:
    """All within 4 units of the last digit: of itself, or of 1 for the hyperbolic tangent."""
    generator, axes = np.random.default_rng(1), LANE_AXES[count]
    worst = np.zeros(9)
    for scale in (0.01, 0.5, 3.0, 20.0) * 50:
        values = np.stack([generator.uniform(1e-3, 30.0, count), generator.normal(0.0, scale, count)])
        out = np.zeros((1, 9, *axes))
        _functions(values.reshape(1, 2, *axes), out)
        x, y = values
        expected = [np.log(x), np.exp(y), np.sin(y), np.cos(y), x**y, np.tan(y), np.arctan(y), np.arctan2(y, x)]
        found = out.reshape(9, count)
        for k, one in enumerate(expected):
            worst[k] = max(worst[k], np.max(np.abs(found[k] - one) / np.spacing(np.abs(one))))
        # the digits that y ln x has before its point are lost behind it
        lost = 2.0 * np.finfo(float).eps * np.maximum(np.abs(y * np.log(x)), 1.0)
        worst[4] = np.max(np.abs(found[4] / expected[4] - 1.0) / lost)
        worst[8] = max(worst[8], np.max(np.abs(found[8] - np.tanh(y))) / np.finfo(float).eps)
    assert np.all(worst <= 4.0), worst


@njit(error_model="numpy")
def _choices(values: np.ndarray, out: np.ndarray) -> int:
    x, y = at(values, 0, 0), at(values, 0, 1)
    put(out, 0, 0, min(x, y))
    put(out, 0, 1, max(x, y))
    put(out, 0, 2, where((x > y) & (y > 0.0), x - y, 7.0))
    put(out, 0, 3, where((x <= y) | (y == 0.0), abs(x), -y))
    put(out, 0, 4, math.copysign(x, y) / math.sqrt(abs(y)))
    put(out, 0, 5, where(x != x, 1.0, 0.0))
    return int(some(x > y)) + 2 * int(some(y == 0.0))


@pytest.mark.parametrize("count", LANE_AXES)
def test_choices_and_quotients_are_those_of_each_car_alone(count: int) -> None:
    """Bit for bit, with numbers that are none, infinite ones and zeros of both signs among them."""
    special = np.array([0.0, -0.0, 1.5, -1.5, np.nan, np.inf, -np.inf, 3.0])
    generator, axes = np.random.default_rng(2), LANE_AXES[count]
    for _ in range(200):
        values = generator.choice(special, (2, count))
        out, alone = np.zeros((1, 6, *axes)), np.zeros((1, 6))
        told = _choices(values.reshape(1, 2, *axes), out)
        tells = 0
        for lane in range(count):
            tells |= _choices(np.ascontiguousarray(values[:, lane])[None], alone)
            np.testing.assert_array_equal(out.reshape(6, count)[:, lane], alone[0])
        assert told == tells


@njit(error_model="numpy")
def _cells(values: np.ndarray, out: np.ndarray) -> None:
    put(out, 0, 0, cell_of(at(values, 0, 0), 5) + 0.0)


@pytest.mark.parametrize("count", LANE_AXES)
def test_no_place_leads_out_of_a_table(count: int) -> None:
    for shift in range(8):
        rolled = np.roll([-3.0, -0.5, 0.2, 4.9, 5.0, 1e300, np.inf, np.nan], shift)[:count]
        out = np.zeros((1, 1, *LANE_AXES[count]))
        _cells(rolled.reshape(1, 1, *LANE_AXES[count]), out)
        expected = np.clip(np.floor(np.where(np.isnan(rolled), 0.0, rolled)), 0.0, 5.0)
        np.testing.assert_array_equal(out.reshape(count), expected)


def _drawn(replay: Replay, seed: int) -> np.ndarray:
    """Deviations of all columns, a third of an effect's width each."""
    generator = np.random.default_rng(seed)
    return np.array(
        [np.clip(0.3 * generator.normal() * one.effect_std, one.low, one.high) for one in replay.parameters]
    )


def _size(replay: Replay, m: int) -> np.ndarray:
    """Size of each signal, at least its sensor's noise: what a drive does not excite is nothing but rounding."""
    noise = [replay.sensor_std(signal) for signal in replay.signals(m)]
    return np.maximum(np.abs(replay.measured(m)).max(axis=0), noise)


def test_every_car_of_eight_runs_as_it_does_alone(replay: Replay) -> None:
    """To 1e-9 of each signal's size: sums of products round once where they can, and a stop takes 5000 steps."""
    prepared = replay.prepared[1]
    asked = [replay.deviations_at(_drawn(replay, seed), 1) for seed in range(8)]
    runs = [replay.run_of(deviations, prepared, replay.pressures.at(deviations, prepared)) for deviations in asked]
    together = run_eight(runs, replay.gains)
    for lane, run in enumerate(runs):
        found = together[:, :, lane]
        alone = run_one(run, replay.gains, 0, prepared.chosen)
        assert np.all(np.abs(found - alone).max(axis=0) <= 1e-9 * np.abs(alone).max(axis=0))
    assert np.ptp(together[-1, 0]) > 0.1


@pytest.mark.parametrize("count", [1, 2, 5])
def test_manoeuvres_of_unequal_length_run_side_by_side_as_alone(replay: Replay, count: int) -> None:
    few = Replay(replay.vehicle, replay.manoeuvres[:count])
    theta = _drawn(few, 3)
    for m, found in enumerate(few.residuals(theta)):
        alone = Replay(replay.vehicle, [replay.manoeuvres[m]]).residuals(theta)[0]
        assert found.shape == alone.shape
        assert np.all(np.abs(found - alone).max(axis=0) <= 1e-9 * _size(few, m))


def test_sweeps_are_differences_of_single_runs(replay: Replay) -> None:
    """Columns of car, tyre tables, sensors, pressures: each as a finite difference by runs of one car alone.

    The difference of two replays loses 1e-9 of a signal to a thousandth of an effect's width.
    """
    theta = _drawn(replay, 4)
    of_car = "mass_change.factor", "tyre_peak_shape.sliding_loss", "spring_rate.front"
    wanted = (*of_car, "gyro_scale.yaw_rate", "tone_ring_error.fl", "pressure_sensor_scale.wheels")
    columns = [replay.columns.index(name) for name in wanted]
    for m, matrix in enumerate(replay.sensitivities(theta, columns)):
        alone = Replay(replay.vehicle, [replay.manoeuvres[m]])
        for k, column in enumerate(columns):
            step = replay.step_of(theta, column)
            moved = theta.copy()
            moved[column] += step
            difference = (alone.predict(moved, 0) - alone.predict(theta, 0)) / step
            off = np.abs(matrix[:, :, k] - difference).max(axis=0)
            assert np.all(off <= 1e-9 * _size(replay, m) / abs(step)), wanted[k]
