"""Tyres as one picture: longitudinal, lateral, aligning, combined slip, and what a change of load does."""

from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from bench.report.plot_style import INK, SOFT, plot_style
from bench.tyre_bench.rig_data import FloatArray
from bench.tyre_bench.sources import Source
from signals.errors import InputError

if TYPE_CHECKING:
    from matplotlib.axes import Axes

ENDINGS = (".png", ".svg", ".pdf")
COLOURS = ("#0b62c4", "#c2410c", "#0f7b4f", "#9333a8", "#14181f", "#0aa2c0", "#e05297", "#a58100")
SIZE_INCH = (13.0, 7.6)
RESOLUTION_DPI = 110

_SLIPS = np.linspace(-1.0, 1.0, 801)
_ANGLES = np.linspace(-0.35, 0.35, 401)
_SIDE_ANGLES = (2.0, 5.0, 10.0)
_LOADS = (0.5, 1.0, 1.5, 2.0)


def checked_ending(path: str | Path) -> Path:
    """The path; InputError if its ending is no kind of picture."""
    path = Path(path)
    if path.suffix.lower() not in ENDINGS:
        raise InputError(f"{path}: unknown kind of picture", allowed=", ".join(ENDINGS))
    return path


def draw_tyres(sources: Sequence[Source], path: str | Path, load: float | None = None) -> Path:
    """Draw tyres beside each other, one of them at several loads.

    Parameters
    ----------
    sources
        At most eight.
    path
        PNG, SVG or PDF by its ending.
    load : N, optional
        Load of all of them; each one's nominal load if left out.

    Raises
    ------
    InputError
        If the file's ending is unknown or there are too many tyres.
    """
    path = checked_ending(path)
    if len(sources) > len(COLOURS):
        raise InputError("too many tyres for one picture", found=str(len(sources)), allowed=f"{len(COLOURS)} at most")
    import matplotlib

    matplotlib.use("agg")
    from matplotlib import pyplot

    with matplotlib.rc_context(plot_style()):
        figure, axes = pyplot.subplots(2, 3, figsize=SIZE_INCH, layout="constrained")
        _longitudinal(axes[0, 0], sources, load)
        _lateral(axes[0, 1], sources, load)
        _aligning(axes[0, 2], sources, load)
        _combined(axes[1, 0], sources, load)
        _peaks_over_load(axes[1, 1], sources)
        _stiffness_over_load(axes[1, 2], sources)
        title = ", ".join(source.name for source in sources) + (f" at {load / 1e3:.1f} kN" if load else "")
        figure.suptitle(title, x=0.012, ha="left", fontsize=13, fontweight="bold", color=INK)
        path.parent.mkdir(parents=True, exist_ok=True)
        figure.savefig(path, dpi=RESOLUTION_DPI, metadata={"Date": None} if path.suffix == ".svg" else None)
        pyplot.close(figure)
    return path


def _curves(sources: Sequence[Source], load: float | None) -> list[tuple[Source, float, dict[str, Any]]]:
    """Tyre, load and look of each curve: one tyre is shown at several loads, several at one each."""
    if len(sources) == 1:
        source = sources[0]
        nominal = load or source.nominal_load
        return [
            (source, share * nominal, {"color": COLOURS[place], "label": f"{share * nominal / 1e3:.1f} kN"})
            for place, share in enumerate(_LOADS)
        ]
    return [
        (
            source,
            load or source.nominal_load,
            {
                "color": COLOURS[place],
                "label": source.name if load else f"{source.name}, {source.nominal_load / 1e3:.1f} kN",
            },
        )
        for place, source in enumerate(sources)
    ]


def _longitudinal(axis: "Axes", sources: Sequence[Source], load: float | None) -> None:
    for source, at, look in _curves(sources, load):
        axis.plot(100.0 * _SLIPS, source.tyre.forces(_SLIPS, 0.0, 0.0, at, check=False).fx / at, **look)
    axis.set(xlabel="slip ratio in %", ylabel="longitudinal force / load", title="straight ahead")
    axis.legend(loc="upper left")


