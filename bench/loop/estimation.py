"""Estimators of a run, bound to the tap and to their place in the signal vector."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from typing import Any

from estimators.interface import Estimator
from estimators.registry import create
from signals.catalogue import Signal
from signals.vector import SignalVector


@dataclass(frozen=True)
class NamedEstimator:
    """An estimator under the name that the scenario gives it; two of one kind need two names."""

    name: str
    estimator: Estimator

    def signals(self) -> list[Signal]:
        """Outputs as signals of the run, ``<name>.<output>``."""
        return [
            replace(signal, name=f"{self.name}.{signal.name.partition('.')[2]}", block=f"estimator {self.name}")
            for signal in self.estimator.outputs
        ]


def create_estimators(
    requests: Mapping[str, tuple[str, Mapping[str, Any]]], vehicle: Mapping[str, float]
) -> list[NamedEstimator]:
    """Build the estimators of a scenario.

    Parameters
    ----------
    requests : mapping
        Name in the run to (kind, settings).
    vehicle : mapping
        Numbers of the nominal vehicle file: what an estimator may know of the car.
    """
    return [NamedEstimator(name, create(kind, vehicle, settings)) for name, (kind, settings) in requests.items()]


class EstimatorSlot:
    """One estimator with its views of the signal vector.

    Attributes
    ----------
    tick : callable
        Reads the tap, writes the outputs.
    """

    tick: Callable[[], Any]

    def __init__(self, named: NamedEstimator, vector: SignalVector) -> None:
        first = vector.index(named.signals()[0].name)
        outputs = vector.values[first : first + len(named.estimator.outputs)]
        # what is bound works on the estimator's memory without owning it
        self._estimator = named.estimator
        self.tick = self._estimator.bind(vector.block("bus"), vector.block("bus_age"), outputs)
