"""All manoeuvres behind each other on one time axis, so that charts share range and cursor."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np

from model_diagnosis.findings import FloatArray, ManoeuvreFindings
from model_diagnosis.manoeuvre import SAMPLE_TIME_S

GAP_S = 0.5


@dataclass(frozen=True)
class Stretch:
    """Place of a manoeuvre on the axis: first row, one past the last row."""

    findings: ManoeuvreFindings
    begin: int
    end: int

    @property
    def start_s(self) -> float:
        """Time of its first sample on the axis [s]."""
        return self.begin * SAMPLE_TIME_S

    @property
    def end_s(self) -> float:
        """Time of its last sample on the axis [s]."""
        return (self.end - 1) * SAMPLE_TIME_S

    @property
    def name(self) -> str:
        """Name of the manoeuvre, with a remark where it took no part in the search."""
        return self.findings.manoeuvre.name.replace("_", " ") + (" (held out)" if self.findings.held_out else "")


class Timeline:
    """Manoeuvres one after the other with a pause between them.

    Parameters
    ----------
    manoeuvres : sequence of ManoeuvreFindings
    """

    def __init__(self, manoeuvres: Sequence[ManoeuvreFindings]) -> None:
        gap = round(GAP_S / SAMPLE_TIME_S)
        self.stretches: list[Stretch] = []
        row = 0
        for findings in manoeuvres:
            self.stretches.append(Stretch(findings, row, row + findings.manoeuvre.samples))
            row += findings.manoeuvre.samples + gap
        self.rows = max(row - gap, 2)
        self.time: FloatArray = SAMPLE_TIME_S * np.arange(self.rows, dtype=np.float64)

    @property
    def signals(self) -> list[str]:
        """Names of all compared signals, in the order in which they first appear."""
        return list(dict.fromkeys(name for stretch in self.stretches for name in stretch.findings.signals))

    def column(self, signal: str, array: Callable[[ManoeuvreFindings], FloatArray | None]) -> FloatArray | None:
        """Values of a signal on the axis (rows,), not a number in pauses; None where no manoeuvre has it.

        Parameters
        ----------
        signal : str
        array : callable
            Gives the (n, c) array of a manoeuvre, or None where it has none.
        """
        values = np.full(self.rows, np.nan)
        found = False
        for stretch in self.stretches:
            findings = stretch.findings
            if signal not in findings.signals or (whole := array(findings)) is None:
                continue
            values[stretch.begin : stretch.end] = whole[:, findings.signals.index(signal)]
            found = True
        return values if found else None
