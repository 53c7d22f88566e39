"""The unscented friction filter meets the figures of the EKF and agrees with an independent library."""

import friction_twin as twin
import numpy as np
import pytest
from filterpy.kalman import MerweScaledSigmaPoints, UnscentedKalmanFilter
from friction_figures import Estimate, stop

import estimators
from estimators.friction_settings import initial_deviations, measurement_deviations, process_deviations
from estimators.friction_setup import friction_tuning
from estimators.friction_ukf import measure_point, step_point

WHEELS = ("fl", "fr", "rl", "rr")
each_path = pytest.mark.parametrize("path", ["ideal", "bus"])


@each_path
@pytest.mark.parametrize("points", ["unscented", "cubature"])
@pytest.mark.parametrize("name", ["E6", "E7", "E8", "E9"])
def test_braking_figures(name, points, path):
    """A5 to A10 of the friction document, 4.8."""
    truth = stop(name)
    estimate = Estimate(truth, path=path, estimator="friction_ukf", points=points)
    assert estimate["active"][estimate.phase].all()
    assert estimate.rmse("speed", truth.speed) <= 0.05
    for axle in ("front", "rear"):
        assert estimate.rmse(f"slip_{axle}", getattr(truth, f"slip_{axle}")) <= 0.02
        assert estimate.rmse(f"friction_used_{axle}", getattr(truth, f"used_{axle}")) <= 0.05
        limit = float(getattr(truth, f"limit_{axle}")[estimate.phase].mean())
        assert estimate.mean(f"friction_limit_{axle}") == pytest.approx(limit, rel=0.05)


@each_path
@pytest.mark.parametrize("name", ["E6", "E7", "E8", "E9", "E10"])
def test_without_torques(name, path):
    truth = stop(name)
    estimate = Estimate(truth, path=path, estimator="friction_ukf", torque_mode="z2")
    assert estimate.mean_limit_ratio() == pytest.approx(1.0, abs=0.05)
    assert estimate.rmse("speed", truth.speed) <= 0.3


@each_path
def test_a_jump_of_the_road_is_followed(path):
    truth = stop("E10")
    estimate = Estimate(truth, path=path, estimator="friction_ukf")
    jump = truth.brake_onset() + 1500
    for axle in ("front", "rear"):
        assert estimate.settling_time(f"friction_limit_{axle}", getattr(truth, f"limit_{axle}"), jump, 0.1) <= 0.3


def test_step_equals_filterpy():
    """500 steps into a stop with the same sigma points, drawn anew before the correction."""
    truth = stop("E8")
    columns = twin.measured(truth, actual_torque=True)
    estimator = estimators.create("friction_ukf", twin.TABLE_8, {"brake_torque": "actual"})
    settings = estimator.settings
    tuning = friction_tuning(twin.TABLE_8, settings, 0.001)
    torques = np.zeros(4)

    def f(x, dt):
        moved = x.copy()
        step_point(moved, torques, dt, tuning)
        return moved

    def h(x):
        output = np.zeros(8)
        measure_point(x, tuning, output)
        return output

    points = MerweScaledSigmaPoints(9, alpha=settings.alpha, beta=settings.beta, kappa=settings.kappa)
    reference = UnscentedKalmanFilter(9, 8, 0.001, h, f, points)
    reference.Q = np.diag(np.square(process_deviations(settings)))
    reference.R = np.diag(np.square(measurement_deviations(settings)))
    reference.P = np.diag(np.square(initial_deviations(settings)))
    estimator.replay({name: values[:1] for name, values in columns.items()})
    reference.x = estimator.state.copy()
    for k in range(1, 500):
        estimator.replay({name: values[k : k + 1] for name, values in columns.items()})
        torques[:2] = columns["drive_torque_f"][k], columns["drive_torque_r"][k]
        before = reference.x[0]
        wheels = [0.5 * sum(columns[f"wheel_speed_{w}"][k] for w in axle) for axle in (WHEELS[:2], WHEELS[2:])]
        a = columns["longitudinal_acceleration"][k]
        reference.predict()
        reference.update(np.array([a, *wheels, 0.0, 0.0, 1.0, 1.0, before + 0.001 * a]))
        assert (np.abs(estimator.state - reference.x) / np.maximum(np.abs(reference.x), 1.0)).max() < 1e-9
        assert np.abs(estimator.covariance - reference.P).max() < 1e-9
