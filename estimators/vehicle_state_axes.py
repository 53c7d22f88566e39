"""The one place where the vehicle-state document's axes and wheel order meet those of the bench.

The document (0.3): x forward, y to the **right**, z down; wheel ij with axle i and side j, 1 right and 2 left, so that
its order is FR, FL, RR, RL; yaw rate positive to the right, pitch positive nose up, slip referred to the speed of the
wheel centre. The bench: ISO 8855, y to the left, z up; order FL, FR, RL, RR; slip referred to the larger speed. The
slip angle has the same sign in both: the document's positive one gives a force to the right, which is ISO's negative.
"""

from numba import njit

BENCH_INDEX = (1, 0, 3, 2)
"""Wheel of the bench for each of the document's, and the other way round: the exchange is its own inverse."""


@njit(cache=True)
def mirrored(value: float) -> float:
    """A quantity along y, about z or about x (lateral speed, acceleration and force, yaw rate, steering, roll)."""
    return -value


@njit(cache=True)
def bench_slip(slip: float) -> float:
    """The catalogue's slip (R w - v)/max(R w, v) of the document's (R w - v)/v."""
    return slip / (1.0 + slip) if slip > 0.0 else slip


@njit(cache=True)
def document_slip(slip: float) -> float:
    """The document's slip (R w - v)/v of the catalogue's, below 1."""
    return slip / (1.0 - slip) if slip > 0.0 else slip
