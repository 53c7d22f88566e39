"""A road as a picture: friction over the plane, grade and bank, the two tracks and their spectra."""

from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from bench.report.plot_style import INK, SOFT, WHEEL_COLOURS, plot_style
from signals.errors import InputError
from vehicle_model.road import RoadTables, friction_at, height_at, slopes_at, water_factor_at
from vehicle_model.road_file import RoadFile
from vehicle_model.roughness import HIGHEST_FREQUENCY, LOWEST_FREQUENCY, POINTS, SPACING_M, coherence, spectrum
from vehicle_model.roughness_classes import CLASS_LEVELS

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

ENDINGS = (".png", ".svg", ".pdf")
RESOLUTION_DPI = 110
_ALONG, _ACROSS = 420, 80
_HALF_WIDTH_M = 5.0
_LEFT, _RIGHT = WHEEL_COLOURS["fl"], WHEEL_COLOURS["fr"]
Range = tuple[float, float]


def draw_road(
    road: RoadFile, path: Path, *, along: Range | None = None, time_s: float = 0.0, speed_m_s: float = 22.22
) -> Path:
    """Draw a road.

    Parameters
    ----------
    along : (m, m), optional
        Stretch to draw; by default everything that changes on the road, with some road before and behind.
    time_s, speed_m_s
        Time for jumps by time; speed for the friction under water.

    Raises
    ------
    InputError
        If the file's ending is none of png, svg, pdf, or the stretch is empty.
    """
    if path.suffix.lower() not in ENDINGS:
        raise InputError(f"{path}: unknown kind of picture", allowed=", ".join(ENDINGS))
    stretch = along or usual_stretch(road)
    if stretch[1] <= stretch[0]:
        raise InputError(f"a stretch from {stretch[0]:g} m to {stretch[1]:g} m", allowed="its end behind its start")
    import matplotlib

    matplotlib.use("agg")
    from matplotlib import pyplot

    tables = RoadTables(road)
    rough = road.roughness.level > 0.0
    with matplotlib.rc_context(plot_style()):
        figure, axes = pyplot.subplots(
            4 if rough else 2,
            1,
            figsize=(11.0, 9.6 if rough else 5.2),
            height_ratios=(3.0, 1.6, 1.6, 3.0) if rough else (3.0, 1.6),
            layout="constrained",
        )
        figure.suptitle(road.name, x=0.012, ha="left", fontsize=14, fontweight="bold", color=INK)
        figure.text(0.988, 0.985, road.description, ha="right", va="top", fontsize=9, color=SOFT)
        _friction_map(figure, axes[0], tables, stretch, time_s, speed_m_s)
        _slopes(axes[1], tables, stretch)
        if rough:
            _tracks(axes[2], tables, stretch)
            _spectra(axes[3], road, tables)
        path.parent.mkdir(parents=True, exist_ok=True)
        figure.savefig(path, dpi=RESOLUTION_DPI, metadata={"Date": None} if path.suffix == ".svg" else None)
        pyplot.close(figure)
    return path


def usual_stretch(road: RoadFile) -> Range:
    """From some road before the first change to some behind the last one; 100 m of a road without changes."""
    places = [jump.position for jump in road.jumps if jump.position is not None]
    places += [place for patch in road.patches for place in (patch.x_from, patch.x_to)]
    places += [point.position for point in road.profile]
    places = [place for place in places if abs(place) < 1e3] or [0.0, 100.0]
    low, high = min(*places, 0.0), max(*places, 0.0)
    margin = max(10.0, 0.15 * (high - low))
    return low - margin, high + margin


def friction_map(
    tables: RoadTables, along: NDArray[np.float64], across: NDArray[np.float64], time_s: float, speed_m_s: float
) -> NDArray[np.float64]:
    """Peak friction at each place, shape ``(across, along)``, for a tyre whose own curve peaks at 1."""
    road = tables.record[0]
    peaks = np.array([surface.peak_friction() for surface in tables.road.used_surfaces().values()])
    result = np.empty((len(across), len(along)))
    for row, y in enumerate(across):
        for column, x in enumerate(along):
            friction, surface = friction_at(road, tables.jumps, tables.patches, x, y, time_s)
            result[row, column] = friction * peaks[surface] * water_factor_at(road, tables.patches, x, y, speed_m_s)
    return result


