"""Effects of the replay against the same effects in the plant: the extension of a found effect is that effect."""

import numpy as np
import pytest
from plant_log import Course, brake_in_turn, coast_and_drive, drive, pulsed_stop, sine_steer

from model_diagnosis.effects.catalogue import effect
from model_diagnosis.extension.car_change import change_of
from model_diagnosis.replay import Replay
from vehicle_model.vehicle_file import VehicleFile

_COMPARED = ("wheel_speed_", "longitudinal_acceleration", "lateral_acceleration", "yaw_rate", "speed")


@pytest.fixture(scope="module")
def lagging_car(car: VehicleFile) -> VehicleFile:
    """The car with tyres that lag, so that their relaxation can be changed."""
    changed = car.model_copy(deep=True)
    for tyre in (changed.tyre_pair.front, changed.tyre_pair.rear):
        tyre.relaxation_length_longitudinal, tyre.relaxation_length_lateral = 0.25, 0.35
    return changed


def _whitened(replay: Replay, theta: np.ndarray) -> np.ndarray:
    """Residuals of the signals above over their sensors' noise, in one vector."""
    signals = replay.signals(0)
    chosen = [k for k, name in enumerate(signals) if name.startswith(_COMPARED)]
    noise = np.array([replay.sensor_std(signals[k]) for k in chosen])
    return (replay.residuals(theta)[0][:, chosen] / noise).ravel()


# Size: about half of an effect's width. The best factor on the replay's deviation has to be 1 within 10 %, 15 % for
# those that act on the body's motion, whose form differs most.
@pytest.mark.parametrize(
    ("name", "parameter", "size", "course", "speed", "tolerance"),
    [
        ("tyre_friction", "front", 0.1, pulsed_stop, 28.0, 0.1),
        ("tyre_longitudinal_stiffness", "factor", 0.12, pulsed_stop, 28.0, 0.1),
        ("tyre_cornering_stiffness", "rear", 0.09, sine_steer, 25.0, 0.1),
        ("tyre_load_sensitivity", "loss", 0.05, pulsed_stop, 28.0, 0.1),
        ("tyre_relaxation_length", "length", 0.09, pulsed_stop, 28.0, 0.1),
        ("tyre_peak_shape", "peak_slip", 0.12, pulsed_stop, 28.0, 0.1),
        ("tyre_ageing_pressure", "pressure", 0.08, coast_and_drive, 25.0, 0.1),
        ("brake_pad_speed", "exponent", 0.06, brake_in_turn, 20.0, 0.1),
        ("brake_in_stop_rise", "rise", 0.06, pulsed_stop, 28.0, 0.1),
        ("brake_balance", "shift", 0.05, pulsed_stop, 28.0, 0.1),
        ("caliper_lag", "time_constant", 0.015, pulsed_stop, 28.0, 0.1),
        ("spring_rate", "front", 0.12, pulsed_stop, 28.0, 0.15),
        ("anti_roll_bar", "front", 0.2, sine_steer, 25.0, 0.15),
        ("anti_dive_anti_lift", "front", 0.05, pulsed_stop, 28.0, 0.15),
        ("anti_dive_anti_lift", "rear", 0.15, coast_and_drive, 25.0, 0.15),
        ("roll_centre_height", "front", 0.05, sine_steer, 25.0, 0.15),
        ("mass_change", "factor", 0.1, coast_and_drive, 25.0, 0.1),
        ("cg_height_change", "factor", 0.1, pulsed_stop, 28.0, 0.15),
        ("yaw_inertia", "factor", 0.12, sine_steer, 25.0, 0.15),
        ("aero_drag", "factor", 0.2, coast_and_drive, 25.0, 0.1),
        ("driveline_drag", "constant", 9.0, coast_and_drive, 25.0, 0.1),
        ("differential_locking", "preload", 45.0, brake_in_turn, 20.0, 0.1),
        ("steering_ratio", "factor", 0.03, sine_steer, 25.0, 0.1),
        ("wheel_radius_load", "speed", 7e-7, coast_and_drive, 25.0, 0.1),
    ],
)
def test_replay_and_plant_mean_the_same_effect(
    lagging_car: VehicleFile, name: str, parameter: str, size: float, course: Course, speed: float, tolerance: float
) -> None:
    changed = lagging_car.model_copy(deep=True)
    change_of(changed, effect(name), {parameter: size}).apply(changed)
    before = Replay(lagging_car, [drive(lagging_car, course, 3.5, speed)])
    after = Replay(lagging_car, [drive(changed, course, 3.5, speed)])
    theta = np.zeros(len(after.columns))
    # the difference of the two drives is the effect alone, whatever the two models describe differently
    change = _whitened(after, theta) - _whitened(before, theta)
    theta[after.columns.index(f"{name}.{parameter}")] = size
    left = _whitened(after, theta) - _whitened(before, np.zeros(len(theta)))
    explained = change - left
    factor = float(change @ explained / (explained @ explained))
    assert np.linalg.norm(change) > 12.0  # in noises: the drive shows the effect
    assert factor == pytest.approx(1.0, abs=tolerance)
