"""``comparison.json``, a picture and a text of a comparison of surfaces."""

import json
import math
from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from bench.estimation.surfaces import EKF, SIMPLE, Difference, Stop, SurfaceComparison
from bench.report.plot_style import INK, SOFT, WHEEL_COLOURS, plot_style
from bench.verdict.output_files import replace_file
from signals.errors import InputError

if TYPE_CHECKING:
    from matplotlib.axes import Axes

SUMMARY_FILE, PICTURE_FILE = "comparison.json", "comparison.png"
_METHODS = {EKF: "friction EKF", SIMPLE: "simple model"}


def write_comparison(folder: Path, result: SurfaceComparison) -> None:
    """Write the files of a comparison.

    Raises
    ------
    InputError
        If the folder cannot be written.
    """
    try:
        folder.mkdir(parents=True, exist_ok=True)
        text = json.dumps(as_json(result), indent=2, allow_nan=False, ensure_ascii=False)
        replace_file(folder / SUMMARY_FILE, (text + "\n").encode())
        draw(folder / PICTURE_FILE, result)
    except OSError as error:
        raise InputError(f"{folder}: {(error.strerror or str(error)).lower()}") from None


def as_json(result: SurfaceComparison) -> dict[str, Any]:
    """Contents of ``comparison.json``."""
    return {
        "title": result.title,
        "verdict": result.verdict,
        "rules": [rule.as_json() for rule in result.rules],
        "surfaces": [_surface(name, stops) for name, stops in zip(result.names, result.stops, strict=True)],
        "target_speed_m_s": result.target_speed_m_s,
        "shortening": _finite(result.shortening.as_json()),
        "friction": {name: _finite(found.as_json()) for name, found in result.friction.items()},
    }


def _finite(entry: dict[str, Any]) -> dict[str, Any]:
    return {key: None if isinstance(value, float) and math.isinf(value) else value for key, value in entry.items()}


def _surface(name: str, stops: Sequence[Stop]) -> dict[str, Any]:
    distances = [stop.corrected_distance_m for stop in stops]
    return {
        "name": name,
        "runs": [vars(stop) for stop in stops],
        "distance_m": float(np.mean(distances)),
        "coefficient_of_variation": float(np.std(distances, ddof=1) / np.mean(distances)) if len(stops) > 1 else None,
        "friction": {method: float(np.mean([stop.friction[method] for stop in stops])) for method in _METHODS},
        "friction_deviation": {
            method: float(np.mean([stop.friction_deviation[method] for stop in stops])) for method in _METHODS
        },
    }


def text_of(result: SurfaceComparison) -> str:
    """The comparison for people."""
    lines = [result.title or "comparison of surfaces", ""]
    lines.append(f"{'surface':<24} {'runs':>4} {'distance':>10} {'variation':>9} {'friction EKF':>16} {'simple':>16}")
    for entry in (_surface(name, stops) for name, stops in zip(result.names, result.stops, strict=True)):
        variation = entry["coefficient_of_variation"]
        cells = [f"{entry['friction'][m]:.3f} ± {entry['friction_deviation'][m]:.3f}" for m in (EKF, SIMPLE)]
        shown = "-" if variation is None else f"{100 * variation:.2f} %"
        lines.append(
            f"{entry['name']:<24} {len(entry['runs']):>4} {entry['distance_m']:>8.2f} m {shown:>9} "
            f"{cells[0]:>16} {cells[1]:>16}"
        )
    lines += ["", f"distance from {3.6 * result.target_speed_m_s:.0f} km/h: {_percent(result.shortening, 'shorter')}"]
    lines += [f"{_METHODS[name]}: {_percent(found, 'more friction')}" for name, found in result.friction.items()]
    lines += ["", "rules:"]
    lines += [f"  {rule.number} {rule.verdict:<8} {rule.text} ({rule.found})" for rule in result.rules]
    return "\n".join([*lines, "", f"verdict: {result.verdict}"])


def _percent(found: Difference, word: str) -> str:
    interval = f"95 %: {100 * found.low:+.2f} ... {100 * found.high:+.2f} %"
    return f"{100 * found.value:+.2f} % {word} ({interval}){'' if found.reported else ', no difference'}"


def draw(path: Path, result: SurfaceComparison) -> None:
    """Draw corrected distances and friction, every run and the means."""
    import matplotlib

    matplotlib.use("agg")
    from matplotlib import pyplot

    with matplotlib.rc_context(plot_style()):
        figure, axes = pyplot.subplots(1, 3, figsize=(10.0, 3.8), layout="constrained")
        figure.suptitle(result.title, x=0.012, ha="left", fontsize=12, fontweight="bold", color=INK)
        _bars(axes[0], result, [[stop.corrected_distance_m for stop in stops] for stops in result.stops])
        axes[0].set_ylabel(f"distance from {3.6 * result.target_speed_m_s:.0f} km/h in m")
        for axis, method in zip(axes[1:], _METHODS, strict=True):
            _bars(axis, result, [[stop.friction[method] for stop in stops] for stops in result.stops])
            axis.set_ylabel(f"friction in use, {_METHODS[method]}")
        figure.savefig(path, dpi=110)
        pyplot.close(figure)


def _bars(axis: "Axes", result: SurfaceComparison, values: Sequence[Sequence[float]]) -> None:
    """Bars of the means from zero, each run as a point, the mean as a number above."""
    colours = (SOFT, WHEEL_COLOURS["fl"])
    for place, (runs, colour) in enumerate(zip(values, colours, strict=True)):
        mean = float(np.mean(runs))
        axis.bar(place, mean, width=0.62, color=colour, alpha=0.35)
        spots = place + np.linspace(-0.2, 0.2, len(runs)) if len(runs) > 1 else [place]
        axis.plot(spots, runs, "o", markersize=4, color=colour)
        axis.annotate(f"{mean:.3g}", (place, max(runs)), xytext=(0, 5), textcoords="offset points", ha="center")
    axis.set_xticks(range(len(values)), result.names)
    axis.set_ylim(0.0, 1.15 * max(max(runs) for runs in values))
    axis.grid(axis="x", visible=False)
