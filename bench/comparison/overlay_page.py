"""One page with the signals of two runs drawn over each other, both counted from their brake start."""

import os
from pathlib import Path
from typing import Any

import numpy as np

from bench.comparison.compare import Comparison, figure_texts
from bench.report.brake_charts import BAR, WHEEL_WORDS
from bench.report.charts import Chart, ChartBook, LineChart, Series
from bench.report.formatting import VERDICT_SYMBOLS, quantity
from bench.report.motion_charts import DEGREES, FAST_M_S, KMH, STANDING_M_S
from bench.report.page_rendering import render
from bench.report.run_data import FloatArray, RunData
from signals.wheels import WHEELS

_COLOURS = ("fl", "fr")
BEFORE_BRAKE_S = 1.0


def build_page(comparison: Comparison, path: Path) -> Path:
    """Write the overlay page."""
    runs = (comparison.a, comparison.b)
    book = ChartBook(_span(runs))
    _Overlay(runs, book).add_all()
    span = book.span
    contents: dict[str, Any] = {
        "title": f"{comparison.a.folder.name} and {comparison.b.folder.name}",
        "icon_colour": "%231d4ed8",
        "runs": [("A", comparison.a), ("B", comparison.b)],
        "symbols": VERDICT_SYMBOLS,
        "settings": comparison.settings,
        "criteria": [
            {**entry, "shown": [quantity(entry[run]["value"], entry["unit"]) for run in ("a", "b")]}
            for entry in comparison.criteria
        ],
        "figures": [figure_texts(figure) for figure in comparison.figures],
        "book": book,
        "ranges": [("everything", *span), ("stop", 0.0, max(span[1], 0.1))],
        "aligned": all(run.brake_start_s() is not None for run in runs),
    }
    partial = path.with_name(f".{path.name}.partial")
    partial.write_text(render("comparison.html.j2", book.inline(_steps(span)), contents), encoding="utf-8")
    os.replace(partial, path)
    return path


def default_page(comparison: Comparison) -> Path:
    """Path of the page beside the first run's folder."""
    a, b = comparison.a.folder, comparison.b.folder
    return a.parent / f"compare-{a.name}-{b.name}.html"


def _origin(run: RunData) -> float:
    return run.brake_start_s() or 0.0


def _span(runs: tuple[RunData, RunData]) -> tuple[float, float]:
    """From a second before the earlier brake start to the end of the longer run, on the common time."""
    starts = [float(run.time[0]) - _origin(run) for run in runs if len(run.time)]
    ends = [float(run.time[-1]) - _origin(run) for run in runs if len(run.time)]
    if not starts:
        return 0.0, 1.0
    return max(min(starts), -BEFORE_BRAKE_S) if min(starts) < 0 else min(starts), max(ends)


def _steps(span: tuple[float, float]) -> list[dict[str, Any]]:
    return [{"name": "before", "start": span[0], "end": 0.0}, {"name": "brake start", "start": 0.0, "end": span[1]}]


class _Overlay:
    """Charts with a curve of each run."""

    def __init__(self, runs: tuple[RunData, RunData], book: ChartBook) -> None:
        self._runs = runs
        self._book = book

    def add_all(self) -> None:
        """Every chart for which a run has the signal."""
        self._book.add_section(
            "Motion",
            [
                self._chart("speed", "Speed", "km/h", "speed", KMH, wide=True, height=230, step_names=True),
                self._chart(
                    "deceleration", "Deceleration", "m/s²", "true_longitudinal_acceleration", -1.0, smallest=1.0
                ),
                self._chart("distance", "Distance since the brake start", "m", "distance", 1.0, from_origin=True),
            ],
        )  # fmt: skip
        self._book.add_section("Brake slip", [self._slip(wheel) for wheel in WHEELS])
        self._book.add_section(
            "Brake pressure",
            [
                self._chart(
                    f"pressure-{wheel}",
                    WHEEL_WORDS[wheel].capitalize(),
                    "bar",
                    f"true_brake_pressure_{wheel}",
                    BAR,
                    smallest=10.0,
                )
                for wheel in WHEELS
            ],
        )  # fmt: skip
        self._book.add_section("Estimated friction", [self._friction(axle) for axle in ("front", "rear")])
        self._book.add_section(
            "Course",
            [
                self._chart("yaw", "Yaw rate", "°/s", "true_yaw_rate", DEGREES, smallest=4.0),
                self._chart("lateral", "Place across the road", "m", "position_y", 1.0, smallest=0.4),
                self._chart("steering", "Steering wheel", "°", "driver_steering_wheel_angle", DEGREES, smallest=10.0),
            ],
        )  # fmt: skip

    def _chart(
        self,
        id: str,
        title: str,
        unit: str,
        signal: str,
        factor: float,
        *,
        smallest: float = 0.0,
        wide: bool = False,
        height: int = 170,
        step_names: bool = False,
        from_origin: bool = False,
    ) -> Chart | None:
        curves = [(run.array(signal) * factor if run.has(signal) else None) for run in self._runs]
        if from_origin:
            curves = [self._since_origin(run, curve) for run, curve in zip(self._runs, curves, strict=True)]
        series = self._series(id, curves)
        if not series:
            return None
        return LineChart(
            id, title, unit, series, smallest_span=smallest, wide=wide, height=height, step_names=step_names
        )

    def _series(self, id: str, curves: list[FloatArray | None]) -> list[Series]:
        found = []
        for letter, run, curve, colour in zip("AB", self._runs, curves, _COLOURS, strict=True):
            if curve is None:
                continue
            time = run.time - _origin(run)
            shown = time >= self._book.span[0]
            found.append(Series(letter, self._book.add_signal(f"{letter}.{id}", time[shown], curve[shown]), colour))
        return found

    @staticmethod
    def _since_origin(run: RunData, curve: FloatArray | None) -> FloatArray | None:
        if curve is None:
            return None
        row = int(np.searchsorted(run.time, _origin(run)))
        return np.where(run.time >= _origin(run), curve - curve[min(row, len(curve) - 1)], np.nan)

    def _slip(self, wheel: str) -> Chart | None:
        curves: list[FloatArray | None] = []
        highest = 20.0
        for run in self._runs:
            if not run.has(f"slip_ratio_{wheel}", "speed"):
                curves.append(None)
                continue
            slip, speed = -100.0 * run.array(f"slip_ratio_{wheel}"), run.array("speed")
            fast = slip[speed > FAST_M_S]
            highest = max(highest, 1.08 * float(fast.max())) if len(fast) else highest
            curves.append(np.where(speed > STANDING_M_S, slip, np.nan))
        series = self._series(f"slip-{wheel}", curves)
        if not series:
            return None
        return LineChart(
            f"slip-{wheel}", WHEEL_WORDS[wheel].capitalize(), "%", series, range=(-1.0, highest), height=150
        )

    def _friction(self, axle: str) -> Chart | None:
        curves: list[FloatArray | None] = []
        for run in self._runs:
            names = run.signals.names if run.signals is not None else ()
            name = next((n for n in names if n.endswith(f".friction_limit_{axle}")), None)
            curves.append(run.array(name) if name is not None else None)
        series = self._series(f"friction-{axle}", curves)
        if not series:
            return None
        return LineChart(f"friction-{axle}", f"{axle.capitalize()} axle", "1", series, smallest_span=0.2, height=150)
