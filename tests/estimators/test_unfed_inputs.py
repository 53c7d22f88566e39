"""An observer that has no use for a signal neither asks for it nor waits for it."""

import numpy as np

import estimators
from estimators.inputs import INPUTS_GOOD, INPUTS_LOST, VALUE, accept_inputs, input_guard
from estimators.registry import describe
from signals.catalogue import block_slice
from vehicle_model.vehicle_file import load_vehicle

TORQUES = {"engine_torque", "engine_speed", "gear", "drive_torque_f", "drive_torque_r"}


def test_a_row_that_no_signal_feeds_is_never_lost() -> None:
    guard, positions = input_guard([None, "yaw_rate"], 0.1)
    inputs, ages = (np.zeros(block_slice(name).stop - block_slice(name).start) for name in ("bus", "bus_age"))
    inputs[:] = 0.5
    assert accept_inputs(guard, positions, inputs, ages, 0.001) == INPUTS_GOOD
    assert guard[:, VALUE].tolist() == [0.0, 0.5]
    ages[:] = 1.0
    verdicts = [accept_inputs(guard, positions, inputs, ages, 0.001) for _ in range(150)]
    assert verdicts[-1] == INPUTS_LOST  # the other row still is


def test_lateral_filter_needs_no_torque_and_the_others_do() -> None:
    """Its speed is the wheels'; a log without engine signals is enough for it."""
    car = load_vehicle("lada_vesta_assumed_steering").numbers()
    lateral = estimators.create("vehicle_state_ukf", car)
    assert not TORQUES & set(lateral.inputs)
    for name in ("wheel_sliding_mode", "magic_formula_fit", "road_grade", "observer_cascade"):
        description = describe(name)
        assert set(description.inputs(description.settings())) >= TORQUES
    columns = {name: np.zeros(500) for name in lateral.inputs}
    for i, wheel in enumerate(("fl", "fr", "rl", "rr")):
        columns[f"wheel_speed_{wheel}"][:] = 15.0 / (0.3015 if i < 2 else 0.3023)
    results = lateral.replay(columns)
    outputs = [signal.name.partition(".")[2] for signal in lateral.outputs]
    last = dict(zip(outputs, results[-1], strict=True))
    assert (last["active"], last["input_state"], last["resets"]) == (1.0, 0.0, 0.0)
    # 15 m/s and the slip of towed wheels, 0.06 %
    assert abs(last["speed"] - 15.0) < 0.02