def _friction_map(
    figure: "Figure", axis: "Axes", tables: RoadTables, stretch: Range, time_s: float, speed_m_s: float
) -> None:
    edges = [abs(y) for patch in tables.road.patches for y in (patch.y_from, patch.y_to) if abs(y) < 50.0]
    half = max(_HALF_WIDTH_M, 1.2 * max(edges, default=0.0), 1.5 * abs(tables.road.split_position))
    along, across = np.linspace(*stretch, _ALONG), np.linspace(-half, half, _ACROSS)
    values = friction_map(tables, along, across, time_s, speed_m_s)
    image = axis.imshow(
        values,
        origin="lower",
        extent=(*stretch, -half, half),
        aspect="auto",
        cmap="viridis",
        vmin=0.0,
        vmax=max(1.0, float(values.max())),
        interpolation="nearest",
    )
    axis.grid(visible=False)
    wet = f", at {speed_m_s * 3.6:.0f} km/h" if tables.record["wet"][0] else ""
    timed = any(jump.time is not None for jump in tables.road.jumps)
    when = f", at {time_s:g} s" if timed else ""
    figure.colorbar(image, ax=axis, label=f"peak friction{wet}{when}", pad=0.01)
    axis.set_ylabel("y in m (left is up)")
    axis.set_xlabel("x in m")


def _slopes(axis: "Axes", tables: RoadTables, stretch: Range) -> None:
    along = np.linspace(*stretch, 600)
    slopes = 100.0 * np.array([slopes_at(tables.record[0], tables.points, x) for x in along])
    axis.plot(along, slopes[:, 0], color=_LEFT, label="grade, uphill positive")
    axis.plot(along, slopes[:, 1], color=_RIGHT, linestyle="--", label="bank, left side higher positive")
    axis.set_ylabel("slope in %")
    axis.set_xlabel("x in m")
    axis.set_xlim(*stretch)
    reach = max(1.0, 1.2 * float(np.abs(slopes).max()))
    axis.set_ylim(-reach, reach)
    axis.legend(ncols=2, loc="upper right")


def _tracks(axis: "Axes", tables: RoadTables, stretch: Range) -> None:
    along = np.arange(stretch[0], stretch[1], 0.5 * SPACING_M)
    for side, (label, colour) in enumerate((("left track", _LEFT), ("right track", _RIGHT))):
        heights = [1e3 * height_at(tables.heights, side, x)[0] for x in along]
        axis.plot(along, heights, color=colour, linewidth=0.9, label=label)
    axis.set_ylabel("height in mm")
    axis.set_xlabel("x in m")
    axis.set_xlim(*stretch)
    axis.legend(ncols=2, loc="upper right")


def _spectra(axis: "Axes", road: RoadFile, tables: RoadTables) -> None:
    from scipy.signal import coherence as estimated_coherence
    from scipy.signal import welch

    rough, segment = road.roughness, POINTS // 8
    limits = np.geomspace(LOWEST_FREQUENCY, HIGHEST_FREQUENCY, 100)
    for name, level in CLASS_LEVELS.items():
        curve = spectrum(limits, level)
        axis.loglog(limits, curve, color="#c4cad3", linewidth=0.8)
        axis.annotate(name, (limits[-1], curve[-1]), fontsize=7, color=SOFT, va="center")
    for side, (label, colour) in enumerate((("left track", _LEFT), ("right track", _RIGHT))):
        frequency, density = welch(tables.heights[side], 1.0 / SPACING_M, nperseg=segment)
        inside = (frequency >= LOWEST_FREQUENCY) & (frequency <= HIGHEST_FREQUENCY)
        axis.loglog(frequency[inside], density[inside], color=colour, linewidth=0.9, label=f"{label}, Welch estimate")
    declared = spectrum(limits, rough.level, rough.waviness)
    axis.loglog(limits, declared, color=INK, linewidth=1.6, label="declared")
    axis.set_ylabel("displacement spectrum in m³\n(grey: classes of ISO 8608)")
    axis.set_xlabel("spatial frequency in cycles/m")
    axis.set_ylim(declared.min() / 300.0, declared.max() * 30.0)
    right = axis.twinx()
    frequency, squared = estimated_coherence(*tables.heights, 1.0 / SPACING_M, nperseg=segment)
    inside = (frequency >= LOWEST_FREQUENCY) & (frequency <= HIGHEST_FREQUENCY)
    right.plot(frequency[inside], squared[inside], color="#0f7b4f", linewidth=0.7, alpha=0.6)
    right.plot(limits, coherence(limits, rough.track, rough.waviness) ** 2, color="#0f7b4f", linewidth=1.6)
    right.set_ylabel("coherence γ² of the tracks", color="#0f7b4f")
    right.set_ylim(0.0, 1.05)
    right.grid(visible=False)
    axis.legend(ncols=3, loc="lower left")
