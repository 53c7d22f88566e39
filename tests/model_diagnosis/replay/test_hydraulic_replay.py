"""Pressures of the hydraulic unit from pedal, valves and pump, and the effects before the wheel brakes."""

from dataclasses import replace

import numpy as np
import pytest
from plant_log import hydraulic_log

from hydraulics import HydraulicUnit
from model_diagnosis.manoeuvre import Manoeuvre
from model_diagnosis.replay import Replay
from model_diagnosis.replay.hydraulic import acts_by_valves
from signals.wheels import WHEELS
from vehicle_model.vehicle_file import VehicleFile, set_parameter


@pytest.fixture(scope="module")
def log(car: VehicleFile) -> Manoeuvre:
    return hydraulic_log(car)


def _error_bar(replay: Replay, theta: np.ndarray, signal: str = "brake_pressure_fl") -> float:
    k = replay.signals(0).index(signal)
    residual = replay.residuals(theta)[0][:, k]
    return float(np.sqrt(np.mean(residual**2))) / 1e5


def test_pressures_follow_the_unit(car: VehicleFile, log: Manoeuvre) -> None:
    """The same model with the same inputs: what is left is that a valve moves somewhere between two samples."""
    model = Replay(car, [log])
    theta = np.zeros(len(model.columns))
    steepest_bar_s = 55.0 / car.hydraulics.decrease_time_constant
    assert _error_bar(model, theta) < 0.25 * steepest_bar_s * 0.005
    assert _error_bar(model, theta, "master_pressure") < 1e-9


@pytest.mark.parametrize(
    ("column", "size", "path"),
    [
        ("inlet_valve_conductance.fl", -0.3, "hydraulics.inlet_conductance_fl"),
        ("outlet_valve_conductance.fl", -0.3, "hydraulics.outlet_conductance_fl"),
        ("caliper_air.fl", 1.5e-6, "hydraulics.air_volume_fl"),
        ("hydraulic_leak.fl", 2e-13, "hydraulics.brake_leak_fl"),
        ("circuit_failure.first", 0.3, "hydraulics.first_circuit_failure"),
    ],
)
def test_an_effect_of_the_unit_is_taken_out_by_its_column(
    car: VehicleFile, log: Manoeuvre, column: str, size: float, path: str
) -> None:
    changed = car.model_copy(deep=True)
    relative = column.split(".")[0].endswith("conductance")
    set_parameter(changed, path, 1.0 + size if relative else size)
    model = Replay(car, [hydraulic_log(changed)])
    theta = np.zeros(len(model.columns))
    before = _error_bar(model, theta)
    theta[model.columns.index(column)] = size
    nominal = Replay(car, [log])
    assert before > 1.5 * _error_bar(nominal, np.zeros(len(theta)))
    assert _error_bar(model, theta) < 1.2 * _error_bar(nominal, np.zeros(len(theta)))


def test_dead_times_of_the_valves_are_continuous(car: VehicleFile, log: Manoeuvre) -> None:
    model = Replay(car, [log])
    index = model.columns.index("inlet_valve_delay.delay")
    predictions = []
    for delay in (2e-3, 2.5e-3, 3e-3):
        theta = np.zeros(len(model.columns))
        theta[index] = delay
        predictions.append(model.predict(theta, 0))
    middle = 0.5 * (predictions[0] + predictions[2])
    assert np.abs(predictions[2] - predictions[0]).max() > 1e4
    assert np.allclose(predictions[1], middle, rtol=0.0, atol=1e-6 * np.abs(middle).max())


@pytest.mark.parametrize("valve", ["inlet", "outlet"])
def test_dead_times_have_no_kink_at_whole_milliseconds(car: VehicleFile, log: Manoeuvre, valve: str) -> None:
    """A fit rests in a kink. At 5 ms commands cross a sample of the log: blended in straight lines between whole
    milliseconds, the slopes before and after differ by 0.44 and 0.52 of their sum, smoothly by 0.02 and 0.03."""
    model = Replay(car, [log])
    index = model.columns.index(f"{valve}_valve_delay.delay")
    predictions = []
    for delay in (4.95e-3, 5e-3 + 1e-9, 5.05e-3):
        theta = np.zeros(len(model.columns))
        theta[index] = delay
        predictions.append(model.predict(theta, 0))
    before, after = predictions[1] - predictions[0], predictions[2] - predictions[1]
    assert np.linalg.norm(after - before) < 0.1 * np.linalg.norm(after + before)


