"""Accelerations without gravity: those of the motion over ground, by the kinematics of the plane, and told as such."""

import sys
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

sys.path.insert(0, str(Path(__file__).parents[1] / "data"))

from hidden_car import INERTIAL, hidden_logs
from hidden_effects.data_faults import Fault
from plant_log import coast_and_drive, drive

from model_diagnosis.diagnosis import diagnose
from model_diagnosis.manoeuvre import SAMPLE_TIME_S
from model_diagnosis.replay import Replay
from vehicle_model.vehicle_file import VehicleFile

TURN = 3
EDGE = 20
"""Samples at either end that no derivative and no filter is held to."""


@pytest.mark.parametrize(("axis", "other"), [("longitudinal", 0.2), ("lateral", 0.2)])
def test_a_levelled_accelerometer_reads_the_motion_over_ground(replay: Replay, axis: str, other: float) -> None:
    """a_x = dv/dt - r v_y and a_y = dv_y/dt + r v, on a grade of 3 % and a bank of 2 %, while the body leans.

    What an accelerometer in the body reads differs from it by ``other`` m/s^2 and more: gravity of lean and road.
    """
    theta = np.zeros(len(replay.columns))
    for column, value in (("road_grade.grade", 0.03), ("road_bank.bank", 0.02)):
        theta[replay.columns.index(column)] = value
    k = replay.signals(TURN).index(f"{axis}_acceleration")
    leaning = replay.free_run(theta, TURN)[:, k]
    theta[replay.columns.index("accelerometer_levelled.share")] = 1.0
    levelled = replay.free_run(theta, TURN)[:, k]
    run = replay.free_run(theta, TURN)
    speed, across, turn = (run[:, replay.signals(TURN).index(name)] for name in ("speed", "lateral_speed", "yaw_rate"))
    rate = {
        "longitudinal": np.gradient(speed, SAMPLE_TIME_S) - turn * across,
        "lateral": np.gradient(across, SAMPLE_TIME_S) + turn * speed,
    }[axis]
    inside = slice(EDGE, -EDGE)
    scale = np.sqrt(np.mean(rate[inside] ** 2))
    assert np.sqrt(np.mean((levelled - rate)[inside] ** 2)) < 0.02 * scale
    assert np.sqrt(np.mean((leaning - rate)[inside] ** 2)) > other


@pytest.mark.parametrize(("share", "climbs_m_s"), [(1.0, 0.0), (0.0, -0.03 * 9.81 * 8.0)])
def test_a_drive_inferred_from_levelled_accelerations_climbs_the_road(
    car: VehicleFile, share: float, climbs_m_s: float
) -> None:
    """A grade of 3 % is in no levelled acceleration: the force that it asks for is the road's too, and the speed after
    8 s the same. An accelerometer in the body reads it, and what it reads drives a car that loses g s t."""
    driven = drive(car, coast_and_drive, 8.0, 25.0, name="coast")
    kept = {name: values for name, values in driven.channels.items() if "torque" not in name and "pressure" not in name}
    replay = Replay(car, [replace(driven, channels=kept, weights={name: driven.weights[name] for name in kept})])
    theta = np.zeros(len(replay.columns))
    theta[replay.columns.index("accelerometer_levelled.share")] = share
    speed = replay.signals(0).index("wheel_speed_fl")
    level = replay.free_run(theta, 0)[:, speed]
    theta[replay.columns.index("road_grade.grade")] = 0.03
    change = car.wheels.fl.radius * (replay.free_run(theta, 0)[:, speed] - level)[-1]
    assert change == pytest.approx(climbs_m_s, abs=0.25)


def test_levelled_accelerations_are_told_and_nothing_else(tmp_path: Path) -> None:
    """Of a car of the challenge's generator, which differentiates its own motion; both channels are wrong at once."""
    vehicle, manoeuvres = hidden_logs(
        tmp_path,
        311,
        ("brake_in_turn", "sine_steer"),
        fault=Fault("accelerometer_levelled", INERTIAL[:2], 1.0, "1"),
    )
    answer = diagnose(manoeuvres, vehicle).diagnosis
    assert answer.verdict == "effect_found"
    assert [cause.effect for cause in answer.causes] == ["accelerometer_levelled"]
    assert answer.causes[0].parameters["share"].value == 1.0
