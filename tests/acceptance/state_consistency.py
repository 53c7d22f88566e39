"""NEES and NIS of the lateral filter in the dry slalom: reported, since its measurements are made of its own state."""

import numpy as np
from state_runs import NOISE, drive

import estimators
from estimators.channels import CHANNELS
from estimators.kalman.consistency import Consistency, chi_square_band, normalised_estimation_error

RUNS = 60
TURNING_IN = 10_370
"""Tick of a step of the filter with the steering wheel near its largest angle, where every wheel has its row."""
ROWS = 5
"""Rows of the measurement in use: the yaw rate, and slope or limit of each wheel."""


def lateral_filter() -> tuple[Consistency, Consistency]:
    """NEES of lateral speed and yaw rate, and NIS, over 60 seeds of the sensors' noise, one value per run."""
    run = drive("state/slalom_dry_asphalt")
    truth = -np.array([run[name][TURNING_IN - 1] for name in ("lateral_speed", "true_yaw_rate")])  # y to the right
    nees, nis = [], []
    for seed in range(RUNS):
        estimator = estimators.create("vehicle_state_ukf", run.vehicle)
        columns = run.columns(estimator.inputs, seed, NOISE)
        ages = {CHANNELS[name].age for name in columns}
        out = estimator.replay(
            {name: values[:TURNING_IN] for name, values in columns.items()},
            {name: run[name][:TURNING_IN] for name in ages},
        )[-1]
        assert estimator._memory.rows.sum() == ROWS
        nees.append(normalised_estimation_error(truth - estimator.state[:2], estimator.covariance[:2, :2]))
        nis.append(out[[signal.name for signal in estimator.outputs].index("vehicle_state_ukf.innovation")])
    return chi_square_band(nees, 2), chi_square_band(nis, ROWS)
