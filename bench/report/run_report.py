"""``report.html`` of a run."""

import os
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from bench.recording.arrays import RunArrays
from bench.report import brake_charts, bus_charts, details, friction_charts, motion_charts, page_content, timing_charts
from bench.report.charts import ChartBook
from bench.report.criteria_table import tally
from bench.report.film_strip import strip_of
from bench.report.formatting import VERDICT_SYMBOLS
from bench.report.page_rendering import render as render_page
from bench.report.run_data import RunData
from bench.report.run_reading import load_run

_ICON_COLOURS = {"pass": "%2312713f", "fail": "%23b3132f", "inconclusive": "%23b07a00", "error": "%237a1fa2"}


def build(
    run_dir: str | Path,
    *,
    signals: RunArrays | None = None,
    frames: NDArray[np.void] | None = None,
    render: bool = False,
) -> Path:
    """Write ``report.html`` into a run's folder and return its path.

    Whatever the folder lacks is left out and said: the report of a run that broke off is made from what is there.

    Parameters
    ----------
    run_dir : path
        Folder of the run, or its name under ``runs/``.
    signals, frames : optional
        The recording, where the caller still has it in memory.
    render : bool
        Show the car as MuJoCo renders it, which takes some seconds; without it the strip is a drawing from above.

    Raises
    ------
    signals.errors.InputError
        If the folder does not exist or its files are not readable.
    """
    run = load_run(run_dir, signals=signals, frames=frames)
    path = run.folder / "report.html"
    partial = path.with_name(f".{path.name}.partial")
    partial.write_text(page_of(run, render=render), encoding="utf-8")
    os.replace(partial, path)
    return path


def page_of(run: RunData, *, render: bool = False) -> str:
    """The page of a run."""
    statistics = bus_charts.message_statistics(run)
    book = charts_of(run, statistics)
    steps = run.steps()
    criteria = page_content.criteria(run)
    strip = strip_of(run, render=render)
    contents: dict[str, Any] = {
        "title": f"{run.outcome}: {run.name}",
        "icon_colour": _ICON_COLOURS.get(run.outcome, _ICON_COLOURS["error"]),
        "run": run,
        "symbols": VERDICT_SYMBOLS,
        "description": run.title if run.title != run.name else "",
        "tally": tally(run.verdict),
        "facts": page_content.facts(run),
        "errors": run.verdict.get("errors") or [],
        "remarks": [*(run.verdict.get("remarks") or []), *run.remarks],
        "tiles": page_content.tiles(run),
        "strip": strip,
        "drawn": any(picture.startswith("<svg") for picture, _ in strip),
        "criteria": [entry for entry in criteria if not entry[0].informative],
        "figures": [(row.name, row.value, row.description) for row, _ in criteria if row.informative],
        "book": book,
        "ranges": time_ranges(run),
        "steps": details.step_table(run),
        "metrics": details.metric_pairs(run),
        "estimators": details.estimator_table(run),
        "messages": details.message_table(statistics),
        "percentiles": details.percentile_table(run),
        "timing": details.timing_pairs(run),
        "receivers": details.receiver_table(run),
        "faults": details.fault_table(run),
        "injector": details.injector_pairs(run),
        "parameters": details.parameter_table(run),
        "versions": _versions(run),
        "scenario_text": run.scenario_text,
        "files": page_content.files(run),
        "version": (run.verdict.get("versions") or {}).get("brake-control-bench", ""),
    }
    return render_page("report.html.j2", book.inline([step.inline() for step in steps]), contents)


def charts_of(run: RunData, statistics: list[bus_charts.MessageStatistics]) -> ChartBook:
    """Charts of a run, in the order of the page."""
    time = run.time
    if len(time) < 2:
        return ChartBook((0.0, 1.0))
    book = ChartBook((float(time[0]), float(time[-1])), run.focus())
    book.add_section(
        "Motion",
        [motion_charts.speed_chart(run, book), motion_charts.slip_chart(run, book)],
    )
    book.add_section(
        "Brakes and ECU",
        [
            brake_charts.phases_chart(run),
            *brake_charts.pressure_charts(run, book),
            brake_charts.driver_chart(run, book),
            brake_charts.accumulator_chart(run, book),
        ],
    )
    book.add_section("Friction", friction_charts.friction_charts(run, book))
    book.add_section(
        "Deceleration and course",
        [
            motion_charts.deceleration_chart(run, book),
            motion_charts.yaw_chart(run, book),
            motion_charts.steering_chart(run, book),
            motion_charts.lateral_chart(run, book),
        ],
    )
    book.add_section("Bus", [bus_charts.frames_chart(run, statistics), bus_charts.load_chart(run, book)])
    book.add_section(
        "Timing",
        [
            timing_charts.lateness_chart(run, book),
            timing_charts.lateness_histogram(run),
            timing_charts.cpu_histogram(run),
        ],
    )
    return book


def time_ranges(run: RunData) -> list[tuple[str, float, float]]:
    """Buttons of the toolbar: the whole run, the stop, each step."""
    time = run.time
    if len(time) < 2:
        return []
    ranges = [("whole run", float(time[0]), float(time[-1]))]
    focus = run.focus()
    if focus is not None:
        ranges.append(("stop", *focus))
    ranges += [(step.name, step.start_s, step.end_s) for step in run.steps()[:12] if step.end_s > step.start_s]
    return ranges


def _versions(run: RunData) -> list[tuple[str, str]]:
    return [("seed", str(run.verdict.get("seed", "–"))), *details.pairs(run.verdict.get("versions") or {})]
