"""Pictures of a fit: measured points with the fitted curves, and what is left over."""

from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from bench.report.plot_style import INK, SOFT, plot_style
from bench.tyre_bench.rig_data import RigData
from bench.tyre_bench.tyre_pictures import COLOURS, RESOLUTION_DPI, SIZE_INCH
from vehicle_model.tyres.magic_formula_tyre import MagicFormulaTyre

if TYPE_CHECKING:
    from matplotlib.axes import Axes

_STRAIGHT = 0.01
_UPRIGHT = 0.01
_MOST_POINTS = 2500
_UNITS = {"fx": "N", "fy": "N", "mx": "N m", "mz": "N m"}
_NAMES = {"fx": "longitudinal force", "fy": "side force", "mx": "overturning moment", "mz": "aligning moment"}


def draw_fit(tyre: MagicFormulaTyre, data: RigData, folder: Path) -> list[Path]:
    """Write ``fit.png`` and ``residuals.png`` into a folder; returns the files."""
    import matplotlib

    matplotlib.use("agg")
    from matplotlib import pyplot

    forces = tyre.forces(*data.inputs.T, check=False)
    written = []
    with matplotlib.rc_context(plot_style()):
        for name, draw in (("fit.png", _draw_curves), ("residuals.png", _draw_residuals)):
            figure, axes = pyplot.subplots(2, 3, figsize=SIZE_INCH, layout="constrained")
            draw(axes, tyre, data, forces._asdict())
            figure.suptitle(
                f"{tyre.name}: {'measured and fitted' if name == 'fit.png' else 'fitted minus measured'}",
                x=0.012, ha="left", fontsize=13, fontweight="bold", color=INK,
            )  # fmt: skip
            figure.savefig(folder / name, dpi=RESOLUTION_DPI)
            pyplot.close(figure)
            written.append(folder / name)
    return written


