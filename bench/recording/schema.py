"""What a recording says about itself: the signals of a row, the manoeuvre's steps, where the run came from."""

import json
from collections.abc import Mapping, Sequence
from dataclasses import asdict, dataclass, field
from typing import Any

from signals.catalogue import Signal


@dataclass(frozen=True)
class RunSchema:
    """Layout of the rows of a run and what belongs to it.

    Attributes
    ----------
    signals : tuple of Signal
        In the order of the signal vector; the first column of a stored row is the tick.
    phase_names : tuple of str
        Steps of the manoeuvre; the signal ``manoeuvre_phase`` is an index into them.
    start_time_ns : int
        Origin of the frames' time stamps: 0 in virtual time, CLOCK_REALTIME at the start in real time.
    information : dict
        Plain data: scenario, seed, mode, versions, link.
    """

    signals: tuple[Signal, ...]
    phase_names: tuple[str, ...] = ()
    start_time_ns: int = 0
    information: dict[str, Any] = field(default_factory=dict)

    @classmethod
    def of(
        cls,
        signals: Sequence[Signal],
        *,
        phase_names: Sequence[str] = (),
        start_time_ns: int = 0,
        information: Mapping[str, Any] | None = None,
    ) -> "RunSchema":
        """Schema from any sequences."""
        return cls(tuple(signals), tuple(phase_names), start_time_ns, dict(information or {}))

    @property
    def names(self) -> tuple[str, ...]:
        """Names of the signals."""
        return tuple(signal.name for signal in self.signals)

    def to_json(self) -> str:
        """The schema as one line of JSON."""
        return json.dumps(asdict(self), separators=(",", ":"))

    @classmethod
    def from_json(cls, text: str | bytes) -> "RunSchema":
        """Schema from :meth:`to_json`."""
        content = json.loads(text)
        signals = tuple(Signal(**signal) for signal in content["signals"])
        return cls(signals, tuple(content["phase_names"]), content["start_time_ns"], content["information"])
