"""Disturbance of single bits: where on the wires, when, what level, how long, how often."""

from collections.abc import Callable
from dataclasses import dataclass
from typing import Literal

import numpy as np
from numpy.typing import NDArray

from can_fault_injector import bus_kernel as kernel
from can_fault_injector import node_state as ns

TAPS = ("bus", "transmit", "receive")
ACTIONS = ("flip", "dominant", "recessive")
ENDLESS = -1
_ROUNDING = 1e-9


@dataclass(frozen=True)
class Disturbance:
    """Force or flip bits on the bus, or on one node's transmit or receive line.

    Parameters
    ----------
    action : str
        "flip", "dominant" or "recessive".
    at : str or int
        Bit by field and number, ``crc.14``, ``stuff.0``, ``eof.6``, ``error_delimiter.1``, ``intermission.2``,
        ``bit.25`` (counted from SOF); or the number of a bit since the bus began. Numbers count from 0 in the order of
        transmission.
    tap : str
        "bus" reaches all nodes, "transmit" what a node puts on the bus, "receive" what a node sees.
    node : str, optional
        Node of a transmit or receive tap; all nodes if left out.
    reference : str, optional
        Node whose count of the bits is meant; by default the sender of the frame.
    identifier, mask : int, optional
        Only in frames whose identifier equals this one in the bits of the mask (all by default).
    skip, repeat : int
        Matches to let pass before the first one, and matches to disturb (-1: all).
    length : int [bit]
        Duration.
    begin, width : float [bit]
        A pulse within each of these bits, from ``begin`` on: only nodes whose sample point lies in it see it. Width 1
        (the whole bit) by default.
    from_time_s : float [s]
        Counted from the call of ``Bus.disturb``; a place is looked for from then on.

    Raises
    ------
    ValueError
        With what was found and what is allowed.
    """

    action: Literal["flip", "dominant", "recessive"]
    at: str | int
    tap: Literal["bus", "transmit", "receive"] = "bus"
    node: str | None = None
    reference: str | None = None
    identifier: int | None = None
    mask: int = 0x1FFFFFFF
    skip: int = 0
    repeat: int = 1
    length: int = 1
    from_time_s: float = 0.0
    begin: float = 0.0
    width: float = 1.0

    def __post_init__(self) -> None:
        if self.action not in ACTIONS:
            raise ValueError(f"action: found {self.action!r}, allowed: {', '.join(ACTIONS)}")
        if self.tap not in TAPS:
            raise ValueError(f"tap: found {self.tap!r}, allowed: {', '.join(TAPS)}")
        if self.tap == "bus" and self.node is not None:
            raise ValueError(f"node: found {self.node!r} with tap 'bus', which has no node")
        if self.length < 1 or self.skip < 0 or self.repeat < ENDLESS or self.repeat == 0:
            raise ValueError("length, skip and repeat: allowed are length >= 1, skip >= 0, repeat >= 1 or -1 (all)")
        if not (0.0 <= self.begin < 1.0 and self.width > 0.0 and self.begin + self.width <= 1.0 + _ROUNDING):
            raise ValueError(
                f"begin and width: found {self.begin:g} and {self.width:g}, allowed: a pulse inside the bit, 0 to 1"
            )
        if isinstance(self.at, str):
            self.place()

    @property
    def trigger_bit(self) -> int | None:
        """Bit of the bus at which it begins, if it was given as a number."""
        return self.at if isinstance(self.at, int) else None

    def place(self) -> tuple[int, int]:
        """Codes of the field and the number in it."""
        name, _, number = str(self.at).partition(".")
        if name not in ns.PLACES or not (number or "0").isdecimal():
            raise ValueError(f"at: found {self.at!r}, allowed: a bit number or FIELD.N, FIELD {', '.join(ns.PLACES)}")
        return ns.PLACES[name], int(number or 0)

    def row(self, index: Callable[[str], int]) -> NDArray[np.int64]:
        """Columns of the compiled loop; ``index`` gives the number of a node."""
        row = np.zeros(kernel.DISTURBANCE_COLUMNS, np.int64)
        row[kernel.D_TAP], row[kernel.D_ACTION] = TAPS.index(self.tap), ACTIONS.index(self.action)
        row[kernel.D_NODE] = -1 if self.node is None else index(self.node)
        row[kernel.D_REFERENCE] = -1 if self.reference is None else index(self.reference)
        if self.trigger_bit is None:
            row[kernel.D_TRIGGER] = kernel.AT_PLACE
            row[kernel.D_PLACE], row[kernel.D_NUMBER] = self.place()
        if self.identifier is not None:
            row[kernel.D_IDENTIFIER], row[kernel.D_MASK] = self.identifier, self.mask
        if self.width < 1.0:
            row[kernel.D_BEGIN] = round(self.begin * kernel.WHOLE_BIT)
            row[kernel.D_END] = round((self.begin + self.width) * kernel.WHOLE_BIT)
        row[kernel.D_SKIP], row[kernel.D_REPEAT], row[kernel.D_LENGTH] = self.skip, self.repeat, self.length
        return row
