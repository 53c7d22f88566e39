"""The step of the wheels' rotation is fine enough also where an ABS decides on valves by thresholds.

A single stop under ABS is no smooth function of the step: one release earlier or later moves it. So the mean over
seeds of the sensors' noise is what twice the sub-steps must leave where it is.
"""

from typing import Any

import numpy as np
import pytest

SEEDS = range(10)


@pytest.mark.parametrize("road", ["dry", pytest.param("ice_polished", marks=pytest.mark.nightly)])
def test_twice_the_sub_steps_move_the_mean_stop_by_less_than_a_percent(judged: Any, road: str) -> None:
    def stopping_distance(sub_steps: int, seed: int) -> float:
        run = judged(f"stops/{road}", sets={"plant_options.wheel_substeps": sub_steps}, seed=seed)
        assert (run.run.data.array("ecu_phase_fl") == 3).any(), "the ABS did nothing"
        return float(run.verdict.metrics["stopping_distance_m"])

    shipped, twice = (float(np.mean([stopping_distance(n, seed) for seed in SEEDS])) for n in (5, 10))
    assert twice == pytest.approx(shipped, rel=0.01)
    assert twice != shipped  # the option reached the plant
