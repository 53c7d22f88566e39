"""Pressures that drive a replay, against what the challenge's generator knows of the car's true ones."""

import sys
from collections.abc import Mapping
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from numpy.typing import NDArray

sys.path.insert(0, str(Path(__file__).parents[1] / "data"))

from hidden_car import hidden_logs
from hidden_effects import sensors
from hidden_effects.car import as_record
from hidden_effects.case import Case
from hidden_effects.families import Draw, Hidden, named
from hidden_effects.manoeuvres import SIX
from hidden_effects.outputs import INDEX
from hidden_effects.simulator import simulate

from model_diagnosis.effects.hydraulics import HYDRAULICS_EFFECTS
from model_diagnosis.effects.sensor_chain import true_inputs
from model_diagnosis.manoeuvre import Manoeuvre
from model_diagnosis.replay import Replay, wheel_pressures
from model_diagnosis.replay.driving_pressures import driving_pressures, numbers_by_pressures
from model_diagnosis.replay.prepared import PRESSURES
from signals.wheels import WHEELS
from vehicle_model.vehicle_file import VehicleFile

NAMES = ("gentle_stops", "abs_stop", "brake_in_turn")
MOVING_PA_S = 2e6
FloatArray = NDArray[np.float64]


def stacked(log: Manoeuvre) -> FloatArray:
    return np.stack([log.channels[name] for name in PRESSURES], axis=1)


@pytest.fixture(scope="module", params=[882, 1027])
def stops(request: pytest.FixtureRequest, tmp_path_factory: pytest.TempPathFactory) -> tuple[VehicleFile, list, list]:
    """Vehicle file, logs of a healthy car, and the same logs by sensors without noise."""
    vehicle, logs = hidden_logs(tmp_path_factory.mktemp("noisy"), request.param, NAMES)
    with pytest.MonkeyPatch.context() as patch:
        for name, channel in sensors.CHANNELS.items():
            if "pressure" in name:
                patch.setitem(sensors.CHANNELS, name, replace(channel, noise=1.0, resolution=1.0))
        _, quiet = hidden_logs(tmp_path_factory.mktemp("quiet"), request.param, NAMES)
    return vehicle, logs, quiet


def test_flanks_and_abs_cycles_lose_most_of_the_noise(stops: tuple[VehicleFile, list, list]) -> None:
    """0.25 to 0.5 of it is left where pressures move; the smoothing of each channel alone leaves 0.6 to 1.3."""
    vehicle, logs, quiet = stops
    for log, true, prepared in zip(logs, map(stacked, quiet), Replay(vehicle, logs).prepared, strict=True):
        moving = np.max(np.abs(np.gradient(true, log.time, axis=0)), axis=1) > MOVING_PA_S
        raw, left = stacked(log) - true, prepared.inputs.values[:, :4] - true
        assert np.std(left[moving]) < 0.55 * np.std(raw[moving]), log.name
        assert np.std(left[~moving]) < 0.35 * np.std(raw[~moving]), log.name
        # what all wheels err by together brakes the car: a quarter to a third of a channel's noise is left
        assert np.std(left[moving].mean(axis=1)) < 0.5 * np.std(raw[moving]), log.name


def test_what_drives_a_car_is_what_its_sensors_report(stops: tuple[VehicleFile, list, list]) -> None:
    """A sensor that reports too much is told by the car, not taken back by the unit's opinion."""
    vehicle, logs, quiet = stops
    more = [
        replace(one, channels={**one.channels, **{name: 1.2 * one.channels[name] for name in PRESSURES}})
        for one in logs
    ]
    for prepared, true in zip(Replay(vehicle, more).prepared, map(stacked, quiet), strict=True):
        held = true.min(axis=1) > 2e6
        ratio = prepared.inputs.values[held, :4].mean(axis=0) / true[held].mean(axis=0)
        np.testing.assert_allclose(ratio, 1.2, rtol=5e-3)


