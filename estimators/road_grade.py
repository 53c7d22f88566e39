"""Grade observer on the wheels' sliding-mode observers (3.6)."""

from estimators.vehicle_state_observer import StateObserver
from estimators.vehicle_state_outputs import GRADE_OUTPUTS


class RoadGrade(StateObserver):
    """Grade observer on the wheels' sliding-mode observers (3.6).

    Build it with :func:`estimators.create`.
    """

    estimator_name = "road_grade"
    written = GRADE_OUTPUTS
    longitudinal = True
    grade = True
