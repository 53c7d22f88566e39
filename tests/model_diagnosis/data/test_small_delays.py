"""Delays of one to four samples against the replay: found, and what only looks late in the car's physics is refused.

Logs are those of the challenge's generator; every number of its cars is off within its scatter.
"""

from dataclasses import replace
from pathlib import Path

import pytest
from hidden_car import INERTIAL, WHEEL_SPEEDS, drawn_logs, hidden_logs, late

from model_diagnosis.data import check_data
from model_diagnosis.replay import Replay

NAMES = ("gentle_stops", "brake_in_turn", "sine_steer", "accelerate_and_brake")


@pytest.mark.parametrize(
    ("seed", "kind", "channels", "delay_s"),
    [
        pytest.param(201, "wheel_speed_delay", WHEEL_SPEEDS, 0.02, marks=pytest.mark.nightly),
        pytest.param(205, "wheel_speed_delay", WHEEL_SPEEDS, 0.04, marks=pytest.mark.nightly),
        (206, "can_latency", INERTIAL, 0.015),
        (202, "can_latency", INERTIAL, 0.03),
    ],
)
def test_a_small_delay_is_found(
    seed: int, kind: str, channels: tuple[str, ...], delay_s: float, tmp_path: Path
) -> None:
    """Shifted by the nearest whole samples; 4 ms are what 3 % of stiffnesses and inertias do to the phases."""
    vehicle, manoeuvres = hidden_logs(tmp_path, seed, NAMES, fault=late(kind, channels, delay_s))
    faults, _ = check_data(manoeuvres, vehicle, Replay)
    (fault,) = [one for one in faults if one.unit == "s"]
    assert (fault.kind, set(fault.channel.split(", "))) == (kind, set(channels))
    assert fault.value == pytest.approx(delay_s, abs=0.004)


@pytest.mark.parametrize(
    ("seed", "effect"),
    [
        (207, ("brake_drag_torque", 45.0, 0)),
        pytest.param(208, ("tyre_friction", -0.3, 0), marks=pytest.mark.nightly),
        (209, ("tyre_relaxation_length", 0.35, 0)),
        (203, None),
    ],
    ids=["brake drag", "low friction", "long relaxation", "clean"],
)
def test_physics_that_shifts_phases_is_no_delay(
    seed: int, effect: tuple[str, float, int] | None, tmp_path: Path
) -> None:
    vehicle, manoeuvres = hidden_logs(tmp_path, seed, NAMES, effect)
    faults, _ = check_data(manoeuvres, vehicle, Replay)
    assert [one.kind for one in faults if one.unit == "s"] == []


def test_pressures_behind_a_lag_of_first_order_are_not_late_by_a_sample(tmp_path: Path) -> None:
    """In an ABS stop 18 ms of lag are no delay: what they let through of the valves' flanks has another shape."""
    vehicle, manoeuvres = hidden_logs(tmp_path, 212, (*NAMES, "abs_stop"), ("pressure_sensor_lag", 0.018, 0))
    faults, _ = check_data(manoeuvres, vehicle, Replay)
    assert [one.kind for one in faults if one.unit == "s"] == []


@pytest.mark.nightly
def test_low_friction_hides_no_late_logger_and_invents_no_late_message(tmp_path: Path) -> None:
    """A car that slides for seconds moves none of its channels as its twins do, but in four of six manoeuvres."""
    everything = (*NAMES, "coast", "abs_stop")
    fault = late("clock_offset", ("speed",), 0.12)
    vehicle, manoeuvres = hidden_logs(tmp_path, 211, everything, ("tyre_friction", -0.34, 0), fault)
    faults, _ = check_data(manoeuvres, vehicle, Replay)
    (found,) = [one for one in faults if one.unit == "s"]
    assert (found.kind, found.channel) == ("clock_offset", "speed")
    assert found.value == pytest.approx(fault.value, abs=0.01)


def test_where_innovations_refuse_the_likeliest_late_channels_the_next_ones_are_tried(tmp_path: Path) -> None:
    """A dragging brake makes pressures and acceleration look early by what the other logger's speed is late."""
    vehicle, manoeuvres = drawn_logs(tmp_path, 48, 10)
    faults, _ = check_data(manoeuvres, vehicle, Replay)
    (fault,) = [one for one in faults if one.unit == "s"]
    assert (fault.kind, fault.channel) == ("clock_offset", "speed")
    assert fault.value == pytest.approx(0.0534, abs=0.005)


@pytest.mark.parametrize(
    ("index", "hidden_s"),
    [
        pytest.param(34, 0.0346, id="refitted numbers took half of the delay upon them"),
        pytest.param(
            14, 0.0772, id="beside two channels that are not late another delay fits", marks=pytest.mark.nightly
        ),
    ],
)
def test_a_logger_late_by_a_few_samples_is_found_beside_an_effect(index: int, hidden_s: float, tmp_path: Path) -> None:
    """Left unsettled it comes out as a scale of the accelerometer of 0.8 to 0.93, far beyond any sensor's."""
    vehicle, manoeuvres = drawn_logs(tmp_path, 64, index, "single")
    faults, _ = check_data(manoeuvres, vehicle, Replay)
    (fault,) = [one for one in faults if one.unit == "s"]
    assert (fault.kind, fault.channel) == ("clock_offset", "speed")
    assert fault.value == pytest.approx(hidden_s, abs=0.005)


def test_without_the_acceleration_the_innovations_alone_tell_a_late_logger(tmp_path: Path) -> None:
    """The first of the two above: only its brakes are left to compare with, whose valve is late by 6 ms."""
    vehicle, manoeuvres = drawn_logs(tmp_path, 64, 34, "single")
    without = [
        replace(one, channels={name: of for name, of in one.channels.items() if name != "longitudinal_acceleration"})
        for one in manoeuvres
    ]
    faults, _ = check_data(without, vehicle, Replay)
    (fault,) = [one for one in faults if one.unit == "s"]
    assert (fault.kind, fault.channel) == ("clock_offset", "speed")
    assert fault.value == pytest.approx(0.0346, abs=0.005)
