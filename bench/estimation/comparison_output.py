"""A comparison of estimators as text, JSON, picture and page."""

import base64
import json
import math
from collections.abc import Callable, Sequence
from html import escape
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from bench.estimation.comparison import GroupComparison, Score
from bench.report.plot_style import INK, plot_style
from bench.verdict.output_files import replace_file
from signals.errors import InputError

if TYPE_CHECKING:
    from matplotlib.axes import Axes

SUMMARY_FILE, PICTURE_FILE, PAGE_FILE = "comparison.json", "comparison.png", "comparison.html"
_HEADS = ("estimator", "RMSE", "mean error", "relative", "to ±10 %", "jumps")
_LABEL_POINTS, _SMALL_LABEL_POINTS = 8.0, 5.5
_FEW_CASES = 10
"""Cases beside each other whose labels have room at the usual size."""
_COLOURS = (
    "#0b62c4", "#7fb2ea", "#c2410c", "#f0b23e", "#0f7b4f", "#7cc4a2", "#9333a8", "#b45309", "#515b6a", "#14181f",
)  # fmt: skip


def write_group_comparison(folder: Path, result: GroupComparison) -> None:
    """Write JSON, picture and page.

    Raises
    ------
    InputError
        If the folder cannot be written.
    """
    try:
        folder.mkdir(parents=True, exist_ok=True)
        text = json.dumps(result.as_json(), indent=2, allow_nan=False, ensure_ascii=False)
        replace_file(folder / SUMMARY_FILE, (text + "\n").encode())
        draw(folder / PICTURE_FILE, result)
        replace_file(folder / PAGE_FILE, page(result, folder / PICTURE_FILE).encode())
    except OSError as error:
        raise InputError(f"{folder}: {(error.strerror or str(error)).lower()}") from None


def text_of(result: GroupComparison) -> str:
    """For people: root mean squared errors of each quantity by run, of friction limits times to ±10 % and jumps."""
    lines = [f"estimators of the group {result.name}: {result.group.title}; RMSE {result.group.phase}"]
    for quantity in _shown(result):
        lines += ["", _heading(result, quantity)]
        lines += [f"  in the document: {text} ({source})" for text, source in _figures(result, quantity)]
        lines += _matrix(result, quantity, lambda score: f"{score.rmse:.3g}")
        if quantity.startswith("friction_limit"):
            lines += ["  time to ±10 %:", *_matrix(result, quantity, lambda score: cells(score)[3])]
            lines += ["  jumps, largest less smallest:", *_matrix(result, quantity, lambda score: cells(score)[4])]
    lines += ["", "processor time of a step, us:"]
    lines += [f"  {name:<30} {value:6.1f}" for name, value in result.step_time_us.items()]
    lines += [f"  {name:<30} {reason}" for name, reason in result.skipped.items()]
    return "\n".join(lines)


def _shown(result: GroupComparison) -> list[str]:
    """Quantities without the measured wheel speeds, which every filter follows."""
    return [name for name in result.quantities() if not name.startswith("wheel_speed")]


def _matrix(result: GroupComparison, quantity: str, cell: Callable[[Score], str]) -> list[str]:
    """Estimators down, runs across."""
    grouped = _by_case(result, quantity)
    width = max(30, *(len(name) + 1 for name in result.group.variants))
    columns = [max(18, len(case) + 2) for case, _ in grouped]
    lines = ["  " + " " * width + "".join(f"{case:>{n}}" for n, (case, _) in zip(columns, grouped, strict=True))]
    for name in result.group.variants:
        found = [next((score for score in scores if score.estimator == name), None) for _, scores in grouped]
        if any(score is not None for score in found):
            texts = ("-" if score is None else cell(score) for score in found)
            lines.append(f"  {name:<{width}}" + "".join(f"{t:>{n}}" for n, t in zip(columns, texts, strict=True)))
    return lines


def _heading(result: GroupComparison, quantity: str) -> str:
    unit = next(score.unit for score in result.scores if score.quantity == quantity)
    return quantity.replace("_", " ") + ("" if unit == "1" else f" in {unit}")


def _figures(result: GroupComparison, quantity: str) -> list[tuple[str, str]]:
    return [(figure.text, figure.source) for figure in result.group.figures if figure.quantity == quantity]


def _by_case(result: GroupComparison, quantity: str) -> list[tuple[str, list[Score]]]:
    return [
        (case.name, scores)
        for case in result.group.cases
        if (scores := [s for s in result.scores if s.quantity == quantity and s.case == case.name])
    ]


def cells(score: Score) -> list[str]:
    """RMSE, mean error, relative error, settling time and spread as texts."""
    settling = "never" if math.isinf(score.settling_s) else f"{score.settling_s:.2f} s"
    relative = "-" if math.isnan(score.relative_error) else f"{100 * score.relative_error:+.1f} %"
    return [f"{score.rmse:.3g}", f"{score.mean_error:+.2g}", relative, settling, f"{score.spread:.3g}"]


