"""Charts of every compared signal: measured against replayed, and what is left over, beside the sensor's own noise."""

from collections.abc import Mapping

import numpy as np

from bench.diagnosis_report.timeline import Timeline
from bench.diagnosis_report.words import REPLAYS, shown, signal_words
from bench.report.charts import Area, Chart, ChartBook, LineChart, Series
from model_diagnosis.findings import Findings, FloatArray, ManoeuvreFindings
from signals.measured.channel_map import channel_units
from signals.wheels import WHEELS

NOISE_BAND_STDS = 2.0
BEFORE, AFTER, MEASURED = "fr", "fl", "reference"


def add_signal_charts(book: ChartBook, timeline: Timeline, findings: Findings) -> None:
    """A section of two charts for each signal, the one that improves most first."""
    extended = any(np.any(part.after != part.before) for part in findings.manoeuvres)
    for name in ranked_signals(timeline, findings.sensor_std):
        charts = [
            _curves(book, timeline, name, findings.sensor_std, extended),
            _residuals(book, timeline, name, findings, extended),
        ]
        book.add_section(signal_words(name).capitalize(), charts)


def ranked_signals(timeline: Timeline, sensor_std: Mapping[str, float]) -> list[str]:
    """Compared signals by their root mean squared residual over the sensor's noise, the largest first.

    One of each kind comes before a second one of the same kind: four wheels that tell the same are not four pictures.
    Signals no sample of which counts (`uncompared_signals`) are left out.
    """

    def misfit(name: str) -> float:
        residual = residual_of(timeline, name, after=False)
        return float(np.sqrt(np.nanmean(residual**2))) / max(sensor_std.get(name, 0.0), 1e-12)

    silent = uncompared_signals(timeline)
    ordered = sorted((name for name in timeline.signals if name not in silent), key=misfit, reverse=True)
    seen: dict[str, int] = {}
    turns = {}
    for name in ordered:
        turns[name] = seen[kind_of(name)] = seen.get(kind_of(name), 0) + 1
    return sorted(ordered, key=lambda name: turns[name])


def uncompared_signals(timeline: Timeline) -> list[str]:
    """Measured signals no sample of which counts: what drives them was not measured, or the car was too slow."""
    return [name for name in timeline.signals if not np.isfinite(residual_of(timeline, name, after=False)).any()]


def kind_of(signal: str) -> str:
    """Name of a signal without its wheel."""
    stem, _, wheel = signal.rpartition("_")
    return stem if wheel in WHEELS else signal


def residual_of(timeline: Timeline, name: str, *, after: bool) -> FloatArray:
    """Measured less replayed (observer replay) on the axis of all manoeuvres; not a number where the weight is 0."""

    def left_over(part: ManoeuvreFindings) -> FloatArray:
        replayed = part.after if after else part.before
        return np.where(part.weights > 0, part.measured - replayed, np.nan)

    residual = timeline.column(name, left_over)
    return np.full(timeline.rows, np.nan) if residual is None else residual


def _curves(
    book: ChartBook, timeline: Timeline, name: str, sensor_std: Mapping[str, float], extended: bool
) -> Chart | None:
    factor, unit = shown(name, channel_units().get(name, "1"))
    measured = timeline.column(name, lambda part: np.where(part.weights > 0, part.measured, np.nan))
    if measured is None:
        return None
    free = any(part.findings.free_before is not None for part in timeline.stretches)
    before = timeline.column(name, lambda part: part.free_before if part.free_before is not None else part.before)
    after = timeline.column(name, lambda part: part.free_after if part.free_after is not None else part.after)
    series = [_series(book, timeline, f"{name}.measured", measured, factor, "measured", MEASURED)]
    if before is not None:
        label = "vehicle file" if extended else "replay"
        series.append(_series(book, timeline, f"{name}.before", before, factor, label, BEFORE, dashed=True))
    if after is not None and extended:
        series.append(_series(book, timeline, f"{name}.after", after, factor, "with what was found", AFTER))
    restarted = timeline.column(name, lambda part: part.restarted_after if extended else part.restarted_before)
    if restarted is not None:
        label, colour = "restarted each second", AFTER if extended else BEFORE
        series.append(_series(book, timeline, f"{name}.restarted", restarted, factor, label, colour, weight="thin"))
    band = NOISE_BAND_STDS * sensor_std.get(name, 0.0)
    areas = [_band(book, timeline, f"{name}.measured", measured - band, measured + band, factor)] if band > 0 else []
    return LineChart(
        f"curve-{name}",
        "measured and replayed",
        unit,
        series,
        explanation=f"{'free run' if free else 'observer replay'}; grey: sensor ± 2 σ",
        height=210,
        areas=areas,
        include_zero=False,
        step_names=True,
        smallest_span=4 * band * factor,
    )


def _residuals(book: ChartBook, timeline: Timeline, name: str, findings: Findings, extended: bool) -> Chart | None:
    factor, unit = shown(name, channel_units().get(name, "1"))
    before, sensor_std = residual_of(timeline, name, after=False), findings.sensor_std
    series = [_series(book, timeline, f"{name}.residual_before", before, factor, "vehicle file", BEFORE, weight="thin")]
    if extended:
        after = residual_of(timeline, name, after=True)
        label = "with what was found"
        series.append(_series(book, timeline, f"{name}.residual_after", after, factor, label, AFTER, weight="thin"))
    band = NOISE_BAND_STDS * sensor_std.get(name, 0.0)
    areas = []
    if band > 0:
        inside = np.where(np.isfinite(before), band, np.nan)
        areas = [_band(book, timeline, f"{name}.noise", -inside, inside, factor)]
    return LineChart(
        f"residual-{name}",
        "measured less replayed",
        unit,
        series,
        explanation=f"{REPLAYS[findings.diagnosis.subject]}; grey: sensor ± 2 σ",
        height=210,
        areas=areas,
        smallest_span=4 * band * factor,
    )


def _series(
    book: ChartBook,
    timeline: Timeline,
    key: str,
    values: FloatArray,
    factor: float,
    label: str,
    colour: str,
    *,
    dashed: bool = False,
    weight: str = "",
) -> Series:
    return Series(label, book.add_signal(key, timeline.time, factor * values), colour, weight, dashed)


def _band(book: ChartBook, timeline: Timeline, key: str, low: FloatArray, high: FloatArray, factor: float) -> Area:
    lower = book.add_signal(f"{key}.low", timeline.time, factor * low)
    return Area(lower, book.add_signal(f"{key}.high", timeline.time, factor * high), "other")
