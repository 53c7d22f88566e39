"""Predictive fit of the friction curves, lateral and longitudinal (3.4)."""

from estimators.vehicle_state_observer import StateObserver
from estimators.vehicle_state_outputs import FIT_OUTPUTS


class MagicFormulaFit(StateObserver):
    """Predictive fit of the friction curves, lateral and longitudinal (3.4).

    Build it with :func:`estimators.create`.
    """

    estimator_name = "magic_formula_fit"
    written = FIT_OUTPUTS
    lateral = True
    longitudinal = True
    fits = (True, True)
