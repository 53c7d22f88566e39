"""Baselines of the friction document: slip slope (A15), cornering stiffness (A16), simple evaluation (A18, A21)."""

import math
from functools import cache

import friction_twin as twin
import numpy as np
import planar_twin
import pytest
from friction_figures import Estimate

import estimators
from estimators import simple_braking, slip_slope
from estimators.cornering_stiffness import window_slope
from signals.errors import InputError

each_path = pytest.mark.parametrize("path", ["ideal", "bus"])


def replay(name, columns, path="ideal", vehicle=twin.TABLE_8, **settings):
    ages = None
    if path == "bus":
        columns, ages = twin.held(columns)
    estimator = estimators.create(name, vehicle, settings)
    results = estimator.replay(columns, ages)
    return {signal.name.split(".")[1]: results[:, i] for i, signal in enumerate(estimator.outputs)}


@cache
def dry_stop(scale: float = 1.0, magic: bool = True) -> twin.Run:
    """An ABS stop from 100 km/h, friction limit 1 times ``scale``."""
    return twin.simulate((scale, scale), abs_on=True, start_speed=102 / 3.6, brake_speed=100 / 3.6, magic=magic)


@pytest.mark.acceptance("F-14", "F-A15")
@each_path
def test_slip_slope_settles_near_one(path, record):
    """E1: emergency stop from 100 km/h on dry asphalt with ABS, lambda 0.98."""
    truth = dry_stop()
    out = replay("slip_slope_rls", twin.measured(truth), path)
    onset = truth.brake_onset()
    settled = out["friction_limit"][onset + 1000 : onset + 2500]
    record("friction limit 1 s after onset and later, smallest", float(settled.min()), "0.9 ... 1.1", id="F-A15")
    record("friction limit 1 s after onset and later, largest", float(settled.max()), "0.9 ... 1.1", id="F-A15")
    assert settled.min() >= 0.9
    assert settled.max() <= 1.1
    # the forecast comes before the peak: 0.15 s after onset a quarter of the friction is in use
    assert abs(out["friction_used"][onset + 150]) < 0.35
    assert 0.8 <= out["friction_limit"][onset + 150] <= 1.2
    assert out["friction_limit_confidence"][onset + 150] == 1.0


@pytest.mark.acceptance("F-14")
def test_recursion_equals_weighted_least_squares():
    """Eqs 32-34 with the missing update: the minimum of the exponentially weighted squared error."""
    random = np.random.default_rng(3)
    xi = random.standard_normal(300)
    y = 4.0 * xi + 0.1 * random.standard_normal(300)
    regression = np.array([0.0, 1e4, 0.0])
    for regressor, measured in zip(xi, y, strict=True):
        slip_slope.least_squares_step(regression, regressor, measured, 0.98)
    weights = 0.98 ** np.arange(299, -1, -1)
    # the initial P acts like one more sample of weight lambda^300 / P0
    prior = 0.98**300 / 1e4
    expected = np.sum(weights * xi * y) / (np.sum(weights * xi * xi) + prior)
    assert regression[0] == pytest.approx(expected, rel=1e-9)
    assert regression[1] == pytest.approx(1 / (np.sum(weights * xi * xi) + prior), rel=1e-9)


@pytest.mark.acceptance("F-14")
def test_table_interpolates_and_may_be_given():
    slopes, limits = np.array([1.0, 3.0]), np.array([0.1, 0.5])
    for slope, limit in ((0.0, 0.1), (2.0, 0.3), (9.0, 0.5)):
        assert slip_slope.limit_of_slope(slope, slopes, limits) == pytest.approx(limit)
    with pytest.raises(InputError, match="strictly rising"):
        estimators.create("slip_slope_rls", twin.TABLE_8, {"slopes": [2.0, 1.0], "limits": [0.1, 0.2]})
    assert estimators.create("slip_slope_rls", twin.TABLE_8).settings.forgetting == 0.98


@pytest.mark.acceptance("F-15", "F-A16")
def test_slope_stays_positive_with_a_suitable_span_and_alarms_with_a_small_one(record):
    """E2: double lane change at 33 km/h, no loss of grip: with 1 deg no alarm, with 0.05 deg a false one."""
    signals, truth = planar_twin.double_lane_change()
    assert 0.5 < np.abs(truth["used_front"]).max() < 0.95  # grip is never lost
    suitable = replay("cornering_stiffness_rls", signals, vehicle=planar_twin.CAR, slip_angle_span=math.radians(1.0))
    small = replay("cornering_stiffness_rls", signals, vehicle=planar_twin.CAR, slip_angle_span=math.radians(0.05))
    for axle in ("front", "rear"):
        valid = suitable[f"slope_{axle}_confidence"] > 0
        assert valid.sum() > 1000
        record(
            f"smallest slope {axle} with 1 deg 1/rad", float(suitable[f"slope_{axle}"][valid].min()), "> 0", id="F-A16"
        )
        assert suitable[f"slope_{axle}"][valid].min() > 0.0
        assert not suitable[f"limit_reached_{axle}"].any()
    alarms = float(max(small["limit_reached_front"].mean(), small["limit_reached_rear"].mean()))
    record("share of false alarms with 0.05 deg", alarms, "> 0", id="F-A16")
    assert alarms > 0.0