@pytest.mark.parametrize("changed", ["valves", "pressures", "gap", "vehicle"])
def test_what_one_replay_learned_of_the_unit_serves_the_next_only_if_nothing_of_it_changed(
    stops: tuple[VehicleFile, list, list], changed: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    vehicle, (_, stop, _), _ = stops

    def driving(car: VehicleFile, log: Manoeuvre, *, forgets: bool = False) -> FloatArray:
        if forgets:
            monkeypatch.setattr(wheel_pressures, "_KEPT", {})
        return Replay(car, [log], []).prepared[0].inputs.values[:, :4]

    other, anew = vehicle, stop
    names = {"valves": "valve_inlet_fl", "pressures": "brake_pressure_fl", "gap": "brake_pressure_fl"}
    if changed == "vehicle":
        other = vehicle.model_copy(deep=True)
        other.hydraulics.increase_time_constant *= 1.2
    elif changed == "gap":
        weight = np.where((stop.time > 2.0) & (stop.time < 2.3), 0.0, 1.0)
        anew = replace(stop, weights={**stop.weights, names[changed]: weight})
    else:
        channel = np.roll(stop.channels[names[changed]], 3)
        anew = replace(stop, channels={**stop.channels, names[changed]: channel})
    first = driving(vehicle, stop, forgets=True)
    late = replace(stop, channels={**stop.channels, "speed": np.roll(stop.channels["speed"], 1)})
    np.testing.assert_array_equal(driving(vehicle, late), first)
    found = driving(other, anew)
    np.testing.assert_array_equal(found, driving(other, anew, forgets=True))
    assert not np.array_equal(found, first)


def test_numbers_of_the_unit_are_found_by_its_pressures() -> None:
    """Errors that are linear in two numbers: ridge regression, here by its normal equations."""
    rng = np.random.default_rng(5)
    effect = next(one for one in HYDRAULICS_EFFECTS if one.name == "inlet_valve_conductance")
    parameters, columns = effect.parameters[:2], effect.columns[:2]
    design = 1e6 * rng.standard_normal((200, 2))
    true = np.array([0.02, -0.03])
    noise = 3e3
    measured = design @ true + noise * rng.standard_normal(200)

    def errors(deviations: dict[str, float]) -> FloatArray:
        return measured - design @ np.array([deviations[name] for name in columns])

    found = numbers_by_pressures(errors, columns, parameters, noise)
    scatter = np.array([one.ordinary_std for one in parameters])
    normal = design.T @ design / noise**2 + np.diag(scatter**-2)
    expected = np.linalg.solve(normal, design.T @ measured / noise**2)
    assert list(found) == list(columns)
    np.testing.assert_allclose(list(found.values()), expected, rtol=1e-3)


def test_gaps_are_bridged_by_the_unit() -> None:
    """Where nothing was measured the unit tells the course, off by what it was off on both sides."""
    rng = np.random.default_rng(6)
    true = 4e6 + 1e6 * np.sin(np.arange(400) / 15.0)[:, None] * np.ones(4)
    valid = np.ones((400, 4))
    valid[150:200] = 0.0
    measured = np.where(valid > 0.0, true + 3e4 * rng.standard_normal((400, 4)), 4e6)
    found = driving_pressures(measured, true - 2e5, valid)
    assert np.max(np.abs(found[150:200] - true[150:200])) < 3e4


@pytest.mark.parametrize("lag_s", [0.0106, 0.0152, 0.02])
def test_a_unit_with_the_lag_in_it_knows_flanks_better_than_samples(lag_s: float, tmp_path: Path) -> None:
    """Readings are 6 to 11 bar off the brakes' pressures; by the slope of the samples 0.6 to 0.7 bar are left.

    Where the unit's numbers are sought from no lag on, 0.9 bar of the larger lags are.
    """
    seed = 218
    vehicle, logs = hidden_logs(tmp_path, seed, ("abs_stop", "gentle_stops"), ("pressure_sensor_lag", lag_s, 0))
    prepared, deviations = Replay(vehicle, logs).prepared[0], {"pressure_sensor_lag.time_constant": lag_s}
    case = Case(seed, 0, "clean", "first")
    case.draw = Draw("single", (Hidden(named("pressure_sensor_lag"), lag_s, 0),), None)
    script = next(one for one in SIX if one.name == "abs_stop")
    car, chain = case.car_in(script)
    brakes = simulate(as_record(car), script.drive())[:, [INDEX[f"pressure_{wheel}"] for wheel in WHEELS]]
    time = logs[0].time
    true = np.stack([np.interp(time, 1e-3 * np.arange(len(brakes)), column) for column in brakes.T], axis=1)
    true = true * float(chain["pressure_scale"]) + float(chain["pressure_offset"])

    def off(pressures: Mapping[str, FloatArray]) -> float:
        return float(np.sqrt(np.mean((np.stack([pressures[name] for name in PRESSURES], axis=1) - true) ** 2)))

    assert float(chain["pressure_lag"]) == lag_s
    assert off(logs[0].channels) > 6e5
    by_samples = off(true_inputs(deviations, time, prepared.driving))
    assert off(true_inputs(deviations, time, prepared.driving, prepared.leads)) < min(0.9 * by_samples, 0.6e5)


@pytest.mark.parametrize(
    "effect", [("pressure_sensor_lag", 0.0106, 0), ("pressure_sensor_lag", 0.02, 0), ("inlet_valve_delay", 0.0044, 1)]
)
def test_late_readings_and_late_valves_are_no_lost_commands(effect: tuple[str, float, int], tmp_path: Path) -> None:
    """0.1 % of the frames are lost, one in an ABS stop; where late flanks counted as lost, 46 to 111 of a wheel did."""
    vehicle, logs = hidden_logs(tmp_path, 213, NAMES, effect)
    for prepared in Replay(vehicle, logs).prepared:
        assert (prepared.pressure_least[1:] == 1.0).sum(axis=0).max() <= 5