@pytest.mark.parametrize("valve", ["inlet", "outlet"])
def test_dead_times_have_no_kink_at_zero(car: VehicleFile, log: Manoeuvre, valve: str) -> None:
    """Commands are known to half a sample: a valve may have moved before. Held at 0, a fit would rest there."""
    assert getattr(car.hydraulics, f"{valve}_delay_fl") == 0.0
    model = Replay(car, [log])
    index = model.columns.index(f"{valve}_valve_delay.fl")
    predictions = []
    for delay in (-0.05e-3, 1e-9, 0.05e-3):
        theta = np.zeros(len(model.columns))
        theta[index] = delay
        predictions.append(model.predict(theta, 0))
    before, after = predictions[1] - predictions[0], predictions[2] - predictions[1]
    assert np.abs(after).max() > 1e3
    assert np.linalg.norm(after - before) < 0.1 * np.linalg.norm(after + before)


@pytest.mark.parametrize("time_constant", [1e-5, 1e-3, 0.02])
def test_booster_lags_behind_a_ramp_by_its_time_constant(
    car: VehicleFile, log: Manoeuvre, time_constant: float
) -> None:
    """tau dy/dt + y = u of a ramp u = c t from rest: y = c (t - tau (1 - exp(-t/tau))), between samples as well."""
    assert car.hydraulics is not None
    pedal = 100.0 * log.time
    model = Replay(car, [replace(log, channels=dict(log.channels) | {"pedal_force": pedal})])
    hydraulics = replace(model.prepared[0].hydraulics, pedal=pedal)
    lagged = model.pressures.unit.master({"form_booster.lag": time_constant}, hydraulics)
    late = log.time - time_constant * (1.0 - np.exp(-log.time / time_constant))
    assert lagged == pytest.approx(car.brakes.booster_gain * 100.0 * late, rel=1e-9, abs=1e-3)


@pytest.mark.parametrize("lag", [1e-5, 0.005, 0.04])
def test_a_wheels_sensor_reads_a_ramp_by_its_time_constant_late(car: VehicleFile, log: Manoeuvre, lag: float) -> None:
    """As the booster's lag above. The observer compares what the sensor reads: without noise it has nothing to correct,
    while a reading taken for the pressure would draw the unit a time constant behind."""
    model = Replay(car, [log])
    unit, prepared = model.pressures.unit, model.prepared[0]
    unit.flows = True
    n = len(log.time)
    quiet, none = np.zeros((n, 4)), np.zeros(n)
    assert prepared.hydraulics is not None
    ramp = replace(
        prepared.hydraulics,
        master=2e6 * log.time, inlet=quiet, outlet=quiet, pump=none, cornering=np.zeros(n, dtype=np.bool_),
    )  # fmt: skip
    free, _ = unit.wheels({}, ramp, quiet, quiet, gain=0.0)
    rate = np.gradient(free[:, 0], log.time)
    steady = slice(100, -1)
    assert rate[steady] == pytest.approx(2e6, rel=1e-3)
    for measured, valid in ((quiet, quiet), (free - 2e6 * lag, np.ones((n, 4)))):
        read, _ = unit.wheels({"pressure_sensor_lag.time_constant": lag}, ramp, measured, valid)
        assert free[steady, 0] - read[steady, 0] == pytest.approx(2e6 * lag, rel=1e-3, abs=1.0)


@pytest.mark.parametrize(
    "column",
    [
        "outlet_valve_conductance.fl",
        "inlet_valve_conductance.fl",
        "hydraulic_leak.fl",
        "form_booster.lag",
    ],
)
def test_sensitivities_of_a_unit_that_flows_hold_at_the_size_of_a_fits_last_steps(
    car: VehicleFile, log: Manoeuvre, column: str
) -> None:
    """A check valve and a dead band bend pressures within few steps: slopes taken wide promise what no step holds."""
    model = Replay(car, [log])
    model.pressures.unit.flows = True
    theta = np.zeros(len(model.columns))
    index = model.columns.index(column)
    found = model.sensitivities(theta, [index])[0][:, :, 0]
    step = 0.005 * model.parameters[index].effect_std
    nominal = model.predict(theta, 0)
    theta[index] = step
    change = (model.predict(theta, 0) - nominal) / step
    assert np.linalg.norm(found - change) < 0.05 * np.linalg.norm(change)


