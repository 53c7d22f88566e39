"""What every estimator does with inputs that are wrong, missing, late or repeated: hold, reset, flag, never a NaN.

The rule is that of :mod:`estimators.inputs`; it is tried on each entry of the registry.
"""

from functools import cache

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import estimators
from estimators.channels import CHANNELS
from signals.errors import InputError
from vehicle_model.vehicle_file import load_vehicle, vehicle_names

TICKS = 700
each = pytest.mark.parametrize("name", estimators.names())


@cache
def car_for(name: str) -> dict[str, float]:
    """Numbers of a shipped car that has all that the estimator needs."""
    for car in ("ekf_car", *vehicle_names()):
        numbers = load_vehicle(car).numbers()
        try:
            estimators.create(name, numbers)
        except InputError:
            continue
        return numbers
    raise AssertionError(f"no shipped car for {name}")


def build(name: str):
    return estimators.create(name, car_for(name))


def inputs_of(name: str) -> tuple[dict[str, np.ndarray], dict[str, np.ndarray]]:
    """A car that brakes gently from 25 m/s in a slight bend; every signal new in every tick."""
    estimator = build(name)
    numbers = car_for(name)
    time = 1e-3 * np.arange(TICKS)
    speed = 25.0 - 3.0 * time
    columns = {}
    for signal in estimator.inputs:
        if signal.startswith("wheel_speed_"):
            radius = numbers[f"wheels.{signal[-2:]}.radius"]
            columns[signal] = 0.97 * speed / radius
        elif signal.startswith("brake_pressure_") or signal == "master_pressure":
            columns[signal] = np.full(TICKS, 2e6)
        else:
            given_values = {
                "longitudinal_acceleration": np.full(TICKS, -3.0),
                "lateral_acceleration": 0.5 * np.sin(3.0 * time),
                "yaw_rate": 0.02 * np.sin(3.0 * time),
                "steering_wheel_angle": 0.2 * np.sin(3.0 * time),
                "ecu_reference_speed": speed,
                "engine_speed": np.full(TICKS, 200.0),
                "gear": np.full(TICKS, 3.0),
            }
            columns[signal] = given_values.get(signal, np.zeros(TICKS))
    ages = {age: np.zeros(TICKS) for age in sorted({CHANNELS[signal].age for signal in estimator.inputs})}
    return columns, ages


def positions(estimator) -> dict[str, int]:
    return {signal.name.partition(".")[2]: place for place, signal in enumerate(estimator.outputs)}


@each
@settings(max_examples=12, deadline=None)
@given(data=st.data())
def test_no_input_makes_an_output_that_is_not_finite(name, data):
    """Values and ages of any size, NaN, infinities, in stretches of any length."""
    columns, ages = inputs_of(name)
    wild = st.one_of(st.floats(), st.sampled_from([np.nan, np.inf, -np.inf, 1e308, -1e308, 0.0]))
    for _ in range(data.draw(st.integers(1, 6))):
        table = data.draw(st.sampled_from([columns, ages]))
        key = data.draw(st.sampled_from(sorted(table)))
        start = data.draw(st.integers(0, TICKS - 1))
        table[key][start : start + data.draw(st.integers(1, 300))] = data.draw(wild)
    assert np.isfinite(build(name).replay(columns, ages)).all()


@each
def test_a_wheel_that_hardly_turns_has_no_endless_delay(name):
    """A tone ring at 6e-12 rad/s is years late: brought forward by that, a speed would leave all bounds."""
    columns, ages = inputs_of(name)
    if "wheel_speed_rl" in columns:
        columns["wheel_speed_rl"][101:116] = 5.921129699080188e-12
    assert np.isfinite(build(name).replay(columns, ages)).all()


@each
def test_a_wrong_sample_is_held_and_flagged(name):
    """Ten ticks of NaN in one input: the value before is held, the flag is 1, nothing is reset."""
    columns, ages = inputs_of(name)
    estimator = build(name)
    at = positions(estimator)
    if "input_state" not in at:
        pytest.skip(f"{name} reports no input_state")
    columns[estimator.inputs[0]][300:310] = np.nan
    results = estimator.replay(columns, ages)
    assert (results[300:310, at["input_state"]] == 1.0).all()
    assert results[311, at["input_state"]] == 0.0
    assert (results[290:320, at["active"]] == results[290, at["active"]]).all()


@each
def test_a_lost_input_stops_it_and_its_return_starts_it(name):
    """A gap of 300 ms in one kind of frame: lost after the timeout, inputs back with the next frame.

    The friction filters then watch the wheels of a braked car for 30 ms before they believe them.
    """
    columns, ages = inputs_of(name)
    estimator = build(name)
    at = positions(estimator)
    if "input_state" not in at:
        pytest.skip(f"{name} reports no input_state")
    age = CHANNELS[estimator.inputs[-1]].age
    ages[age][200:500] = 1e-3 * np.arange(1, 301)
    results = estimator.replay(columns, ages)
    assert results[499, at["input_state"]] == 2.0
    assert results[499, at["active"]] == 0.0
    assert results[520, at["input_state"]] == 0.0
    assert results[560, at["active"]] == results[150, at["active"]]


@each
def test_the_same_samples_again_give_the_same_bits(name):
    """Reset is the state of a new estimator, whatever it has seen."""
    columns, ages = inputs_of(name)
    first = build(name)
    expected = first.replay(columns, ages)
    broken = {key: values.copy() for key, values in columns.items()}
    for values in broken.values():
        values[100:200] = np.nan
    first.replay(broken, ages)
    first.reset()
    assert np.array_equal(first.replay(columns, ages), expected)