def page(result: GroupComparison, picture: Path) -> str:
    """A page of its own with picture and tables."""
    image = base64.b64encode(picture.read_bytes()).decode("ascii")
    title = escape(f"Estimators: {result.group.title}")
    parts = [
        "<!DOCTYPE html><html lang='en'><head><meta charset='utf-8'>",
        f"<title>{title}</title><style>{_STYLE}</style></head><body><h1>{title}</h1>",
        f"<img alt='root mean squared error by quantity, run and estimator' src='data:image/png;base64,{image}'>",
    ]
    for quantity in result.quantities():
        parts.append(f"<h2>{escape(_heading(result, quantity))}</h2>")
        parts += [
            f"<p>In the document: {escape(f'{text} ({source})')}</p>" for text, source in _figures(result, quantity)
        ]
        parts.append("<table><tr><th>run</th>" + "".join(f"<th>{escape(head)}</th>" for head in _HEADS) + "</tr>")
        for case, scores in _by_case(result, quantity):
            for place, score in enumerate(scores):
                first = f"<td rowspan='{len(scores)}'>{escape(case)}</td>" if place == 0 else ""
                row = "".join(f"<td>{escape(cell)}</td>" for cell in [score.estimator, *cells(score)])
                parts.append(f"<tr>{first}{row}</tr>")
        parts.append("</table>")
    parts.append("<h2>processor time of a step</h2><table><tr><th>estimator</th><th>us</th></tr>")
    parts += [f"<tr><td>{escape(name)}</td><td>{value:.1f}</td></tr>" for name, value in result.step_time_us.items()]
    return "".join([*parts, "</table></body></html>"])


_STYLE = (
    "body{font:14px/1.5 system-ui,sans-serif;color:#14181f;max-width:70rem;margin:2rem auto;padding:0 1rem}"
    "img{max-width:100%}table{border-collapse:collapse}td,th{border-bottom:1px solid #d9dde4;padding:.15rem .7rem;"
    "text-align:right;vertical-align:top}td:first-child,th:first-child,td[rowspan]+td{text-align:left}"
)


def draw(path: Path, result: GroupComparison) -> None:
    """Draw the error of each quantity, a group of bars per run, a bar per estimator."""
    import matplotlib

    matplotlib.use("agg")
    from matplotlib import pyplot

    quantities = _shown(result)
    rows = math.ceil(len(quantities) / 2)
    with matplotlib.rc_context(plot_style()):
        figure, axes = pyplot.subplots(rows, 2, figsize=(12.0, 0.9 + 2.3 * rows), layout="constrained", squeeze=False)
        title = f"RMSE {result.group.phase}: {result.group.title}"
        figure.suptitle(title, x=0.012, ha="left", fontsize=13, fontweight="bold", color=INK)
        for axis, quantity in zip(axes.flat, quantities, strict=False):
            _bars(axis, result, quantity)
        for axis in axes.flat[len(quantities) :]:
            axis.set_visible(False)
        handles = [pyplot.Rectangle((0, 0), 1, 1, color=colour) for colour in _colours(result).values()]
        figure.legend(handles, list(_colours(result)), ncols=4, loc="outside lower center")
        figure.savefig(path, dpi=110)
        pyplot.close(figure)


def _colours(result: GroupComparison) -> dict[str, str]:
    return {name: _COLOURS[place % len(_COLOURS)] for place, name in enumerate(result.group.variants)}


def _bars(axis: "Axes", result: GroupComparison, quantity: str) -> None:
    names: Sequence[str] = [
        name
        for name in result.group.variants
        if any(score.quantity == quantity and score.estimator == name for score in result.scores)
    ]
    width = 0.8 / len(names)
    grouped = _by_case(result, quantity)
    highest = _top([score.rmse for _, scores in grouped for score in scores])
    for place, (_, scores) in enumerate(grouped):
        for score in scores:
            x = place - 0.4 + (names.index(score.estimator) + 0.5) * width
            axis.bar(x, min(score.rmse, highest), 0.92 * width, color=_colours(result)[score.estimator])
            if score.rmse > highest:
                axis.annotate(f"{score.rmse:.2g}", (x, highest), ha="center", va="bottom", fontsize=6, rotation=90)
    points = _LABEL_POINTS if len(grouped) <= _FEW_CASES else _SMALL_LABEL_POINTS
    axis.set_xticks(range(len(grouped)), ["\n".join(case.split()) for case, _ in grouped], fontsize=points)
    axis.set_ylim(0.0, 1.12 * highest)
    axis.set_title(_heading(result, quantity), loc="left", fontsize=9)
    axis.grid(axis="x", visible=False)


def _top(values: Sequence[float]) -> float:
    """Height that shows most of the bars; longer ones are cut and say how long they are."""
    finite = np.array([value for value in values if math.isfinite(value)])
    return float(min(finite.max(), 3.0 * np.percentile(finite, 70))) or 1.0
