"""The one interface of all estimators.

An estimator ticks at its declared sample time. It reads views of the blocks "bus" (decoded signals) and "bus_age"
(their ages) of the signal vector and writes its outputs into a view of its own. Between frames it holds the last value;
what it does with late, wrong and lost inputs is told in :mod:`estimators.inputs`. It never writes a value that is not
finite.
"""

from abc import ABC, abstractmethod
from collections.abc import Callable, Mapping
from functools import partial
from typing import Any

import numpy as np
from numpy.typing import NDArray

from estimators.registry import describe
from signals.catalogue import Signal, block_slice, index_of

FloatArray = NDArray[np.float64]

_CHUNK = 4096
"""Rows of the blocks that a replay holds at a time."""


class Estimator(ABC):
    """Base of all estimators; build one with :func:`estimators.create`.

    Attributes
    ----------
    name : str
        Name in the registry, prefix of its outputs.
    inputs : tuple of str
        Catalogue names of the decoded signals that it reads.
    outputs : tuple of Signal
        What a tick writes, in this order.
    sample_time_s : float
        Time between two ticks [s].
    tick : callable
        ``tick(inputs, ages, out)``: ``inputs`` and ``ages`` have the layout of the blocks "bus" and "bus_age", ``out``
        the length of ``outputs``, all float64. Compiled, allocates nothing.
    """

    tick: Callable[[FloatArray, FloatArray, FloatArray], Any]

    def __init__(self, name: str, inputs: tuple[str, ...], sample_time_s: float) -> None:
        self.name = name
        self.description = describe(name)
        self.inputs = inputs
        self.outputs: tuple[Signal, ...] = self.description.signals()
        self.sample_time_s = sample_time_s

    @abstractmethod
    def reset(self) -> None:
        """Return to the state of a new estimator."""

    def bind(self, inputs: FloatArray, ages: FloatArray, out: FloatArray) -> Callable[[], Any]:
        """A tick on these arrays, which stay the same tick by tick; valid as long as the estimator is there."""
        return partial(self.tick, inputs, ages, out)

    def replay(self, columns: Mapping[str, FloatArray], ages: Mapping[str, FloatArray] | None = None) -> FloatArray:
        """Run over recorded signals, one sample per tick.

        Parameters
        ----------
        columns : mapping of str to array, shape (n,)
            Decoded signals by catalogue name; those that the estimator does not read are ignored.
        ages : mapping of str to array, shape (n,), optional
            Ages by catalogue name [s]; an age that is left out is 0, every sample is new then.

        Returns
        -------
        array, shape (n, len(outputs))

        Raises
        ------
        KeyError
            If an input is missing.
        """
        bus, bus_age = block_slice("bus"), block_slice("bus_age")
        length = len(columns[self.inputs[0]])
        inputs = np.zeros((min(length, _CHUNK), bus.stop - bus.start))
        input_ages = np.zeros((min(length, _CHUNK), bus_age.stop - bus_age.start))
        results = np.zeros((length, len(self.outputs)))
        for first in range(0, length, _CHUNK):
            last = min(first + _CHUNK, length)
            for name in self.inputs:
                inputs[: last - first, index_of(name) - bus.start] = columns[name][first:last]
            for name, values in (ages or {}).items():
                input_ages[: last - first, index_of(name) - bus_age.start] = values[first:last]
            self.tick_rows(inputs[: last - first], input_ages[: last - first], results[first:last])
        return results

    def tick_rows(self, inputs: FloatArray, ages: FloatArray, out: FloatArray) -> None:
        """Tick once for every row; an estimator that has its own loop compiles it."""
        for k in range(len(inputs)):
            self.tick(inputs[k], ages[k], out[k])
