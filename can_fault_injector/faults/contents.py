"""What the injector is told of the contents of frames; it knows no database, whoever has one passes this in."""

from collections.abc import Mapping
from typing import Protocol

from can_fault_injector.frame import Frame
from can_fault_injector.places import SignalBits


class Contents(Protocol):
    """Signals and protection of the messages on the bus; an unknown frame has none of either."""

    def decode(self, frame: Frame) -> Mapping[str, float]:
        """Signals in a frame by their catalogue names, SI."""

    def changed(self, frame: Frame, values: Mapping[str, float]) -> Frame:
        """The frame with other values of some of its signals, everything else as it was."""

    def counter(self, frame: Frame) -> int | None:
        """Alive counter, None without protection."""

    def protected(self, frame: Frame, counter: int | None = None) -> Frame:
        """The frame with its checksum made anew, and with another alive counter if one is given."""

    def signal_bits(self, frame: Frame) -> SignalBits | None:
        """Where the bits of its signals lie in the data field."""


class NoContents:
    """A bus of unknown messages."""

    def decode(self, frame: Frame) -> Mapping[str, float]:
        """None known."""
        return {}

    def changed(self, frame: Frame, values: Mapping[str, float]) -> Frame:
        """Nothing known, nothing changed."""
        return frame

    def counter(self, frame: Frame) -> int | None:
        """No protection known."""
        return None

    def protected(self, frame: Frame, counter: int | None = None) -> Frame:
        """No protection known."""
        return frame

    def signal_bits(self, frame: Frame) -> SignalBits | None:
        """No layout known."""
        return None
