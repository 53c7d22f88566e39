"""Sweeps of a wheel on a rig in an order in which the first few already say the most different things."""

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from model_diagnosis.data.rig import LOAD, SET_SLIPS, rig_wheel
from model_diagnosis.manoeuvre import Manoeuvre

FloatArray = NDArray[np.float64]


def farthest_apart(manoeuvres: Sequence[Manoeuvre]) -> list[int]:
    """Numbers of all manoeuvres: first the one with the heaviest load, then always the one farthest from those before.

    A rig goes through its programme one load and one kind of slip at a time. Distances are those of median and spread
    of load and slips, each over its own standard deviation (Kennard and Stone 1969).
    """
    points = np.array([_point(manoeuvre) for manoeuvre in manoeuvres])
    spread = points.std(axis=0)
    scaled = points / np.where(spread > 0.0, spread, 1.0)
    order = [int(np.argmax(points[:, 0]))]
    nearest = np.linalg.norm(scaled - scaled[order[0]], axis=1)
    while len(order) < len(points):
        nearest[order] = -1.0
        order.append(int(np.argmax(nearest)))
        nearest = np.minimum(nearest, np.linalg.norm(scaled - scaled[order[-1]], axis=1))
    return order


def _point(manoeuvre: Manoeuvre) -> FloatArray:
    """Median of the load, then median and standard deviation of both slips, 0 where one is not set."""
    wheel = rig_wheel(manoeuvre.channels)
    nothing = np.zeros(manoeuvre.samples)
    load, *slips = (manoeuvre.channels.get(f"{kind}_{wheel}", nothing) for kind in (LOAD, *SET_SLIPS))
    return np.array([np.median(load), *(f(slip) for slip in slips for f in (np.median, np.std))])
