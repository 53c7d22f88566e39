"""The replay of a wheel on a rig against the plant's own tyre and the closed form of the relaxation."""

import numpy as np
import pytest

from model_diagnosis.manoeuvre import Manoeuvre
from model_diagnosis.replay import RigReplay
from vehicle_model.tyres.formula_tyre import tyre_of
from vehicle_model.vehicle_file import VehicleFile, load_vehicle

SPEED, LOAD, LENGTH = 12.0, 3300.0, 0.4
FORCES = ("longitudinal_force_fl", "lateral_force_fl")


def rig_log(ratio: np.ndarray, angle: np.ndarray, load: float = LOAD) -> Manoeuvre:
    time = 0.01 * np.arange(len(ratio))
    channels = {
        "speed": np.full_like(time, SPEED),
        "slip_ratio_fl": ratio,
        "slip_angle_fl": angle,
        "vertical_load_fl": np.full_like(time, load),
        **{name: np.zeros_like(time) for name in FORCES},
    }
    return Manoeuvre("rig", time, channels, {name: np.ones_like(time) for name in channels}, "made for a test")


def with_length(name: str, length: float) -> VehicleFile:
    """A car whose front tyre has a relaxation length [m]."""
    vehicle = load_vehicle(name)
    for tyre in (vehicle.tyre_pair.front, vehicle.tyre_pair.rear):
        tyre.relaxation_length_lateral = tyre.relaxation_length_longitudinal = length
    return vehicle


@pytest.mark.parametrize("name", ["ekf_car", "asphalt_car"])
@pytest.mark.parametrize(("ratio", "angle"), [(-0.05, 0.0), (-0.3, 0.0), (0.0, 0.05), (0.0, -0.12), (-0.06, 0.07)])
def test_at_steady_slip_the_forces_are_those_of_the_plants_tyre(name: str, ratio: float, angle: float) -> None:
    vehicle = load_vehicle(name)
    replay = RigReplay(vehicle, [rig_log(np.full(200, ratio), np.full(200, angle))])
    forces = replay.predict(np.zeros(len(replay.columns)), 0)[-1]
    exact = tyre_of(vehicle.tyre_pair.front, "front").forces(ratio, angle, 0.0, LOAD, speed=15.0, check=False)
    assert forces == pytest.approx([exact.fx, exact.fy], abs=max(replay.tyre_error[0], 1e-3) * LOAD)


def test_a_step_of_the_slip_angle_relaxes_along_the_way() -> None:
    angle = np.where(np.arange(200) < 50, 0.0, 1e-4)
    replay = RigReplay(with_length("ekf_car", LENGTH), [rig_log(np.zeros(200), angle)])
    side = replay.predict(np.zeros(len(replay.columns)), 0)[:, 1]
    # between samples the slip is on a straight line: the step is one of 10 ms about its middle
    way = SPEED * 0.01 * (np.arange(52, 120) - 49.5)
    assert side[52:120] / side[-1] == pytest.approx(1.0 - np.exp(-way / LENGTH), abs=3e-3)


def test_a_longer_relaxation_length_is_the_vehicles_own() -> None:
    """The deviation and the file with that length give the same forces."""
    course = 0.05 * np.sin(0.2 * np.arange(300))
    log = rig_log(np.zeros(300), course)
    replay = RigReplay(with_length("ekf_car", 0.2), [log])
    theta = np.zeros(len(replay.columns))
    theta[replay.columns.index("tyre_relaxation_length.length")] = 0.2
    longer = RigReplay(with_length("ekf_car", 0.4), [log])
    assert replay.predict(theta, 0) == pytest.approx(longer.predict(np.zeros(len(theta)), 0), abs=1e-6)


def test_a_lag_and_offsets_of_the_load_cells() -> None:
    course = 0.05 * np.sin(0.1 * np.arange(300))
    replay = RigReplay(load_vehicle("ekf_car"), [rig_log(np.zeros(300), course)])
    theta = np.zeros(len(replay.columns))
    at_once = replay.predict(theta, 0)
    theta[replay.columns.index("form_rig_forces.lag")] = 0.01
    theta[replay.columns.index("form_rig_forces.offset_across")] = 7.0
    theta[replay.columns.index("form_rig_forces.rolling")] = -0.02
    late = replay.predict(theta, 0)
    assert late[1:, 1] == pytest.approx(at_once[:-1, 1] + 7.0)
    assert late[1:, 0] == pytest.approx(at_once[1:, 0] - 0.02 * LOAD)


def test_nothing_counts_while_the_tyre_remembers_what_was_not_measured() -> None:
    log = rig_log(np.zeros(400), np.zeros(400))
    log.weights["slip_angle_fl"][100:150] = 0.0
    weights = RigReplay(load_vehicle("ekf_car"), [log]).weights()[0][:, 1]
    assert not weights[:20].any()
    assert not weights[100:170].any()
    assert weights[20:100].all()
    assert weights[170:].all()


def test_sensitivities_are_the_slopes_of_the_prediction() -> None:
    course = 0.06 * np.sin(0.07 * np.arange(200))
    replay = RigReplay(load_vehicle("ekf_car"), [rig_log(-np.abs(course), course)])
    theta = np.zeros(len(replay.columns))
    column = replay.columns.index("tyre_friction.front")
    slope = replay.sensitivities(theta, [column])[0][:, :, 0]
    theta[column] = 1e-4
    there = replay.predict(theta, 0)
    theta[column] = -1e-4
    central = (there - replay.predict(theta, 0)) / 2e-4
    assert slope == pytest.approx(central, abs=2.0)
