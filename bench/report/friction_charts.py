"""Charts of friction: what the road offers, what is used, what the estimators make of it."""

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from bench.report.brake_charts import coloured
from bench.report.charts import Area, Chart, ChartBook, LineChart, Series, State, Strip
from bench.report.motion_charts import deviation_area
from bench.report.run_data import FloatArray, RunData

_AXLES = (("front", ("fl", "fr")), ("rear", ("rl", "rr")))
_ESTIMATE_COLOURS = ("fl", "fr", "rr", "second")
_SPLIT = 0.02
_LEAST_TOP, _ROOM_ABOVE_ROAD = 0.6, 1.5
_CONFIDENT = State("confident", "rebuild")


def friction_charts(run: RunData, book: ChartBook) -> list[Chart | None]:
    """One chart for each axle."""
    return [_axle_chart(run, book, axle, wheels) for axle, wheels in _AXLES]


def _axle_chart(run: RunData, book: ChartBook, axle: str, wheels: tuple[str, str]) -> Chart | None:
    limits = [run.array(f"friction_limit_{wheel}") for wheel in wheels if run.has(f"friction_limit_{wheel}")]
    if len(limits) != len(wheels):
        return None
    series = [_used(run, book, axle, wheels)] if run.has(*(f"friction_used_{wheel}" for wheel in wheels)) else []
    areas: list[Area] = []
    strips: list[Strip] = []
    for estimator, colour in zip(_estimators(run, axle), _ESTIMATE_COLOURS, strict=False):
        estimate = f"{estimator}.friction_limit_{axle}"
        running = _running(run, estimator)
        name = book.add_signal(estimate, run.time, np.where(running, run.array(estimate), np.nan))
        series.append(Series(f"estimate {estimator}", name, colour))
        if run.has(f"{estimate}_std"):
            areas.append(deviation_area(book, run, estimate, f"{estimate}_std", running, colour))
        if run.has(f"{estimate}_confidence"):
            sure = (run.array(f"{estimate}_confidence") > 0.5) & running
            strips.append(Strip("sure", coloured(run.time, sure.astype(np.float64), {1: _CONFIDENT}), colour))
    series += _truth(run, book, axle, wheels, limits)
    return LineChart(
        f"friction-{axle}", f"Friction, {axle} axle", "1", series, areas=areas, strips=strips, height=200,
        states=[_CONFIDENT] if strips else [], range=(0.0, friction_top(limits)),
        explanation="Area: ± one standard deviation. Sure: enough is used to tell the limit." if areas else "",
    )  # fmt: skip


def friction_top(limits: Sequence[FloatArray]) -> float:
    """Upper end of the friction axis: an estimate that is not sure yet must not set the scale."""
    return max(_LEAST_TOP, _ROOM_ABOVE_ROAD * max((float(np.nanmax(limit)) for limit in limits), default=1.0))


def _estimators(run: RunData, axle: str) -> list[str]:
    ending = f".friction_limit_{axle}"
    names = run.signals.names if run.signals is not None else ()
    return [name.removesuffix(ending) for name in names if name.endswith(ending)]


def _running(run: RunData, estimator: str) -> NDArray[np.bool_]:
    if run.has(f"{estimator}.active"):
        return run.array(f"{estimator}.active") > 0.5
    return np.ones(len(run.time), np.bool_)


def _used(run: RunData, book: ChartBook, axle: str, wheels: tuple[str, str]) -> Series:
    moving = run.array("speed") > 0.3 if run.has("speed") else np.ones(len(run.time), np.bool_)
    used = np.mean([np.abs(run.array(f"friction_used_{wheel}")) for wheel in wheels], axis=0)
    name = book.add_signal(f"friction_used_{axle}", run.time, np.where(moving, used, np.nan))
    return Series("used", name, "other", "thin")


def _truth(run: RunData, book: ChartBook, axle: str, wheels: tuple[str, str], limits: list[FloatArray]) -> list[Series]:
    left, right = limits
    mean = book.add_signal(f"friction_limit_{axle}", run.time, 0.5 * (left + right))
    series = []
    if float(np.nanmax(np.abs(left - right))) > _SPLIT:
        for wheel, values in zip(wheels, limits, strict=True):
            name = book.add_signal(f"friction_limit_{wheel}", run.time, values)
            series.append(Series(f"road at {wheel.upper()}", name, wheel, "thin", dashed=True))
    series.append(Series("road", mean, "reference", dashed=True))
    return series
