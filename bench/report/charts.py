"""What the page's script can draw, as plain records: curves over time, lanes of states, histograms."""

from collections.abc import Sequence
from dataclasses import asdict, dataclass, field
from typing import Any

import numpy as np
from numpy.typing import NDArray

from bench.report.thinning import Thinned, thin_about

LaneSegment = tuple[float, float, str] | tuple[float, float, str, str]


@dataclass(frozen=True)
class Series:
    """One curve. ``colour`` is fl, fr, rl, rr, reference, second or other; ``weight`` is bold, thin or empty."""

    label: str
    signal: str
    colour: str
    weight: str = ""
    dashed: bool = False


@dataclass(frozen=True)
class Area:
    """Ground between two signals, for a deviation about a curve."""

    low: str
    high: str
    colour: str


@dataclass(frozen=True)
class State:
    """Name of a state and the colour class it is drawn in."""

    label: str
    colour: str


@dataclass(frozen=True)
class Strip:
    """Band of states under a line chart; ``colour`` is that of the curve it belongs to."""

    label: str
    segments: Sequence[LaneSegment]
    colour: str = ""


@dataclass(frozen=True)
class Limit:
    """Horizontal line with its text."""

    value: float
    label: str


@dataclass
class LineChart:
    """Curves over time."""

    id: str
    title: str
    unit: str
    series: list[Series]
    explanation: str = ""
    height: int = 190
    wide: bool = False
    areas: list[Area] = field(default_factory=list)
    strips: list[Strip] = field(default_factory=list)
    states: list[State] = field(default_factory=list)
    limits: list[Limit] = field(default_factory=list)
    range: tuple[float, float] | None = None
    include_zero: bool = True
    smallest_span: float = 0.0
    step_names: bool = False
    kind: str = "lines"


@dataclass(frozen=True)
class Lane:
    """One row of states; ``events`` are instants that must not be missed, ``empty`` is said where no state is."""

    label: str
    segments: Sequence[LaneSegment]
    short: str | None = None
    note: str | None = None
    empty: str | None = None
    events: Sequence[float] = ()


@dataclass
class LaneChart:
    """Rows of states over time."""

    id: str
    title: str
    lanes: list[Lane]
    states: list[State]
    explanation: str = ""
    unit: str = ""
    wide: bool = True
    notes: bool = False
    kind: str = "lanes"


@dataclass(frozen=True)
class Marker:
    """Vertical line in a histogram."""

    value: float
    label: str
    text: str
    limit: bool = False


@dataclass
class Histogram:
    """Counts between logarithmic edges."""

    id: str
    title: str
    unit: str
    edges: list[float]
    counts: list[int]
    markers: list[Marker]
    explanation: str = ""
    height: int = 150
    wide: bool = False
    kind: str = "histogram"


Chart = LineChart | LaneChart | Histogram


class ChartBook:
    """Charts of a page in sections, and the thinned signals that they share.

    Parameters
    ----------
    span : (float, float)
        Time range of the page, in s.
    focus : (float, float), optional
        Range that is shown first and drawn most finely.
    """

    def __init__(self, span: tuple[float, float], focus: tuple[float, float] | None = None) -> None:
        self.span = span
        self.focus = focus
        self.sections: list[tuple[str, list[Chart]]] = []
        self._signals: dict[str, list[Thinned]] = {}

    def add_signal(self, name: str, time: NDArray[np.float64], values: NDArray[np.float64]) -> str:
        """Keep a signal, in the unit that is shown, and return the name under which charts refer to it."""
        if name not in self._signals:
            self._signals[name] = thin_about(time, values, self.focus)
        return name

    def add_section(self, title: str, charts: Sequence[Chart | None]) -> None:
        """Append a section; charts that the run has no signals for are None, a section without charts is left out."""
        present = [chart for chart in charts if chart is not None]
        if present:
            self.sections.append((title, present))

    def charts(self) -> list[Chart]:
        """All charts in the order of the page."""
        return [chart for _, charts in self.sections for chart in charts]

    def inline(self, steps: Sequence[dict[str, Any]]) -> dict[str, Any]:
        """Data of the page's script."""
        return {
            "span": list(self.span),
            "focus": list(self.focus or self.span),
            "steps": list(steps),
            "signals": {name: [piece.inline() for piece in pieces] for name, pieces in self._signals.items()},
            "charts": [asdict(chart) for chart in self.charts()],
        }
