"""Signals of the simulated car that an estimate is compared with, as the estimators' descriptions name them."""

from dataclasses import dataclass
from functools import lru_cache


@dataclass(frozen=True)
class Truth:
    """True value of an estimate: mean of signals, weighted by others if there are any, or their sum, by a divisor.

    The front slip of an axle filter is compared with the mean of the two front wheels' slip, the friction limit of the
    whole car with the mean of the wheels' limits weighted by their loads, an axle's force with the sum of its wheels',
    an axle's side friction with that sum over the sum of the loads.
    """

    signals: tuple[str, ...]
    weights: tuple[str, ...]
    total: bool = False
    over: tuple[str, ...] = ()
    sign: float = 1.0


@lru_cache(maxsize=256)
def truth_of(estimate: str) -> Truth | None:
    """What ``<estimator>.<output>`` is compared with; None if the simulated car has no true value of it."""
    from bench.scenario.estimator_names import kind_of
    from estimators import describe
    from signals.errors import InputError

    name, _, output_name = estimate.partition(".")
    try:
        compared = describe(kind_of(name)).compared()
    except InputError:
        return None
    for output in compared:
        if output.name == output_name:
            return Truth(output.references, output.weights, output.total, output.over, output.sign)
    return None
