"""Encoded frames as arrays that the compiled bus reads."""

from dataclasses import replace

import numpy as np

from can_fault_injector import fields as f
from can_fault_injector.frame import Frame

_FIRST_SIZE = 16


class FrameTable:
    """Bits of frames, one row each.

    Attributes
    ----------
    bits, codes : uint8 arrays (rows, MAX_BITS), numbers : int16 array
        Levels, field codes and numbers in the field.
    passive_rows, extended, identifiers : int64 arrays (rows)
        Row to send instead when the sender is error passive (ESI recessive in CAN FD), format, identifier.
    """

    def __init__(self) -> None:
        self._rows = 0
        self.bits = np.ones((_FIRST_SIZE, f.MAX_BITS), np.uint8)
        self.codes = np.zeros((_FIRST_SIZE, f.MAX_BITS), np.uint8)
        self.numbers = np.zeros((_FIRST_SIZE, f.MAX_BITS), np.int16)
        self.passive_rows = np.zeros(_FIRST_SIZE, np.int64)
        self.extended = np.zeros(_FIRST_SIZE, np.int64)
        self.identifiers = np.zeros(_FIRST_SIZE, np.int64)
        self._known: dict[Frame, int] = {}

    def add(self, frame: Frame) -> int:
        """Row of a frame; equal frames share one."""
        if frame in self._known:
            return self._known[frame]
        row = self._add(frame)
        if frame.fd and not frame.error_state_indicator:
            self.passive_rows[row] = self.add(replace(frame, error_state_indicator=True))
        return row

    def _add(self, frame: Frame) -> int:
        if self._rows == self.bits.shape[0]:
            self._double()
        row = self._rows
        bits, codes, numbers = frame.encoded()
        self.bits[row, : bits.size], self.codes[row, : bits.size] = bits, codes
        self.numbers[row, : bits.size] = numbers
        self.passive_rows[row], self.extended[row], self.identifiers[row] = row, frame.extended, frame.identifier
        self._rows += 1
        self._known[frame] = row
        return row

    def _double(self) -> None:
        self.bits = np.concatenate([self.bits, np.ones_like(self.bits)])
        self.codes = np.concatenate([self.codes, np.zeros_like(self.codes)])
        self.numbers = np.concatenate([self.numbers, np.zeros_like(self.numbers)])
        self.passive_rows = np.concatenate([self.passive_rows, np.zeros_like(self.passive_rows)])
        self.extended = np.concatenate([self.extended, np.zeros_like(self.extended)])
        self.identifiers = np.concatenate([self.identifiers, np.zeros_like(self.identifiers)])