def test_one_late_valve_delays_its_own_wheel_alone(car: VehicleFile, log: Manoeuvre) -> None:
    """The same wheel as with all valves late by as much, and the others as with none."""
    model = Replay(car, [log])
    found = {}
    for column in ("inlet_valve_delay.delay", "inlet_valve_delay.fl"):
        theta = np.zeros(len(model.columns))
        theta[model.columns.index(column)] = 2.5e-3
        found[column] = model.predict(theta, 0)
    nominal = model.predict(np.zeros(len(model.columns)), 0)
    wheels = [model.signals(0).index(f"brake_pressure_{wheel}") for wheel in ("fl", "fr", "rl", "rr")]
    one, every = found["inlet_valve_delay.fl"][:, wheels], found["inlet_valve_delay.delay"][:, wheels]
    assert np.abs(one[:, 0] - nominal[:, wheels[0]]).max() > 1e4
    assert np.allclose(one[:, 0], every[:, 0], rtol=0.0, atol=1.0)
    assert np.allclose(one[:, 1:], nominal[:, wheels[1:]], rtol=0.0, atol=1.0)


def test_knock_back_delays_the_first_pressure_after_cornering(car: VehicleFile, log: Manoeuvre) -> None:
    lateral = np.where(log.time < 0.25, 6.0, 0.0)
    channels = dict(log.channels) | {"lateral_acceleration": lateral}
    weights = dict(log.weights) | {"lateral_acceleration": np.ones(log.samples)}
    model = Replay(car, [replace(log, channels=channels, weights=weights)])
    theta = np.zeros(len(model.columns))
    k = model.signals(0).index("brake_pressure_fl")
    usual = model.free_run(theta, 0)[:, k]
    theta[model.columns.index("brake_knock_back.volume")] = 5e-7
    late = model.free_run(theta, 0)[:, k]
    assert np.all(late <= usual + 1.0)
    # 0.5 cm^3 at the caliper's stiffness is the pressure that is lacking while the supply still rises
    assert np.max(usual - late) > 0.1 * 5e-7 * car.hydraulics.caliper_stiffness_front
    assert abs(late[-1] - usual[-1]) < 0.05 * usual[-1]


def test_without_cornering_there_is_no_knock_back(car: VehicleFile, log: Manoeuvre) -> None:
    """A volume that no pad was pushed back by changes not a bit of any pressure."""
    model = Replay(car, [log])
    theta = np.zeros(len(model.columns))
    nominal = model.predict(theta, 0)
    theta[model.columns.index("brake_knock_back.volume")] = 5e-7
    assert np.array_equal(model.predict(theta, 0), nominal)


def test_what_acts_by_valves_is_left_out_where_none_is_moved_and_changes_no_bit_there(
    car: VehicleFile, log: Manoeuvre
) -> None:
    at_rest = {name: 0.0 * values for name, values in log.channels.items() if name.startswith("valve_")}
    model = Replay(car, [log, replace(log, channels=dict(log.channels) | at_rest)])
    theta = np.zeros(len(model.columns))
    chosen = [index for index, name in enumerate(model.columns) if acts_by_valves(name)]
    # four wheels' outlets and what they share, two kinds of delay of all and of each, pump and its back pressure,
    # accumulators, what passes two valves that change places
    assert len(chosen) == 19
    moved, rested = model.sensitivities(theta, chosen)
    nominal = model.predict(theta, 1)
    for place, column in enumerate(chosen):
        theta[column] = model.parameters[column].effect_std
        assert np.array_equal(model.predict(theta, 1), nominal), model.columns[column]
        theta[column] = 0.0
        assert not rested[:, :, place].any()
    assert moved[:, :, chosen.index(model.columns.index("outlet_valve_conductance.fl"))].any()


