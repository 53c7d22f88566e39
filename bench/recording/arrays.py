"""A run as arrays: what verdicts, reports and replays read, whether it comes from memory or from a file."""

import hashlib
from collections.abc import Mapping, Sequence
from itertools import pairwise
from typing import Any

import numpy as np
from numpy.typing import NDArray

from signals.catalogue import Signal

FloatArray = NDArray[np.float64]


class RunArrays:
    """Signals of one run on one time base.

    Parameters
    ----------
    time : ndarray, shape (n,)
        Time of each row, in s, strictly rising.
    columns : mapping of str to ndarray, shape (n,)
        Signals in SI units.
    units : mapping of str to str
        Unit of each signal.
    phase_names : sequence of str
        Steps of the manoeuvre; the signal ``manoeuvre_phase`` holds their index.
    timing : mapping, optional
        Timing block of the run, as in ``verdict.json``.
    information : mapping, optional
        What else is known of the run: scenario, seed, versions.
    """

    def __init__(
        self,
        time: FloatArray,
        columns: Mapping[str, FloatArray],
        units: Mapping[str, str],
        *,
        phase_names: Sequence[str] = (),
        timing: Mapping[str, Any] | None = None,
        information: Mapping[str, Any] | None = None,
    ) -> None:
        self.time = np.ascontiguousarray(time, np.float64)
        self._columns = dict(columns)
        self.units = dict(units)
        self.phase_names = tuple(phase_names)
        self.timing: dict[str, Any] = dict(timing or {})
        self.information: dict[str, Any] = dict(information or {})

    @classmethod
    def from_matrix(
        cls,
        matrix: FloatArray,
        signals: Sequence[Signal],
        *,
        phase_names: Sequence[str] = (),
        timing: Mapping[str, Any] | None = None,
        information: Mapping[str, Any] | None = None,
    ) -> "RunArrays":
        """Run from rows of a signal vector, shape (n, signals); columns are copied when first asked for."""
        columns = {signal.name: matrix[:, position] for position, signal in enumerate(signals)}
        units = {signal.name: signal.unit for signal in signals}
        return cls(columns["time"], columns, units, phase_names=phase_names, timing=timing, information=information)

    @property
    def names(self) -> tuple[str, ...]:
        """Signals of the run."""
        return tuple(self._columns)

    def __contains__(self, name: object) -> bool:
        return name in self._columns

    def __len__(self) -> int:
        return len(self.time)

    def array(self, name: str) -> FloatArray:
        """Values of a signal, shape (n,), contiguous.

        Raises
        ------
        KeyError
            If the run has no such signal.
        """
        column = self._columns[name]
        if not column.flags.c_contiguous:
            column = self._columns[name] = np.ascontiguousarray(column, np.float64)
        return column

    def wheels(self, name: str) -> FloatArray:
        """Values of a signal at the four wheels, shape (n, 4)."""
        return np.column_stack([self.array(f"{name}_{wheel}") for wheel in ("fl", "fr", "rl", "rr")])

    def digest(self) -> str:
        """SHA-256 over names and values: equal for two runs exactly if every signal is equal bit for bit."""
        whole = hashlib.sha256(self.time.tobytes())
        for name in self.names:
            whole.update(name.encode())
            whole.update(self.array(name).tobytes())
        return whole.hexdigest()

    def steps(self) -> dict[str, slice]:
        """Rows of each step of the manoeuvre that occurred (its first visit)."""
        if "manoeuvre_phase" not in self or len(self) == 0:
            return {}
        index = self.array("manoeuvre_phase")
        starts = np.concatenate(([0], np.flatnonzero(np.diff(index)) + 1, [len(index)]))
        found: dict[str, slice] = {}
        for begin, end in pairwise(starts.tolist()):
            step = int(index[begin])
            if 0 <= step < len(self.phase_names):
                found.setdefault(self.phase_names[step], slice(begin, end))
        return found
