"""The whole diagnosis on manoeuvres that the replay itself made, with a known effect and the sensors' own noise."""

from dataclasses import replace

import numpy as np
import pytest

from model_diagnosis.diagnosis import diagnose
from model_diagnosis.evidence.manoeuvre_library import LIBRARY
from model_diagnosis.findings import Findings
from model_diagnosis.manoeuvre import Manoeuvre
from model_diagnosis.replay import Replay
from model_diagnosis.replay.disturbances import ALIKE
from signals.errors import InputError
from signals.wheels import WHEELS
from vehicle_model import load_vehicle

CAR = "ekf_car"
SIGNALS = ("speed", "longitudinal_acceleration", *(f"wheel_speed_{wheel}" for wheel in WHEELS))


def _drive(name: str, column: str, deviation: float, seed: int) -> Manoeuvre:
    """A manoeuvre of the library as the car with one deviation drives it."""
    vehicle = load_vehicle(CAR)
    planned = next(one for one in LIBRARY if one.name == name)
    time, inputs = planned.inputs("r")
    guess = {signal: np.full_like(time, planned.speed) for signal in SIGNALS}
    for wheel in WHEELS:
        guess[f"wheel_speed_{wheel}"] = guess["speed"] / getattr(vehicle.wheels, wheel).radius
    channels = guess | inputs
    blank = Manoeuvre(name, time, channels, {key: np.ones_like(time) for key in channels}, "made for a test")
    replay = Replay(vehicle, [blank])
    theta = np.zeros(len(replay.columns))
    theta[replay.columns.index(column)] = deviation
    run = replay.free_run(theta, 0)
    noise = np.random.default_rng(seed)
    made = {
        signal: run[:, place] + replay.sensor_std(signal) * noise.standard_normal(len(time))
        for place, signal in enumerate(replay.signals(0))
        if signal in SIGNALS
    }
    moving = made["speed"] > 5.0
    end = len(time) if moving.all() else int(np.argmin(moving))
    kept = {key: values[:end] for key, values in (inputs | made).items()}
    return replace(blank, time=time[:end], channels=kept, weights={key: np.ones(end) for key in kept})


@pytest.fixture(scope="module")
def worn_pads() -> Findings:
    names = ("stop_gentle", "stop_medium", "coast_fast")
    return diagnose(
        [_drive(name, "brake_pad_friction.factor", -0.3, seed) for seed, name in enumerate(names)],
        CAR,
        hold_out=[_drive("pressure_stairs", "brake_pad_friction.factor", -0.3, 9)],
    )


def test_worn_pads_are_named_or_in_the_group_of_what_looks_the_same(worn_pads: Findings) -> None:
    cause = worn_pads.diagnosis.causes[0]
    assert "brake_pad_friction" in cause.group
    assert worn_pads.diagnosis.verdict in ("effect_found", "indistinguishable")


def test_the_brakes_of_both_axles_are_the_most_violated_equation(worn_pads: Findings) -> None:
    assert next(iter(worn_pads.diagnosis.guilty_by_innovations)) == ALIKE


def test_worn_pads_are_the_only_cause(worn_pads: Findings) -> None:
    assert len(worn_pads.diagnosis.causes) == 1


def test_pads_cannot_be_told_from_the_pressure_sensors_and_the_plan_asks_for_another(worn_pads: Findings) -> None:
    cause = worn_pads.diagnosis.causes[0]
    assert "pressure_sensor_scale" in cause.group
    following = worn_pads.diagnosis.next_manoeuvre
    assert following is not None
    assert following.name == "sensor:reference_pressure"


def test_the_extension_gains_on_a_manoeuvre_that_took_no_part(worn_pads: Findings) -> None:
    gain = worn_pads.diagnosis.gain
    assert gain is not None
    assert not gain.cross_validated
    assert gain.overall.high < 1.0
    assert [part.held_out for part in worn_pads.manoeuvres] == [False, False, False, True]


def test_what_straight_stops_do_not_show_is_said(worn_pads: Findings) -> None:
    assert {"yaw_inertia", "steering_ratio", "brake_pad_fade"} <= set(worn_pads.diagnosis.insufficient)


def test_manoeuvres_without_anything_to_compare_are_refused_in_words() -> None:
    time = np.arange(300) * 0.01
    nothing = Manoeuvre("empty", time, {"gear": np.ones(300)}, {"gear": np.ones(300)}, "gears.csv")
    with pytest.raises(InputError, match=r"gears.csv"):
        diagnose([nothing], CAR)
