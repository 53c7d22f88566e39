"""The clock of a measured speed that no longitudinal acceleration is there for.

Against the acceleration, its slope, correlation tells a speed's delay to some milliseconds; against the wheels, whose
slip leads it, to a tenth of a second. Then the innovations of a car that was fitted without the speed tell it.
"""

from collections.abc import Sequence

import numpy as np

from model_diagnosis.data.clock_search import COARSE, FINE, FittedCar, has_speed, without
from model_diagnosis.data.delay_checks import (
    NAMED_S,
    NAMED_STDS,
    Late,
    candidates,
    fitted_delays,
    lag_relations,
    set_right,
)
from model_diagnosis.data.geometry import Geometry
from model_diagnosis.data.replayed import ReplayFactory
from model_diagnosis.manoeuvre import Manoeuvre
from vehicle_model.vehicle_file import VehicleFile

_SPEED, _SLOPE = "speed", "longitudinal_acceleration"
_UNSURE_S = 0.03
"""Standard deviation of what the lags tell from which the innovations are asked: by the slope it is 0.006 to 0.01 s, by
the wheels' slip alone 0.03 to 0.13."""
_WIDE = np.arange(-40, 41, 8)
"""Shifts [samples] around what the lags tell: 2.5 standard deviations of 0.13 s, and one step more."""


def check_unsure_clock(
    manoeuvres: Sequence[Manoeuvre], geometry: Geometry, vehicle: VehicleFile, replay: ReplayFactory
) -> tuple[list[Late], list[Manoeuvre]]:
    """The speed's delay where lags leave it unsure, and the manoeuvres so shifted; none where it cannot be told."""
    channels = [set(m.channels) for m in manoeuvres]
    if any(_SLOPE in names or _SPEED not in names or not has_speed(names - {_SPEED}) for names in channels):
        return [], list(manoeuvres)
    relations = lag_relations(manoeuvres, geometry)
    speeds = [late for late in candidates(manoeuvres) if late.groups == {_SPEED}]
    if not speeds or not any(_SPEED in (one.late, one.early) for one in relations):
        return [], list(manoeuvres)
    (late,) = fitted_delays(relations, speeds[-1:])
    if late.std_s < _UNSURE_S:
        return [], list(manoeuvres)
    car = FittedCar.to([without(m, (_SPEED,)) for m in manoeuvres], vehicle, replay)
    found = car.searched(late, manoeuvres, _WIDE, COARSE, FINE)
    if found is None or abs(found.delay_s) < max(NAMED_S, NAMED_STDS * found.std_s):
        return [], list(manoeuvres)
    return [found], [set_right(m, found.channels, found.delay_s) for m in manoeuvres]
