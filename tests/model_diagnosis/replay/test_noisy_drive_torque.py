"""What acts while no torque drives is not switched by the noise of the torque's sensor."""

from dataclasses import replace

import numpy as np
import pytest
from plant_log import coast_and_drive, drive

from model_diagnosis.manoeuvre import Manoeuvre
from model_diagnosis.replay import Replay
from vehicle_model.vehicle_file import VehicleFile

NOISE_NM = 2.0


@pytest.fixture(scope="module")
def driven(car: VehicleFile) -> Manoeuvre:
    return drive(car, coast_and_drive, 8.0, 25.0, name="coast")


def _noisy(log: Manoeuvre) -> Manoeuvre:
    random = np.random.default_rng(11)
    noise = {name: NOISE_NM * random.standard_normal(log.samples) for name in ("drive_torque_f", "drive_torque_r")}
    return replace(log, channels=log.channels | {name: log.channels[name] + one for name, one in noise.items()})


def test_the_engines_drag_acts_as_without_noise(car: VehicleFile, driven: Manoeuvre) -> None:
    """60 N m slow the car by T / (m r), less what the wheels' inertia takes, in every sample alike: they differ by less
    than a twentieth of a series accelerometer's noise of 0.05 m/s^2."""
    deceleration = []
    for log in (driven, _noisy(driven)):
        replay = Replay(car, [log])
        theta = np.zeros(len(replay.columns))
        place = replay.signals(0).index("longitudinal_acceleration")
        nominal = replay.residuals(theta)[0][:, place]
        theta[replay.columns.index("engine_braking.torque")] = 60.0
        deceleration.append(replay.residuals(theta)[0][:, place] - nominal)
    plain, noisy = deceleration
    coasting = (driven.time > 0.5) & (driven.time < 1.8) | (driven.time > 5.5)
    force = 60.0 / (car.body.mass * car.wheels.rl.radius)
    assert np.median(plain[coasting]) == pytest.approx(force, rel=0.05)
    assert np.max(np.abs(noisy - plain)[coasting]) < 0.0025


def test_a_torque_that_drives_keeps_its_samples(car: VehicleFile, driven: Manoeuvre) -> None:
    """Between 2.5 and 4.5 s the car is driven with 1500 N m: nothing is taken off or smoothed there."""
    log = _noisy(driven)
    values = Replay(car, [log]).prepared[0].inputs.values
    driving = (log.time > 2.5) & (log.time < 4.5)
    assert np.array_equal(values[driving, 5], log.channels["drive_torque_r"][driving])
    assert np.all(values[driving, 4] == 0.0)  # the front axle is not driven: its sensor has nothing but noise
    coasting = log.time < 1.8
    assert np.all(values[coasting, 4:6] == 0.0)
