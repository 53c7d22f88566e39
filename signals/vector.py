"""The signal vector of a run: one float64 per signal, blocks handed out as views."""

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from signals.catalogue import Signal, block_slice, catalogue


class SignalVector:
    """Current value of every signal.

    Parameters
    ----------
    extra : sequence of Signal
        Signals that only this run has (outputs of its estimators), appended to the catalogue.
    """

    def __init__(self, extra: Sequence[Signal] = ()) -> None:
        self.signals: tuple[Signal, ...] = (*catalogue(), *extra)
        self.names: tuple[str, ...] = tuple(signal.name for signal in self.signals)
        self.values: NDArray[np.float64] = np.zeros(len(self.signals))
        self._index = {name: position for position, name in enumerate(self.names)}
        if len(self._index) != len(self.names):
            raise ValueError("two signals of one run have the same name")

    def index(self, name: str) -> int:
        """Position of a signal; KeyError if this run has none of that name."""
        return self._index[name]

    def block(self, name: str) -> NDArray[np.float64]:
        """View of a block of the catalogue; what is written to it is in the vector."""
        return self.values[block_slice(name)]

    def __getitem__(self, name: str) -> float:
        return float(self.values[self._index[name]])
