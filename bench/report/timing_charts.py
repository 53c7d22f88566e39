"""Charts of the loop's timing: how late ticks began and what they cost."""

import math
from collections.abc import Mapping
from typing import Any

import numpy as np

from bench.report.charts import Chart, ChartBook, Histogram, LineChart, Marker, Series
from bench.report.formatting import number
from bench.report.run_data import FloatArray, RunData

BINS_PER_DECADE = 8
MICROSECONDS = 1e6
PERIOD_US = 1000.0


def histogram(
    id: str, title: str, values_us: FloatArray, percentiles: Mapping[str, Any], explanation: str
) -> Chart | None:
    """Histogram of durations in µs with logarithmic bins; what is below the first edge is counted in the first bin."""
    values = values_us[np.isfinite(values_us)]
    if len(values) == 0 or not np.any(values > 0.0):
        return None
    low = 10.0 ** math.floor(math.log10(max(0.1, float(np.percentile(values, 0.5)))))
    high = 10.0 ** math.ceil(math.log10(max(float(values.max()), 10.0 * low, 1.05 * PERIOD_US)))
    bins = round(BINS_PER_DECADE * math.log10(high / low))
    edges = np.geomspace(low, high, bins + 1)
    counts, _ = np.histogram(np.clip(values, low, high), edges)
    markers = [
        Marker(min(max(float(percentiles[key]), low), high), label, f"{number(float(percentiles[key]), 3)} µs")
        for key, label in (("p50", "p50"), ("p99", "p99"), ("p999", "p99.9"), ("max", "max"))
        if isinstance(percentiles.get(key), (int, float))
    ]
    markers.append(Marker(PERIOD_US, "period", "1 ms", limit=True))
    return Histogram(
        id, title, "µs", [float(edge) for edge in edges], [int(count) for count in counts], markers,
        explanation=explanation,
    )  # fmt: skip


def lateness_histogram(run: RunData) -> Chart | None:
    """How long after its deadline each tick began; only real time has deadlines."""
    if not run.real_time or not run.has("lateness"):
        return None
    values = run.array("lateness") * MICROSECONDS
    return histogram(
        "lateness", "Lateness of the ticks", values, _percentiles(run, "lateness_us", values),
        "How long after its deadline a tick began. Both axes are logarithmic.",
    )  # fmt: skip


def cpu_histogram(run: RunData) -> Chart | None:
    """Processor time of each tick."""
    if not run.has("tick_cpu_time"):
        return None
    values = run.array("tick_cpu_time") * MICROSECONDS
    return histogram(
        "cpu", "Processor time of a tick", values, _percentiles(run, "tick_cpu_us", values),
        "Plant, hydraulics, sensors, frames, estimators and recording of one millisecond.",
    )  # fmt: skip


def lateness_chart(run: RunData, book: ChartBook) -> Chart | None:
    """Lateness over the run: where in time a stall happened."""
    if not run.real_time or not run.has("lateness"):
        return None
    name = book.add_signal("lateness", run.time, run.array("lateness") * MICROSECONDS)
    return LineChart(
        "lateness-time", "Lateness over the run", "µs", [Series("start after the deadline", name, "reference", "thin")],
        smallest_span=50.0, height=150, wide=True,
    )  # fmt: skip


def _percentiles(run: RunData, key: str, values: FloatArray) -> Mapping[str, Any]:
    given = run.timing.get(key)
    if isinstance(given, dict):
        return given
    p50, p99, p999 = np.percentile(values, [50, 99, 99.9])
    return {"p50": float(p50), "p99": float(p99), "p999": float(p999), "max": float(values.max())}
