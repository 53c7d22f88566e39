"""Sliding-mode observers of the four wheels (3.5)."""

from estimators.vehicle_state_observer import StateObserver
from estimators.vehicle_state_outputs import LONGITUDINAL_OUTPUTS


class WheelSlidingMode(StateObserver):
    """Sliding-mode observers of the four wheels (3.5).

    Build it with :func:`estimators.create`.
    """

    estimator_name = "wheel_sliding_mode"
    written = LONGITUDINAL_OUTPUTS
    longitudinal = True
