"""What is taken for the log of one wheel on a rig, and in which order its sweeps are searched."""

from dataclasses import replace

import numpy as np
import pytest

from model_diagnosis.data.checks import check_data
from model_diagnosis.data.liveliest import liveliest
from model_diagnosis.data.rig import is_on_rig, rig_wheel
from model_diagnosis.manoeuvre import Manoeuvre
from vehicle_model.vehicle_file import load_vehicle

RIG = ("speed", "slip_ratio_fl", "slip_angle_fl", "vertical_load_fl", "longitudinal_force_fl", "lateral_force_fl")


def sweep(load: float, swing: float) -> Manoeuvre:
    time = 0.01 * np.arange(400)
    angle = 0.1 * np.sin(3.0 * time)
    channels = {name: np.zeros_like(time) for name in RIG} | {
        "speed": np.full_like(time, 11.0),
        "slip_angle_fl": swing * angle,
        "vertical_load_fl": np.full_like(time, load),
        "lateral_force_fl": -10.0 * swing * load * angle,
    }
    return Manoeuvre(
        f"{load:.0f} N", time, channels, {name: np.ones_like(time) for name in channels}, "made for a test"
    )


def test_slips_load_and_forces_of_one_wheel_are_a_rigs() -> None:
    assert rig_wheel(RIG) == "fl"
    assert rig_wheel([name for name in RIG if name != "slip_ratio_fl"]) == "fl"


@pytest.mark.parametrize(
    "more",
    ["wheel_speed_fl", "steering_wheel_angle", "brake_pressure_fl", "yaw_rate", "longitudinal_acceleration",
     "drive_torque_f", "master_pressure", "vertical_load_fr", "valve_inlet_fl"],
)  # fmt: skip
def test_whatever_a_car_has_makes_it_a_cars(more: str) -> None:
    assert rig_wheel([*RIG, more]) is None


def test_forces_alone_are_no_rigs() -> None:
    assert rig_wheel(["speed", "longitudinal_force_fl", "vertical_load_fl"]) is None


def test_the_checks_keep_a_rigs_forces_and_its_level_speed() -> None:
    faults, repaired = check_data([sweep(2000.0, 1.0)], load_vehicle("ekf_car"))
    assert not faults
    assert set(repaired[0].channels) == set(RIG)


def test_forces_of_a_car_without_their_cause_are_left_out() -> None:
    one = sweep(2000.0, 1.0)
    car = replace(one, channels=dict(one.channels) | {"yaw_rate": 0.01 * np.sin(one.time)})
    assert not is_on_rig([car])
    faults, repaired = check_data([car], load_vehicle("ekf_car"))
    assert "missing_channel" in [fault.kind for fault in faults]
    assert "lateral_force_fl" not in repaired[0].channels


def test_sweeps_that_differ_most_are_searched_first() -> None:
    sweeps = [sweep(load, swing) for load, swing in ((4000.0, 1.0), (3900.0, 1.0), (3800.0, 0.95), (500.0, 0.1))]
    assert [one.name for one in liveliest(sweeps, 8.0)] == ["4000 N", "500 N"]
