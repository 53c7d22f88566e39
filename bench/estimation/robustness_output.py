"""Tables in Markdown and charts of a robustness study."""

import math
from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING

from bench.estimation.comparison import Score
from bench.estimation.perturbations import RobustnessPlan
from bench.estimation.robustness import PerturbationResult
from bench.report.plot_style import INK, plot_style

if TYPE_CHECKING:
    from matplotlib.axes import Axes

_COLOURS = ("#0b62c4", "#c2410c", "#0f7b4f", "#9333a8", "#515b6a", "#be185d", "#b45309")
_NO_UNIT = "1"
_WORDS = {"rmse": "RMSE", "relative": "mean error", "share": "share of the run", "smallest": "smallest"}
_IN_PERCENT = ("relative", "share")
_PANELS = 3
"""Panels in a row of a chart."""


def table(plan: RobustnessPlan, result: PerturbationResult) -> str:
    """Rows: estimators; columns: quantities at each level."""
    labels = list(result.scores)
    lines = [
        "| Estimator | Quantity | " + " | ".join(labels) + " |",
        "|---|---|" + "---:|" * len(labels),
    ]
    for name in plan.variants:
        for quantity, figure in plan.quantities.items():
            found = [_find(result.scores[label], name, quantity) for label in labels]
            if any(score is not None for score in found):
                shown = " | ".join("-" if score is None else _shown(score, figure) for score in found)
                lines.append(f"| `{name}` | {_heading(result, quantity, figure)} | {shown} |")
    return "\n".join(lines)


def _find(scores: Sequence[Score], estimator: str, quantity: str) -> Score | None:
    return next((s for s in scores if s.estimator == estimator and s.quantity == quantity), None)


def _value(score: Score, figure: str) -> float:
    return {
        "rmse": score.rmse,
        "relative": 100.0 * score.relative_error,
        "share": 100.0 * score.mean,
        "smallest": score.smallest_sure,
    }[figure]


def _shown(score: Score, figure: str) -> str:
    value = _value(score, figure)
    if math.isnan(value):
        return "-"
    return {"relative": f"{value:+.1f} %", "share": f"{value:.1f} %"}.get(figure, f"{value:.3g}")


def _heading(result: PerturbationResult, quantity: str, figure: str) -> str:
    words = quantity.replace("_", " ")
    if figure in ("relative", "share"):
        return f"{words}, {_WORDS[figure]}"
    unit = next((s.unit for scores in result.scores.values() for s in scores if s.quantity == quantity), _NO_UNIT)
    return f"{words}, {_WORDS[figure]}" + ("" if unit == _NO_UNIT else f" in {unit}")


def draw(path: Path, plan: RobustnessPlan, result: PerturbationResult) -> None:
    """One chart: a panel for each quantity, a line for each estimator over the levels."""
    import matplotlib

    matplotlib.use("agg")
    from matplotlib import pyplot

    with matplotlib.rc_context(plot_style()):
        columns = min(_PANELS, len(plan.quantities))
        rows = -(-len(plan.quantities) // columns)
        figure, axes = pyplot.subplots(
            rows, columns, figsize=(10.0, 0.5 + 2.4 * rows), layout="constrained", squeeze=False
        )
        figure.suptitle(result.perturbation.title, x=0.012, ha="left", fontsize=11, fontweight="bold", color=INK)
        for axis in axes.flat[len(plan.quantities) :]:
            axis.axis("off")
        for axis, (quantity, kind) in zip(axes.flat, plan.quantities.items(), strict=False):
            _panel(axis, plan, result, quantity, kind)
        handles = [
            pyplot.Line2D([], [], color=colour, marker="o", markersize=4) for colour in _COLOURS[: len(plan.variants)]
        ]
        figure.legend(handles, list(plan.variants), ncols=len(plan.variants), loc="outside lower center")
        path.parent.mkdir(parents=True, exist_ok=True)
        figure.savefig(path, dpi=90)
        pyplot.close(figure)


def _panel(axis: "Axes", plan: RobustnessPlan, result: PerturbationResult, quantity: str, kind: str) -> None:
    labels = list(result.scores)
    for name, colour in zip(plan.variants, _COLOURS, strict=False):
        found = [_find(result.scores[label], name, quantity) for label in labels]
        values = [math.nan if score is None else _value(score, kind) for score in found]
        if not all(math.isnan(value) for value in values):
            axis.plot(range(len(labels)), values, "o-", color=colour, markersize=4)
    axis.set_xticks(range(len(labels)), labels)
    axis.set_xlim(-0.3, len(labels) - 0.7)
    axis.set_ylabel(
        _heading(result, quantity, kind).replace("friction", "fr.") + (" in %" if kind in _IN_PERCENT else "")
    )
    if kind == "rmse":
        axis.set_ylim(bottom=0.0)
    else:
        axis.axhline(0.0, color=INK, linewidth=0.8)
