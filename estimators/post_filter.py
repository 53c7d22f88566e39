"""Post-filters for estimates that jump while the ABS works (Enisz 2015, l. 1487): low-pass or running median."""

from numba import njit

from estimators.kalman.covariance import FloatArray

NO_FILTER, LOW_PASS, MEDIAN = 0, 1, 2

# a post-filter's memory: [filled, next, value], then the window in time order, then the window in order of size
FILLED, NEXT, FILTERED, WINDOW = range(4)


def memory_size(window: int) -> int:
    """Entries of the memory of a post-filter with a median over ``window`` samples."""
    return WINDOW + 2 * window


@njit(cache=True)
def forget(memory: FloatArray) -> None:
    """Start anew: the next sample is taken over as it is."""
    memory[FILLED] = 0.0
    memory[NEXT] = 0.0


@njit(cache=True)
def post_filter(memory: FloatArray, kind: int, weight: float, sample: float) -> float:
    """Next filtered value.

    Parameters
    ----------
    memory : array
        Length ``memory_size(window)``.
    kind : int
        ``NO_FILTER``, ``LOW_PASS`` or ``MEDIAN``.
    weight : float
        Share of the new sample in the first-order low-pass, time step over time constant.
    sample : float
        New value.
    """
    if kind == NO_FILTER:
        return sample
    if kind == LOW_PASS:
        if memory[FILLED] == 0.0:
            memory[FILLED] = 1.0
            memory[FILTERED] = sample
        memory[FILTERED] += weight * (sample - memory[FILTERED])
        return memory[FILTERED]
    window = (memory.shape[0] - WINDOW) // 2
    return _running_median(memory, memory[WINDOW : WINDOW + window], memory[WINDOW + window :], sample)


@njit(cache=True)
def _running_median(memory: FloatArray, by_time: FloatArray, by_size: FloatArray, sample: float) -> float:
    filled, position = int(memory[FILLED]), int(memory[NEXT])
    if filled == by_time.shape[0]:
        oldest = by_time[position]
        hole = 0
        while by_size[hole] != oldest:
            hole += 1
        filled -= 1
        for i in range(hole, filled):
            by_size[i] = by_size[i + 1]
    place = filled
    while place > 0 and by_size[place - 1] > sample:
        by_size[place] = by_size[place - 1]
        place -= 1
    by_size[place] = sample
    by_time[position] = sample
    filled += 1
    memory[FILLED] = filled
    memory[NEXT] = (position + 1) % by_time.shape[0]
    middle = filled // 2
    if filled % 2 == 1:
        return by_size[middle]
    return 0.5 * (by_size[middle - 1] + by_size[middle])
