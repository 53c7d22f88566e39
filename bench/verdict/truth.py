"""Signals of the simulated car that an estimate is compared with, as the estimators' descriptions name them."""

from functools import lru_cache


@lru_cache(maxsize=256)
def truth_signals(estimate: str) -> tuple[str, ...]:
    """Signals whose mean is the true value of ``<estimator>.<output>``; empty if there is none.

    The front slip of an axle filter is compared with the mean of the two front wheels' slip.
    """
    from estimators import describe
    from signals.errors import InputError

    name, _, _ = estimate.partition(".")
    try:
        references = describe(name).references()
    except InputError:
        return ()
    return references.get(estimate, ())
