"""The replay against the MuJoCo car with the same vehicle file, and the promises of its interface."""

from dataclasses import replace

import numpy as np
import pytest
from plant_log import drive, gentle_stop

from model_diagnosis.manoeuvre import Manoeuvre
from model_diagnosis.replay import Replay
from signals.errors import InputError
from signals.wheels import WHEELS
from vehicle_model.vehicle_file import Scatter, VehicleFile

GENTLE, PULSED, SINE, TURN, COAST = range(5)
_START = 20
"""Samples after which the plant, which starts from rolling freely in equilibrium, has settled."""


def _neutral(replay: Replay) -> np.ndarray:
    return np.zeros(len(replay.columns))


def _error(replay: Replay, m: int, signal: str, predicted: np.ndarray) -> float:
    """Root mean square error of a signal over the samples that count."""
    k = replay.signals(m).index(signal)
    valid = replay.weights()[m][:, k] > 0.0
    valid[:_START] = False
    return float(np.sqrt(np.mean((replay.measured(m)[valid, k] - predicted[valid, k]) ** 2)))


# Bounds: below a good sensor's noise (0.04 rad/s, 0.03 m/s^2) where the drive is below the limit; the sine reaches
# 9 m/s^2. What remains is form: the plant has unsprung masses of their own, finite angles and 0.2 ms steps of the spin,
# the replay springs in series with tyres, small angles and 2 ms. At the limit (pulsed) the wheel is unstable.
@pytest.mark.parametrize(
    ("m", "signal", "most"),
    [
        (GENTLE, "wheel_speed_fl", 0.02),
        (GENTLE, "longitudinal_acceleration", 0.01),
        (GENTLE, "vertical_load_fl", 5.0),
        (GENTLE, "pitch_angle", 3e-4),
        (PULSED, "wheel_speed_fl", 0.15),
        (PULSED, "longitudinal_acceleration", 0.03),
        (SINE, "yaw_rate", 0.0015),
        (SINE, "lateral_acceleration", 0.07),
        (SINE, "roll_angle", 0.0015),
        (SINE, "wheel_speed_rr", 0.03),
        (TURN, "yaw_rate", 0.002),
        (TURN, "lateral_speed", 0.02),
        (TURN, "wheel_speed_rl", 0.03),
        (COAST, "wheel_speed_rl", 0.01),
        (COAST, "longitudinal_acceleration", 0.005),
    ],
)
def test_observer_replay_follows_the_plant(replay: Replay, m: int, signal: str, most: float) -> None:
    assert _error(replay, m, signal, replay.predict(_neutral(replay), m)) < most


# without corrections errors add up: 0.2 % of the speed after some seconds
@pytest.mark.parametrize(("m", "most"), [(GENTLE, 0.03), (SINE, 0.05), (COAST, 0.03)])
def test_free_run_keeps_to_the_plant(replay: Replay, m: int, most: float) -> None:
    assert _error(replay, m, "speed", replay.free_run(_neutral(replay), m)) < most


def test_restarted_run_lies_between_observer_and_free_run(replay: Replay) -> None:
    theta = _neutral(replay)
    theta[replay.columns.index("mass_change.factor")] = 0.1
    errors = [
        _error(replay, GENTLE, "speed", predicted)
        for predicted in (
            replay.predict(theta, GENTLE),
            replay.free_run(theta, GENTLE, horizon_s=1.0),
            replay.free_run(theta, GENTLE),
        )
    ]
    assert errors[0] < errors[1] < errors[2]


def test_loads_add_up_to_the_weight(replay: Replay, car: VehicleFile) -> None:
    states = replay.states(_neutral(replay), COAST)
    total = sum(states[f"vertical_load_{wheel}"] for wheel in ("fl", "fr", "rl", "rr"))
    # heave moves the sum by a few newtons in transients, never on average
    assert np.mean(total) == pytest.approx(car.body.mass * 9.81, rel=1e-4)


def test_without_a_measured_speed_a_car_with_other_radii_begins_at_its_own(replay: Replay, car: VehicleFile) -> None:
    """Wheels 1 % larger turn 1 % slower: begun at the file's radii, the first second would deny what is true."""
    log = replay.manoeuvres[GENTLE]
    channels = {name: values for name, values in log.channels.items() if name != "speed"}
    for wheel in WHEELS:
        channels[f"wheel_speed_{wheel}"] = channels[f"wheel_speed_{wheel}"] / 1.01
    model = Replay(car, [replace(log, channels=channels)])
    theta = _neutral(model)
    theta[[model.columns.index(f"wheel_radius_change.{wheel}") for wheel in WHEELS]] = 0.01
    k = model.signals(0).index("wheel_speed_rr")
    assert abs(model.residuals(theta)[0][:100, k]).max() < 0.03
    assert abs(model.residuals(_neutral(model))[0][:100, k]).max() < 0.03  # the whole car 1 % slower says the same


