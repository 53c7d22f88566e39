"""What an estimator is called, reads, writes and can be told, without importing any compiled code."""

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

from signals.catalogue import Signal
from signals.quantities import FileModel

_DISPLAY = {"m/s": ("km/h", 3.6), "rad": ("deg", 57.29577951308232)}


@dataclass(frozen=True)
class Output:
    """One estimated quantity.

    Attributes
    ----------
    name, unit, description
        Name without the estimator's prefix, SI unit, one line of explanation.
    references : tuple of str
        Signals of the simulated car whose mean is the true value; empty where there is none. The estimator never sees
        them: reports and criteria compare with them.
    weights : tuple of str
        Signals of the simulated car that weight this mean, one for each reference; empty for a plain mean.
    total : bool
        True where the true value is the sum of the references instead.
    over : tuple of str
        Signals of the simulated car whose sum divides it, as side forces by loads; empty for no divisor.
    sign : float
        -1 where the estimate counts the other way than the signals.
    """

    name: str
    unit: str
    description: str
    references: tuple[str, ...] = ()
    weights: tuple[str, ...] = ()
    total: bool = False
    over: tuple[str, ...] = ()
    sign: float = 1.0


@dataclass(frozen=True)
class Description:
    """An entry of the registry.

    Attributes
    ----------
    name, group, summary, source
        Name in files and on the command line, family of estimators that are compared with each other, one line of
        explanation, document and section that define it.
    settings : type of FileModel
        Keys that a scenario or ``--set`` may give, validated.
    inputs : callable
        Catalogue names of the decoded signals that it reads, given its settings.
    outputs : tuple of Output
        What it writes, in this order.
    implementation : str
        ``module:function`` that builds it; imported only when it is built.
    """

    name: str
    group: str
    summary: str
    source: str
    settings: type[FileModel]
    inputs: Callable[[Any], tuple[str, ...]]
    outputs: tuple[Output, ...]
    implementation: str

    def signals(self) -> tuple[Signal, ...]:
        """Outputs as entries for the signal vector of a run, named ``<estimator>.<output>``."""
        return tuple(
            Signal(
                f"{self.name}.{output.name}",
                output.unit,
                output.description,
                "estimators",
                *_DISPLAY.get(output.unit, (output.unit, 1.0)),
            )
            for output in self.outputs
        )

    def compared(self) -> tuple[Output, ...]:
        """Outputs that the simulated car has a true value of: the mean, weighted mean or sum of ``references``."""
        return tuple(output for output in self.outputs if output.references)


def with_deviation(
    name: str,
    unit: str,
    description: str,
    references: tuple[str, ...] = (),
    weights: tuple[str, ...] = (),
    *,
    total: bool = False,
) -> tuple[Output, Output]:
    """An output and its standard deviation beside it."""
    return (
        Output(name, unit, description, references, weights, total),
        Output(f"{name}_std", unit, f"standard deviation: {description}"),
    )
