"""The attitude filters on the car of the bench (attitude document, 6), from decoded CAN frames."""

from collections.abc import Callable

import numpy as np
import pytest
from conftest import Judge, JudgedRun

from estimators import create
from vehicle_model.vehicle_file import load_vehicle

NAMES = ("attitude_slalom", "attitude_slalom_offset", "attitude_suspicious_sensor", "attitude_abs_stop")


def passed(run: JudgedRun) -> None:
    """Every criterion with limits has to pass."""
    for criterion in run.criteria.values():
        assert criterion.verdict == "pass", (
            f"{criterion.id} = {criterion.value}, {criterion.limits}: {criterion.reason}"
        )


@pytest.mark.parametrize("name", NAMES)
def test_scenario(name: str, judged: Judge) -> None:
    passed(judged(f"state/{name}"))


@pytest.mark.acceptance("B-57")
def test_three_references_on_the_car(judged: Judge, record: Callable[..., None]) -> None:
    run = judged("state/attitude_slalom_offset")
    record("car, 100 mG: b_y of the bank", run.value("offset") / 9.80665e-3, "100 +- 25 mG")
    for criterion, label in (
        ("roll_angle", "one filter, bank's R"),
        ("roll_angle_own_noise", "one filter, own R"),
        ("roll_angle_extra_state", "extra state"),
    ):
        record(f"car, 100 mG: RMSE of roll over that of {label}", run.value(criterion), "reported")
    record("car, 100 mG: b_y without roll balance", run.value("offset_no_roll_balance") / 9.80665e-3, "< 30 mG")
    assert run.value("offset") == pytest.approx(0.980665, rel=0.25)
    assert run.value("offset_no_roll_balance") < 0.3


def test_weights_are_held_near_the_limit_of_friction() -> None:
    """0.8 of friction 0.9: above 7.06 m/s^2 of specific force."""
    bank = create("attitude_bank", load_vehicle("ekf_car").numbers())
    n = 4000
    columns = {name: np.zeros(n) for name in bank.inputs}
    columns |= {f"wheel_speed_{wheel}": np.full(n, 80.0) for wheel in ("fl", "fr", "rl", "rr")}
    columns["lateral_acceleration"] = np.where(np.arange(n) < 2000, 6.5, 7.6)
    results = bank.replay(columns)
    held = results[:, [signal.name for signal in bank.outputs].index("attitude_bank.weights_held")]
    assert held[1000:2000].max() == 0.0
    assert held[2500:].min() == 1.0


def test_offsets_of_all_sensors_have_an_output() -> None:
    names = {
        signal.name.partition(".")[2] for signal in create("attitude_bank", load_vehicle("ekf_car").numbers()).outputs
    }
    wanted = {f"{axis}_rate_offset" for axis in ("roll", "yaw", "pitch")}
    wanted |= {f"{axis}_acceleration_offset" for axis in ("longitudinal", "lateral", "vertical")}
    assert wanted | {"roll_angle", "pitch_angle", "side_slip_angle"} <= names
    assert {f"{name}_std" for name in wanted} <= names
