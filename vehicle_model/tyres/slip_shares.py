"""Rolling and travelling speed as shares of the faster of the two, from slip S5 and the direction of travel."""

from numba import njit

SMALLEST_SHARE = 0.02
"""Share below which a slip that refers to the slower speed grows no further."""


@njit(cache=True)
def shares(slip_x: float, direction: float) -> tuple[float, float]:
    """Rolling and travelling speed over the faster one.

    Parameters
    ----------
    slip_x
        Slip S5 of the plant: sliding of the tread over the faster speed, driving forwards positive.
    direction
        1 when the wheel travels forwards, -1 backwards.

    Returns
    -------
    rolling, travelling
        One of them is 1, the other at least 0; ``travelling`` at least ``SMALLEST_SHARE``, since speeds and slips are
        divided by it.
    """
    slower = 1.0 - abs(slip_x)
    if slip_x * direction > 0.0:
        return 1.0, max(slower, SMALLEST_SHARE)
    return max(slower, 0.0), 1.0


@njit(cache=True)
def faded_trail(trail: float, wanted: float, capacity: float) -> float:
    """Pneumatic trail that falls linearly to zero where a brush slides fully: at three times its friction.

    Parameters
    ----------
    trail : m
        At small slip.
    wanted : N
        Force that the tyre would have without limit of friction.
    capacity : N
        Friction times load.
    """
    return trail * max(1.0 - wanted / (3.0 * max(capacity, 1e-9)), 0.0)
