"""The four observers in a chain, from production sensors only (1.4, 3.7)."""

from estimators.vehicle_state_observer import StateObserver
from estimators.vehicle_state_outputs import CASCADE_OUTPUTS


class ObserverCascade(StateObserver):
    """The four observers in a chain, from production sensors only (1.4, 3.7).

    Build it with :func:`estimators.create`.
    """

    estimator_name = "observer_cascade"
    written = CASCADE_OUTPUTS
    lateral = True
    longitudinal = True
    fits = (True, True)
    grade = True
