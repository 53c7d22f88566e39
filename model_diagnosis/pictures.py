"""Manoeuvres measured and replayed before and after, as the report draws them."""

import numpy as np
from numpy.typing import NDArray

from model_diagnosis.findings import ManoeuvreFindings
from model_diagnosis.replay import Replay, ReplayBase

FloatArray = NDArray[np.float64]

HORIZON_S = 1.0
"""Time after which the short free runs start again from what was measured (model discrepancy anchor, section 3.2)."""


def manoeuvre_findings(
    replay: ReplayBase, after: FloatArray, *, held_out: bool, free_runs: bool = True
) -> list[ManoeuvreFindings]:
    """Every manoeuvre of a replay with the vehicle as given and at the deviations ``after`` (p,)."""
    neutral = np.zeros(len(replay.columns))
    weights = replay.weights()
    restarts = free_runs and isinstance(replay, Replay)  # a wheel on a rig has no state to begin anew with
    found = []
    for number, manoeuvre in enumerate(replay.manoeuvres):
        signals = replay.signals(number)
        measured = np.stack([manoeuvre.channels[name] for name in signals], axis=1)
        found.append(
            ManoeuvreFindings(
                manoeuvre=manoeuvre,
                signals=signals,
                measured=measured,
                before=replay.predict(neutral, number),
                after=replay.predict(after, number),
                weights=weights[number],
                free_before=replay.free_run(neutral, number) if free_runs else None,
                free_after=replay.free_run(after, number) if free_runs else None,
                restarted_before=replay.free_run(neutral, number, HORIZON_S) if restarts else None,
                restarted_after=replay.free_run(after, number, HORIZON_S) if restarts else None,
                states=replay.states(after, number),
                held_out=held_out,
            )
        )
    return found
