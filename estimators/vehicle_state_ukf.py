"""Lateral filter of ten states with its friction curves (3.3, 3.4)."""

from estimators.vehicle_state_observer import StateObserver
from estimators.vehicle_state_outputs import LATERAL_OUTPUTS


class VehicleStateUkf(StateObserver):
    """Lateral filter of ten states with its friction curves (3.3, 3.4).

    Build it with :func:`estimators.create`.
    """

    estimator_name = "vehicle_state_ukf"
    written = LATERAL_OUTPUTS
    lateral = True
    fits = (True, False)
