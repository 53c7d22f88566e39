"""The vehicle-state observers are defined for traction: they say so in braking, or take the brakes' torque if asked."""

from typing import Any

import numpy as np
import pytest

import estimators
from vehicle_model.vehicle_file import load_vehicle

CAR = load_vehicle("lada_vesta_assumed_steering").numbers()
OBSERVERS = ("vehicle_state_ukf", "wheel_sliding_mode", "magic_formula_fit", "road_grade", "observer_cascade")
PRESSURES = {f"brake_pressure_{wheel}" for wheel in ("fl", "fr", "rl", "rr")}
BRAKE, TICKS = 600, 1000
WHEEL_RADIUS_M = {"f": 0.3015, "r": 0.3023}


def in_a_gentle_stop(name: str, settings: dict[str, Any]) -> tuple[Any, dict[str, np.ndarray]]:
    """A car that rolls at 15 m/s and brakes with 2 m/s^2 from tick BRAKE on; the estimator and its outputs by name."""
    estimator = estimators.create(name, CAR, settings)
    speed = 15.0 - 2.0e-3 * np.maximum(np.arange(TICKS) - BRAKE, 0.0)
    braking = np.arange(TICKS) >= BRAKE
    columns = {signal: np.zeros(TICKS) for signal in estimator.inputs}
    for signal in columns:
        if signal.startswith("wheel_speed_"):
            columns[signal] = speed / WHEEL_RADIUS_M[signal[-2]]
        elif signal in PRESSURES:
            columns[signal] = np.where(braking, 1e6, 0.0)
    columns["brake_switch"] = braking.astype(float)
    columns["longitudinal_acceleration"] = np.where(braking, -2.0, 0.0)
    if "gear" in columns:
        columns["gear"][:] = 3.0
        columns["engine_speed"] = 1.357 * 3.938 * speed / WHEEL_RADIUS_M["f"]
    results = estimator.replay(columns)
    names = [signal.name.partition(".")[2] for signal in estimator.outputs]
    return estimator, dict(zip(names, results.T, strict=True))


@pytest.mark.parametrize("name", OBSERVERS)
def test_they_say_in_braking_that_they_are_defined_for_traction_only(name: str) -> None:
    estimator, found = in_a_gentle_stop(name, {})
    assert not PRESSURES & set(estimator.inputs)
    assert not found["traction_only"][:BRAKE].any()
    assert found["traction_only"][BRAKE + 10 :].all()
    told = [key for key in ("speed_confidence", "road_grade_confidence", "slip_fl_confidence") if key in found]
    for key in told:
        assert not found[key][BRAKE + 10 :].any(), key
    assert found["speed_confidence"][BRAKE // 2 : BRAKE].all()


@pytest.mark.parametrize("name", OBSERVERS[1:])
def test_brake_torque_is_an_input_only_where_it_is_asked_for(name: str) -> None:
    estimator, found = in_a_gentle_stop(name, {"longitudinal.brake_torque": "pressure"})
    assert set(estimator.inputs) >= PRESSURES
    assert not found["traction_only"].any()
    assert found["speed_confidence"][BRAKE + 10 :].all()