def _lateral(axis: "Axes", sources: Sequence[Source], load: float | None) -> None:
    for source, at, look in _curves(sources, load):
        axis.plot(np.degrees(_ANGLES), source.tyre.forces(0.0, _ANGLES, 0.0, at, check=False).fy / at, **look)
    axis.set(xlabel="slip angle in degrees", ylabel="side force / load", title="rolling freely")


def _aligning(axis: "Axes", sources: Sequence[Source], load: float | None) -> None:
    for source, at, look in _curves(sources, load):
        axis.plot(np.degrees(_ANGLES), source.tyre.forces(0.0, _ANGLES, 0.0, at, check=False).mz, **look)
    axis.set(xlabel="slip angle in degrees", ylabel="aligning moment in N m", title="rolling freely")


def _combined(axis: "Axes", sources: Sequence[Source], load: float | None) -> None:
    """Side force over longitudinal force while the slip ratio goes from lock to 100 %."""
    for place, source in enumerate(sources):
        at = load or source.nominal_load
        for number, angle in enumerate(_SIDE_ANGLES):
            forces = source.tyre.forces(_SLIPS, np.radians(-angle), 0.0, at, check=False)
            shade = 1.0 - 0.3 * number
            label = f"{angle:.0f}°" if place == 0 else None
            axis.plot(forces.fx / at, forces.fy / at, color=COLOURS[place], alpha=shade, label=label)
    axis.axhline(0.0, color=SOFT, linewidth=0.6)
    axis.axvline(0.0, color=SOFT, linewidth=0.6)
    axis.set_aspect("equal", adjustable="datalim")
    axis.set(
        xlabel="longitudinal force / load", ylabel="side force / load", title="slip angle held, slip from lock to 100 %"
    )
    axis.legend(loc="lower center", ncols=3, title="slip angle", title_fontsize=8)


def _peaks_over_load(axis: "Axes", sources: Sequence[Source]) -> None:
    for place, source in enumerate(sources):
        loads, braking, locked, side = _sweep(source)
        axis.plot(loads / 1e3, braking, color=COLOURS[place], label="braking" if place == 0 else None)
        axis.plot(loads / 1e3, locked, color=COLOURS[place], linestyle=":", label="locked" if place == 0 else None)
        axis.plot(loads / 1e3, side, color=COLOURS[place], linestyle="--", label="cornering" if place == 0 else None)
    axis.set_ylim(bottom=0.0)
    axis.set(xlabel="load in kN", ylabel="largest force / load", title="friction over load")
    axis.legend(loc="lower left")


def _sweep(source: Source) -> tuple[FloatArray, FloatArray, FloatArray, FloatArray]:
    loads = np.linspace(0.2, 2.0, 19) * source.nominal_load
    slips, angles = _SLIPS[_SLIPS <= 0.0][:, None], np.linspace(0.0, 0.6, 241)[:, None]
    braking = -source.tyre.forces(slips, 0.0, 0.0, loads[None, :], check=False).fx / loads
    side = -source.tyre.forces(0.0, angles, 0.0, loads[None, :], check=False).fy / loads
    return loads, braking.max(axis=0), braking[0], side.max(axis=0)


def _stiffness_over_load(axis: "Axes", sources: Sequence[Source]) -> None:
    for place, source in enumerate(sources):
        loads = np.linspace(0.1, 2.0, 20) * source.nominal_load
        slopes = source.tyre.slopes(1e-6, 1e-6, 0.0, loads)
        label = ("slip stiffness per unit", "cornering stiffness per rad") if place == 0 else (None, None)
        axis.plot(loads / 1e3, slopes.fx_by_slip_ratio / 1e3, color=COLOURS[place], label=label[0])
        axis.plot(loads / 1e3, -slopes.fy_by_slip_angle / 1e3, color=COLOURS[place], linestyle="--", label=label[1])
    axis.set_ylim(bottom=0.0)
    axis.set(xlabel="load in kN", ylabel="stiffness in kN", title="stiffness over load")
    axis.legend(loc="upper left")
