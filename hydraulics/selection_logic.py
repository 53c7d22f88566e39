"""Selection logic: which state and which target pressure a combination of valves and pump means.

The logic is data: a table over inlet valve, outlet valve, pump and active build-up. Another stability system is another
table; the pressure model stays as it is.
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from hydraulics.record import DECREASE, HOLD, INCREASE, INVALID

# what the pressure of a wheel approaches
TARGET_MASTER, TARGET_FROZEN, TARGET_LOW, TARGET_PUMP = range(4)


@dataclass(frozen=True)
class SelectionLogic:
    """Table of a hydraulic unit's valve logic.

    Attributes
    ----------
    name
        Name shown to people.
    table : int64, shape (2, 2, 2, 2, 2)
        Indexed by inlet energised (closed), outlet energised (open), pump on, active build-up; the last axis holds
        state (``INCREASE``, ``HOLD``, ``DECREASE``, ``INVALID``) and target (``TARGET_…``).
    """

    name: str
    table: NDArray[np.int64]

    def __post_init__(self) -> None:
        if self.table.shape != (2, 2, 2, 2, 2):
            raise ValueError(f"selection logic {self.name!r}: table has shape {self.table.shape}, not (2, 2, 2, 2, 2)")
        if not (np.all(self.table >= 0) and np.all(self.table <= 3)):
            raise ValueError(f"selection logic {self.name!r}: states and targets are numbers 0 to 3")


def abs_logic() -> SelectionLogic:
    """Conventional ABS with two valves per wheel (friction document 2.6.1).

    Inlet valve normally open, outlet valve normally closed. An open inlet with an open outlet is invalid.
    """
    table = np.zeros((2, 2, 2, 2, 2), np.int64)
    table[0, 0] = (INCREASE, TARGET_MASTER)
    table[1, 0] = (HOLD, TARGET_FROZEN)
    table[1, 1] = (DECREASE, TARGET_LOW)
    table[0, 1] = (INVALID, TARGET_FROZEN)
    return SelectionLogic("abs", table)


def esp_logic() -> SelectionLogic:
    """ESP unit: as ABS, but a running pump with active build-up fills open wheels up to the pump's pressure.

    Source: friction document 2.6.1, "pressure-raising pumps".
    """
    table = abs_logic().table.copy()
    table[0, 0, 1, 1] = (INCREASE, TARGET_PUMP)
    return SelectionLogic("esp", table)


LOGICS = {"abs": abs_logic, "esp": esp_logic}