def _thinned(rows: NDArray[np.bool_]) -> NDArray[np.intp]:
    places = np.flatnonzero(rows)
    return places[:: max(1, len(places) // _MOST_POINTS)]


def _load_levels(data: RigData, rows: NDArray[np.bool_]) -> list[float]:
    """Loads at which measurements lie, from the peaks of their histogram."""
    loads = data.inputs[rows, 3]
    if len(loads) == 0:
        return []
    counts, edges = np.histogram(loads, bins=12)
    levels: list[float] = []
    for count, low, high in zip(counts, edges[:-1], edges[1:], strict=True):
        if count > 0.06 * len(loads):
            middle = float(np.median(loads[(loads >= low) & (loads <= high)]))
            if not levels or middle > 1.25 * levels[-1]:
                levels.append(middle)
            else:
                levels[-1] = 0.5 * (levels[-1] + middle)
    return levels


def _measured_and_fitted(
    axis: "Axes", tyre: MagicFormulaTyre, data: RigData, rows: NDArray[np.bool_], over: int, force: str
) -> None:
    """Points of a force over an input (column of the inputs), coloured by load, and a curve for each load."""
    rows = rows & np.isfinite(data.measured[force])
    levels = _load_levels(data, rows)
    scale = 100.0 if over == 0 else np.degrees(1.0)
    for place, level in enumerate(levels):
        near = rows & (np.abs(data.inputs[:, 3] - level) < 0.2 * level)
        chosen = _thinned(near)
        colour = COLOURS[place % len(COLOURS)]
        axis.plot(
            scale * data.inputs[chosen, over], data.measured[force][chosen], ".", ms=1.6, alpha=0.35, color=colour
        )
        others: list[Any] = [float(np.median(data.inputs[near, column])) for column in range(6)]
        low, high = np.percentile(data.inputs[near, over], [0.2, 99.8])
        others[over] = np.linspace(float(low), float(high), 161)
        curve = getattr(tyre.forces(*others, check=False), force)
        axis.plot(scale * others[over], curve, color=colour, label=f"{level / 1e3:.2f} kN")
    axis.set(
        xlabel="slip ratio in %" if over == 0 else "slip angle in degrees",
        ylabel=f"{_NAMES[force]} in {_UNITS[force]}",
    )
    if levels:
        axis.legend(loc="best")
    else:
        axis.text(0.5, 0.5, "not measured", ha="center", color=SOFT, transform=axis.transAxes)


def _draw_curves(axes: Any, tyre: MagicFormulaTyre, data: RigData, forces: dict[str, Any]) -> None:
    angle, upright = data.inputs[:, 1], np.abs(data.inputs[:, 2]) < _UPRIGHT
    straight = np.abs(angle) < _STRAIGHT
    nominal = _nominal_pressure(data)
    turned = data.driven & (np.abs(angle - _largest_angle(data)) < _STRAIGHT)
    _measured_and_fitted(axes[0, 0], tyre, data, data.driven & straight & upright & nominal, 0, "fx")
    _measured_and_fitted(axes[0, 1], tyre, data, ~data.driven & upright & nominal, 1, "fy")
    _measured_and_fitted(axes[0, 2], tyre, data, ~data.driven & upright & nominal, 1, "mz")
    _measured_and_fitted(axes[1, 0], tyre, data, turned & upright & nominal, 0, "fx")
    _measured_and_fitted(axes[1, 1], tyre, data, turned & upright & nominal, 0, "fy")
    _measured_and_fitted(axes[1, 2], tyre, data, turned & upright & nominal, 0, "mz")
    for axis, title in zip(axes[0], ("straight", "rolling freely", "rolling freely"), strict=True):
        axis.set_title(title)
    for axis in axes[1]:
        axis.set_title(f"at a slip angle of {np.degrees(_largest_angle(data)):.1f}°")


def _nominal_pressure(data: RigData) -> NDArray[np.bool_]:
    """Rows of the upper half of the pressures, where several were measured."""
    pressure = data.inputs[:, 4]
    low, high = np.percentile(pressure, [2.0, 98.0])
    if high - low < 5e3:
        return np.ones(len(pressure), np.bool_)
    return np.asarray(pressure > 0.5 * (low + high))


def _largest_angle(data: RigData) -> float:
    """The slip angle of drive/brake tests that is furthest from straight."""
    angles = data.inputs[data.driven, 1]
    if len(angles) == 0:
        return 0.0
    low, high = np.percentile(angles, [5.0, 95.0])
    return float(low if abs(low) > abs(high) else high)


def _draw_residuals(axes: Any, tyre: MagicFormulaTyre, data: RigData, forces: dict[str, Any]) -> None:
    for column, (force, over) in enumerate((("fx", 0), ("fy", 1), ("mz", 1))):
        known = np.isfinite(data.measured[force])
        off = forces[force] - data.measured[force]
        axis, histogram = axes[0, column], axes[1, column]
        scale = 100.0 if over == 0 else np.degrees(1.0)
        for kind, rows, colour in (("drive/brake", data.driven, COLOURS[1]), ("cornering", ~data.driven, COLOURS[0])):
            chosen = _thinned(rows & known)
            if len(chosen) == 0:
                continue
            axis.plot(scale * data.inputs[chosen, over], off[chosen], ".", ms=1.6, alpha=0.4, color=colour)
            rms = float(np.sqrt(np.mean(off[rows & known] ** 2)))
            width = float(np.percentile(np.abs(off[known]), 99.5))
            label = f"{kind}, rms {rms:.3g} {_UNITS[force]}"
            bins = np.linspace(-width, width, 81)
            histogram.hist(off[rows & known], bins=bins, histtype="step", density=True, color=colour, label=label)
        axis.axhline(0.0, color=SOFT, linewidth=0.6)
        axis.set(xlabel="slip ratio in %" if over == 0 else "slip angle in degrees")
        axis.set_ylabel(f"{_NAMES[force]} in {_UNITS[force]}")
        histogram.set(xlabel=f"{_NAMES[force]}, fitted minus measured, in {_UNITS[force]}", ylabel="share of rows")
        histogram.set_yticks([])
        if histogram.get_legend_handles_labels()[0]:
            histogram.legend(loc="upper left")
