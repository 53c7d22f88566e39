"""First-order lag over a step of which the mean is known too; compiled."""

from numba import njit


@njit(cache=True, nogil=True, forceinline=True, error_model="numpy")
def followed(lagged: float, target: float, change: float, share: float) -> float:
    """Lagged value after a step in which its target changes; ``share`` of the way is made in the step's mean."""
    return lagged + min(2.0 * share, 1.0) * (target + max(share, 0.5) * change - lagged)


@njit(cache=True, nogil=True, forceinline=True, error_model="numpy")
def behind(lagged: float, mean: float, share: float) -> float:
    """Lagged value after a step of which the mean is known."""
    return lagged + min(2.0, 1.0 / share) * (mean - lagged)
