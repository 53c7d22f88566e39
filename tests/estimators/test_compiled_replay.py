"""A replay whose loop is compiled gives what single ticks give, bit for bit, over the borders of its chunks too."""

import numpy as np
import pytest

import estimators
from estimators import interface
from estimators.channels import CHANNELS
from estimators.interface import Estimator
from vehicle_model.vehicle_file import load_vehicle

ROWS = 700


@pytest.mark.parametrize("name", ["observer_cascade", "road_grade"])
def test_compiled_loop_equals_single_ticks(name: str, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(interface, "_CHUNK", 256)
    estimator = estimators.create(name, load_vehicle("lada_vesta_assumed_steering").numbers())
    random = np.random.default_rng(4)
    start = {"wheel_speed": 40.0, "engine_speed": 200.0, "gear": 2.0}
    columns = {}
    for signal in estimator.inputs:
        mean = next((value for prefix, value in start.items() if signal.startswith(prefix)), 0.0)
        columns[signal] = mean + (0.0 if mean == 2.0 else 0.05) * random.standard_normal(ROWS)
    ages = {CHANNELS[signal].age: 1e-3 * (np.arange(ROWS) % 10) for signal in estimator.inputs}
    compiled = estimator.replay(columns, ages)
    estimator.reset()
    monkeypatch.setattr(estimator, "tick_rows", lambda *rows: Estimator.tick_rows(estimator, *rows))
    assert np.ptp(compiled[:, :40], axis=0).max() > 0.0
    assert compiled.tobytes() == estimator.replay(columns, ages).tobytes()