@pytest.mark.acceptance("F-15")
def test_window_is_the_shortest_that_spans_the_angle():
    """Eq. 40 and the slope of eq. 39 against numpy's fit, also across the end of the ring."""
    random = np.random.default_rng(4)
    angles = np.cumsum(0.001 * random.uniform(0.5, 1.5, 60))
    frictions = 12.0 * angles + 0.01 * random.standard_normal(60)
    ring = np.arange(60) - 60 + 50  # oldest sample at position 50
    stored_a, stored_f = np.zeros(60), np.zeros(60)
    stored_a[ring], stored_f[ring] = angles, frictions
    result = np.zeros(3)
    window_slope(stored_a, stored_f, 49, 60, 0.02, result)
    length = next(n for n in range(3, 60) if np.ptp(angles[-n:]) >= 0.02)
    assert result[2] == length
    assert result[0] == pytest.approx(np.polyfit(angles[-length:], frictions[-length:], 1)[0], rel=1e-9)
    window_slope(stored_a, stored_f, 49, 60, 1.0, result)
    assert result[2] == 0.0


@pytest.mark.acceptance("F-28")
def test_simple_evaluation_of_forces():
    """Eqs 120-125 by hand: a braking car of Table 8 on a grade of 5 % with head wind."""
    values = np.zeros(14)
    numbers = {
        simple_braking.MASS: 1296.0,
        simple_braking.WHEELBASE: 2.57,
        simple_braking.FRONT_LENGTH: 1.25,
        simple_braking.HEIGHT: 0.535,
        simple_braking.DRAG_HEIGHT: 0.6,
        simple_braking.DRAG_FACTOR: 0.48,
        simple_braking.ROLLING: 0.015,
        simple_braking.HEAD_WIND: 5.0,
        simple_braking.GRADE: 0.05,
    }
    for index, number in numbers.items():
        values[index] = number
    drag = 0.48 * 25.0 * 25.0
    weight = 1296.0 * 9.81
    assert simple_braking.drag_force(20.0, values) == pytest.approx(drag)
    assert simple_braking.drag_force(-15.0, values) == pytest.approx(-0.48 * 100.0)
    front, rear = simple_braking.axle_loads(-8.0, 20.0, values)
    moment = -drag * 0.6 + 1296.0 * 8.0 * 0.535 - weight * 0.535 * math.sin(0.05)
    assert front == pytest.approx((moment + weight * 1.32 * math.cos(0.05)) / 2.57)
    assert front + rear == pytest.approx(weight * math.cos(0.05))
    force = 1296.0 * -8.0 + drag + 0.015 * weight * math.cos(0.05) + weight * math.sin(0.05)
    assert simple_braking.friction_in_use(-8.0, 20.0, values) == pytest.approx(force / (weight * math.cos(0.05)))


@pytest.mark.acceptance("F-28")
@each_path
def test_simple_evaluation_of_a_stop(path):
    truth = dry_stop(magic=False)
    out = replay("simple_braking", twin.measured(truth), path)
    share = truth.load_front / (truth.load_front + truth.load_rear)
    used = share * truth.used_front + (1 - share) * truth.used_rear
    phase = truth.braking_phase()
    assert out["friction_used"][phase].mean() == pytest.approx(used[phase].mean(), rel=0.01)
    braking = slice(truth.brake_onset() + 60, int(phase[-1]))
    assert out["friction_mean"][phase[-1]] == pytest.approx(np.abs(used[braking]).mean(), rel=0.02)
    assert out["friction_mean_confidence"][phase[-1]] == 1.0


@pytest.mark.acceptance("F-A21", "F-28")
@each_path
def test_the_filter_is_less_disturbed_by_noise_than_the_simple_evaluation(path, record):
    """E14 against E13: standard deviation of the friction over the braking phase, 0.3 m/s^2 noise, torque zero."""
    truth = dry_stop(magic=False)
    estimate = Estimate(truth, path=path, noise=(0.3, 0.05), torque_mode="z2")
    simple = replay("simple_braking", twin.measured(truth, acceleration_noise=0.3), path)
    filtered = float(estimate["friction_used_mean"][estimate.phase].std())
    plain = float(simple["friction_used"][estimate.phase].std())
    record("std of friction, filter over simple", filtered / plain, "< 1", id="F-A21")
    assert filtered < plain


# each day: the same limits over bus and procedure in tests/bench/estimation/test_surfaces.py
@pytest.mark.nightly
@pytest.mark.acceptance("F-A18")
def test_a_road_with_4_percent_shorter_stops_is_told(record):
    """Five stops on each of two roads, 0.3 m/s^2 noise, torque zero: 2 ... 6 % in at least 19 of 20 seeds."""
    base, better = dry_stop(1.0, magic=False), dry_stop(1.0505, magic=False)
    distance = [run.speed[run.brake_onset() :].sum() for run in (base, better)]
    assert distance[1] / distance[0] == pytest.approx(0.96, abs=0.002)

    def friction(run: twin.Run, first_seed: int) -> float:
        estimates = (Estimate(run, seed=first_seed + k, noise=(0.3, 0.05), torque_mode="z2") for k in range(5))
        return float(np.mean([estimate.mean("friction_limit_mean") for estimate in estimates]))

    told, same = [], []
    for seed in range(20):
        reference = friction(base, 100 * seed)
        told.append(friction(better, 100 * seed + 20) / reference - 1)
        same.append(friction(base, 100 * seed + 40) / reference - 1)
    right = sum(0.02 <= gain <= 0.06 for gain in told)
    none = sum(abs(gain) < 0.02 for gain in same)
    record("seeds with 2 ... 6 %", right, ">= 19 of 20")
    record("seeds without a difference on the same road", none, ">= 19 of 20")
    record("mean difference %", 100 * float(np.mean(told)), "2 ... 6")
    assert right >= 19
    assert none >= 19