@pytest.mark.parametrize(
    "effect",
    [
        "",
        "form_return.lag",
        "caliper_air.fl",
        "hydraulic_leak.rr",
        "circuit_failure.first",
        "pressure_sensor_lag.time_constant",
    ],
)
@pytest.mark.parametrize("flows", [False, True])
def test_steps_that_are_left_out_while_the_brakes_rest_change_no_bit(
    car: VehicleFile, log: Manoeuvre, flows: bool, effect: str
) -> None:
    """A pump that runs with empty accumulators moves nothing, but has the unit stepped through the rest."""
    model = Replay(car, [log])
    unit, prepared = model.pressures.unit, model.prepared[0]
    unit.flows = flows
    pressed = np.linspace(0.0, 6e6, 50), np.full(50, 3e6)
    master = np.concatenate([np.zeros(100), pressed[0], np.zeros(300), pressed[1], np.zeros(200)])
    n, none = len(master), np.zeros((len(master), 4))
    assert prepared.hydraulics is not None
    resting = replace(
        prepared.hydraulics,
        master=master, inlet=none, outlet=none, pump=np.zeros(n), cornering=np.zeros(n, dtype=np.bool_),
    )  # fmt: skip
    measured = 3e4 * np.random.default_rng(1).standard_normal((n, 4))  # draws the pressures up and down
    deviations = {effect: model.parameters[model.columns.index(effect)].effect_std} if effect else {}
    found, stepped = (
        unit.wheels(deviations, one, measured + master[:, None], np.ones((n, 4)), noise=1.5e4)[0]
        for one in (resting, replace(resting, pump=np.ones(n)))
    )
    assert found[140:150].min() > 1e6
    assert np.array_equal(found, stepped)


def test_a_lost_command_of_a_valve_is_not_carried_on(car: VehicleFile, log: Manoeuvre) -> None:
    """The log holds the valves' commands for a frame more: the unit errs in that sample and not in those behind it."""
    row = 163  # the outlets open at 1.626 s
    channels = dict(log.channels)
    for name in (name for name in log.channels if name.startswith("valve_")):
        channels[name] = log.channels[name].copy()
        channels[name][row] = channels[name][row - 1]
    assert channels["valve_outlet_fl"][row] != log.channels["valve_outlet_fl"][row]
    whole, lost = (Replay(car, [one]) for one in (log, replace(log, channels=channels)))
    theta = np.zeros(len(lost.columns))
    wheels = [lost.signals(0).index(f"brake_pressure_{wheel}") for wheel in ("fl", "fr", "rl", "rr")]
    added = np.abs(lost.residuals(theta)[0] - whole.residuals(theta)[0])[:, wheels] / 1e5
    assert np.all(added[row : row + 2].max(axis=0) > 6.0)
    assert added[row + 2 :].max() < 0.3


def test_without_wheel_pressures_the_unit_drives_the_brakes(car: VehicleFile, log: Manoeuvre) -> None:
    channels = {name: values for name, values in log.channels.items() if not name.startswith("brake_pressure_")}
    model = Replay(car, [replace(log, channels=channels)])
    theta = np.zeros(len(model.columns))
    k = model.signals(0).index("wheel_speed_fl")
    residual = model.residuals(theta)[0][:, k]
    assert np.sqrt(np.mean(residual**2)) < 0.15
    index = model.columns.index("inlet_valve_conductance.fl")
    assert np.abs(model.sensitivities(theta, [index])[0][:, k, 0]).max() > 1.0


def test_pressure_sensor_scale_differs_from_pad_friction_beside_a_master_sensor(
    car: VehicleFile, log: Manoeuvre
) -> None:
    """Wheel pressures alone cannot tell the two; the unit's pressures see the sensor, not the pad."""
    model = Replay(car, [log])
    theta = np.zeros(len(model.columns))
    columns = [model.columns.index(name) for name in ("pressure_sensor_scale.wheels", "brake_pad_friction.factor")]
    shown = model.sensitivities(theta, columns)[0]
    pressures = [model.signals(0).index(f"brake_pressure_{wheel}") for wheel in WHEELS]
    assert np.abs(shown[:, pressures, 0]).max() > 1e6
    assert np.abs(shown[:, pressures, 1]).max() == 0.0


