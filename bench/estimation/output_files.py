"""``estimates.parquet``, ``estimates.json`` and pictures of offline estimates."""

import json
from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from bench.estimation.offline import Comparison, OfflineEstimate, compare
from bench.report.plot_style import INK, SOFT, WHEEL_COLOURS, plot_style
from bench.report.thinning import thin
from bench.verdict.output_files import replace_file
from signals.errors import InputError

if TYPE_CHECKING:
    from matplotlib.axes import Axes

    from bench.recording.arrays import FloatArray, RunArrays

TABLE_FILE, SUMMARY_FILE, PICTURE_FILE = "estimates.parquet", "estimates.json", "estimates.png"
_SIDE_OUTPUTS = ("_std", "_confidence", "_filtered")
_STATE_OUTPUTS = ("active", "resets", "input_state", "innovation")
_MOST_CHARTS = 8
_WIDTH_INCH, _CHART_INCH, _RESOLUTION_DPI = 10.0, 1.7, 100


def write_estimates(folder: Path, data: "RunArrays", estimates: Sequence[OfflineEstimate]) -> list[dict[str, Any]]:
    """Write the files of each estimator: into the folder, or where there are several into one below it for each.

    Returns
    -------
    list of dict
        Contents of each ``estimates.json``.

    Raises
    ------
    InputError
        If the folder cannot be written.
    """
    summaries = []
    for estimate in estimates:
        place = folder if len(estimates) == 1 else folder / estimate.name
        comparisons = compare(data, estimate)
        content = summary(estimate, comparisons)
        try:
            place.mkdir(parents=True, exist_ok=True)
            _write_table(place / TABLE_FILE, estimate)
            replace_file(place / SUMMARY_FILE, (json.dumps(content, indent=2, allow_nan=False) + "\n").encode())
            draw(place / PICTURE_FILE, estimate, comparisons)
        except OSError as error:
            raise InputError(f"{place}: {(error.strerror or str(error)).lower()}") from None
        summaries.append(content)
    return summaries


def summary(estimate: OfflineEstimate, comparisons: dict[str, Comparison]) -> dict[str, Any]:
    """Contents of ``estimates.json``."""
    outputs: dict[str, dict[str, Any]] = {}
    for signal in estimate.outputs:
        name = signal.name.partition(".")[2]
        outputs[name] = {"unit": signal.unit}
        if name in comparisons:
            found = comparisons[name]
            outputs[name] |= {
                "rmse": found.rmse,
                "mean_error": found.mean_error,
                "reference": ", ".join(found.signals),
            }
            if found.rmse_confident is not None:
                outputs[name]["rmse_confident"] = found.rmse_confident
    return {
        "estimator": estimate.name,
        "kind": estimate.request.kind,
        "settings": dict(estimate.request.settings),
        "outputs": outputs,
        "step_time_us": estimate.step_time_us,
        "active_share": float(np.mean(estimate.running())),
    }


def _write_table(path: Path, estimate: OfflineEstimate) -> None:
    import pyarrow as pa
    import pyarrow.parquet as parquet

    columns = {"time": estimate.time}
    fields = [pa.field("time", pa.float64(), metadata={"unit": "s"})]
    for position, signal in enumerate(estimate.outputs):
        name = signal.name.partition(".")[2]
        columns[name] = np.ascontiguousarray(estimate.values[:, position])
        fields.append(pa.field(name, pa.float64(), metadata={"unit": signal.unit, "description": signal.description}))
    parquet.write_table(pa.table(columns, schema=pa.schema(fields)), path)


def shown_outputs(estimate: OfflineEstimate, comparisons: dict[str, Comparison]) -> list[str]:
    """Outputs worth a chart: those with a reference first, no deviations, no states."""
    names = [signal.name.partition(".")[2] for signal in estimate.outputs]
    plain = [name for name in names if not name.endswith(_SIDE_OUTPUTS) and name not in _STATE_OUTPUTS]
    return sorted(plain, key=lambda name: name not in comparisons)[:_MOST_CHARTS]


def draw(path: Path, estimate: OfflineEstimate, comparisons: dict[str, Comparison]) -> None:
    """Draw each shown output with two standard deviations and its reference."""
    import matplotlib

    matplotlib.use("agg")
    from matplotlib import pyplot

    names = shown_outputs(estimate, comparisons)
    with matplotlib.rc_context(plot_style()):
        figure, axes = pyplot.subplots(
            len(names), 1, sharex=True, squeeze=False, layout="constrained",
            figsize=(_WIDTH_INCH, 0.8 + _CHART_INCH * len(names)),
        )  # fmt: skip
        figure.suptitle(estimate.name, x=0.012, ha="left", fontsize=13, fontweight="bold", color=INK)
        for axis, name in zip(axes[:, 0], names, strict=True):
            _chart(axis, estimate, name, comparisons.get(name))
        axes[-1, 0].set_xlabel("time in s")
        figure.savefig(path, dpi=_RESOLUTION_DPI)
        pyplot.close(figure)


def _chart(axis: "Axes", estimate: OfflineEstimate, name: str, comparison: Comparison | None) -> None:
    signal = next(signal for signal in estimate.outputs if signal.name.partition(".")[2] == name)
    factor = signal.display_factor
    values = np.where(estimate.running(), estimate.output(name), np.nan) * factor
    time, colour = estimate.time, WHEEL_COLOURS["fl"]
    if estimate.has(f"{name}_std"):
        rows = slice(None, None, max(1, len(time) // 1500))
        width = 2.0 * factor * estimate.output(f"{name}_std")[rows]
        axis.fill_between(
            time[rows], values[rows] - width, values[rows] + width, color=colour, alpha=0.16, linewidth=0.0
        )
    if comparison is not None:
        _curve(axis, time, comparison.reference * factor, color=INK, linewidth=1.6, label="reference")
    sure = estimate.confident(name)
    if not sure.all():
        _curve(axis, time, values, color=colour, alpha=0.35, label="not confident")
    _curve(axis, time, np.where(sure, values, np.nan), color=colour, label="estimate")
    _limit_axis(axis, values, None if comparison is None else comparison.reference * factor)
    unit = "" if signal.display_unit == "1" else f"\nin {signal.display_unit}"
    axis.set_ylabel(name.replace("_", " ", 1).replace("_", "\n", 1).replace("_", " ") + unit, fontsize=7, color=SOFT)
    axis.legend(ncols=3, loc="lower right", bbox_to_anchor=(1.0, 0.98), borderaxespad=0.0)


def _curve(axis: "Axes", time: "FloatArray", values: "FloatArray", **options: Any) -> None:
    points = thin(time, values)
    axis.plot(points.times(), points.values, **options)


def _limit_axis(axis: "Axes", values: "FloatArray", reference: "FloatArray | None") -> None:
    """Let neither a short spike nor a wide deviation set the scale."""
    shown = values if reference is None else np.concatenate((values, reference))
    shown = shown[np.isfinite(shown)]
    if len(shown) == 0:
        return
    low, high = np.percentile(shown, (0.2, 99.8))
    room = 0.12 * (high - low) or 0.1 * max(abs(high), 1e-3)
    axis.set_ylim(float(low - room), float(high + room))