def test_locked_wheels_stop_the_car_by_sliding_friction(car: VehicleFile) -> None:
    """Newton: with all wheels locked the deceleration is the curve's value at slip 1 times g, plus the air's."""
    n = 150
    channels = {f"wheel_speed_{wheel}": np.zeros(n) for wheel in ("fl", "fr", "rl", "rr")}
    channels |= {f"brake_pressure_{wheel}": np.full(n, 2e7) for wheel in ("fl", "fr", "rl", "rr")}
    channels |= {"speed": np.full(n, 20.0), "longitudinal_acceleration": np.zeros(n)}
    channels |= {"drive_torque_f": np.zeros(n), "drive_torque_r": np.zeros(n)}
    manoeuvre = Manoeuvre("locked", np.arange(n) * 0.01, channels, {name: np.ones(n) for name in channels}, "made up")
    model = Replay(car, [manoeuvre])
    speed = model.free_run(_neutral(model), 0)[:, model.signals(0).index("speed")]
    curve = car.tyre_pair.front.longitudinal
    friction = curve.peak_friction * np.sin(curve.shape * np.arctan(curve.stiffness))
    air = car.aerodynamics
    drag = 0.5 * air.air_density * air.drag_coefficient * air.frontal_area * 19.0**2 / car.body.mass
    assert (speed[10] - speed[40]) / 0.3 == pytest.approx(friction * 9.81 + drag, rel=5e-3)


def test_deviations_of_zero_change_no_bit(replay: Replay, car: VehicleFile) -> None:
    """Also against a replay that carries no effects at all."""
    bare = Replay(car, replay.manoeuvres, effects=())
    for m in range(len(replay.manoeuvres)):
        expected = bare.predict(np.zeros(0), m)
        assert np.array_equal(replay.predict(_neutral(replay), m), expected)
        assert np.array_equal(replay.predict(-_neutral(replay), m), expected)


def test_nothing_counts_below_walking_speed_or_where_samples_are_missing(car: VehicleFile) -> None:
    log = drive(car, gentle_stop, 4.0, 12.0)
    slow = log.channels["speed"] < 4.0
    weights = dict(log.weights)
    weights["yaw_rate"] = np.where(np.arange(log.samples) < 50, 0.0, 1.0)
    model = Replay(car, [replace(log, weights=weights)])
    k = model.signals(0).index("yaw_rate")
    found, theta = model.weights()[0], _neutral(model)
    assert slow.any()
    assert not found[slow].any()
    assert not found[:50, k].any()
    assert np.all(model.residuals(theta)[0][found == 0.0] == 0.0)


def test_drive_torque_that_was_not_measured_gives_no_longitudinal_evidence(replay: Replay, car: VehicleFile) -> None:
    log = replay.manoeuvres[COAST]
    channels = {name: values for name, values in log.channels.items() if not name.startswith("drive_torque")}
    model = Replay(car, [replace(log, channels=channels)])
    k = model.signals(0).index("longitudinal_acceleration")
    driven = (log.time > 2.5) & (log.time < 4.9)
    braked = log.time > 6.3
    assert not model.weights()[0][driven, k].any()
    assert model.weights()[0][braked, k].all()
    # the torque taken from the acceleration still drives the car as it was driven
    assert _error(model, 0, "wheel_speed_rl", model.predict(_neutral(model), 0)) < 0.1


def test_engine_torque_and_gear_stand_for_the_drive_torque(replay: Replay, car: VehicleFile) -> None:
    log = replay.manoeuvres[COAST]
    line = car.driveline
    ratio = line.gear_ratios[2] * line.final_drive * line.efficiency
    channels = {name: values for name, values in log.channels.items() if not name.startswith("drive_torque")}
    channels |= {"engine_torque": log.channels["drive_torque_r"] / ratio, "gear": np.full(log.samples, 3.0)}
    model = Replay(car, [replace(log, channels=channels)])
    found = model.predict(_neutral(model), 0)
    assert np.allclose(found, replay.predict(_neutral(replay), COAST), rtol=0.0, atol=1e-9 * np.abs(found).max())


def test_without_steering_the_lateral_balance_is_left_out(replay: Replay, car: VehicleFile) -> None:
    log = replay.manoeuvres[SINE]
    channels = {name: values for name, values in log.channels.items() if name != "steering_wheel_angle"}
    model = Replay(car, [replace(log, channels=channels)])
    for signal in ("yaw_rate", "lateral_acceleration"):
        assert not model.weights()[0][:, model.signals(0).index(signal)].any()


def test_a_log_without_any_speed_is_refused(replay: Replay, car: VehicleFile) -> None:
    log = replay.manoeuvres[GENTLE]
    channels = {"longitudinal_acceleration": log.channels["longitudinal_acceleration"]}
    with pytest.raises(InputError, match="no speed"):
        Replay(car, [replace(log, channels=channels)])


def test_scatter_of_the_vehicle_file_replaces_the_catalogues(car: VehicleFile) -> None:
    changed = car.model_copy(deep=True)
    changed.scatter = {
        "body.mass": Scatter(std=0.01),
        "steering.offset": Scatter(std=0.002, kind="absolute"),
    }
    model = Replay(changed, [])
    parameters = dict(zip(model.columns, model.parameters, strict=True))
    assert parameters["mass_change.factor"].nuisance_std == 0.01
    assert parameters["steering_offset.angle"].nuisance_std == 0.002


def test_physical_values(car: VehicleFile) -> None:
    model = Replay(car, [])
    assert model.physical("mass_change.factor", 0.1) == (pytest.approx(1.1 * car.body.mass), "kg", car.body.mass)
    assert model.physical("road_grade.grade", 0.02) == (0.02, "1", 0.0)
    value, unit, nominal = model.physical("aero_drag.factor", -0.5)
    assert (value, unit, nominal) == (pytest.approx(0.135), "1", 0.27)
    with pytest.raises(InputError, match="mass_change"):
        model.physical("mass_chang.factor", 0.1)