def test_booster_that_runs_out_of_vacuum_shows_in_the_master_pressure(car: VehicleFile, log: Manoeuvre) -> None:
    """Above the knee a share of the slope is lost: p = k F - d (k F - p_k)."""
    gain, knee, loss = car.brakes.booster_gain, 5e6, 0.4
    full = gain * log.channels["pedal_force"]
    channels = dict(log.channels) | {"master_pressure": full - loss * np.maximum(full - knee, 0.0)}
    model = Replay(car, [replace(log, channels=channels)])
    theta = np.zeros(len(model.columns))
    assert _error_bar(model, theta, "master_pressure") > 3.0
    theta[model.columns.index("booster_saturation.slope_loss")] = loss
    nominal = model.physical("booster_saturation.knee", 0.0)[2]
    theta[model.columns.index("booster_saturation.knee")] = knee - nominal
    assert _error_bar(model, theta, "master_pressure") < 1e-9


def _followed(car: VehicleFile, log: Manoeuvre, threshold_pa: float) -> Manoeuvre:
    """The log with a driver who breathes on the pedal, valves at rest, and what the car's unit makes of that."""
    other = car.model_copy(deep=True)
    set_parameter(other, "hydraulics.pressure_change_threshold", threshold_pa)
    unit, out, rest = HydraulicUnit(other.numbers()), np.zeros(18), np.zeros(4)
    master = 3e6 + 6e5 * np.sin(2.0 * np.pi * 0.5 * np.arange(10 * len(log.time)) * 1e-3)
    pressures = np.empty((len(master), 4))
    for tick, pressure in enumerate(master):
        unit.tick(pressure, rest, rest, 0.0, out, np.full(4, 50.0))
        pressures[tick] = unit.wheel_pressure_pa
    channels = {f"valve_{kind}_{wheel}": np.zeros(len(log.time)) for kind in ("inlet", "outlet") for wheel in WHEELS}
    channels |= {f"brake_pressure_{wheel}": pressures[::10, i] for i, wheel in enumerate(WHEELS)}
    return replace(log, channels=dict(log.channels) | channels | {"master_pressure": master[::10]})


@pytest.mark.parametrize(("threshold_pa", "form_std"), [(1e5, 0.01), (0.0, 0.0)])
def test_only_a_unit_that_moves_by_steps_rests_off_its_line(
    car: VehicleFile, log: Manoeuvre, threshold_pa: float, form_std: float
) -> None:
    """Steps of 1 bar leave 1 bar over root 12 of some 30; what of the two a log shows, the replay finds by itself."""
    model = Replay(car, [_followed(car, log, threshold_pa)])
    failures = [model.columns.index(f"circuit_failure.{number}") for number in ("first", "second")]
    assert [model.parameters[column].ordinary_std for column in failures] == [form_std, form_std]


@pytest.mark.parametrize("failed", [0.0, 0.02, 0.3])
def test_a_throttled_return_stays_above_its_own_line_by_rate_times_lag(
    car: VehicleFile, log: Manoeuvre, failed: float
) -> None:
    """tau dp/dt = p_line - p under a line that falls by r: p = p_line + r tau once the transient is over."""
    master = np.maximum(8e6 - 2e6 * log.time, 1e6)
    shape = len(master), 4
    rest = {f"valve_{kind}_{wheel}": np.zeros(len(master)) for kind in ("inlet", "outlet") for wheel in WHEELS}
    still = replace(log, channels=dict(log.channels) | rest | {"master_pressure": master})
    model = Replay(car, [still])
    hydraulics = replace(model.prepared[0].hydraulics, master=master, behind_master=0.0)
    deviations = {"form_return.lag": 0.02, "circuit_failure.first": failed, "circuit_failure.second": failed}
    pressures, _ = model.pressures.unit.wheels(deviations, hydraulics, np.zeros(shape), np.zeros(shape), gain=0.0)
    settled = (log.time > 1.0) & (log.time < 3.0)
    rate = 2e6 * (1.0 - failed)
    above = pressures[settled] - (1.0 - failed) * master[settled, None]
    assert above == pytest.approx(np.full_like(above, rate * 0.02), rel=0.01)
