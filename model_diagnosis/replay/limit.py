"""How near a drive comes to the limit of its tyres: below half of their friction their slope counts, not their peak."""

from collections.abc import Mapping

import numpy as np
from numpy.typing import NDArray
from scipy.ndimage import minimum_filter1d

from model_diagnosis.manoeuvre import SAMPLE_TIME_S
from model_diagnosis.replay.derived import GRAVITY
from signals.wheels import WHEELS

FloatArray = NDArray[np.float64]

NEAR_SHARE = 0.5
"""Of the friction, or of the slip at its peak. A brush tyre (Pacejka, 3.2) with a fifth less friction slips 8 % more
there for the same force; at a fifth of the friction 2 %, less than what its stiffness is uncertain by."""
_HELD_S = 0.1
"""Knocks of the road are shorter."""


def used_share(
    record: np.void, measured: Mapping[str, FloatArray], states: Mapping[str, FloatArray], moving: NDArray[np.bool_]
) -> float:
    """Largest share held for 0.1 s: of the friction by the acceleration, or of the slip at the peak by any wheel.

    Parameters
    ----------
    record : of the nominal car (``REPLAY_RECORD``)
    measured : channels (n,) of the manoeuvre; without accelerations the slips alone tell
    states : (n,) of the observer's replay; a rig has the slips of one wheel
    moving : (n,) where slips have a meaning
    """
    zero = np.zeros(len(moving))
    shares = [
        np.hypot(
            states.get(f"slip_ratio_{wheel}", zero) / record["peak_slip_x"][k],
            np.tan(states.get(f"slip_angle_{wheel}", zero)) / record["peak_slip_y"][k],
        )
        for k, wheel in enumerate(WHEELS)
    ]
    along, across = (
        measured.get(f"{name}_acceleration", zero) / (GRAVITY * np.mean(record["friction"] * record[peak]))
        for name, peak in (("longitudinal", "peak_x"), ("lateral", "peak_y"))
    )
    shares.append(np.hypot(along, across))
    samples = max(round(_HELD_S / SAMPLE_TIME_S), 1)
    known = np.where(moving, np.nan_to_num(np.array(shares)), 0.0)
    return float(minimum_filter1d(known, samples, axis=1).max(initial=0.0))
